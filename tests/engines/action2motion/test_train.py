"""Training Action2Motion: what is drawn and shared out, what is written down, and mistakes in data and settings."""

from __future__ import annotations

import csv
import json
import logging
from pathlib import Path

import numpy as np
import pytest
import torch
from safetensors.torch import load_file

import engines
from engines.action2motion import train
from engines.action2motion.config import DECODERS
from engines.action2motion.data import Sequences, vocabulary_of
from engines.action2motion.losses import draws, losses
from engines.errors import CheckpointError, FormatError, MotionloomError, OutOfRangeError, UnknownLabelError
from engines.training.devices import Share
from tests.engines.action2motion.tiny import clip, clips, config, model

PLAN = {"log_every": 2, "validate_every": 2}


def fit(folder: Path, decoder: str = "glmi-m", steps: int = 4, **options):
    """A few steps on a few clips; settings of the model and of `fit` by name."""
    of_fit = ("clips", "validation", "plan", "resume", "seed", "progress", "device")
    told = {name: options.pop(name) for name in of_fit if name in options}
    told = {"clips": clips(), "validation": clips(1), "plan": PLAN, **told}
    return train.fit(config(decoder, actions=(), nominal_frames=(), steps=steps, **options), folder, **told)


@pytest.mark.parametrize("decoder", DECODERS)
@pytest.mark.parametrize("feed_rounds", [0, 1])
def test_a_few_steps_of_every_decoder(tmp_path: Path, decoder: str, feed_rounds: int) -> None:
    state = fit(tmp_path, decoder, feed_rounds=feed_rounds)
    assert [line["step"] for line in state.history] == [line["step"] for line in state.validation] == [2, 4]
    assert all(np.isfinite(value) for line in state.history + state.validation for value in line.values())
    train.export(state, tmp_path / "weights.safetensors")
    engine = engines.load("action2motion", checkpoint=tmp_path / "weights.safetensors")
    assert engine.variant == decoder
    assert len(engine.generate("throw", frames=10)) == 10


def test_the_folder_says_all_there_is_to_know(tmp_path: Path) -> None:
    state = fit(tmp_path, seed=3)
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "checkpoint.pt", "config.json", "history.json", "losses.csv", "losses.html", "training.json", "validation.json",
    ]  # fmt: skip
    settings = json.loads((tmp_path / "config.json").read_text())
    assert settings["actions"] == list(train._config(state).actions)
    about = json.loads((tmp_path / "training.json").read_text())
    assert (about["plan"]["seed"], about["plan"]["log_every"]) == (3, 2)
    assert (about["clips"], about["clips_held_back"], about["device"], about["processes"]) == (12, 6, "cpu", 1)
    rows = list(csv.DictReader((tmp_path / "losses.csv").read_text().splitlines()))
    assert [(row["split"], row["step"]) for row in rows] == [("train", "2"), ("val", "2"), ("train", "4"), ("val", "4")]
    assert float(rows[0]["kl"]) == state.history[0]["kl"]
    assert float(rows[3]["total"]) == pytest.approx(sum(float(rows[3][name]) for name in ("reconstruction", "kl",
        "alignment", "rotation", "velocity", "contact")))  # fmt: skip
    assert json.loads((tmp_path / "validation.json").read_text()) == state.validation


@pytest.mark.parametrize("feed_rounds", [0, 1])
@pytest.mark.parametrize("batch_size", [6, 8])
def test_shares_make_up_the_whole_batch(feed_rounds: int, batch_size: int) -> None:
    """Means over shares are those of the batch: terms, gradients and all that is drawn."""
    made = model(feed_rounds=feed_rounds, batch_size=batch_size)
    sequences = Sequences(clips(), made.config)

    def terms(share: Share):
        batch = sequences.draw(np.random.default_rng(5), share=share)
        return losses(made, batch, 7, train.FEET, torch.Generator().manual_seed(5), share)

    def gradient(found):
        made.zero_grad()
        torch.stack(list(found.values())).sum().backward()
        return torch.cat([p.grad.flatten() for p in made.parameters()])

    whole, halves = terms(Share()), [terms(Share(rank, 2)) for rank in range(2)]
    for name, value in whole.items():
        torch.testing.assert_close((halves[0][name] + halves[1][name]) / 2, value, atol=1e-5, rtol=1e-4)
    assert halves[0]["reconstruction"] != whole["reconstruction"]
    mean = (gradient(halves[0]) + gradient(halves[1])) / 2
    torch.testing.assert_close(mean, gradient(whole), atol=2e-5, rtol=1e-3)


def test_forced_sequences_are_counted_over_all_shares() -> None:
    made = config(feed_rounds=0, teacher_forcing=0.5, batch_size=8)
    sequences = Sequences(clips(), made)
    for seed in range(5):
        forced = [
            draws(
                made, sequences.draw(np.random.default_rng(0), share=s), torch.Generator().manual_seed(seed), s
            ).forced
            for s in (Share(), Share(0, 2), Share(1, 2))
        ]
        assert forced[0] == forced[1] + forced[2]
        assert forced[1] - forced[2] in {0, 1}


def test_a_batch_that_cannot_be_shared_out_is_refused() -> None:
    Share(1, 3).check(6)
    with pytest.raises(OutOfRangeError, match="batch_size is 6; accepted: a multiple of 4"):
        Share(0, 4).check(6)


def test_validation_sees_every_sequence_once_and_always_the_same() -> None:
    sequences = Sequences(clips(), config())
    first, again = ([b.vectors for b in sequences.each(np.random.default_rng(1))] for _ in range(2))
    assert [len(b[0]) for b in first] == [6, 6, 6, 6], "22 sequences in batches of 6"
    assert all(torch.equal(a, b) for a, b in zip(first, again, strict=True))
    labels = torch.cat([b.conditions[0, :, :-1].argmax(-1) for b in sequences.each(np.random.default_rng(1))])
    assert labels[:22].tolist() == sequences.labels.tolist()
    halves = [[b.vectors for b in sequences.each(np.random.default_rng(1), Share(r, 2))] for r in range(2)]
    assert torch.equal(halves[1][3], first[3][:, 1::2])


def test_the_best_weights_are_exported_when_training_stops_early(tmp_path: Path) -> None:
    state = fit(tmp_path, steps=6, plan={**PLAN, "patience": 50})
    state.best = {name: torch.full_like(value, 0.25) for name, value in state.best.items()}
    state.best_step = 4
    for which, expected in ((None, 0.25), ("best", 0.25), ("last", None)):
        train.export(state, tmp_path / "w.safetensors", which)
        stored = load_file(tmp_path / "w.safetensors")
        kept = json.loads((tmp_path / "w.json").read_text())["extra"]["step"]
        assert kept == (4 if expected else 6)
        for name, value in stored.items():
            wanted = torch.full_like(value, expected) if expected else state.averaged[name].half()
            assert torch.equal(value, wanted)


def test_bf16_is_close_to_single_precision(tmp_path: Path) -> None:
    runs = {
        precision: fit(tmp_path / precision, steps=2, plan={**PLAN, "precision": precision}).history[-1]
        for precision in ("32", "bf16")
    }
    for name in ("reconstruction", "kl", "rotation"):
        assert runs["bf16"][name] == pytest.approx(runs["32"][name], rel=0.1)
        assert runs["bf16"][name] != runs["32"][name]


def test_mistakes_in_the_data_are_told(tmp_path: Path) -> None:
    unlabelled = clip("walk")
    object.__setattr__(unlabelled, "action", None)
    for none in ([], [unlabelled]):
        with pytest.raises(MotionloomError, match=f"none of the {len(none)} clips has an action"):
            fit(tmp_path, clips=none)
    misspelt = clip("walk")
    object.__setattr__(misspelt, "action", "wlak")
    with pytest.raises(FormatError, match=r"formula/walk-0: unknown action 'wlak'; did you mean 'walk'"):
        fit(tmp_path, clips=[*clips(), misspelt])
    assert list(tmp_path.iterdir()) == []


def test_labels_held_back_that_are_not_learned_are_passed_over(tmp_path: Path, caplog) -> None:
    caplog.set_level(logging.INFO)
    fit(tmp_path, validation=[clip("walk"), clip("kick")], steps=2)
    assert "1 of 2 clips held back show no action of the vocabulary" in caplog.text
    with pytest.raises(OutOfRangeError, match="patience is 3; accepted: 0"):
        fit(tmp_path / "b", validation=[clip("kick")], plan={"patience": 3})


def test_only_the_actions_asked_for_are_learned() -> None:
    assert vocabulary_of(clips(), 10.0, ("throw", "walk"))[0] == ("walk", "throw")
    with pytest.raises(UnknownLabelError, match="unknown action among the clips 'kick'"):
        vocabulary_of(clips(), 10.0, ("kick",))


def test_a_training_on_other_labels_is_not_gone_on_from(tmp_path: Path) -> None:
    fit(tmp_path)
    before = (tmp_path / "checkpoint.pt").read_bytes()
    fewer = [clip for clip in clips() if clip.action != "throw"]
    with pytest.raises(CheckpointError, match="cannot resume: actions are now without throw; begin anew"):
        fit(tmp_path, clips=fewer)
    assert (tmp_path / "checkpoint.pt").read_bytes() == before
    assert "throw" in json.loads((tmp_path / "config.json").read_text())["actions"]


def test_resume_demands_and_fresh_keeps_the_old_one(tmp_path: Path) -> None:
    with pytest.raises(CheckpointError, match="no checkpoint to go on from"):
        fit(tmp_path, resume=True)
    fit(tmp_path, steps=2)
    first = (tmp_path / "checkpoint.pt").read_bytes()
    assert fit(tmp_path, steps=4, resume=True).history[0]["step"] == 2
    again = fit(tmp_path, steps=2, resume=False)
    assert again.step == 2
    assert (tmp_path / "checkpoint.pt").read_bytes() != (tmp_path / "checkpoint.old.pt").read_bytes()
    old = torch.load(tmp_path / "checkpoint.old.pt", weights_only=True)
    assert json.loads(old["rest"])["step"] == 4
    assert len(first) > 0


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"batch_size": 0}, "batch_size is 0; accepted: 1"),
        ({"learning_rate": -1.0}, "learning_rate is -1.0; accepted: 0 or more"),
        ({"kl_weight": (0.1, float("nan"))}, "kl_weight is .*accepted: 0 or more"),
        ({"teacher_forcing": 1.5}, "teacher_forcing is 1.5; accepted: 0 to 1"),
        ({"window": 1}, "window is 1"),
        ({"fps": 0.0}, "fps is 0.0"),
    ],
)
def test_settings_out_of_range_are_told(tmp_path: Path, changes: dict, says: str) -> None:
    with pytest.raises(OutOfRangeError, match=says):
        fit(tmp_path, **changes)


def test_a_device_that_is_not_there_is_told(tmp_path: Path) -> None:
    with pytest.raises(UnknownLabelError, match="unknown device 'gpu'; did you mean"):
        fit(tmp_path, device="gpu")
    if not torch.cuda.is_available():
        with pytest.raises(OutOfRangeError, match="finds no GPU"):
            fit(tmp_path, device="cuda")


@pytest.mark.skipif(not torch.cuda.is_available(), reason="needs a GPU")
def test_on_a_gpu_it_learns_the_same_and_resumes(tmp_path: Path) -> None:
    runs = [fit(tmp_path / device, device=device, plan={**PLAN, "precision": "32"}) for device in ("cpu", "cuda")]
    for name in ("reconstruction", "kl", "gradient_norm"):
        assert runs[1].history[-1][name] == pytest.approx(runs[0].history[-1][name], rel=1e-2)
    assert fit(tmp_path / "cuda", device="cuda", steps=8, plan={**PLAN, "precision": "32"}).step == 8


def test_a_trunk_serves_another_decoder(tmp_path: Path) -> None:
    state = train.fit(config("glmi-m", steps=2), tmp_path / "first", clips())
    train.export(state, tmp_path / "mine.safetensors")
    trunk = tmp_path / "mine.safetensors"
    other = train.fit(config("lie", steps=3), tmp_path / "second", clips(), trunk=trunk)
    stored = load_file(trunk)
    for name, value in other.averaged.items():
        if name.startswith("velocity."):
            continue
        torch.testing.assert_close(value, stored[name].float(), msg=name)
    begun, _ = train.start(config("lie", steps=3), clips())
    assert not torch.equal(other.model.velocity.output.weight, begun.model.velocity.output.weight)
    with pytest.raises(CheckpointError, match="does not fit"):
        train.fit(config("plain", steps=1), tmp_path / "third", clips(), trunk=trunk)
    with pytest.raises(CheckpointError, match="cannot take a trunk"):
        train.fit(config("lie", steps=1), tmp_path / "fourth", clips(), trunk=tmp_path / "none.safetensors")
