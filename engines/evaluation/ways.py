"""The simple ways to get from one action into the next, beside which MultiAct is judged.

All have Action2Motion perform the actions, each by itself: the paper's "ACTOR + interpolation". The clips are turned
and set down behind each other (the paper's "with align"), else nobody would compare anything but that.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from engines.features.smplh import SMPLH_HOUSE
from engines.geometry import rotations, seams
from engines.motion import Motion, Segment
from engines.multiact.triplets import behind
from engines.skeletons import SMPL22

SECONDS = 0.5
"""Of a transition."""

Blocks = Sequence[tuple[str, float]]
"""(action, seconds)."""
Join = Callable[[Motion, Motion, int], Motion]
"""(what there is, a clip, frames of the transition) -> both, and between them the transition."""


class Way:
    """A row of the table.

    Args:
        engine: performs actions.
        variant: name of the way.
        join: how it gets from clip to clip; the engine's own switch of labels if none.
    """

    name = "action2motion"
    capabilities = frozenset({"actions", "sequences"})

    def __init__(self, engine: Any, variant: str, join: Join | None) -> None:
        self.engine, self.variant, self.join = engine, variant, join
        self.actions, self.licence, self.weights_hash = engine.actions, engine.licence, engine.weights_hash

    def sequence(self, blocks: Blocks, seed: int = 0) -> Motion:
        """As `MultiActEngine.sequence`: a block's seconds have the transition into it."""
        lengths = [round(seconds * self.engine.fps) for _, seconds in blocks]
        names = [name for name, _ in blocks]
        between = round(SECONDS * self.engine.fps)
        if self.join is None:
            made = self.engine.transition(list(zip(names, lengths, strict=True)), seed=seed)
        else:
            made = self.engine.generate(names[0], lengths[0], seed)
            for place, (name, frames) in enumerate(zip(names[1:], lengths[1:], strict=True), start=1):
                clip = self.engine.generate(name, frames, (seed + place) % 2**63)
                made = self.join(made, clip, between)
        return made.replaced(labels=_labels(names, lengths, between))


def ways(engine: Any) -> dict[str, Way]:
    """All of them by the names of their rows.

    Args:
        engine: `engines.load("action2motion")`.
    """
    joins: dict[str, Join | None] = {
        "linear": _linear, "slerp": _slerp, "inertialised": _inertialised, "label switch": None,
    }  # fmt: skip
    return {f"action2motion, {name}": Way(engine, name, join) for name, join in joins.items()}


def _labels(names: Sequence[str], lengths: Sequence[int], between: int) -> tuple[Segment, ...]:
    ends = np.cumsum([0, *lengths]).tolist()
    made = [Segment(0, ends[1], "action", names[0])]
    for i in range(1, len(names)):
        seam = ends[i] + min(between, lengths[i] // 2)
        made.append(Segment(ends[i], seam, "transition", f"{names[i - 1]} > {names[i]}"))
        made.append(Segment(seam, ends[i + 1], "action", names[i]))
    return tuple(made)


def _inertialised(before: Motion, clip: Motion, frames: int) -> Motion:
    return seams.join(before, behind(before[-2:], clip), frames / before.fps)


def _linear(before: Motion, clip: Motion, frames: int) -> Motion:
    """Between the features of both poses: 6-D and places."""
    last, first, rest = _apart(before, clip, frames)
    here, there = (SMPLH_HOUSE.encode_arrays(pose.rotations, pose.translation)[0] for pose in (last, first))
    values = here + _shares(frames)[:, None] * (there - here)
    return before.concat(SMPLH_HOUSE.decode(values.astype(np.float32), source="rotations"), rest)


def _slerp(before: Motion, clip: Motion, frames: int) -> Motion:
    """Along the arcs between the rotations of both poses, and straight from place to place."""
    last, first, rest = _apart(before, clip, frames)
    share = _shares(frames)
    turns = rotations.slerp(np.array([0.0, 1.0]), np.concatenate([last.rotations, first.rotations]), share)
    path = last.translation + share[:, None] * (first.translation - last.translation)
    return before.concat(Motion(SMPL22, turns, path, before.fps), rest)


def _shares(frames: int) -> np.ndarray:
    return np.arange(1, frames + 1) / (frames + 1)


def _apart(before: Motion, clip: Motion, frames: int) -> tuple[Motion, Motion, Motion]:
    """The last pose, the first of the clip so many frames further on at the same speed, and the clip from there on."""
    step = before.translation[-1] - before.translation[-2]
    placed = behind(before[-2:], clip[frames:]).moved((float(frames * step[0]), 0.0, float(frames * step[2])))
    return before[-1:], placed[:1], placed
