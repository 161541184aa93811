"""How Action2Motion sees a Motion: local poses and root velocities, free of where the body stands and faces.

A pose is taken relative to the root and to the body's heading (the yaw of its root), so that a step to the north and
the same step to the east are one to the networks; the way it travels is three numbers a frame, `velocity`: sideways,
forward and turning. The thesis feeds poses relative to the first root and predicts relative root translations (section
3.2.1); leaving the heading out as well is ours.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from engines.geometry import planes, rotations
from engines.motion import Motion
from engines.skeletons import SMPL22

VELOCITY_SIZE = 3
"""x and z in metres a frame along the previous frame's heading, and yaw in radians a frame."""


@dataclass(frozen=True)
class Features:
    """A Motion as arrays; T frames, J joints."""

    height: Float[np.ndarray, "T 1"]
    """(T, 1) root height, metres."""
    lie: Float[np.ndarray, "T J 3"]
    """(T, J, 3) axis-angle, radians; the root's is what remains of it after its yaw is taken out."""
    matrices: Float[np.ndarray, "T J 3 3"]
    """(T, J, 3, 3) the same rotations as matrices."""
    positions: Float[np.ndarray, "T J 3"]
    """(T, J, 3) joints in the heading frame, above the origin, metres."""
    velocity: Float[np.ndarray, "T 3"]
    """(T, 3) step from the frame before; zero for the first."""
    contacts: Float[np.ndarray, "T 4"]
    """(T, 4) left ankle, left toe, right ankle, right toe stand still: 0 or 1."""


def root_yaw(root_matrix: Float[np.ndarray, "T 3 3"]) -> Float[np.ndarray, " T"]:
    """(T,) yaw of root rotations (T, 3, 3): the heading of its z axis, or of -y where the body is bent double."""
    forward = root_matrix[:, :, 2]
    folded = np.hypot(forward[:, 0], forward[:, 2]) < 0.3
    ahead = np.where(folded[:, None], -np.sign(forward[:, 1:2]) * root_matrix[:, :, 1], forward)
    return np.unwrap(np.arctan2(ahead[:, 0], ahead[:, 2]))


def encode(motion: Motion) -> Features:
    """A Motion on smpl22 as the networks see it, at the motion's own rate."""
    yaw = root_yaw(motion.global_rotations[:, 0])
    back = rotations.yaw_quaternion(-yaw)
    turns = np.array(motion.rotations)
    turns[:, 0] = rotations.multiply(back, turns[:, 0])
    path = motion.positions[:, 0]
    local = motion.positions - path[:, None] * np.array([1.0, 0.0, 1.0])
    step = rotations.rotate(back[:-1], np.diff(path, axis=0))
    velocity = np.zeros((len(motion), VELOCITY_SIZE))
    velocity[1:, 0], velocity[1:, 1], velocity[1:, 2] = step[:, 0], step[:, 2], np.diff(yaw)
    return Features(
        height=path[:, 1:2].astype(np.float32),
        lie=rotations.quaternion_to_rotvec(turns).astype(np.float32),
        matrices=rotations.quaternion_to_matrix(turns).astype(np.float32),
        positions=rotations.rotate(back[:, None], local).astype(np.float32),
        velocity=velocity.astype(np.float32),
        contacts=motion.contacts.reshape(len(motion), -1).astype(np.float32),  # (T, 2, 2) -> (T, 4)
    )


def local_positions(
    height: Float[Tensor, "*batch 1"], lie: Float[Tensor, "*batch J 3"]
) -> tuple[Float[Tensor, "*batch J 3"], Float[Tensor, "*batch J 3 3"]]:
    """Joints (..., J, 3) in the heading frame and local rotations (..., J, 3, 3).

    One forward kinematics over all frames of all sequences (thesis eq. 3.4, the map Gamma).

    Args:
        height: (..., 1) of the root, metres.
        lie: (..., J, 3) so(3) parameters, radians.
    """
    offsets = torch.tensor(SMPL22.offsets, dtype=lie.dtype, device=lie.device)
    positions, matrices = planes.forward_kinematics(lie, offsets, SMPL22.parents)
    return positions + torch.nn.functional.pad(height, (1, 1))[..., None, :], matrices


def decode(
    height: Float[np.ndarray, "T 1"], matrices: Float[np.ndarray, "T J 3 3"], velocity: Float[np.ndarray, "T 3"]
) -> tuple[Float[np.ndarray, "T J 4"], Float[np.ndarray, "T 3"]]:
    """Quaternions (T, J, 4) and root path (T, 3) of the world from what the networks predict.

    Args:
        height: (T, 1) of the root, metres.
        matrices: (T, J, 3, 3) local rotations, the root's without yaw.
        velocity: (T, 3) as in `Features`.
    """
    yaw, ground = travel(velocity)
    turns = rotations.matrix_to_quaternion(matrices)
    turns[:, 0] = rotations.multiply(rotations.yaw_quaternion(yaw), turns[:, 0])
    path = np.stack([ground[:, 0], height[:, 0], ground[:, 1]], axis=-1)
    return rotations.continuous(turns), path


def travel(
    velocity: Float[np.ndarray, "T *batch 3"],
) -> tuple[Float[np.ndarray, " T *batch"], Float[np.ndarray, "T *batch 2"]]:
    """Yaw (T, ...) and ground path (T, ..., 2) as x, z, summed up from velocities (T, ..., 3)."""
    velocity = np.asarray(velocity, dtype=np.float64)
    yaw = np.cumsum(velocity[..., 2], axis=0)
    before = np.concatenate([np.zeros_like(yaw[:1]), yaw[:-1]])
    cos, sin = np.cos(before), np.sin(before)
    x, z = velocity[..., 0], velocity[..., 1]
    return yaw, np.cumsum(np.stack([cos * x + sin * z, -sin * x + cos * z], axis=-1), axis=0)


def world_step(positions: Float[Tensor, "T B J 3"], velocity: Float[Tensor, "T B 3"]) -> Float[Tensor, "T-1 B J 3"]:
    """How far joints move over the ground from frame to frame, in the frame of the earlier heading.

    Args:
        positions: (T, B, J, 3) in the heading frame.
        velocity: (T, B, 3) as in `Features`.

    Returns:
        (T - 1, B, J, 3) metres.
    """
    now, step = positions[1:], velocity[1:, :, None]  # (T - 1, B, J, 3), (T - 1, B, 1, 3)
    cos, sin = torch.cos(step[..., 2]), torch.sin(step[..., 2])
    x = cos * now[..., 0] + sin * now[..., 2] + step[..., 0]
    z = -sin * now[..., 0] + cos * now[..., 2] + step[..., 1]
    return torch.stack([x, now[..., 1], z], dim=-1) - positions[:-1]
