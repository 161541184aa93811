"""Forward kinematics by tree depth, for NumPy arrays and torch tensors alike.

Joints of one depth are computed together, so a 22-joint body costs about nine matrix products whatever the
number of frames, and gradients flow through it.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from jaxtyping import Float

Array = Any
"""A NumPy array or a torch tensor; every argument of a call is of the same library, and so is what comes back."""


@lru_cache(maxsize=64)
def depth_levels(parents: tuple[int, ...]) -> tuple[tuple[int, ...], ...]:
    """Joint indices grouped by depth below the root; `parents[j] < j`, and -1 for the root."""
    depth = []
    for parent in parents:
        depth.append(0 if parent < 0 else depth[parent] + 1)
    return tuple(tuple(j for j, d in enumerate(depth) if d == level) for level in range(max(depth) + 1))


def global_rotations(rotations: Float[Array, "*batch J 3 3"], parents: tuple[int, ...]) -> Float[Array, "*batch J 3 3"]:
    """Parent-relative rotation matrices (..., J, 3, 3) -> rotations relative to the world, same shape and type."""
    levels = depth_levels(tuple(parents))
    result = [None] * len(parents)
    result[0] = rotations[..., 0, :, :]
    for level in levels[1:]:
        above = _stack([result[parents[j]] for j in level], rotations)
        turned = above @ rotations[..., list(level), :, :]
        for place, joint in enumerate(level):
            result[joint] = turned[..., place, :, :]
    return _stack(result, rotations)


def forward_kinematics(
    rotations: Float[Array, "*batch J 3 3"],
    translation: Float[Array, "*#batch 3"],
    offsets: Float[Array, "*#batch J 3"],
    parents: tuple[int, ...],
) -> tuple[Float[Array, "*batch J 3"], Float[Array, "*batch J 3 3"]]:
    """Joint positions from parent-relative rotations (thesis eq. 3.4, for a tree with one rotation a joint).

    Args:
        rotations: (..., J, 3, 3) parent-relative matrices, NumPy or torch.
        translation: (..., 3) root position, metres.
        offsets: (J, 3) or (..., J, 3) rest offset of each joint from its parent; the root's is added to translation.
        parents: parent index of each joint, -1 for the root, parents before children.

    Returns:
        positions (..., J, 3) and global rotations (..., J, 3, 3), of the type that came in.
    """
    world = global_rotations(rotations, parents)
    above = world[..., [max(parent, 0) for parent in parents], :, :]
    bones = (above @ offsets[..., None])[..., 0]  # (..., J, 3, 3) @ (..., J, 3, 1) -> (..., J, 3)
    result = [None] * len(parents)
    result[0] = translation + offsets[..., 0, :]
    for level in depth_levels(tuple(parents))[1:]:
        for joint in level:
            result[joint] = result[parents[joint]] + bones[..., joint, :]
    return _stack_points(result, rotations), world


def _stack(parts, like):
    """Stack matrices on the joint axis with the library `like` belongs to."""
    if isinstance(like, np.ndarray):
        return np.stack(parts, axis=-3)
    import torch

    return torch.stack(parts, dim=-3)


def _stack_points(parts, like):
    if isinstance(like, np.ndarray):
        return np.stack(np.broadcast_arrays(*parts), axis=-2)
    import torch

    return torch.stack(torch.broadcast_tensors(*parts), dim=-2)
