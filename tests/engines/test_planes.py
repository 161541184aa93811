"""Rotations with the components in front: the same numbers as matrices the usual way."""

from __future__ import annotations

import pytest
import roma
import torch

from engines.geometry import kinematics, planes
from engines.skeletons import SMPL22


def angles(scale: float) -> torch.Tensor:
    return scale * torch.randn(5, 7, 22, 3, generator=torch.Generator().manual_seed(0))


@pytest.mark.parametrize("scale", [0.0, 1e-5, 1e-2, 1.0, 3.0])
def test_forward_kinematics_equals_the_plain_one(scale):
    offsets = torch.tensor(SMPL22.offsets, dtype=torch.float32)
    lie = angles(scale)
    positions, matrices = planes.forward_kinematics(lie, offsets, SMPL22.parents)
    expected_matrices = roma.rotvec_to_rotmat(lie)
    root = torch.zeros(5, 7, 3)
    expected, _ = kinematics.forward_kinematics(expected_matrices, root, offsets, SMPL22.parents)
    torch.testing.assert_close(matrices, expected_matrices, atol=2e-6, rtol=0)
    torch.testing.assert_close(positions, expected, atol=5e-6, rtol=0)


@pytest.mark.parametrize("scale", [0.0, 1e-6, 0.5])
def test_gradients_are_those_of_the_plain_one(scale):
    offsets = torch.tensor(SMPL22.offsets, dtype=torch.float64)
    ours, theirs = (angles(scale).double().requires_grad_() for _ in range(2))
    weights = torch.randn(5, 7, 22, 3, dtype=torch.float64, generator=torch.Generator().manual_seed(1))
    (planes.forward_kinematics(ours, offsets, SMPL22.parents)[0] * weights).sum().backward()
    matrices = roma.rotvec_to_rotmat(theirs)
    root = torch.zeros(5, 7, 3, dtype=torch.float64)
    (kinematics.forward_kinematics(matrices, root, offsets, SMPL22.parents)[0] * weights).sum().backward()
    assert ours.grad is not None and theirs.grad is not None
    torch.testing.assert_close(ours.grad, theirs.grad, atol=1e-4, rtol=1e-4)
