"""Made-up movement for the tests of representations."""

from __future__ import annotations

import numpy as np

from engines.geometry import rotations
from engines.motion import Motion
from engines.skeletons import SMPL22


def swinging(seed: int, frames: int = 24, turning: float = 0.0, fps: float = 20.0) -> Motion:
    """All joints swing, none past 140 degrees; the body walks a winding path and turns by `turning` radians a frame."""
    rng = np.random.default_rng(seed)
    time = np.arange(frames)[:, None, None] / fps
    swing = rng.uniform(-0.9, 0.9, (22, 3)) * np.sin(time * rng.uniform(1, 6, (22, 1)) + rng.uniform(0, 6, (22, 1)))
    turns = rotations.rotvec_to_quaternion(swing)
    yaw = rng.uniform(-3, 3) + turning * np.arange(frames)
    turns[:, 0] = rotations.multiply(rotations.yaw_quaternion(yaw), turns[:, 0])
    path = np.stack([np.sin(time[:, 0, 0]), 0.9 + 0.1 * np.cos(3 * time[:, 0, 0]), 1.2 * time[:, 0, 0]], axis=-1)
    return Motion(SMPL22, turns, path + rng.normal(size=3) * [3, 0, 3], fps)


def spinning(frames: int, rate: float, begin: float = 0.0) -> Motion:
    """The rest pose, turning on the spot by `rate` radians a frame."""
    turns = np.tile(rotations.IDENTITY, (frames, 22, 1))
    turns[:, 0] = rotations.yaw_quaternion(begin + rate * np.arange(frames))
    return Motion(SMPL22, turns, np.tile([0.0, 0.93, 0.0], (frames, 1)), 20.0)


def stepping(frames: int = 60) -> Motion:
    """The rest pose on the floor, lifting one knee after the other while it stands on the other foot."""
    lift = np.sin(np.arange(frames) / frames * 4 * np.pi)
    swing = np.zeros((frames, 22, 3))
    for side, up in (("left", lift), ("right", -lift)):
        swing[:, SMPL22.index(f"{side}_hip"), 0] = -np.maximum(up, 0)
        swing[:, SMPL22.index(f"{side}_knee"), 0] = np.maximum(up, 0)
    height = -SMPL22.rest_positions[:, 1].min()
    return Motion(SMPL22, rotations.rotvec_to_quaternion(swing), np.tile([0, height, 0], (frames, 1)), 20.0)


def apart(found: Motion, wanted: Motion) -> float:
    """Largest distance of a joint, metres."""
    return float(np.linalg.norm(found.positions - wanted.positions, axis=-1).max())


def turned(found: Motion, wanted: Motion) -> np.ndarray:
    """(J,) largest angle between the joints' rotations, radians."""
    off = rotations.multiply(rotations.invert(found.rotations), wanted.rotations)
    return rotations.angle(off).max(axis=0)
