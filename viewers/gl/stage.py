"""A scene made ready to draw: every pose, camera and mark of all moments worked out and uploaded ahead."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from viewers.camera import CameraTrack
from viewers.gl import extent
from viewers.gl.context import GraphicsContext
from viewers.gl.figures import Mesh, Poses, mesh
from viewers.gl.marks import Label, Marks, actor_marks
from viewers.played import Ghost, Played, Worn, at_home, ghost_frames, play, visible_ghosts, worn
from viewers.scene import Actor, Scene, hex_to_rgb

FLOOR = (3.0, 2.2)
"""The floor has faded away at so many metres, plus so many times the camera's distance, from what is looked at."""


@dataclass
class Figure:
    """One body of an actor, at all moments."""

    mesh: Mesh
    poses: Poses
    alpha: float = 1.0
    ghost_poses: Poses | None = None
    ghosts: Sequence[Sequence[Ghost]] = ()
    """For each moment, what is seen of them."""
    casts_shadow: bool = True


@dataclass
class Stage:
    """What the renderer needs for each of N moments of a scene."""

    scene: Scene
    times: np.ndarray
    track: CameraTrack
    view_projections: np.ndarray
    """(N, 4, 4), y pointing down the picture, float32."""
    figures: list[Figure]
    marks: list[Marks]
    labels: list[Label]
    shadow_areas: np.ndarray
    """(N, figures, 4) centre x, z and 1 / half size of the floor under each shadow."""
    boxes: np.ndarray
    """(N, 4) left, top, width, height in pixels of the part of the picture that figures may touch."""
    strips: np.ndarray
    """(N, BANDS, 4) left, top, right, bottom in pixels: the same, closer."""
    heights: np.ndarray
    """(N, figures) height of each figure in pixels, roughly."""
    floor_clip: float = -1e9
    """Height below which figures are hidden by the floor."""
    owned: list[Poses] = field(default_factory=list)

    @property
    def largest_box(self) -> tuple[int, int]:
        """Width and height that hold the box of any moment."""
        return int(self.boxes[:, 2].max()), int(self.boxes[:, 3].max())

    def release(self) -> None:
        """Free what was uploaded for this scene."""
        for part in (*self.owned, *self.marks, *self.labels):
            part.release()


@dataclass
class _Seen:
    """A figure, and where it may be seen."""

    figure: Figure
    points: np.ndarray
    """(N, P, 3) along its bones."""
    ghosts: np.ndarray
    """(N, Q, 3) along those of its ghosts."""
    reach: np.ndarray
    """(P,) metres its skin may reach beyond them."""


def build(
    graphics: GraphicsContext, scene: Scene, times: np.ndarray, size: tuple[int, int], track: CameraTrack | None = None
) -> Stage:
    """The stage of a scene at `times` (N,) seconds, for pictures of `size` (width, height).

    The camera is the scene's own, or `track`.
    """
    scene, aspect = at_home(scene), size[0] / size[1]
    track = track or scene.track(times, aspect)
    flip = np.diag([1.0, -1.0, 1.0, 1.0])  # OpenGL's first row becomes the top of the picture
    matrices = (flip @ track.projection(aspect) @ track.views()).astype(np.float32)
    seen = [one for actor in scene.actors for one in _figures(graphics, actor, times)]
    boxes, strips = _extents(seen, matrices, track.fov, size)
    figures = [one.figure for one in seen]
    lowest = min(float(one.points[..., 1].min()) for one in seen)
    distance = np.stack([np.linalg.norm(one.points.mean(1) - track.eye, axis=-1) for one in seen], axis=1)
    light = scene.light.direction
    return Stage(
        scene=scene,
        times=times,
        track=track,
        view_projections=matrices,
        figures=figures,
        marks=[marks for actor in scene.actors for marks in actor_marks(graphics, actor)],
        labels=[Label(graphics, actor, times, size) for actor in scene.actors if actor.label],
        shadow_areas=np.stack([extent.shadow_areas(one.points, one.reach, light) for one in seen], axis=1),
        boxes=boxes,
        strips=strips,
        heights=1.75 * size[1] / (2 * np.tan(track.fov / 2) * distance),
        floor_clip=-0.004 if scene.floor and lowest > -0.25 else -1e9,
        owned=[poses for figure in figures for poses in (figure.poses, figure.ghost_poses) if poses is not None],
    )


def _extents(
    seen: list[_Seen], matrices: np.ndarray, fov: float, size: tuple[int, int]
) -> tuple[np.ndarray, np.ndarray]:
    """`extent.bands` around all figures and ghosts."""
    discs = [
        extent.project(points, np.resize(one.reach, points.shape[1]), matrices, fov, size)
        for one in seen
        for points in (one.points, one.ghosts)
        if points.shape[1]
    ]
    places, radii = (np.concatenate(parts, axis=1) for parts in zip(*discs, strict=True))
    return extent.bands(places, radii, size)


def _figures(graphics: GraphicsContext, actor: Actor, times: np.ndarray) -> list[_Seen]:
    """The actor's bodies and where they may be seen."""
    colour = hex_to_rgb(actor.colour) if actor.colour else None
    made = []
    for one in worn(actor):
        played = play(one.body, one.motion, times, actor.offset)
        uploaded = mesh(graphics, one.body, colour)
        figure = Figure(uploaded, Poses(graphics, played.matrices, uploaded.rows), one.alpha)
        figure.casts_shadow = not made
        ghosts = np.zeros((len(times), 0, 3))
        if actor.ghosts:
            ghosts = _add_ghosts(graphics, figure, actor, one, times)
        made.append(_Seen(figure, _outline(played), ghosts, extent.reach(one.body)))
    return made


def _add_ghosts(graphics: GraphicsContext, figure: Figure, actor: Actor, one: Worn, times: np.ndarray) -> np.ndarray:
    """Give a figure its ghosts; returns the points (N, Q, 3) of those that are seen at each moment."""
    frames = ghost_frames(one.motion, actor.ghosts)
    still = play(one.body, one.motion, frames / one.motion.fps, actor.offset)
    figure.ghost_poses = Poses(graphics, still.matrices, figure.mesh.rows)
    figure.ghosts = [visible_ghosts(frames / one.motion.fps, float(now), actor.ghost_count) for now in times]
    most = max(len(now) for now in figure.ghosts)
    poses = [[ghost.pose for ghost in now] for now in figure.ghosts]
    if not most:
        return np.zeros((len(times), 0, 3))
    first = next(now for now in poses if now)
    filled = np.array([(now or first) + (now or first)[-1:] * (most - len(now or first)) for now in poses])
    return _outline(still)[filled].reshape(len(times), -1, 3)


def _outline(played: Played) -> np.ndarray:
    return extent.outline(played.body.skeleton, played.positions, played.turns)


def floor_reach(distance: float) -> float:
    """Metres from what is looked at to where the floor has faded away."""
    return FLOOR[0] + FLOOR[1] * distance
