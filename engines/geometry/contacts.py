"""Which foot joints stand on the ground."""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float

from engines.skeletons.skeleton import Skeleton

SPEED_LIMIT = 0.35
"""A joint slower than this, in m/s, may be in contact."""
HEIGHT_MARGIN = 0.06
"""... if it is also no higher than this above where that joint stands, in metres."""


def joint_speed(positions: Float[np.ndarray, "T *points D"], fps: float) -> Float[np.ndarray, " T *points"]:
    """Speed (T, ...), m/s, of points (T, ..., D) of D axes: the mean over the steps before and after each frame."""
    if len(positions) < 2:
        return np.zeros(positions.shape[:-1])
    step = np.linalg.norm(np.diff(positions, axis=0), axis=-1) * fps
    padded = np.concatenate([step[:1], step, step[-1:]])
    return (padded[:-1] + padded[1:]) / 2


def detect(positions: Float[np.ndarray, "T J 3"], fps: float, skeleton: Skeleton) -> Bool[np.ndarray, "T feet 2"]:
    """Contacts (T, feet, 2) of ankle and toe, by low speed and low height.

    A joint's standing height is its own 5th percentile over the motion, at most the skeleton's rest height above
    the floor y = 0, so that a clip that never lands (a hang, a handstand) has no contacts made up for it.

    Args:
        positions: (T, J, 3), metres, Y up.
        fps: frames a second.
        skeleton: gives the feet; one without feet has contacts of shape (T, 0, 2).
    """
    joints = [skeleton.index(name) for foot in skeleton.feet for name in foot]
    if not joints:
        return np.zeros((len(positions), 0, 2), dtype=bool)
    feet = positions[:, joints]
    rest = skeleton.rest_positions[joints, 1] - skeleton.rest_positions[:, 1].min()
    standing = np.minimum(np.percentile(feet[..., 1], 5, axis=0), rest + 0.03)
    low = feet[..., 1] < standing + HEIGHT_MARGIN
    slow = joint_speed(feet, fps) < SPEED_LIMIT
    return (low & slow).reshape(len(positions), len(skeleton.feet), 2)  # (T, feet * 2) -> (T, feet, 2)
