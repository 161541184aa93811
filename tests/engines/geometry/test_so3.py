"""so(3) and SO(3) by their axioms, and against the matrix exponential."""

from __future__ import annotations

import math

import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from torch import Tensor
from torch.autograd import gradcheck
from torch.autograd.functional import jacobian

from engines.geometry import so3

SHAPES = ((), (1,), (4,), (2, 3), (0,))
EPS = {torch.float64: 1e-11, torch.float32: 3e-6}
CALM = settings(deadline=None, max_examples=60)
EYE = torch.eye(3, dtype=torch.float64)
GENERATORS = so3.hat(EYE)  # d exp(w) / d w_k at w = 0 is the k-th of these


@st.composite
def rotvecs(draw, limit: float = 3.0, dtypes=(torch.float64, torch.float32)) -> Tensor:
    """Rotation vectors of some batch shape whose angles spread over many magnitudes up to `limit`."""
    shape, dtype = draw(st.sampled_from(SHAPES)), draw(st.sampled_from(dtypes))
    generator = torch.Generator().manual_seed(draw(st.integers(0, 2**31)))
    axis = torch.nn.functional.normalize(torch.randn(*shape, 3, generator=generator, dtype=torch.float64), dim=-1)
    exponent = draw(st.sampled_from([0.0, 0.0, -3.0, -7.0, -12.0, -300.0]))
    return (axis * torch.rand(*shape, 1, generator=generator, dtype=torch.float64) * limit * 10**exponent).to(dtype)


def close(actual: Tensor, expected: Tensor, factor: float = 1.0) -> None:
    assert actual.shape == expected.shape
    assert actual.dtype == expected.dtype
    torch.testing.assert_close(actual, expected, atol=factor * EPS[expected.dtype], rtol=0)


@CALM
@given(rotvecs())
def test_hat_is_the_cross_product_and_vee_undoes_it(w: Tensor) -> None:
    x = torch.linspace(-1, 2, 3, dtype=w.dtype).expand(w.shape)
    close((so3.hat(w) @ x[..., None])[..., 0], torch.linalg.cross(w, x))
    close(so3.hat(w), -so3.hat(w).mT)
    close(so3.vee(so3.hat(w)), w)
    close(so3.vee(so3.hat(w) + x[..., None] * x[..., None, :]), w)


@CALM
@given(rotvecs(limit=12.0))
def test_exp_is_the_matrix_exponential_and_a_rotation(w: Tensor) -> None:
    matrix = so3.rotvec_to_matrix(w)
    close(matrix.double(), torch.linalg.matrix_exp(so3.hat(w.double())), EPS[w.dtype] / 1e-11)
    close(matrix @ matrix.mT, torch.eye(3, dtype=w.dtype).expand_as(matrix))
    close(torch.linalg.det(matrix), torch.ones(w.shape[:-1], dtype=w.dtype))


@CALM
@given(rotvecs(), st.floats(-2, 2), st.floats(-2, 2))
def test_one_axis_is_a_one_parameter_group(w: Tensor, a: float, b: float) -> None:
    exp = so3.rotvec_to_matrix
    close(exp(a * w) @ exp(b * w), exp((a + b) * w), factor=3)
    close(exp(-w), exp(w).mT)


@CALM
@given(rotvecs(dtypes=(torch.float64,)), rotvecs(dtypes=(torch.float64,)))
def test_conjugation_turns_the_axis(w: Tensor, v: Tensor) -> None:
    if w.shape != v.shape:
        v = v.reshape(-1, 3)[:1].reshape(3) if v.numel() else torch.tensor([0.3, -0.2, 0.9], dtype=w.dtype)
    turn = so3.rotvec_to_matrix(v)
    turned = (turn @ w[..., None])[..., 0]
    close(so3.rotvec_to_matrix(turned), turn @ so3.rotvec_to_matrix(w) @ turn.mT, factor=3)


@CALM
@given(rotvecs(limit=math.pi - 0.05))
def test_log_undoes_exp(w: Tensor) -> None:
    close(so3.matrix_to_rotvec(so3.rotvec_to_matrix(w)), w, factor=3)


@CALM
@given(rotvecs(limit=12.0, dtypes=(torch.float64,)))
def test_exp_undoes_log_and_angles_stay_within_pi(w: Tensor) -> None:
    matrix = so3.rotvec_to_matrix(w)
    back = so3.matrix_to_rotvec(matrix)
    close(so3.rotvec_to_matrix(back), matrix, factor=3)
    assert (back.norm(dim=-1) <= math.pi + 1e-9).all()


@pytest.mark.parametrize("dtype", [torch.float64, torch.float32])
def test_log_of_the_identity_is_zero(dtype: torch.dtype) -> None:
    eye = torch.eye(3, dtype=dtype, requires_grad=True)
    rotvec = so3.matrix_to_rotvec(eye)
    assert (rotvec == 0).all()
    (gradient,) = torch.autograd.grad(rotvec.sum(), eye)
    assert gradient.isfinite().all()


@pytest.mark.parametrize("axis", [[1, 0, 0], [0, -1, 0], [0, 0, 1], [1, 1, 0], [0.2, -0.5, 3], [-1, -1, -1]])
@pytest.mark.parametrize("gap", [0.0, 1e-12, 1e-8, 1e-6, 1e-4])
def test_log_is_right_at_half_a_turn(axis: list[float], gap: float) -> None:
    w = torch.nn.functional.normalize(torch.tensor(axis, dtype=torch.float64), dim=0) * (math.pi - gap)
    matrix = torch.linalg.matrix_exp(so3.hat(w)).requires_grad_()
    back = so3.matrix_to_rotvec(matrix)
    assert back.norm().item() == pytest.approx(math.pi - gap, abs=1e-7)
    close(so3.rotvec_to_matrix(back), matrix)
    if gap >= 1e-6:
        close(back, w, factor=1e3)
    (gradient,) = torch.autograd.grad(back.sum(), matrix)
    assert gradient.isfinite().all()


@pytest.mark.parametrize("size", [0.0, 1e-15, 1e-9, 1e-7, 1e-6, 1e-5, 1e-3])
def test_gradients_are_smooth_at_zero(size: float) -> None:
    w = torch.tensor([0.6, -0.64, 0.48], dtype=torch.float64) * size
    slope = jacobian(so3.rotvec_to_matrix, w)
    expected = jacobian(lambda x: torch.linalg.matrix_exp(so3.hat(x)), w)
    torch.testing.assert_close(slope, expected, atol=1.1e-6, rtol=0)  # the library is first order below 1e-6
    torch.testing.assert_close(slope, GENERATORS.movedim(0, -1), atol=1e-6 + 2 * size, rtol=0)
    there_and_back = jacobian(lambda x: so3.matrix_to_rotvec(so3.rotvec_to_matrix(x)), w)
    torch.testing.assert_close(there_and_back, EYE, atol=1e-9, rtol=0)


@settings(parent=CALM, max_examples=20)
@given(rotvecs(limit=3.0, dtypes=(torch.float64,)))
def test_gradients_agree_with_finite_differences(w: Tensor) -> None:
    w = (w.reshape(-1, 3)[:2] + 0.01).requires_grad_()
    if w.numel():
        assert gradcheck(so3.rotvec_to_matrix, (w,))
        assert gradcheck(lambda x: so3.matrix_to_rotvec(so3.rotvec_to_matrix(x)), (w,))
