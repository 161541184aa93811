"""The training loop: exact resuming, validation, early stops, and what must not cost the last good checkpoint."""

from __future__ import annotations

import errno
import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from torch import Tensor, nn

from engines.errors import Cancelled, CheckpointError, OutOfRangeError, TrainingError
from engines.training import files
from engines.training.loop import TrainingPlan, TrainingState, train
from engines.training.schedules import LengthCurriculum

PLAN = TrainingPlan(
    steps=20, learning_rate=0.02, final_learning_rate=0.001, warmup=4, weight_decay=0.01, seed=3, log_every=5
)


class Tiny(nn.Module):
    """Two layers, dropout, and a buffer that counts."""

    def __init__(self) -> None:
        super().__init__()
        self.layers = nn.Sequential(nn.Linear(3, 5), nn.Tanh(), nn.Dropout(0.2), nn.Linear(5, 1))
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
    best = {f"best/{name}": value for name, value in state.best.items()}
    return {**state.model.state_dict(), **averaged, **best, **moments, "generator": state.generator.get_state()}


def lines(rows: list[dict[str, float]]) -> list[dict[str, float]]:
    """Logged lines without the time they took."""
    return [{name: value for name, value in row.items() if name != "seconds"} for row in rows]


def held_back(state: TrainingState) -> Iterator[dict[str, Tensor]]:
    """Two batches, always the same."""
    rng = np.random.default_rng(9)
    for _ in range(2):
        x = torch.from_numpy(rng.normal(size=(16, 3))).float()
        yield {"fit": ((state.model.layers(x)[:, 0] - x.sum(-1)) ** 2).mean()}


def assert_same(a: TrainingState, b: TrainingState) -> None:
    first, second = everything(a), everything(b)
    assert first.keys() == second.keys()
    for name, value in first.items():
        assert torch.equal(value, second[name]), name
    assert a.rng.bit_generator.state == b.rng.bit_generator.state
    assert (a.step, a.stale, a.best_step, a.best_total) == (b.step, b.stale, b.best_step, b.best_total)
    assert lines(a.history) == lines(b.history)
    assert lines(a.validation) == lines(b.validation)


@pytest.mark.parametrize("cut", [1, 10, 13])
def test_resuming_is_exact(tmp_path: Path, cut: int) -> None:
    plan = replace(PLAN, validate_every=4)
    whole = train(new(plan), losses, validate=held_back)
    path = tmp_path / "run.pt"
    with pytest.raises(Cancelled, match=f"after step {cut}"):
        first = new(plan)
        train(first, losses, path, cancel=lambda: first.step == cut, validate=held_back)
    torch.manual_seed(123)  # what others did with torch's own generator in the meantime does not matter
    resumed = new(plan)
    resumed.restore(path)
    assert resumed.step == cut
    train(resumed, losses, path, validate=held_back)
    assert_same(whole, resumed)
    assert [line["step"] for line in resumed.history] == [5, 10, 15, 20]
    assert [line["step"] for line in resumed.validation] == [4, 8, 12, 16, 20]
    again = new(plan)
    again.restore(path)
    assert_same(again, whole)


def test_it_learns_and_logs(tmp_path: Path) -> None:
    seen: list[int] = []
    state = new(replace(PLAN, steps=150, log_every=25))
    train(state, losses, progress=lambda s: seen.append(s.step))
    assert seen == [25, 50, 75, 100, 125, 150]
    assert state.history[-1]["fit"] < 0.5 * state.history[0]["fit"]
    assert set(state.history[0]) == {"step", "seconds", "learning_rate", "gradient_norm", "fit", "size"}
    assert state.history[1]["learning_rate"] == state.plan.rate(49)
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
    path = tmp_path / "run.pt"
    with pytest.raises(Cancelled):
        train(state, poisoned, path, cancel=lambda: state.step == 5)
    good = path.read_bytes()
    with pytest.raises(TrainingError, match=r"not finite at step 6.*'fit': (nan|inf).*lower learning_rate.*stands"):
        train(state, poisoned, path)
    assert state.step == 6
    assert all(value.isfinite().all() for value in state.model.state_dict().values())
    assert path.read_bytes() == good


def test_a_gradient_that_is_not_finite_stops_before_the_weights_are_touched() -> None:
    """The root's slope at nothing is endless, though the loss is not."""
    state = new()
    before = {name: value.clone() for name, value in state.model.state_dict().items()}
    with pytest.raises(TrainingError, match="gradient is not finite at step 0"):
        train(state, lambda s: {"root": (s.model.layers[0].weight * 0).sum().sqrt()})
    assert all(torch.equal(value, before[name]) for name, value in state.model.state_dict().items())


def test_gradients_are_clipped() -> None:
    state = new(replace(PLAN, steps=1, clip_norm=0.01))
    train(state, lambda s: {"huge": 1e6 * losses(s)["fit"]})
    norm = torch.stack([p.grad.norm() for p in state.model.parameters() if p.grad is not None]).norm()
    assert norm.item() == pytest.approx(0.01, rel=1e-3)


def test_gradients_may_be_left_as_they_are() -> None:
    norms = []
    for clip_norm in (0.0, 1e9):
        state = new(replace(PLAN, steps=1, clip_norm=clip_norm, log_every=1))
        train(state, lambda s: {"huge": 1e6 * losses(s)["fit"]})
        norms.append(torch.stack([p.grad.norm() for p in state.model.parameters() if p.grad is not None]).norm())
        assert state.history[0]["gradient_norm"] == pytest.approx(norms[-1].item(), rel=1e-5)
    assert norms[0] == norms[1] > 1e3


def test_groups_learn_at_their_own_rate() -> None:
    torch.manual_seed(0)
    model = Tiny()
    groups = [{"params": model.layers[0].parameters()}, {"params": model.layers[3].parameters(), "scale": 0.0}]
    before = {name: value.clone() for name, value in model.state_dict().items()}
    train(TrainingState(model, replace(PLAN, steps=2), groups=groups), losses)
    assert not torch.equal(model.layers[0].weight, before["layers.0.weight"])
    assert torch.equal(model.layers[3].weight, before["layers.3.weight"])


def test_decoupled_decay_shrinks_weights_that_no_loss_touches() -> None:
    plan = replace(PLAN, steps=1, warmup=0, learning_rate=0.1, weight_decay=0.5, optimiser="adamw")
    state = new(plan)
    before = state.model.layers[0].weight.clone()
    train(state, lambda s: {"nothing": s.model.layers[0].weight.sum() * 0})
    torch.testing.assert_close(state.model.layers[0].weight, before * (1 - 0.1 * 0.5))


def test_validation_sees_the_averaged_weights_and_changes_nothing() -> None:
    quiet = train(new(), losses)
    seen: list[dict[str, Tensor]] = []

    def looking(state: TrainingState) -> Iterator[dict[str, Tensor]]:
        assert not state.model.training
        assert not torch.is_grad_enabled()
        seen.append({name: value.clone() for name, value in state.model.state_dict().items()})
        assert all(torch.equal(value, state.averaged[name]) for name, value in seen[-1].items())
        torch.rand(3)  # draws from torch's own generator
        yield from held_back(state)

    told: list[int] = []
    state = new(replace(PLAN, validate_every=8))
    train(state, losses, validate=looking, progress=lambda s: told.append(s.step))
    assert [line["step"] for line in state.validation] == [8, 16, 20], "and at the end"
    assert told == [5, 8, 10, 15, 16, 20]
    for name, value in quiet.model.state_dict().items():
        assert torch.equal(value, state.model.state_dict()[name])
    assert state.model.training
    assert lines(quiet.history) == lines(state.history)
    assert set(state.validation[0]) == {"step", "seconds", "total", "fit"}


def scripted(values: list[float]):
    """A validation that says these totals, one after another."""
    left = iter(values)

    def validate(state: TrainingState) -> Iterator[dict[str, Tensor]]:
        yield {"fit": torch.tensor(next(left))}

    return validate


def test_it_stops_when_validation_gets_no_better_and_keeps_the_best(tmp_path: Path) -> None:
    path = tmp_path / "run.pt"
    state = new(replace(PLAN, validate_every=2, patience=2))
    kept: dict[int, dict[str, Tensor]] = {}

    def remember(s: TrainingState) -> None:
        kept[s.step] = {name: value.clone() for name, value in s.averaged.items()}

    train(state, losses, path, tick=remember, validate=scripted([5.0, 3.0, 4.0, 2.5, 2.5, 9.0, 1.0]))
    assert (state.step, state.best_step, state.best_total, state.finished) == (12, 8, 2.5, True)
    assert all(torch.equal(value, kept[8][name]) for name, value in state.best.items())
    assert state.weights() is state.best
    assert state.weights("last") is state.averaged
    again = new(state.plan)
    again.restore(path)
    assert all(torch.equal(value, kept[8][name]) for name, value in again.best.items())
    train(again, losses, path, validate=scripted([]))
    assert again.step == 12, "a training that has stopped stays stopped"


def test_without_patience_it_goes_on_and_gives_the_last_weights() -> None:
    state = train(new(replace(PLAN, validate_every=5)), losses, validate=scripted([1.0, 2.0, 3.0, 4.0]))
    assert (state.step, state.best_step) == (20, 5)
    assert state.weights() is state.averaged
    assert state.weights("best") is state.best


def test_a_validation_that_is_not_finite_stops(tmp_path: Path) -> None:
    with pytest.raises(TrainingError, match="held back is not finite at step 4"):
        train(new(replace(PLAN, validate_every=2)), losses, validate=scripted([1.0, float("nan")]))


def test_a_curriculum_moves_on_when_validation_rises_and_patience_begins_anew(tmp_path: Path) -> None:
    path, plan = tmp_path / "run.pt", replace(PLAN, validate_every=2, patience=2)

    def fresh() -> TrainingState:
        state = new(plan)
        state.curricula["length"] = LengthCurriculum(length=8, longest=9, term="fit")
        return state

    state = fresh()
    # 3.0 rises: nine from now on, so 4.0 is a new best; then nothing better for two
    train(state, losses, path, validate=scripted([2.0, 3.0, 4.0, 3.5, 3.6, 3.7, 0.0]))
    assert (state.step, state.best_step, state.best_total) == (12, 8, 3.5)
    again = fresh()
    again.restore(path)
    assert again.curricula["length"].state() == state.curricula["length"].state() == {
        "length": 9, "longest": 9, "term": "fit", "best": 3.5,
    }  # fmt: skip


@pytest.mark.parametrize("first", [True, False])
def test_a_full_disk_says_so_and_the_last_checkpoint_stands(tmp_path: Path, monkeypatch, first: bool) -> None:
    path = tmp_path / "run.pt"
    if not first:
        train(new(replace(PLAN, steps=5)), losses, path)
    before = path.read_bytes() if not first else None

    def full(_handle: int) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(files.os, "fsync", full)
    says = "none was written yet" if first else "the last one written stands"
    with pytest.raises(CheckpointError, match=rf"run\.pt.*step 20.*no space left on device.*{says}"):
        train(new(), losses, path)
    monkeypatch.undo()
    assert sorted(p.name for p in tmp_path.iterdir()) == ([] if first else ["run.pt"])
    if not first:
        assert path.read_bytes() == before
        resumed = new()
        resumed.restore(path)
        assert resumed.step == 5


def test_a_checkpoint_of_the_first_version_is_gone_on_from(tmp_path: Path) -> None:
    """Keys model, averaged, optimiser, generator, rest; the rest had four entries, and groups no scale."""
    path = tmp_path / "run.pt"
    whole = new(replace(PLAN, log_every=20))
    train(whole, losses)
    state = new(replace(PLAN, log_every=20))
    with pytest.raises(Cancelled):
        train(state, losses, path, cancel=lambda: state.step == 7)
    stored = torch.load(path, weights_only=True)
    rest = json.loads(stored["rest"])
    old = {name: stored[name] for name in ("model", "averaged", "optimiser", "generator")}
    for group in old["optimiser"]["param_groups"]:
        del group["scale"]
    torch.save({**old, "rest": json.dumps({k: rest[k] for k in ("rng", "step", "seconds", "history")})}, path)
    resumed = new(replace(PLAN, log_every=20))
    resumed.restore(path)
    train(resumed, losses, path)
    for name, value in whole.model.state_dict().items():
        assert torch.equal(value, resumed.model.state_dict()[name]), name


def test_the_checkpoint_of_another_training_is_refused_in_words(tmp_path: Path) -> None:
    path, state = tmp_path / "run.pt", new()
    state.identity = {"decoder": "lie", "actions": ["walk", "jump", "throw"]}
    train(state, losses, path)
    for identity, says in (
        ({"decoder": "plain"}, "decoder was 'lie' and is now 'plain'; begin anew"),
        ({"actions": ("walk", "throw", "kick")}, "actions are now without jump and with kick"),
        ({"actions": ("throw", "jump", "walk")}, "actions are now in another order"),
    ):
        other = new()
        other.identity = identity
        with pytest.raises(CheckpointError, match=f"cannot resume: {says}"):
            other.restore(path)
        assert other.step == 0
    same = new()
    same.identity = {"decoder": "lie", "actions": ("walk", "jump", "throw"), "newer": 1}
    same.restore(path)
    assert same.step == 20


def test_a_changed_rate_holds_for_a_resumed_training_and_the_seed_stays(tmp_path: Path) -> None:
    path = tmp_path / "run.pt"
    train(new(replace(PLAN, steps=5)), losses, path)
    changed = new(replace(PLAN, weight_decay=0.5, seed=99))
    changed.restore(path)
    assert changed.optimiser.param_groups[0]["weight_decay"] == 0.5
    assert changed.plan.seed == PLAN.seed


@pytest.mark.parametrize(
    ("name", "value"),
    [("log_every", 0), ("clip_norm", -1.0), ("average", 1.0), ("learning_rate", float("nan")), ("patience", -1)],
)
def test_a_plan_out_of_range_says_which_number(name: str, value: float) -> None:
    with pytest.raises(OutOfRangeError, match=f"{name} is .*accepted"):
        replace(PLAN, **{name: value})


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
