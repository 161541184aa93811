"""NumPy rotations by axioms, round trips and against naive formulae."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

from engines.geometry import rotations as R

CALM = settings(deadline=None, max_examples=25)
SHAPES = ((), (1,), (5,), (2, 3), (0,), (2, 0, 3))
ORDERS = ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")


@st.composite
def quaternions(draw, shapes=SHAPES) -> np.ndarray:
    """Unit quaternions of some batch shape; now and then very near the identity or half a turn."""
    rng = np.random.default_rng(draw(st.integers(0, 2**31)))
    shape = draw(st.sampled_from(shapes))
    raw = rng.normal(size=(*shape, 4)) * draw(st.sampled_from([[1, 1, 1, 1], [1, 1e-8, 1e-8, 1e-8], [1e-9, 1, 1, 1]]))
    return R.normalise(raw)


def same_turn(a: np.ndarray, b: np.ndarray, atol: float = 1e-7) -> None:
    assert a.shape == b.shape
    assert np.abs(np.abs((a * b).sum(-1)) - 1).max(initial=0) < atol
    np.testing.assert_allclose(R.quaternion_to_matrix(a), R.quaternion_to_matrix(b), atol=atol)


def naive_matrix(q: np.ndarray) -> np.ndarray:
    """Rodrigues' formula, one quaternion at a time."""
    out = np.zeros((*q.shape[:-1], 3, 3))
    for at in np.ndindex(q.shape[:-1]):
        w, *v = q[at]
        half = math.atan2(float(np.linalg.norm(v)), w)
        axis = np.array(v) / max(float(np.linalg.norm(v)), 1e-300)
        k = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
        out[at] = np.eye(3) + math.sin(2 * half) * k + (1 - math.cos(2 * half)) * k @ k
    return out


@CALM
@given(quaternions())
def test_quaternion_to_matrix_is_rodrigues(q: np.ndarray) -> None:
    np.testing.assert_allclose(R.quaternion_to_matrix(q), naive_matrix(q), atol=1e-12)


@CALM
@given(quaternions(), st.sampled_from(ORDERS))
def test_every_conversion_round_trips(q: np.ndarray, order: str) -> None:
    matrix = R.quaternion_to_matrix(q)
    same_turn(R.matrix_to_quaternion(matrix), q)
    same_turn(R.rotvec_to_quaternion(R.quaternion_to_rotvec(q)), q)
    same_turn(R.euler_to_quaternion(R.quaternion_to_euler(q, order), order), q)
    np.testing.assert_allclose(R.rotvec_to_matrix(R.matrix_to_rotvec(matrix)), matrix, atol=1e-7)
    np.testing.assert_allclose(R.rot6d_to_matrix(R.matrix_to_rot6d(matrix)), matrix, atol=1e-12)
    assert (np.linalg.norm(R.quaternion_to_rotvec(q), axis=-1) <= math.pi + 1e-9).all()
    assert (R.matrix_to_quaternion(matrix)[..., 0] >= 0).all()


@CALM
@given(quaternions(), st.sampled_from(ORDERS))
def test_euler_is_intrinsic_in_the_order_named(q: np.ndarray, order: str) -> None:
    angles = R.quaternion_to_euler(q, order)
    product = np.broadcast_to(np.eye(3), (*q.shape[:-1], 3, 3))
    for place, axis in enumerate(order):
        product = product @ R.rotvec_to_matrix(angles[..., place, None] * np.eye(3)["XYZ".index(axis)])
    np.testing.assert_allclose(product, R.quaternion_to_matrix(q), atol=1e-7)


@CALM
@given(quaternions(), st.integers(0, 9))
def test_products_turns_and_inverses_are_those_of_matrices(q: np.ndarray, seed: int) -> None:
    rng = np.random.default_rng(seed)
    other, vectors = R.normalise(rng.normal(size=q.shape)), rng.normal(size=(*q.shape[:-1], 3))
    a, b = R.quaternion_to_matrix(q), R.quaternion_to_matrix(other)
    np.testing.assert_allclose(R.quaternion_to_matrix(R.multiply(q, other)), a @ b, atol=1e-12)
    np.testing.assert_allclose(R.rotate(q, vectors), (a @ vectors[..., None])[..., 0], atol=1e-12)
    np.testing.assert_allclose(R.quaternion_to_matrix(R.invert(q)), a.swapaxes(-1, -2), atol=1e-12)
    np.testing.assert_allclose(R.multiply(q, R.invert(q)), np.broadcast_to(R.IDENTITY, q.shape), atol=1e-12)


@CALM
@given(st.integers(0, 2**31), st.sampled_from([1.0, 1e-3, 1e3]))
def test_6d_need_not_be_orthonormal(seed: int, scale: float) -> None:
    values = np.random.default_rng(seed).normal(size=(4, 6)) * scale
    matrix = R.rot6d_to_matrix(values)
    np.testing.assert_allclose(matrix @ matrix.swapaxes(-1, -2), np.broadcast_to(np.eye(3), matrix.shape), atol=1e-9)
    np.testing.assert_allclose(np.linalg.det(matrix), 1, atol=1e-9)
    np.testing.assert_allclose(matrix[..., 0], R.normalise(values[:, :3]), atol=1e-12)
    assert ((matrix[..., 1] * values[:, 3:]).sum(-1) > 0).all()


@CALM
@given(st.integers(0, 2**31), st.sampled_from([(3,), (1, 3), (4, 3), (2, 3, 3)]))
def test_between_turns_one_onto_the_other_the_short_way(seed: int, shape: tuple[int, ...]) -> None:
    rng = np.random.default_rng(seed)
    start, end = rng.normal(size=shape) * 3, rng.normal(size=shape)
    turn = R.between(start, end)
    np.testing.assert_allclose(R.rotate(turn, R.normalise(start)), R.normalise(end), atol=1e-9)
    angle = np.arccos(np.clip((R.normalise(start) * R.normalise(end)).sum(-1), -1, 1))
    np.testing.assert_allclose(R.angle(turn), angle, atol=1e-6)


@pytest.mark.parametrize("axis", [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, 0, -2], [1, 1, 1], [0.95, 0.1, 0.3]])
def test_between_equal_opposite_and_zero(axis: list[float]) -> None:
    v = np.array(axis, dtype=float)
    np.testing.assert_allclose(R.between(v, v), R.IDENTITY, atol=1e-12)
    half = R.between(v, -v)
    np.testing.assert_allclose(R.rotate(half, v), -v, atol=1e-12)
    assert R.angle(half) == pytest.approx(math.pi)
    np.testing.assert_array_equal(R.between(v, np.zeros(3)), R.IDENTITY)
    np.testing.assert_array_equal(R.between(np.zeros(3), v), R.IDENTITY)
    nearly = -v + np.cross(v, [0.3, -0.7, 0.2]) * 1e-7
    np.testing.assert_allclose(R.rotate(R.between(v, nearly), v), nearly, atol=1e-4)


@CALM
@given(st.integers(0, 2**31), st.sampled_from([(6,), (6, 2), (1, 3), (5, 2, 2)]))
def test_continuous_changes_signs_only_and_neighbours_agree(seed: int, shape: tuple[int, ...]) -> None:
    q = R.normalise(np.random.default_rng(seed).normal(size=(*shape, 4)))
    kept = q.copy()
    smooth = R.continuous(q)
    np.testing.assert_array_equal(q, kept)
    np.testing.assert_array_equal(np.abs(smooth), np.abs(q))
    np.testing.assert_allclose(R.quaternion_to_matrix(smooth), R.quaternion_to_matrix(q), atol=1e-15)
    np.testing.assert_array_equal(smooth[0], q[0])
    assert ((smooth[1:] * smooth[:-1]).sum(-1) >= 0).all()


@CALM
@given(st.integers(0, 2**31), st.integers(2, 6), st.integers(1, 3), st.sampled_from([1.0, 1e-4, 1e-9]))
def test_slerp_is_scipys(seed: int, frames: int, joints: int, spread: float) -> None:
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.uniform(0.1, 1, frames))
    q = R.normalise(R.IDENTITY + rng.normal(size=(frames, joints, 4)) * spread)
    q *= rng.choice([-1.0, 1.0], size=(frames, joints, 1))
    new = np.sort(rng.uniform(times[0], times[-1], 7))
    result = R.slerp(times, q, new)
    for joint in range(joints):
        expected = Slerp(times, Rotation.from_quat(q[:, joint], scalar_first=True))(new).as_matrix()
        np.testing.assert_allclose(R.quaternion_to_matrix(result[:, joint]), expected, atol=1e-7)
    same_turn(R.slerp(times, q, times), q)


def test_yaw_turns_forward_towards_left() -> None:
    ahead = np.array([0.0, 0.0, 1.0])
    np.testing.assert_allclose(R.rotate(R.yaw_quaternion(np.pi / 2), ahead), [1, 0, 0], atol=1e-15)
    yaws = np.linspace(-3, 3, 7)
    turned = R.rotate(R.yaw_quaternion(yaws), ahead)
    np.testing.assert_allclose(np.arctan2(turned[:, 0], turned[:, 2]), yaws, atol=1e-12)


def test_normalise_leaves_zero_alone() -> None:
    np.testing.assert_array_equal(R.normalise(np.array([[0.0, 0.0], [3.0, 4.0]])), [[0, 0], [0.6, 0.8]])


@CALM
@given(quaternions())
def test_angle_is_the_length_of_the_rotation_vector(q: np.ndarray) -> None:
    np.testing.assert_allclose(R.angle(q), np.linalg.norm(R.quaternion_to_rotvec(q), axis=-1), atol=1e-9)
