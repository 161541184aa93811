"""The Lie group SO(3) and its algebra for torch tensors (thesis section 3.2.1, equations 3.2 and 3.3).

An element of so(3) is a rotation vector: axis times angle, radians. Both maps are the `roma` library's, right at the
identity and at half a turn and with finite gradients at both, where the paper's formulas divide zero by zero. The
released model's approximations are in `engines.action2motion.official_lie`; NumPy counterparts in `rotations`.
"""

from __future__ import annotations

import roma
import torch
from jaxtyping import Float
from torch import Tensor


def hat(rotvec: Float[Tensor, "*batch 3"]) -> Float[Tensor, "*batch 3 3"]:
    """The skew-symmetric matrix of a rotation vector (thesis eq. 3.2): `hat(w) @ x` is the cross product of w and x.

    Args:
        rotvec: (..., 3).

    Returns:
        (..., 3, 3).
    """
    x, y, z = rotvec.unbind(-1)
    zero = torch.zeros_like(x)
    return torch.stack([zero, -z, y, z, zero, -x, -y, x, zero], dim=-1).unflatten(-1, (3, 3))


def vee(matrix: Float[Tensor, "*batch 3 3"]) -> Float[Tensor, "*batch 3"]:
    """The rotation vector of a skew-symmetric matrix, inverse of `hat`; a symmetric part is ignored.

    Args:
        matrix: (..., 3, 3).

    Returns:
        (..., 3).
    """
    skew = (matrix - matrix.mT) / 2
    return torch.stack([skew[..., 2, 1], skew[..., 0, 2], skew[..., 1, 0]], dim=-1)


def rotvec_to_matrix(rotvec: Float[Tensor, "*batch 3"]) -> Float[Tensor, "*batch 3 3"]:
    """Exponential map so(3) -> SO(3).

    Args:
        rotvec: (..., 3) axis times angle, radians, any angle.

    Returns:
        (..., 3, 3) rotation matrices.
    """
    return roma.rotvec_to_rotmat(rotvec)


def matrix_to_rotvec(matrix: Float[Tensor, "*batch 3 3"]) -> Float[Tensor, "*batch 3"]:
    """Logarithm SO(3) -> so(3) (thesis eq. 3.3, also where that formula fails: identity and half a turn).

    Args:
        matrix: (..., 3, 3) rotation matrices.

    Returns:
        (..., 3) axis times angle, radians, angle in [0, pi]; at pi either of the two opposite axes.
    """
    return roma.rotmat_to_rotvec(matrix)
