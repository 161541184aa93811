"""Training MACVAE: losses fall, a stopped run goes on exactly, weights go to a file and back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch

from engines.errors import Cancelled, CheckpointError, MotionloomError, OutOfRangeError
from engines.multiact import config as presets
from engines.multiact import train, triplets
from engines.multiact.data import Windows
from engines.multiact.losses import joints_and_place, losses
from engines.multiact.representation import encode
from engines.training.devices import Share
from engines.training.run import RunOptions
from tests.engines.action2motion.tiny import movement
from tests.engines.multiact.tiny import clips, config, model

PLAN = {"log_every": 1, "validate_every": 2, "save_every_seconds": 1e9}


def fit(folder: Path, options: RunOptions | None = None):
    return train.fit(config(), folder, clips(), validation=clips(1), plan=PLAN, options=options)


def test_a_run_that_was_stopped_goes_on_as_if_it_had_not_been(tmp_path: Path) -> None:
    whole = fit(tmp_path / "whole")
    asked: list[int] = []

    def second() -> bool:
        asked.append(1)
        return len(asked) == 2

    with pytest.raises(Cancelled):
        fit(tmp_path / "parts", RunOptions(cancel=second))
    parts = fit(tmp_path / "parts", RunOptions(resume=True))
    assert parts.step == whole.step == 4
    assert all(torch.equal(value, parts.averaged[name]) for name, value in whole.averaged.items())
    assert {"pose", "joints", "acceleration", "kl", "length"} <= whole.validation[-1].keys()
    train.export(whole, tmp_path / "m.safetensors")
    back = train.read(tmp_path / "m.safetensors")
    assert back.config.actions == train.model_of(whole).config.actions
    assert torch.allclose(back.mean, whole.averaged["mean"], atol=1e-3)


def test_losses_of_one_batch_fall() -> None:
    told = config(width=48, inner=64)
    state, windows = train.start(told, triplets.make(clips(), 24))
    net, batch = train.model_of(state), windows.draw(np.random.default_rng(0))
    optimiser, generator = torch.optim.AdamW(net.parameters(), lr=3e-3), torch.Generator().manual_seed(0)
    totals = []
    for _ in range(60):
        total = torch.stack(list(losses(net, batch, generator).values())).sum()
        optimiser.zero_grad()
        total.backward()
        optimiser.step()
        totals.append(float(total.detach()))
    assert np.mean(totals[-5:]) < 0.6 * np.mean(totals[:5])


def test_joints_and_places_of_features_are_those_of_the_motion() -> None:
    motion = movement(40)
    features = torch.from_numpy(encode(motion, 11))[None]
    joints, place = joints_and_place(features[:, 10:])
    there = motion.face_front(11).positions[10:]
    np.testing.assert_allclose((joints + place[:, :, None])[0].numpy(), there, atol=1e-5)


def test_what_a_perfect_model_would_lose(monkeypatch: pytest.MonkeyPatch) -> None:
    net = model(noise=0.0, free_nats=1e6)
    windows = Windows(triplets.make(clips(), 8), net.config.actions, 4)
    batch = windows.draw(np.random.default_rng(0))
    real = batch.x[:, triplets.PREVIOUS :]
    monkeypatch.setattr(net, "decode", lambda *_: real.clone())
    terms = losses(net, batch, torch.Generator().manual_seed(0))
    for name in ("pose", "joints", "place", "acceleration", "movement", "kl"):
        assert float(terms[name].detach()) == pytest.approx(0, abs=1e-5), name
    monkeypatch.setattr(net, "decode", lambda *_: real + 0.01)
    worse = losses(net, batch, torch.Generator().manual_seed(0))
    for name in ("pose", "joints", "place"):
        assert float(worse[name].detach()) > 1e-3, name


def test_shares_of_a_batch_make_the_whole() -> None:
    windows = Windows(triplets.make(clips(), 12), config().actions, 4)
    whole = windows.draw(np.random.default_rng(2))
    parts = [windows.draw(np.random.default_rng(2), Share(rank, 2)) for rank in range(2)]
    for rank, part in enumerate(parts):
        assert torch.equal(part.labels, whole.labels[rank::2])
        assert torch.equal(part.x, whole.x[rank::2, : part.x.shape[1]])


def test_mistakes_are_told(tmp_path: Path) -> None:
    with pytest.raises(OutOfRangeError, match="multiple of 4"):
        presets.SMALL.replaced(width=30, heads=3).checked()
    with pytest.raises(OutOfRangeError, match="0 or more"):
        presets.SMALL.replaced(kl_weight=-1.0).checked()
    with pytest.raises(MotionloomError, match="motionloom data prepare"):
        triplets.make([], 4)
    with pytest.raises(CheckpointError, match="motionloom train multiact"):
        train.read(tmp_path / "none.safetensors")
