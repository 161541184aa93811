"""The training loop: exact resuming, cancelling, averages, and a loss that is not a number."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
import torch
from torch import Tensor, nn

from engines.errors import Cancelled, CheckpointError
from engines.training.loop import TrainingPlan, TrainingState, train

PLAN = TrainingPlan(
    steps=20, learning_rate=0.02, final_learning_rate=0.001, warmup=4, weight_decay=0.01, seed=3, log_every=5
)


class Tiny(nn.Module):
    """Two layers, dropout, and a buffer that counts."""

    def __init__(self) -> None:
        super().__init__()
        self.layers = nn.Sequential(nn.Linear(3, 5), nn.Tanh(), nn.Linear(5, 1))
        self.register_buffer("seen", torch.zeros((), dtype=torch.long))


def new(plan: TrainingPlan = PLAN) -> TrainingState:
    torch.manual_seed(0)
    return TrainingState(Tiny(), plan)


def losses(state: TrainingState) -> dict[str, Tensor]:
    """Draws from both generators: resuming must put both back."""
    x = torch.from_numpy(state.rng.normal(size=(8, 3))).float()
    x = x + 0.1 * torch.randn(8, 3, generator=state.generator)
    state.model.seen += 8
    found = state.model.layers(x)[:, 0]
    return {"fit": ((found - x.sum(-1)) ** 2).mean(), "size": 0.01 * found.abs().mean()}


def everything(state: TrainingState) -> dict[str, Tensor]:
    moments = {
        f"{i}/{name}": torch.as_tensor(value)
        for i, entry in state.optimiser.state_dict()["state"].items()
        for name, value in entry.items()
    }
    averaged = {f"averaged/{name}": value for name, value in state.averaged.items()}
    return {**state.model.state_dict(), **averaged, **moments, "generator": state.generator.get_state()}


def assert_same(a: TrainingState, b: TrainingState) -> None:
    first, second = everything(a), everything(b)
    assert first.keys() == second.keys()
    for name, value in first.items():
        assert torch.equal(value, second[name]), name
    assert a.rng.bit_generator.state == b.rng.bit_generator.state
    assert a.step == b.step


@pytest.mark.parametrize("cut", [1, 10, 13])
def test_resuming_is_exact(tmp_path: Path, cut: int) -> None:
    whole = train(new(), losses)
    path = tmp_path / "run.pt"
    with pytest.raises(Cancelled, match=f"after step {cut}"):
        first = new()
        train(first, losses, path, cancel=lambda: first.step == cut)
    resumed = new()
    resumed.restore(path)
    assert resumed.step == cut
    train(resumed, losses, path)
    assert_same(whole, resumed)
    assert [line["step"] for line in resumed.history] == [line["step"] for line in whole.history] == [5, 10, 15, 20]
    again = new()
    again.restore(path)
    assert_same(again, whole)


def test_it_learns_and_logs(tmp_path: Path) -> None:
    seen: list[int] = []
    state = new(replace(PLAN, steps=150, log_every=25))
    train(state, losses, progress=lambda s: seen.append(s.step))
    assert seen == [25, 50, 75, 100, 125, 150]
    assert state.history[-1]["fit"] < 0.5 * state.history[0]["fit"]
    assert set(state.history[0]) == {"step", "seconds", "fit", "size"}
    assert state.model.seen == 150 * 8


def test_the_rate_warms_up_and_falls_along_a_cosine() -> None:
    state = new()
    rates = []
    while state.step < 21:
        rates.append(state.learning_rate())
        state.step += 1
    assert rates[0] == pytest.approx(0.02 / 4)
    assert rates[:4] == sorted(rates[:4])
    assert rates[4:] == sorted(rates[4:], reverse=True)
    assert rates[10] == pytest.approx((0.02 + 0.001) / 2)
    assert rates[20] == pytest.approx(0.001)


def test_the_average_is_a_moving_average_of_the_weights() -> None:
    state = new(replace(PLAN, average=0.5))
    expected = {name: value.clone() for name, value in state.model.state_dict().items()}

    def watched(s: TrainingState) -> dict[str, Tensor]:
        if s.step:
            absorb(s)
        return losses(s)

    def absorb(s: TrainingState) -> None:
        decay = min(0.5, (1 + s.step) / (10 + s.step))
        for name, value in s.model.state_dict().items():
            if value.dtype.is_floating_point:
                expected[name] = decay * expected[name] + (1 - decay) * value

    train(state, watched)
    absorb(state)
    for name, value in expected.items():
        if value.dtype.is_floating_point:
            torch.testing.assert_close(state.averaged[name], value, atol=1e-5, rtol=1e-5)
    assert state.averaged["seen"] == state.model.seen, "counters are not averaged"
    assert not torch.equal(state.averaged["layers.0.weight"], state.model.layers[0].weight)


def test_no_average_is_the_weights_themselves() -> None:
    state = train(new(replace(PLAN, average=0.0)), losses)
    for name, value in state.model.state_dict().items():
        assert torch.equal(state.averaged[name], value)


@pytest.mark.parametrize("bad", [float("nan"), float("inf")])
def test_a_loss_that_is_not_finite_stops_before_the_weights_are_touched(tmp_path: Path, bad: float) -> None:
    def poisoned(state: TrainingState) -> dict[str, Tensor]:
        terms = losses(state)
        return terms if state.step < 6 else {**terms, "fit": terms["fit"] * bad}

    state = new()
    with pytest.raises(CheckpointError, match=r"not finite at step 6.*'fit': (nan|inf)"):
        train(state, poisoned, tmp_path / "run.pt")
    assert state.step == 6
    assert all(value.isfinite().all() for value in state.model.state_dict().values())
    assert not (tmp_path / "run.pt").exists()


def test_gradients_are_clipped() -> None:
    state = new(replace(PLAN, steps=1, clip_norm=0.01))
    train(state, lambda s: {"huge": 1e6 * losses(s)["fit"]})
    norm = torch.stack([p.grad.norm() for p in state.model.parameters() if p.grad is not None]).norm()
    assert norm.item() == pytest.approx(0.01, rel=1e-3)


def test_a_checkpoint_is_written_beside_and_nothing_is_left_over(tmp_path: Path) -> None:
    train(new(), losses, tmp_path / "run.pt")
    assert [path.name for path in tmp_path.iterdir()] == ["run.pt"]


def test_a_checkpoint_that_cannot_be_resumed_says_so(tmp_path: Path) -> None:
    path = tmp_path / "run.pt"
    with pytest.raises(CheckpointError, match=r"run\.pt"):
        new().restore(path)
    path.write_bytes(b"no checkpoint at all")
    with pytest.raises(CheckpointError, match=r"run\.pt: cannot resume"):
        new().restore(path)
    train(new(), losses, path)
    path.write_bytes(path.read_bytes()[:-200])
    with pytest.raises(CheckpointError, match="cannot resume"):
        new().restore(path)
    train(new(), losses, path)
    other = TrainingState(nn.Linear(2, 2), PLAN)
    with pytest.raises(CheckpointError, match="cannot resume"):
        other.restore(path)
