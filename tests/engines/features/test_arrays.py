"""Planes against the rotations that the rest of the project uses."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from engines.features import arrays
from engines.features.skeletons import KIT21, STYLE21
from engines.geometry import kinematics, rotations
from engines.skeletons import SMPL22, Skeleton

FEW = settings(max_examples=12, deadline=None)
SEEDS = st.integers(0, 2**31)
TREES = st.sampled_from([SMPL22, KIT21, STYLE21])


def some_turns(seed: int, joints: int, frames: int = 5) -> np.ndarray:
    """(T, J, 4) by any angle."""
    return rotations.normalise(np.random.default_rng(seed).normal(size=(frames, joints, 4)))


@FEW
@given(SEEDS, TREES)
def test_forward_kinematics(seed: int, skeleton: Skeleton) -> None:
    turns = some_turns(seed, len(skeleton))
    local = arrays.quaternion_to_matrix(arrays.planes(turns))
    world = arrays.world(local, skeleton.parents)
    joints = arrays.place(world, skeleton.offsets, skeleton.parents)
    places, matrices = kinematics.forward_kinematics(
        rotations.quaternion_to_matrix(turns), -skeleton.offsets[0], skeleton.offsets, skeleton.parents
    )
    np.testing.assert_allclose(local.transpose(3, 2, 0, 1), rotations.quaternion_to_matrix(turns), atol=1e-6)
    np.testing.assert_allclose(world.transpose(3, 2, 0, 1), matrices, atol=3e-6)
    np.testing.assert_allclose(joints.transpose(2, 1, 0), places, atol=3e-6)


@FEW
@given(SEEDS)
def test_matrices_become_quaternions_at_every_angle(seed: int) -> None:
    rng = np.random.default_rng(seed)
    axes = rotations.normalise(np.r_[rng.normal(size=(6, 3)), np.eye(3), -np.eye(3)])
    angles = np.array([0, 1e-5, 1.0, 2.6, 3.0, np.pi - 1e-3, np.pi])
    turns = rotations.rotvec_to_quaternion(axes[:, None] * angles[:, None])
    matrices = rotations.quaternion_to_matrix(turns).transpose(2, 3, 0, 1).astype(np.float32)
    found = arrays.rotation_to_quaternion(matrices[:, 0], matrices[:, 1], matrices[:, 2]).transpose(1, 2, 0)
    np.testing.assert_allclose(np.linalg.norm(found, axis=-1), 1, atol=1e-5)
    assert rotations.angle(rotations.multiply(rotations.invert(found), turns)).max() < 3e-3


@FEW
@given(SEEDS)
def test_six_numbers_become_columns_as_elsewhere(seed: int) -> None:
    slopes = np.random.default_rng(seed).normal(size=(4, 3, 6))
    columns = arrays.rot6d_to_columns(arrays.planes(slopes))
    found = np.stack(columns, axis=1).transpose(3, 2, 0, 1)
    np.testing.assert_allclose(found, rotations.rot6d_to_matrix(slopes), atol=1e-4)
    flat = arrays.rot6d_to_columns(np.zeros((6, 2), np.float32))
    assert np.isfinite(flat).all()


@FEW
@given(SEEDS)
def test_products_and_headings(seed: int) -> None:
    left, right = some_turns(seed, 3), some_turns(seed + 1, 3)
    found = arrays.multiply(arrays.planes(left), arrays.planes(right))
    np.testing.assert_allclose(arrays.unplanes(found, (5,)), rotations.multiply(left, right), atol=1e-6)
    yaw = np.random.default_rng(seed).uniform(-4, 4, 5)
    cosine, sine = np.cos(yaw).astype(np.float32), np.sin(yaw).astype(np.float32)
    points = np.random.default_rng(seed).normal(size=(5, 3, 3))
    out = arrays.yaw(arrays.planes(points), cosine, sine)
    wanted = rotations.rotate(rotations.yaw_quaternion(yaw)[:, None], points)
    np.testing.assert_allclose(out.transpose(2, 1, 0), wanted, atol=1e-5)
    np.testing.assert_allclose(arrays.unyaw(out, cosine, sine), arrays.planes(points), atol=1e-5)
