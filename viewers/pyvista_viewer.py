"""Looking closely at motions with PyVista: in a notebook, in a window, as pictures and strips, as a page.

    from viewers.pyvista_viewer import Inspector

    look = Inspector(motion, contacts=True, trail=True)
    look                       # last line of a notebook cell: play, scrub, step, speed, camera, body or skeleton
    look.window()              # the same on the desktop, with the keys of the browser player
    look.save_strip("a.png", every=10)
    look.save_html("a.html")

For videos there is `viewers.render`, which is several times as fast (moderngl); PyVista is for looking from any side
and for adding one's own meshes and measures to `look.plotter`.

A page is written by the browser player (`viewers.web.standalone`), not by PyVista's `export_html`: that one needs the
packages trame-pyvista and trame-vtk, holds one frozen pose in 2 MB, and cannot be scrubbed; the player's page
plays, is about 1.5 MB whatever the length, and needs no network either.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from PIL import Image

from engines.errors import FormatError, OutOfRangeError
from engines.formats import atomic_path
from engines.motion import Motion
from viewers import strips
from viewers.camera import Camera
from viewers.pv.pictures import Pictures
from viewers.scene import Scene, Show
from viewers.viewing import Playback, Viewing

if TYPE_CHECKING:
    import pyvista


class Inspector:
    """Motions to be looked at, at one frame, from one side, with what is switched on.

    Args:
        what: a Scene; or one or several motions, shown as `Scene.of` shows them.
        width: of pictures, pixels.
        height: of pictures, pixels.
        options: for motions, further arguments of `Scene.of`: layout, camera, body, show ("body", "skeleton",
            "both"), trail, contacts, ghosts, ...

    Raises:
        OutOfRangeError: a size that cannot be.
        UnknownLabelError: an option of no known name or value.
        MissingDependencyError: pyvista is not installed (at the first picture).
    """

    def __init__(self, what: Motion | Scene | Sequence[Motion], width: int = 960, height: int = 540, **options) -> None:
        self.viewing = Viewing(what, **options)
        self.width, self.height = width, height
        self._pictures: Pictures | None = None
        self._panel: Any = None

    def __enter__(self) -> Inspector:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Give the plotter's memory back; the next picture makes another."""
        if self._pictures is not None:
            self._pictures.close()
            self._pictures = None

    # ---- where and what -------------------------------------------------------------------------------------------

    @property
    def playback(self) -> Playback:
        """The clock: frame, speed, loop."""
        return self.viewing.playback

    @property
    def scene(self) -> Scene:
        """What is shown now."""
        return self.viewing.scene

    @property
    def frame(self) -> int:
        """The frame shown, counted from 0."""
        return self.playback.frame

    @frame.setter
    def frame(self, number: int) -> None:
        if not 0 <= number < self.playback.frames:
            raise OutOfRangeError("frame", number, f"0 to {self.playback.frames - 1}")
        self.playback.seek(number)
        self._redraw()

    @property
    def show(self) -> Show:
        """body, skeleton or both."""
        return self.scene.actors[0].show

    @show.setter
    def show(self, value: Show) -> None:
        self.change(show=value)

    def step(self, count: int = 1) -> Inspector:
        """Go on (or back) by so many frames."""
        self.playback.step(count)
        return self._redraw()

    def look(self, camera: str | Camera) -> Inspector:
        """Look through a camera, or from "front", "back", "left", "right", "orbit" or "follow".

        Raises:
            UnknownLabelError: no such camera.
        """
        self.viewing.look(camera)
        return self._redraw()

    def change(self, **fields) -> Inspector:
        """Switch things on and off: `show="both", contacts=True, trail=True, ghosts=8, colour="#d9b38c"`."""
        self.viewing.change(**fields)
        return self._redraw()

    # ---- pictures -------------------------------------------------------------------------------------------------

    @property
    def plotter(self) -> pyvista.Plotter:
        """The one plotter that pictures are drawn with; what is added to it stays until the scene changes."""
        return self._drawn().plotter

    def image(self) -> np.ndarray:
        """(height, width, 3) uint8 sRGB picture of what is shown; while it plays edges are not smoothed."""
        return self._drawn().frame(self.scene, self.playback.seconds, fine=not self.playback.playing)

    def screenshot(self, path: str | Path) -> Path:
        """Write what is shown as .png, beside and renamed.

        Raises:
            FormatError: the ending is not .png, or the file cannot be written.
        """
        return _save_png(self.image(), path)

    def strip(self, frames: list[int] | None = None, every: int | None = None, height: int = 360) -> np.ndarray:
        """Poses of the first motion side by side, as the papers' figures show motions.

        Args:
            frames: which frames; default: `strips.USUAL` spread over all.
            every: every so many frames instead.
            height: pixels; each pose is three quarters as wide.

        Returns:
            (height, W, 3) uint8 sRGB.

        Raises:
            OutOfRangeError: frames or sizes that cannot be.
        """
        first = self.scene.actors[0]
        if every is not None:
            frames = strips.every(first.motion, every)
        return strips.strip(
            first.motion, frames, height, body="stick" if first.show == "skeleton" else first.body,
            backdrop=self.scene.backdrop, draw=Pictures,
        )  # fmt: skip

    def save_strip(self, path: str | Path, **options) -> Path:
        """Write a strip as .png; options as in `strip`.

        Raises:
            FormatError: the ending is not .png, or the file cannot be written.
            OutOfRangeError: frames or sizes that cannot be.
        """
        return _save_png(self.strip(**options), path)

    def save_html(self, path: str | Path, title: str = "Motion", **options) -> Path:
        """Write a page that plays the motions in any browser, without network or server.

        Args:
            path: the file; it appears whole or not at all.
            title: of the page.
            options: further ones of `viewers.web.controls.Controls`, on top of what is shown here.

        Raises:
            OutOfRangeError: more motions than the page can show.
        """
        from viewers.web.standalone import save_html

        first = self.scene.actors[0]
        shown = {"show": first.show, "trail": first.trail, "contacts": first.contacts, "ghosts": first.ghosts}
        shown["camera"] = self.scene.camera.mode
        shown["theme"] = "light" if self.scene.backdrop == "light" else "dark"
        labels = [actor.label or "" for actor in self.scene.actors]
        return save_html(
            [actor.motion for actor in self.scene.actors], path, body=first.body, labels=labels, title=title,
            **{**shown, **options},
        )  # fmt: skip

    # ---- windows and notebooks ------------------------------------------------------------------------------------

    def window(self) -> None:
        """Open a window on the desktop and come back when it is closed. Press ? in it for its keys.

        Raises:
            NoDisplayError: there is no screen here; the message says what to use instead.
        """
        from viewers.pv.window import Window

        Window(self.viewing, self.width, self.height).run()

    def notebook(self) -> Any:
        """Controls and picture as one widget for a notebook; the picture is drawn by the kernel."""
        from viewers.pv.notebook import Panel

        if self._panel is None:
            self._panel = Panel(self)
        return self._panel.box

    def _repr_mimebundle_(self, **kwargs) -> Any:
        return self.notebook()._repr_mimebundle_(**kwargs)

    def _drawn(self) -> Pictures:
        if self._pictures is None:
            self._pictures = Pictures(self.width, self.height)
        return self._pictures

    def _redraw(self) -> Inspector:
        if self._panel is not None:
            self._panel.draw()
        return self


def _save_png(picture: np.ndarray, path: str | Path) -> Path:
    path = Path(path)
    if path.suffix.lower() != ".png":
        raise FormatError(path, f"pictures end in .png, not in {path.suffix!r}.")
    with atomic_path(path) as temporary:
        Image.fromarray(picture).save(temporary, format="PNG")
    return path
