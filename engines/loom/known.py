"""What training windows are told of themselves beforehand: poses, paths, joints and parts of the body, at random.

At sampling the same masks come from what a person pins (`engines.loom.constraints`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from engines.skeletons import SMPL22

JOINTS = len(SMPL22)
_UPPER = ("spine1", "spine2", "spine3", "neck", "head", "left_collar", "right_collar", "left_shoulder",
          "right_shoulder", "left_elbow", "right_elbow", "left_wrist", "right_wrist")  # fmt: skip
PARTS: dict[str, tuple[int, ...]] = {
    "upper body": tuple(SMPL22.index(name) for name in _UPPER),
    "lower body": tuple(i for i, name in enumerate(SMPL22.joints) if name not in _UPPER),
    "left arm": tuple(SMPL22.index(f"left_{name}") for name in ("collar", "shoulder", "elbow", "wrist")),
    "right arm": tuple(SMPL22.index(f"right_{name}") for name in ("collar", "shoulder", "elbow", "wrist")),
    "head": tuple(SMPL22.index(name) for name in ("neck", "head")),
}
"""Parts of the body: joints whose rotations make it up. The legs' includes the root."""
_PINNED = tuple(SMPL22.index(name) for name in (
    "left_wrist", "right_wrist", "left_ankle", "right_ankle", "head", "left_wrist", "right_wrist",
))  # fmt: skip


@dataclass
class Masks:
    """Which facts of B windows of T frames are known."""

    turns: np.ndarray
    """(B, T, J) bool."""
    height: np.ndarray
    """(B, T) bool."""
    ground: np.ndarray
    """(B, T) bool."""
    facing: np.ndarray
    """(B, T) bool."""
    joints: np.ndarray
    """(B, T, J - 1) bool; all joints but the root."""

    @classmethod
    def nothing(cls, count: int, frames: int) -> Masks:
        """No fact known."""

        def none(*more: int) -> np.ndarray:
            return np.zeros((count, frames, *more), dtype=bool)

        return cls(none(JOINTS), none(), none(), none(), none(JOINTS - 1))

    def pose(self, row: int, frames: slice | np.ndarray, placed: bool = True) -> None:
        """Whole poses are known, and where they stand and face."""
        self.turns[row, frames] = True
        self.height[row, frames] = True
        if placed:
            self.ground[row, frames] = True
            self.facing[row, frames] = True


def draw(rng: np.random.Generator, lengths: np.ndarray, frames: int, share: float) -> Masks:
    """Random masks for windows of `lengths` frames, padded to `frames`; a share of windows has any."""
    masks = Masks.nothing(len(lengths), frames)
    for row in np.flatnonzero(rng.random(len(lengths)) < share):
        length = int(lengths[row])
        if length >= 8:
            _KINDS[int(rng.choice(len(_KINDS), p=_CHANCES))](rng, masks, int(row), length)
    return masks


def _beginning(rng: np.random.Generator, masks: Masks, row: int, length: int) -> None:
    masks.pose(row, slice(0, int(rng.integers(1, min(40, length // 2) + 1))))
    if rng.random() < 0.3:
        _path(rng, masks, row, length)


def _ends(rng: np.random.Generator, masks: Masks, row: int, length: int) -> None:
    masks.pose(row, slice(0, int(rng.integers(1, 11))))
    masks.pose(row, slice(length - int(rng.integers(1, 11)), length), placed=rng.random() < 0.8)


def _keys(rng: np.random.Generator, masks: Masks, row: int, length: int) -> None:
    placed = rng.random() < 0.6
    for frame in rng.choice(length, size=int(rng.integers(1, 5)), replace=False):
        masks.pose(row, np.array([frame]), placed)


def _path(rng: np.random.Generator, masks: Masks, row: int, length: int) -> None:
    at: slice | np.ndarray = slice(0, length)
    if rng.random() < 0.4:  # waypoints
        at = rng.choice(length, size=int(rng.integers(1, 7)), replace=False)
    masks.ground[row, at] = True
    if rng.random() < 0.4:
        masks.facing[row, at] = True


def _joints(rng: np.random.Generator, masks: Masks, row: int, length: int) -> None:
    for joint in rng.choice(_PINNED, size=int(rng.integers(1, 4)), replace=False):
        if rng.random() < 0.3:
            begin = int(rng.integers(0, length))
            at: slice | np.ndarray = slice(begin, begin + int(rng.integers(1, 40)))
        else:
            at = rng.choice(length, size=min(length, int(rng.integers(1, 7))), replace=False)
        masks.joints[row, at, joint - 1] = True
    masks.joints[row, length:] = False


def _parts(rng: np.random.Generator, masks: Masks, row: int, length: int) -> None:
    name = rng.choice(list(PARTS), p=[0.2, 0.4, 0.15, 0.15, 0.1])
    kept = rng.random() < 0.75  # the part is known, or else all but the part
    joints = PARTS[str(name)] if kept else [i for i in range(JOINTS) if i not in PARTS[str(name)]]
    masks.turns[row, :length, joints] = True
    if 0 in joints:
        masks.height[row, :length] = masks.ground[row, :length] = masks.facing[row, :length] = True


_KINDS = (_beginning, _ends, _keys, _path, _joints, _parts)
_CHANCES = (0.25, 0.17, 0.15, 0.18, 0.12, 0.13)
