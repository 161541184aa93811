"""Training Loom: a few steps, resuming exactly, shares of a batch, what a window is told."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from safetensors.torch import load_file

import engines
from engines import text
from engines.datasets.captions import encoded
from engines.errors import Cancelled, CheckpointError, UnknownLabelError
from engines.loom import train
from engines.loom.data import Windows, vocabulary_of
from engines.loom.losses import _quiet, losses
from engines.loom.representation import KNOWN, LAYOUT
from engines.text import sides
from engines.text.everyday import EVERYDAY
from engines.training.devices import Share
from tests.engines.action2motion.tiny import clip, clips
from tests.engines.loom.tiny import SIZES, config, model

PLAN = {"log_every": 1, "validate_every": 3, "save_every_seconds": 1e9}


def told(found) -> np.ndarray:
    """Two sentence vectors a clip, of its action."""
    rng = np.random.default_rng(0)
    table = {name: rng.normal(size=sides.SIZE) for name in sorted({c.action for c in found})}
    return np.stack([np.stack([table[c.action], -table[c.action]]) for c in found]).astype(np.float16)


def fit(folder: Path, steps: int = 6, **options):
    settings = config(steps=steps, **SIZES)
    return train.fit(settings, folder, clips(), validation=clips(1), captions=told, plan=PLAN, **options)


def test_a_few_steps_then_an_engine(tmp_path: Path) -> None:
    state = fit(tmp_path)
    assert [line["step"] for line in state.history] == [1, 2, 3, 4, 5, 6]
    assert [line["step"] for line in state.validation] == [3, 6]
    assert all(np.isfinite(value) for line in state.history + state.validation for value in line.values())
    train.export(state, tmp_path / "loom.safetensors")
    engine = engines.load("loom", checkpoint=tmp_path / "loom.safetensors")
    assert len(engine.generate("throw", frames=10, prompt="a throw")) == 10


def test_a_training_that_was_stopped_goes_on_as_if_it_had_not_been(tmp_path: Path) -> None:
    whole = fit(tmp_path / "whole")
    asked: list[int] = []

    def third() -> bool:
        asked.append(1)
        return len(asked) == 3

    with pytest.raises(Cancelled):
        fit(tmp_path / "parts", cancel=third)
    parts = fit(tmp_path / "parts", resume=True)
    for line, other in zip(whole.history, parts.history, strict=True):
        assert {k: v for k, v in line.items() if k != "seconds"} == {k: v for k, v in other.items() if k != "seconds"}
    assert all(torch.equal(value, parts.averaged[name]) for name, value in whole.averaged.items())


def test_loss_falls_on_one_batch() -> None:
    torch.manual_seed(0)
    state, windows = train.start(config(**SIZES).replaced(constrained=0.3), clips(), plan={"learning_rate": 3e-3})
    net = train.model_of(state)
    batch = windows.draw(np.random.default_rng(0), net.mean, net.std, size=8)
    totals = []
    for group in state.optimiser.param_groups:
        group["lr"] = 3e-3
    for _ in range(60):
        total = torch.stack(list(losses(net, batch, state.generator).values())).sum()
        state.optimiser.zero_grad()
        total.backward()
        state.optimiser.step()
        totals.append(float(total))
    assert np.mean(totals[-5:]) < 0.6 * np.mean(totals[:5])


def test_shares_of_a_batch_make_the_whole() -> None:
    net = model()
    windows = Windows(clips(), net.config, told)
    whole = windows.draw(np.random.default_rng(3), net.mean, net.std, size=8)
    total = losses(net, whole, torch.Generator().manual_seed(1))
    parts = []
    for rank in range(2):
        share = Share(rank, 2)
        part = windows.draw(np.random.default_rng(3), net.mean, net.std, size=8, share=share)
        assert torch.equal(part.x, whole.x[rank::2])
        parts.append((losses(net, part, torch.Generator().manual_seed(1), share), part.mask.sum()))
    frames = sum(count for _, count in parts)
    for name, value in total.items():
        together = sum(found[name] * count for found, count in parts) / frames
        torch.testing.assert_close(value, together, rtol=1e-4, atol=1e-6)


def test_windows_are_what_the_clips_show() -> None:
    net = model(constrained=1.0, unconditional=0.0, wordy=0.0, both=0.0)
    windows = Windows(clips(), net.config)
    assert len(windows) == 2 * len(clips())
    batch = windows.draw(np.random.default_rng(0), net.mean, net.std, size=32)
    raw = batch.x * net.std + net.mean
    first = raw[:, 0]
    assert LAYOUT.read(first, "ground").abs().max() < 1e-5
    torch.testing.assert_close(LAYOUT.read(first, "facing")[:, 0], torch.ones(32), atol=1e-5, rtol=0)
    for name in ("turns", "height", "ground", "facing"):
        mask = KNOWN.read(batch.known, f"{name}_known")
        mask = mask[..., None] if name == "turns" else mask
        torch.testing.assert_close(KNOWN.read(batch.known, name), LAYOUT.read(batch.x, name) * mask)
    assert set(batch.wanted.action.tolist()) <= set(range(len(net.config.actions) + 1))


def test_a_mirrored_throw_is_not_told_to_be_a_throw() -> None:
    named = vocabulary_of([clip("throw"), clip("wave left hand")])
    assert named[0] == ("wave left hand", "wave right hand", "throw")
    windows = Windows([clip("throw")], config(actions=named[0], styles=(), usual_frames=named[2]))
    assert windows.actions.tolist() == [3, 0]


def test_long_and_rare_clips_are_drawn_more_often() -> None:
    some = [clip("walk", 30, i) for i in range(9)] + [replace(clip("throw", 30), name="one")]
    chance = Windows(some, config()).probability
    assert chance[18:].sum() > 2 * 2 / 20
    assert chance.sum() == pytest.approx(1)


def test_a_wave_counts_more_than_a_run_and_empty_frames_count_nothing() -> None:
    swing, stride = torch.zeros(1, 20, 22, 3), torch.full((1, 20, 22, 3), 0.05)
    swing[..., 20, 0] = 0.04
    mask = torch.ones(1, 21, dtype=torch.bool)
    quiet, lively = _quiet(swing, mask), _quiet(stride, mask)
    assert (quiet.item(), lively.item()) == (4.0, 0.5)
    half = mask.clone()
    half[:, 11:] = False
    stride[:, 10:] = 0
    assert torch.allclose(_quiet(stride, half), lively)


def test_clips_are_told_by_captions_and_by_what_people_ask(monkeypatch: pytest.MonkeyPatch) -> None:
    found = clip("walk")
    rows = {encoded.key(found): np.array([0, 1])}
    captions = encoded.EncodedCaptions(("one", "left"), np.eye(2, sides.ENCODED, dtype=np.float16), rows)
    monkeypatch.setattr(encoded, "load", lambda: captions)
    told = train.told_in_words([found, found], count=5, asked=3)
    assert told.shape == (2, 8, sides.SIZE)
    assert told[0, :5, :2].argmax(-1).tolist() == [0, 1, 0, 1, 0]
    asked = text.load().encode(EVERYDAY["walk"]).sentences.numpy()
    assert all((asked @ row[: sides.ENCODED].astype(float)).max() > 0.999 for row in told.reshape(2, 8, -1)[0, 5:])
    assert not (told[0, 5:] == told[1, 5:]).all(), "clips of one action are asked for in different words"


def test_a_training_begins_from_weights_and_counts_their_steps_on(tmp_path: Path) -> None:
    first = fit(tmp_path / "first", steps=3)
    path = tmp_path / "first.safetensors"
    train.export(first, path)
    state, _ = train.start(config(steps=2, **SIZES), clips(1), base=path)
    held = load_file(path)
    assert set(held) == set(state.model.state_dict())
    for name, value in state.model.state_dict().items():
        torch.testing.assert_close(value, held[name].float(), msg=name)
    more = fit(tmp_path / "more", steps=2, base=path)
    train.export(more, tmp_path / "more.safetensors")
    assert engines.load("loom", checkpoint=tmp_path / "more.safetensors").config.extra["step"] == 5
    with pytest.raises(CheckpointError, match="its width is"):
        train.start(config(steps=2, **{**SIZES, "width": 2 * SIZES["width"]}), clips(1), base=path)


def test_emphasised_actions_are_drawn_more_often() -> None:
    some = [clip("walk", 30), replace(clip("throw", 30), name="one")]
    plain, more = (Windows(some, config(emphasised=which)).probability for which in ((), ("throw",)))
    assert more[2:].sum() / more[:2].sum() == pytest.approx(3 * plain[2:].sum() / plain[:2].sum())
    with pytest.raises(UnknownLabelError, match="throw"):
        train.start(config(steps=2, **SIZES, emphasised=("thrown",)), some)
