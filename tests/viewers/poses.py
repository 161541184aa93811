"""Motions made by hand, for pictures."""

from __future__ import annotations

import numpy as np

from engines.geometry import rotations
from engines.motion import Motion
from engines.skeletons import SMPL22

ANKLE, TOE = 0.0772, 0.0277
"""How high smpl22's ankles and toes stand above the sole, metres."""


def both(joint: str, x: float, y: float, z: float) -> dict[str, tuple[float, float, float]]:
    """The same turn on both sides, degrees as a rotation vector of the left one."""
    return {f"left_{joint}": (x, y, z), f"right_{joint}": (x, -y, -z)}


def pose(frames: int = 1, **turns: tuple[float, float, float]) -> Motion:
    """A motion that holds one pose, its lowest sole on the floor; rotation vectors in degrees by joint."""
    quaternions = np.tile(rotations.IDENTITY, (frames, len(SMPL22), 1))
    for joint, turn in turns.items():
        quaternions[:, SMPL22.index(joint)] = rotations.rotvec_to_quaternion(np.radians(turn))
    motion = Motion(SMPL22, quaternions, np.zeros((frames, 3)), 20.0)
    soles = [
        motion.positions[0, SMPL22.index(f"{side}_{joint}"), 1] - above
        for side in ("left", "right")
        for joint, above in (("ankle", ANKLE), ("foot", TOE))
    ]
    return motion.moved((0.0, -min(soles), 0.0))


def t_pose() -> Motion:
    return pose()


def stand() -> Motion:
    return pose(**both("shoulder", 0, 0, -72), **both("elbow", 0, -12, 0))


def squat() -> Motion:
    return pose(
        pelvis=(20, 0, 0), spine1=(15, 0, 0), **both("hip", -115, 0, 18), **both("knee", 130, 0, 0),
        **both("ankle", -28, 0, 0), **both("shoulder", 0, -80, 0),
    )  # fmt: skip


def arms_up() -> Motion:
    return pose(**both("shoulder", 0, 0, 75), **both("collar", 0, 0, 15))


def seated() -> Motion:
    return pose(
        **both("hip", -88, 0, 0), **both("knee", 88, 0, 0), **both("shoulder", 0, 0, -75), **both("elbow", 0, -60, 0)
    )


def stride(frames: int = 40, speed: float = 1.2) -> Motion:
    """Walking along +Z with swinging limbs, at 20 fps."""
    time = np.arange(frames) / 20.0
    still = stand()
    quaternions = np.repeat(still.rotations, frames, axis=0)
    for side, sign in (("left", 1.0), ("right", -1.0)):
        swing = sign * np.sin(2 * np.pi * time)
        bend = 0.5 + 0.45 * np.sin(2 * np.pi * time + sign * np.pi / 2 - np.pi / 2)
        for joint, angle in (("hip", -0.5 * swing), ("knee", bend)):
            turn = np.stack([angle, 0 * angle, 0 * angle], axis=-1)
            quaternions[:, SMPL22.index(f"{side}_{joint}")] = rotations.rotvec_to_quaternion(turn)
    path = np.tile(still.translation, (frames, 1))
    path[:, 2] = speed * time
    return Motion(SMPL22, quaternions, path, 20.0)
