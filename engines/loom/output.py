"""From the model's features to Motions, and how well they hold to what was pinned."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from torch import Tensor

from engines.geometry.resample import count
from engines.loom.constraints import Constraints, Known, words
from engines.loom.footing import on_feet
from engines.loom.representation import decode
from engines.motion import Motion, Segment
from engines.skeletons import SMPL22

if TYPE_CHECKING:
    from engines.loom.passes import Request

_NEAR = {"pin": 0.08, "path": 0.15}
"""Metres within which a pinned joint or a path counts as met."""


def to_motions(features: Tensor, frames: int, fps: float, known: list[Known] | None) -> list[Motion]:
    """Motions, going by their feet, from features (B, T, D), not normalised; in the world, where the start is known."""
    made = []
    for row, held in enumerate(features.numpy()):
        told = None if known is None else known[row]
        turns, path = decode(on_feet(held[:frames]), None if told is None else told.held[:frames])
        motion = Motion(SMPL22, turns, path, fps)
        if told is not None:
            x, z = (float(value) for value in told.start.ground)
            motion = motion.moved((x, 0.0, z), yaw=float(told.start.yaw))
        made.append(motion)
    return made


def best(motions: list[Motion], best_of: int) -> list[Motion]:
    """Of every `best_of` the one whose feet slide and whose joints jerk least."""
    if best_of == 1:
        return motions
    from engines.metrics import physical

    def cost(motion: Motion) -> float:
        found = physical.summary(motion)
        return found["foot_skate"] / 0.05 + found["jitter"] / 80.0 + found["ground_penetration"] / 0.01

    return [min(motions[i : i + best_of], key=cost) for i in range(0, len(motions), best_of)]


def exact(motion: Motion, constraints: Constraints) -> Motion:
    """The motion with its kept frames just as they were given, to the last bit, where all of the body is kept."""
    turns, path = np.array(motion.rotations), np.array(motion.translation)
    for keep in constraints.kept:
        if keep.parts or not keep.placed:
            continue
        house = keep.motion.retarget(SMPL22)
        house = house if len(house) == 1 else house.resample(motion.fps)
        end = min(len(motion), keep.at + len(house))
        rows = slice(keep.at, end)
        given = np.array(house.rotations[: end - keep.at])
        flip = (given * turns[rows]).sum(-1, keepdims=True) < 0  # the same rotation has two quaternions
        turns[rows] = np.where(flip, -given, given)
        path[rows] = house.translation[: end - keep.at]
    return motion.replaced(rotations=turns, translation=path)


def unmet(motion: Motion, constraints: Constraints) -> list[str]:
    """What of the constraints a motion does not hold to, in words."""
    said = []
    for pin in constraints.pins:
        rows = slice(pin.frame, pin.until or pin.frame + 1)
        gap = np.linalg.norm(motion.positions[rows, SMPL22.index(pin.joint)] - np.array(pin.position), axis=-1).max()
        if gap > _NEAR["pin"]:
            said.append(f"{words(pin.joint)} at frame {pin.frame} is {100 * gap:.0f} cm from its place.")
    if constraints.path is not None:
        points = np.asarray(constraints.path.points, dtype=np.float64)
        fine = np.concatenate([np.linspace(a, b, 50) for a, b in itertools.pairwise(points)])
        root = motion.positions[:, 0, [0, 2]]
        gap = np.linalg.norm(root[:, None] - fine, axis=-1).min(axis=1).max()
        if gap > _NEAR["path"]:
            said.append(f"The body leaves the path by up to {100 * gap:.0f} cm.")
    return said


def labels(segments: Sequence[tuple[Request, int]], pinned: Constraints, fps: float) -> tuple[Segment, ...]:
    """What is done when; what a motion goes on from keeps its own name."""
    given = [keep for keep in pinned.kept if keep.at == 0 and keep.placed and not keep.parts and len(keep.motion) > 1]
    begun = max((count(len(keep.motion), keep.motion.fps, fps) for keep in given), default=0)
    found = [Segment(0, begun, "action", given[0].motion.label_at(0) or "given")] if begun else []
    at = 0
    for request, frames in segments:
        start, end = max(at, begun), at + frames
        for kind, value in (("action", request.action), ("style", request.style), ("text", request.prompt)):
            if value and start < end:
                found.append(Segment(start, end, kind, value))  # type: ignore[arg-type]
        at = end
    return tuple(found)
