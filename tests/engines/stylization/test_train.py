"""Training stylization stage by stage: a few steps, exact resume, shares of a batch."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch

from engines.errors import Cancelled, CheckpointError, MotionloomError, UnknownLabelError
from engines.stylization import losses, train
from engines.stylization.data import Windows
from engines.stylization.engine import load
from engines.training.devices import Share
from engines.training.run import RunOptions
from tests.engines.action2motion.tiny import clip
from tests.engines.stylization.tiny import clips, config, model

PLAN = {"log_every": 1, "validate_every": 2, "save_every_seconds": 1e9}


def fit(folder: Path, stage, options: RunOptions | None = None, **changes):
    return train.fit(
        config(**changes), stage, folder, clips(), validation=clips(1), plan=PLAN, options=options
    )  # fmt: skip


@pytest.mark.parametrize(("latent", "supervised"), [("ae", True), ("vae", False)])
def test_all_stages_then_an_engine(tmp_path: Path, latent: str, supervised: bool) -> None:
    told = {"latent": latent, "supervised": supervised}
    for stage in train.STAGES:
        state = fit(tmp_path, stage, **told)
        assert all(np.isfinite(value) for line in state.history for value in line.values())
    train.export(state, tmp_path / "all.safetensors")
    engine = load(checkpoint=tmp_path / "all.safetensors")
    assert len(engine.stylise(clips()[0].motion, "old" if supervised else None)) == 1
    # the style stage leaves what came before as it was
    before = torch.load(tmp_path / "autoencoder" / "checkpoint.pt", weights_only=True)["averaged"]
    assert torch.equal(state.averaged["encoder.output.weight"], before["encoder.output.weight"])


def test_the_critic_learns_from_real_codes_only_and_does_not_ship(tmp_path: Path) -> None:
    for stage in train.STAGES:
        state = fit(tmp_path, stage, critic_weight=0.5)
    train.export(state, tmp_path / "all.safetensors")
    shipped = load(checkpoint=tmp_path / "all.safetensors").model.state_dict()
    assert not any(name.startswith("critic") for name in shipped)
    net, windows = model(critic_weight=0.5, batch_size=8), Windows(clips(), config(batch_size=8))
    first, second, label = windows.pairs(np.random.default_rng(0))
    assert net.critic is not None
    made = losses.run(net, first, second, label, train._draws(net, 8, torch.Generator().manual_seed(0), Share(0, 1)))
    said = losses.criticised(net, made, label)
    critic, generator = next(net.critic.parameters()), next(net.generator.parameters())
    for term, (learns, not_) in {"critic": (critic, generator), "manner": (generator, critic)}.items():
        grown, none = torch.autograd.grad(said[term], [learns, not_], allow_unused=True, retain_graph=True)
        assert grown.abs().max() > 0 and none is None


def test_the_style_stage_needs_the_others(tmp_path: Path) -> None:
    with pytest.raises(CheckpointError, match="'autoencoder' first"):
        fit(tmp_path, "style")
    with pytest.raises(UnknownLabelError, match="regressor"):
        fit(tmp_path, "regresor")


def test_ablations_without_latent_and_without_regressor(tmp_path: Path) -> None:
    with pytest.raises(UnknownLabelError, match="2 known"):
        fit(tmp_path / "none", "autoencoder", latent="none")
    fit(tmp_path / "none", "regressor", latent="none")
    for folder, changes in {"none": {"latent": "none"}, "still": {"latent": "none", "regressor": ()}}.items():
        state = fit(tmp_path / folder, "style", **changes)
        train.export(state, tmp_path / f"{folder}.safetensors")
        engine = load(checkpoint=tmp_path / f"{folder}.safetensors")
        motion = clips()[3].motion.resample(30)
        made = engine.stylise(motion, "old")[0]
        assert np.allclose(made.translation[:, [0, 2]], motion.translation[:, [0, 2]], atol=1e-3) == (folder == "still")


def test_a_style_stage_on_the_stages_of_another_run(tmp_path: Path) -> None:
    for stage in train.STAGES[:2]:
        fit(tmp_path / "one", stage)
    state = train.fit(config(supervised=False), "style", tmp_path / "two", clips(), base=tmp_path / "one", plan=PLAN)
    before = torch.load(tmp_path / "one" / "regressor" / "checkpoint.pt", weights_only=True)["averaged"]
    assert torch.equal(state.averaged["regressor.output.weight"], before["regressor.output.weight"])


def test_a_stage_that_was_stopped_goes_on_as_if_it_had_not_been(tmp_path: Path) -> None:
    whole = fit(tmp_path / "whole", "autoencoder", latent="vae")
    asked: list[int] = []

    def second() -> bool:
        asked.append(1)
        return len(asked) == 2

    with pytest.raises(Cancelled):
        fit(tmp_path / "parts", "autoencoder", RunOptions(cancel=second), latent="vae")
    parts = fit(tmp_path / "parts", "autoencoder", RunOptions(resume=True), latent="vae")
    assert all(torch.equal(value, parts.averaged[name]) for name, value in whole.averaged.items())


def test_shares_of_pairs_make_the_whole() -> None:
    windows = Windows(clips(), config(batch_size=8))
    whole = windows.pairs(np.random.default_rng(2))
    parts = [windows.pairs(np.random.default_rng(2), Share(rank, 2)) for rank in range(2)]
    for i, value in enumerate(whole):
        assert torch.equal(value.unflatten(0, (-1, 2))[0::2].flatten(0, 1), parts[0][i])
        assert torch.equal(value.unflatten(0, (-1, 2))[1::2].flatten(0, 1), parts[1][i])


def test_pairs_are_of_one_style_and_of_any_of_its_clips() -> None:
    windows = Windows(clips(), config(batch_size=64))
    owner = np.repeat(np.arange(len(windows)), windows.lengths)
    windows.frames = torch.from_numpy(owner)[:, None].float()  # every frame says of which clip it is
    first, second, label = (value.numpy() for value in windows.pairs(np.random.default_rng(0)))
    one, other = first[:, 0, 0].astype(int), second[:, 0, 0].astype(int)
    assert np.array_equal(windows.labels[one], label.argmax(1))
    assert np.array_equal(windows.labels[other], label.argmax(1))
    assert 0 < np.mean(one == other) < 0.9


def test_windows_are_normalised_and_short_clips_go_back_and_forth() -> None:
    windows = Windows([clip("walk", 14)], config(window=64))
    (batch,) = list(windows.each())[:1]
    row, length = batch[0], int(windows.lengths[0])
    assert length < 64
    assert torch.equal(row[length - 1 + 3], row[length - 1 - 3])
    assert torch.equal(row[2 * (length - 1)], row[0])
    with pytest.raises(MotionloomError, match="has one of the styles"):
        windows.pairs(np.random.default_rng(0))


def test_loss_of_the_autoencoder_falls() -> None:
    net, windows = model(latent_size=32, encoder=(48, 48), decoder=(48, 48, 48)).train(), Windows(clips(), config())
    optimiser = torch.optim.Adam(net.parameters(), lr=3e-3)
    motion = windows.draw(np.random.default_rng(0))
    totals = []
    for _ in range(60):
        total = torch.stack(list(losses.autoencoder(net, motion, None).values())).sum()
        optimiser.zero_grad()
        total.backward()
        optimiser.step()
        totals.append(float(total.detach()))
    assert np.mean(totals[-5:]) < 0.7 * np.mean(totals[:5])
