"""A scene made ready to draw: every pose, camera and mark of all moments worked out and uploaded ahead."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from engines.geometry import kinematics, rotations
from engines.motion import Motion
from viewers import bodies
from viewers.bodies.body import Body
from viewers.camera import CameraTrack
from viewers.gl.context import GraphicsContext
from viewers.gl.figures import Mesh, Poses, mesh
from viewers.gl.marks import Label, Marks, actor_marks
from viewers.scene import Actor, Scene, hex_to_rgb, sample

REACH = 0.24
"""A skin's outermost vertex lies no farther than this from some joint, metres, the tips of hands, head and feet included."""
GHOST_LIMIT = 48
"""So many ghosts of one actor at most; with more the interval grows."""


@dataclass
class Ghost:
    """One onion skin as it looks at one moment."""

    pose: int
    """Which of the ghost poses."""
    alpha: float
    """How much of it covers what is behind."""
    fade: float
    """How far its colours have faded into the backdrop."""


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
    floor_clip: float = -1e9
    """Height below which figures are hidden by the floor."""
    owned: list[Poses] = field(default_factory=list)

    def release(self) -> None:
        """Free what was uploaded for this scene."""
        for part in (*self.owned, *self.marks, *self.labels):
            part.release()


@dataclass
class _Played:
    """A body and what it does at each moment, in the scene's world."""

    body: Body
    positions: np.ndarray
    turns: np.ndarray

    @property
    def matrices(self) -> np.ndarray:
        return bodies.skinning_matrices(self.body.skeleton, self.positions, self.turns)


def build(graphics: GraphicsContext, scene: Scene, times: np.ndarray, size: tuple[int, int]) -> Stage:
    """The stage of a scene at `times` (N,) seconds, for pictures of `size` (width, height)."""
    aspect = size[0] / size[1]
    track = scene.track(times, aspect)
    flip = np.diag([1.0, -1.0, 1.0, 1.0])  # OpenGL's first row becomes the top of the picture
    matrices = (flip @ track.projection(aspect) @ track.views()).astype(np.float32)
    figures, owned, points = [], [], []
    for actor in scene.actors:
        for figure, seen in _figures(graphics, actor, times):
            figures.append(figure)
            owned += [figure.poses] + ([figure.ghost_poses] if figure.ghost_poses else [])
            points.append(seen)
    joints = [seen for seen in points]
    lowest = min(float(p[..., 1].min()) for p in joints)
    return Stage(
        scene=scene,
        times=times,
        track=track,
        view_projections=matrices,
        figures=figures,
        marks=[marks for actor in scene.actors for marks in actor_marks(graphics, actor)],
        labels=[Label(graphics, actor, times, size) for actor in scene.actors if actor.label],
        shadow_areas=np.stack([_shadow_areas(p[:, : p.shape[1]], scene.light.direction) for p in joints], axis=1),
        boxes=_boxes(points, matrices, size, track.fov),
        floor_clip=-0.004 if scene.floor and lowest > -0.25 else -1e9,
        owned=owned,
    )


def _figures(graphics: GraphicsContext, actor: Actor, times: np.ndarray) -> list[tuple[Figure, np.ndarray]]:
    """The actor's bodies, each with the points (N, P, 3) it and its ghosts reach at each moment."""
    colour = hex_to_rgb(actor.colour) if actor.colour else None
    wanted = []
    if actor.show in ("body", "both"):
        wanted.append((*_dressed(actor.motion, actor.body), 1.0 if actor.show == "body" else 0.5))
    if actor.show in ("skeleton", "both"):
        wanted.append((*_dressed(actor.motion, "stick"), 1.0))
    made = []
    for body, motion, alpha in wanted:
        played = _play(body, motion, times, actor.offset)
        uploaded = mesh(graphics, body, colour)
        figure = Figure(uploaded, Poses(graphics, played.matrices, uploaded.rows), alpha)
        seen = played.positions
        if actor.ghosts:
            seen = _add_ghosts(graphics, figure, (actor, motion, body), times, seen)
        made.append((figure, seen))
    if len(made) > 1:
        made[1][0].casts_shadow = False
    return made


def _add_ghosts(
    graphics: GraphicsContext, figure: Figure, who: tuple[Actor, Motion, Body], times: np.ndarray, seen: np.ndarray
) -> np.ndarray:
    """Give a figure its ghosts; returns `seen` with the points of those visible at each moment."""
    actor, motion, body = who
    step = max(actor.ghosts, -(-len(motion) // GHOST_LIMIT))
    frames = np.arange(0, len(motion), step)
    still = _play(body, motion, frames / motion.fps, actor.offset)
    figure.ghost_poses = Poses(graphics, still.matrices, figure.mesh.rows)
    figure.ghosts = [_visible_ghosts(frames / motion.fps, float(now), actor.ghost_count) for now in times]
    low = np.array(
        [
            [still.positions[[g.pose for g in now]].min((0, 1)) if now else at.min(0)]
            for now, at in zip(figure.ghosts, seen, strict=True)
        ]
    )
    high = np.array(
        [
            [still.positions[[g.pose for g in now]].max((0, 1)) if now else at.max(0)]
            for now, at in zip(figure.ghosts, seen, strict=True)
        ]
    )
    corners = np.array(np.meshgrid([0, 1], [0, 1], [0, 1])).reshape(3, -1).T
    return np.concatenate([seen, low + corners * (high - low)], axis=1)


def _visible_ghosts(moments: np.ndarray, now: float, count: int | None) -> list[Ghost]:
    """Which ghosts are seen now, the faintest first."""
    if count is None:
        order = np.argsort(-np.abs(moments - now), kind="stable")
        order = order[np.abs(moments[order] - now) > 1e-3]
    else:
        order = np.flatnonzero(moments < now - 1e-3)[-count:] if count else np.array([], int)
    total = len(order)
    return [
        Ghost(int(pose), 0.55 if rank > 0.3 * total else 0.3, 0.25 + 0.45 * (1 - (rank + 1) / total))
        for rank, pose in enumerate(order)
    ]


def _play(body: Body, motion: Motion, times: np.ndarray, offset: tuple[float, float, float]) -> _Played:
    turns, path = sample(motion, times)
    local = rotations.quaternion_to_matrix(turns)
    places, world = kinematics.forward_kinematics(
        local, path + np.asarray(offset), motion.skeleton.offsets, motion.skeleton.parents
    )
    return _Played(body, places, world)


@lru_cache(maxsize=64)
def _dressed(motion: Motion, body: str | Body) -> tuple[Body, Motion]:
    """`bodies.body_for`, remembered: retargeting takes a while and stills ask for the same motion again and again."""
    return bodies.body_for(motion, body)


def _shadow_areas(points: np.ndarray, light: np.ndarray) -> np.ndarray:
    """(N, 4) floor squares of one size that hold the shadow of points (N, P, 3) at each moment."""
    slant = light[[0, 2]] / light[1]
    places = points[..., [0, 2]] - np.maximum(points[..., 1:2], 0.0) * slant
    low, high = places.min(1), places.max(1)
    half = float((high - low).max()) / 2 + REACH + 0.2
    area = np.zeros((len(points), 4))
    area[:, :2] = (low + high) / 2
    area[:, 2] = 1.0 / half
    return area


def _boxes(points: list[np.ndarray], matrices: np.ndarray, size: tuple[int, int], fov: float) -> np.ndarray:
    """(N, 4) pixel rectangles around points (N, P, 3), with room for the skin around the joints."""
    low, high = np.full((len(matrices), 2), np.inf), np.full((len(matrices), 2), -np.inf)
    for group in points:
        clip = np.einsum("nab,npb->npa", matrices[:, :3], np.pad(group, ((0, 0), (0, 0), (0, 1)), constant_values=1.0))
        depth = np.einsum("nb,npb->np", matrices[:, 3], np.pad(group, ((0, 0), (0, 0), (0, 1)), constant_values=1.0))
        depth = np.maximum(depth, 0.05)[..., None]
        room = REACH / np.tan(fov / 2) / depth * np.array([size[1] / size[0], 1.0])
        low = np.minimum(low, (clip[..., :2] / depth - room).min(1))
        high = np.maximum(high, (clip[..., :2] / depth + room).max(1))
    pixels = np.array(size)
    first = np.floor((np.clip(low, -1, 1) + 1) / 2 * pixels)
    last = np.ceil((np.clip(high, -1, 1) + 1) / 2 * pixels)
    return np.concatenate([first, np.maximum(last - first, 1)], axis=1).astype(int)
