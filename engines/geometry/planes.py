"""Rotations of many bodies with the components in front, (3, 3, J, N), for torch.

Products of many 3 x 3 matrices cost far more than their arithmetic. Laid out as nine planes over joints and bodies,
every operation runs over long rows: `benchmarks/action2motion.py` has the factor. Values equal those of
`engines.geometry.kinematics`, which takes any layout and NumPy as well.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import pairwise

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from engines.geometry.kinematics import depth_levels


def exp(rotvec: Float[Tensor, " 3 *many"], smallest: float = 1e-8) -> Float[Tensor, "3 3 *many"]:
    """Rodrigues' formula (thesis eq. 3.2): rotation vectors (3, ...), radians -> matrices (3, 3, ...).

    Args:
        rotvec: components in front.
        smallest: floor of the squared angle that is divided by; the default changes no float32 result.
    """
    x, y, z = rotvec
    xx, yy, zz = x * x, y * y, z * z
    angle = (xx + yy + zz).clamp(min=smallest).sqrt()
    inverse = 1 / angle
    first, second = inverse * torch.sin(angle), inverse * inverse * (1 - torch.cos(angle))
    ax, ay, az = first * x, first * y, first * z
    bxy, bxz, byz = second * (x * y), second * (x * z), second * (y * z)
    planes = [
        1 - second * (yy + zz), bxy - az, bxz + ay,
        bxy + az, 1 - second * (xx + zz), byz - ax,
        bxz - ay, byz + ax, 1 - second * (xx + yy),
    ]  # fmt: skip
    return torch.stack(planes).unflatten(0, (3, 3))  # (9, ...) -> (3, 3, ...)


def world(local: Float[Tensor, "3 3 J N"], parents: tuple[int, ...]) -> Float[Tensor, "3 3 J N"]:
    """Parent-relative rotations (3, 3, J, N) accumulated from the root, same shape, a level of the tree at a time."""
    above, order = _plan(parents)
    worlds = [local[:, :, :1]]
    for rows, level in zip(above, depth_levels(parents)[1:], strict=True):
        upper, turns = worlds[-1][:, :, rows], local[:, :, list(level)]
        products = [upper[:, k, None] * turns[None, k] for k in range(3)]
        worlds.append(products[0] + products[1] + products[2])
    return torch.cat(worlds, dim=2)[:, :, order]


def turn(matrices: Float[Tensor, "3 3 J N"], vectors: Float[Tensor, "3 J #N"]) -> Float[Tensor, "3 J N"]:
    """Matrices (3, 3, J, N) times vectors (3, J, N) or (3, J, 1) -> (3, J, N)."""
    return matrices[:, 0] * vectors[0] + matrices[:, 1] * vectors[1] + matrices[:, 2] * vectors[2]


def place(bones: Float[Tensor, "3 J N"], parents: tuple[int, ...]) -> Float[Tensor, "3 J N"]:
    """Vectors from each joint's parent to it (3, J, N) -> where the joints are, the root at its own vector."""
    return torch.from_numpy(_paths(parents)).to(bones) @ bones


def from_rot6d(columns: Float[Tensor, " 6 *many"]) -> Float[Tensor, "3 3 *many"]:
    """Two columns (6, ...), not quite orthonormal -> rotations (3, 3, ...), by Gram-Schmidt (Zhou et al. 2019)."""
    x, y, z = columns[:3]
    inverse = (x * x + y * y + z * z).clamp(min=1e-8).rsqrt()
    x, y, z = x * inverse, y * inverse, z * inverse
    u, v, w = columns[3:]
    along = x * u + y * v + z * w
    u, v, w = u - along * x, v - along * y, w - along * z
    inverse = (u * u + v * v + w * w).clamp(min=1e-8).rsqrt()
    u, v, w = u * inverse, v * inverse, w * inverse
    planes = [x, u, y * w - z * v, y, v, z * u - x * w, z, w, x * v - y * u]
    return torch.stack(planes).unflatten(0, (3, 3))  # (9, ...) -> (3, 3, ...)


def joints(
    local: Float[Tensor, "3 3 J N"], offsets: Float[Tensor, "J 3"], parents: tuple[int, ...]
) -> Float[Tensor, "3 J N"]:
    """Where the joints are, (3, J, N), for parent-relative rotations and rest offsets; the root at its own offset."""
    above = world(local, parents)[:, :, list(parents[1:])]
    rest = offsets.to(local).t()[:, :, None]  # (J, 3) -> (3, J, 1)
    bones = torch.cat([rest[:, :1].expand(-1, -1, local.shape[-1]), turn(above, rest[:, 1:])], dim=1)
    return place(bones, parents)


def forward_kinematics(
    rotvec: Float[Tensor, "*batch J 3"], offsets: Float[Tensor, "J 3"], parents: tuple[int, ...]
) -> tuple[Float[Tensor, "*batch J 3"], Float[Tensor, "*batch J 3 3"]]:
    """Rotation vectors to joints (thesis eq. 3.4).

    Args:
        rotvec: (..., J, 3) parent-relative, radians.
        offsets: (J, 3) rest offset of each joint from its parent, metres; the root's is where it stands.
        parents: -1 for the root, parents before children.

    Returns:
        positions (..., J, 3) and local rotation matrices (..., J, 3, 3).
    """
    shape = rotvec.shape[:-2]
    local = exp(rotvec.reshape(-1, *rotvec.shape[-2:]).permute(2, 1, 0).contiguous())  # (N, J, 3) -> (3, 3, J, N)
    positions = joints(local, offsets, parents).permute(2, 1, 0).reshape(*shape, -1, 3)  # (3, J, N) -> (..., J, 3)
    return positions, local.permute(3, 2, 0, 1).reshape(*shape, -1, 3, 3)


@lru_cache(maxsize=16)
def _plan(parents: tuple[int, ...]) -> tuple[list[list[int]], list[int]]:
    """For each level below the root, the place of every joint's parent in the level above; then the joints' order."""
    levels = depth_levels(parents)
    above = [[upper.index(parents[joint]) for joint in level] for upper, level in pairwise(levels)]
    flat = [joint for level in levels for joint in level]
    return above, [flat.index(joint) for joint in range(len(parents))]


@lru_cache(maxsize=16)
def _paths(parents: tuple[int, ...]) -> np.ndarray:
    """(J, J) 1 where the column's bone lies on the way from the root to the row's joint, itself included."""
    paths = np.eye(len(parents))
    for joint, parent in enumerate(parents):
        if parent >= 0:
            paths[joint] += paths[parent]
    return paths
