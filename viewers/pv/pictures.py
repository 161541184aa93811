"""Pictures of scenes by PyVista: one plotter, emptied and filled again for every scene."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from engines.errors import OutOfRangeError
from viewers.camera import CameraTrack
from viewers.pv.plotter import LARGEST, make_plotter
from viewers.pv.stage import Stage
from viewers.scene import Scene


class Pictures:
    """Draws scenes into pictures of one size, without a screen; speaks as `moderngl_renderer.Renderer` does.

    Close it, or use it in a `with` block, to give its memory back.

    Raises:
        OutOfRangeError: a size that cannot be.
        MissingDependencyError: pyvista is not installed.
    """

    def __init__(self, width: int, height: int) -> None:
        for name, value in (("width", width), ("height", height)):
            if not 1 <= value <= LARGEST:
                raise OutOfRangeError(name, value, f"1 to {LARGEST} pixels")
        self.width, self.height = int(width), int(height)
        self.plotter = make_plotter(self.width, self.height)
        self._staged: tuple[Scene, Stage] | None = None

    def __enter__(self) -> Pictures:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Free the plotter."""
        self._staged = None
        self.plotter.close()

    def frame(self, scene: Scene, t: float = 0.0, fine: bool = True) -> np.ndarray:
        """(H, W, 3) uint8 sRGB picture of the scene at `t` seconds; with `fine` its edges are smooth."""
        return self._picture(scene, t, scene.track(np.array([t]), self.width / self.height), 0, fine)

    def pictures(self, scene: Scene, times: np.ndarray) -> Iterator[np.ndarray]:
        """(H, W, 3) uint8 pictures at `times` (N,) seconds."""
        track = scene.track(times, self.width / self.height)
        for moment, t in enumerate(times):
            yield self._picture(scene, float(t), track, moment)

    def _picture(self, scene: Scene, t: float, track: CameraTrack, moment: int, fine: bool = True) -> np.ndarray:
        self._stage(scene).show(t, fine)
        aim(self.plotter, track, moment)
        self.plotter.render()
        return np.ascontiguousarray(self.plotter.screenshot(return_img=True)[..., :3])

    def _stage(self, scene: Scene) -> Stage:
        """What stands in the plotter; the same scene is left standing."""
        if self._staged is None or self._staged[0] is not scene:
            self.plotter.clear()
            self.plotter.suppress_rendering = True  # else every mesh that is added is a picture of its own
            self._staged = (scene, Stage(self.plotter, scene))
            self.plotter.suppress_rendering = False
        return self._staged[1]


def aim(plotter, track: CameraTrack, moment: int) -> None:
    """Point a plotter's camera as the track does at one moment."""
    camera = plotter.camera
    camera.position, camera.focal_point = track.eye[moment], track.target[moment]
    steep = abs((track.eye - track.target)[moment, 1]) > 0.999 * np.linalg.norm((track.eye - track.target)[moment])
    camera.up = (0.0, 0.0, -1.0) if steep else (0.0, 1.0, 0.0)
    camera.view_angle = float(np.degrees(track.fov))
    camera.clipping_range = (track.near, track.far)
