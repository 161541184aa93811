"""Bodies at play, with no graphics API: which bodies an actor wears, where their joints are, which ghosts show."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from engines.geometry import kinematics, rotations
from engines.motion import Motion
from viewers import bodies
from viewers.bodies.body import Body
from viewers.scene import Actor, Scene, sample

GHOST_LIMIT = 48
"""So many ghosts of one actor at most; with more the interval grows."""
VEIL = 0.5
"""How much of what is behind it a skin covers when the skeleton is to be seen through it."""


@dataclass
class Worn:
    """A body of an actor and the motion as that body plays it."""

    body: Body
    motion: Motion
    alpha: float
    """How much of what is behind it the body covers."""


@dataclass
class Played:
    """A body and what it does at each of N moments, in the scene's world."""

    body: Body
    positions: np.ndarray
    """(N, J, 3) metres."""
    turns: np.ndarray
    """(N, J, 3, 3) global rotations."""

    @property
    def matrices(self) -> np.ndarray:
        """(N, J, 3, 4) skinning matrices."""
        return bodies.skinning_matrices(self.body.skeleton, self.positions, self.turns)


@dataclass
class Ghost:
    """One onion skin as it looks at one moment."""

    pose: int
    """Which of the ghost poses."""
    alpha: float
    """How much of it covers what is behind."""
    fade: float
    """How far its colours have faded into the backdrop."""


def worn(actor: Actor) -> list[Worn]:
    """The bodies that show an actor: skin, stick figure, or both."""
    made = []
    if actor.show in ("body", "both"):
        made.append(Worn(*dressed(actor.motion, actor.body), 1.0 if actor.show == "body" else VEIL))
    if actor.show in ("skeleton", "both"):
        made.append(Worn(*dressed(actor.motion, "stick"), 1.0))
    return made


def at_home(scene: Scene) -> Scene:
    """The scene with motions as bodies with bones of their own play them, so that marks and cameras see these too."""
    return scene.replaced(actors=tuple(_at_home(actor) for actor in scene.actors))


def _at_home(actor: Actor) -> Actor:
    if actor.body in ("anny", "stick"):
        return actor
    body, motion = dressed(actor.motion, actor.body)
    return actor.replaced(body=body, motion=motion) if body.own_bones else actor


@lru_cache(maxsize=64)
def dressed(motion: Motion, body: str | Body) -> tuple[Body, Motion]:
    """`bodies.body_for`, remembered: retargeting takes a while and stills ask for the same motion again and again."""
    return bodies.body_for(motion, body)


def play(body: Body, motion: Motion, times: np.ndarray, offset: tuple[float, float, float]) -> Played:
    """A motion on a body at `times` (N,) seconds, shifted by `offset` metres."""
    turns, path = sample(motion, times)
    local = rotations.quaternion_to_matrix(turns)
    places, world = kinematics.forward_kinematics(
        local, path + np.asarray(offset), motion.skeleton.offsets, motion.skeleton.parents
    )
    return Played(body, np.asarray(places), np.asarray(world))


def ghost_frames(motion: Motion, step: int) -> np.ndarray:
    """(M,) frames at which ghosts stand, every `step` or as many more as keep them below the limit."""
    return np.arange(0, len(motion), max(step, -(-len(motion) // GHOST_LIMIT)))


def visible_ghosts(moments: np.ndarray, now: float, count: int | None) -> list[Ghost]:
    """Which ghosts are seen now, the faintest first.

    Args:
        moments: (M,) seconds at which ghosts stand.
        now: seconds.
        count: so many of the latest; None for all, also those to come.
    """
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
