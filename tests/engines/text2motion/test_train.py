"""Training Text2Motion: each stage on from the one before, resuming exactly, one batch learned by heart."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch

import engines
from engines.errors import Cancelled, CheckpointError, MotionloomError, OutOfRangeError, UnknownLabelError
from engines.text2motion import data, train
from engines.text2motion.config import PAPER, PRESETS, SMALL, STAGES, Text2MotionConfig, preset
from engines.text2motion.losses import autoencoder_losses, text2length_losses, text2motion_losses
from engines.training.devices import Share
from tests.engines.text2motion.tiny import FakeEncoder, Said, clip, clips, config, material, model

PLAN = {"log_every": 1, "validate_every": 3, "save_every_seconds": 1e9}
CHANGES = {"autoencoder_steps": 4, "length_steps": 4, "steps": 4, "words": (), "parts": ()}


def fit(stage: str, folder: Path, base: Path | None = None, **options):
    settings = config(**{**CHANGES, **options.pop("changes", {})})
    return train.fit(
        settings, stage, folder, clips(), base=base, prepare=prepare, validation=clips(1), plan=PLAN, **options
    )


def prepare(_config, stage: str) -> train.Material | None:
    return None if stage == "autoencoder" else material()


@pytest.fixture(scope="module")
def stages(tmp_path_factory) -> dict[str, Path]:
    """Weights after a few steps of each stage."""
    folder = tmp_path_factory.mktemp("stages")
    made: dict[str, Path] = {}
    before = None
    for stage in STAGES:
        state = fit(stage, folder / stage, before)
        assert [line["step"] for line in state.history] == [1, 2, 3, 4]
        assert [line["step"] for line in state.validation] == [3, 4]
        assert all(np.isfinite(value) for line in state.history + state.validation for value in line.values())
        before = made[stage] = folder / f"{stage}.safetensors"
        train.export(state, before)
    return made


TERMS = {
    "autoencoder": {"reconstruction", "sparsity", "smoothness"},
    "text2length": {"length"},
    "text2motion": {"codes", "motion", "kl"},
}


def test_each_stage_learns_its_part_and_keeps_the_others(stages) -> None:
    nets = {stage: train.load(path) for stage, path in stages.items()}
    assert [nets[stage].config.parts for stage in STAGES] == [STAGES[:1], STAGES[:2], STAGES]
    kept = nets["text2length"].state_dict()
    for name, value in nets["autoencoder"].state_dict().items():
        assert torch.equal(value, kept[name]), name
    whole = nets["text2motion"].state_dict()
    changed = {name for name, value in kept.items() if not torch.equal(value, whole[name])}
    # the motion decoder is fine-tuned, the rest is frozen
    assert changed and all(name.startswith("autoencoder.decoder.") for name in changed)
    assert nets["text2length"].config.words == nets["text2motion"].config.words != ()
    assert set(nets["text2motion"].config.extra) == {f"{s}_{n}" for s in STAGES for n in ("step", "seconds")}


def test_weights_make_an_engine(stages) -> None:
    engine = engines.load("text2motion", checkpoint=stages["text2motion"])
    engine._encoder = FakeEncoder()
    assert engine.capabilities == {"text", "lengths", "word_attention", "scale_bones", "variants"}
    assert len(engine.generate(prompt="a person does throw", frames=10)) == 10
    with pytest.raises(CheckpointError, match="hold no text2motion"):
        engines.load("text2motion", checkpoint=stages["text2length"])


@pytest.mark.parametrize("stage", STAGES)
def test_a_training_that_was_stopped_goes_on_as_if_it_had_not_been(stages, stage: str, tmp_path: Path) -> None:
    base = {"autoencoder": None, "text2length": stages["autoencoder"], "text2motion": stages["text2length"]}[stage]
    whole = fit(stage, tmp_path / "whole", base)
    assert set(whole.history[0]) - {"step", "seconds", "learning_rate", "gradient_norm"} == TERMS[stage]
    asked: list[int] = []

    def second() -> bool:
        asked.append(1)
        return len(asked) == 2

    with pytest.raises(Cancelled):
        fit(stage, tmp_path / "parts", base, cancel=second)
    parts = fit(stage, tmp_path / "parts", base, resume=True)
    for line, other in zip(whole.history, parts.history, strict=True):
        assert {k: v for k, v in line.items() if k != "seconds"} == {k: v for k, v in other.items() if k != "seconds"}
    assert all(torch.equal(value, parts.averaged[name]) for name, value in whole.averaged.items())


def test_a_stage_asks_for_what_it_needs(stages, tmp_path: Path) -> None:
    with pytest.raises(CheckpointError, match="say which"):
        fit("text2motion", tmp_path)
    with pytest.raises(CheckpointError, match="is the first"):
        fit("autoencoder", tmp_path, stages["autoencoder"])
    with pytest.raises(UnknownLabelError, match="did you mean 'text2motion'"):
        fit("motion", tmp_path)
    for wrong in ({"window": 18}, {"latent_hidden": 7}, {"dropout": 2.0}, {"shortest": 44}, {"curriculum_first": 11}):
        with pytest.raises(OutOfRangeError, match=next(iter(wrong))):
            fit("autoencoder", tmp_path, changes=wrong)
    with pytest.raises(MotionloomError, match="data prepare"):
        train.start(config(), "autoencoder", [])
    other = tmp_path / "other.safetensors"
    train.export(fit("autoencoder", tmp_path / "other", changes={"autoencoder_steps": 1}, seed=1), other)
    fit("text2length", tmp_path / "lengths", other, changes={"length_steps": 1})
    with pytest.raises(CheckpointError, match="base was"):
        fit("text2length", tmp_path / "lengths", stages["autoencoder"], changes={"length_steps": 1})


@pytest.mark.parametrize("without", ["snippet_codes", "attention", "tags", "sides", "position"])
def test_ablations_train_and_generate(stages, tmp_path: Path, without: str) -> None:
    """The paper's "w/o SnC", "w/o Att", "w/o PoS" and "w/o PoE", and ours, from the same weights before."""
    path = tmp_path / "ablated.safetensors"
    state = fit("text2motion", tmp_path / "run", stages["text2length"], changes={without: False, "steps": 2})
    train.export(state, path)
    assert ("motion" in state.history[0]) == (without != "snippet_codes")
    engine = engines.load("text2motion", checkpoint=path)
    engine._encoder = FakeEncoder()
    assert not getattr(engine.config, without)
    assert ("word_attention" in engine.capabilities) == (without != "attention")
    assert len(engine.generate("a person does throw", frames=17)) == 17
    assert engine.lengths("a person does throw").chances.sum() == pytest.approx(1)


def test_snippet_codes_cannot_be_told_without_their_autoencoder(stages, tmp_path: Path) -> None:
    path = tmp_path / "frames.safetensors"
    changes = {"snippet_codes": False, "steps": 1}
    train.export(fit("text2motion", tmp_path / "run", stages["text2length"], changes=changes), path)
    with pytest.raises(CheckpointError, match="snippet_codes=false"):
        fit("text2motion", tmp_path / "again", path)


def test_the_curriculum_moves_on_as_validation_says_and_is_resumed(stages, tmp_path: Path, monkeypatch) -> None:
    rising = iter(float(value) for value in range(100))
    losses = text2motion_losses

    def worse(net, *args) -> dict[str, torch.Tensor]:
        terms = losses(net, *args)
        return terms if net.training else {**terms, "codes": torch.tensor(next(rising))}

    monkeypatch.setattr(train, "text2motion_losses", worse)
    changes = {"curriculum_steps": 0, "steps": 6, "keep_short": False}
    state = fit("text2motion", tmp_path / "run", stages["text2length"], changes=changes)
    assert train.aim(state) == 4  # the first validation is the best so far, the second was worse
    again = fit("text2motion", tmp_path / "run", stages["text2length"], changes=changes, resume=True)
    assert train.aim(again) == 4
    # by steps: three codes at first, all ten at the end
    other, _ = train.start(config(), "text2motion", clips(1), base=stages["text2length"], material=material())
    seen = []
    for other.step in range(5):
        seen.append(train.aim(other))
    assert seen == [3, 5, 7, 10, 10]


def test_short_motions_are_left_out_where_the_paper_leaves_them_out() -> None:
    found = data.mirrored([clip("walk", 16), clip("throw", 39)])
    told = material()
    for keep, expected in ((True, {16, 36}), (False, {36})):
        pairs = data.Pairs(found, config(keep_short=keep, cut_end=0.0), told.told, told.captions)
        rng = np.random.default_rng(0)
        batches = [pairs.draw(rng, 6) for _ in range(20)]
        assert {4 * int(n) for batch in batches for n in batch.whole} == expected
        assert all(int(batch.count.max()) <= 6 for batch in batches)


@pytest.mark.parametrize("stage", STAGES)
def test_one_batch_is_learned_by_heart(stage: str) -> None:
    net = model(dropout=0.0)
    net.freeze_all_but(stage)
    net.train()
    both, told = data.mirrored(clips(1)), material()
    rng, generator = np.random.default_rng(0), torch.Generator()
    window = data.windows(both, net.config).draw(rng)
    pairs = data.Pairs(both, net.config, told.told, told.captions)
    batch, texts = pairs.draw(rng, 6), pairs.draw_texts(rng)

    def terms() -> dict[str, torch.Tensor]:
        if stage == "autoencoder":
            return autoencoder_losses(net, window)
        if stage == "text2length":
            return text2length_losses(net, texts)
        return text2motion_losses(net, batch, generator.manual_seed(0), 1.0, 0.01)

    learning = [p for p in net.parameters() if p.requires_grad]
    frozen = {name: p.clone() for name, p in net.named_parameters() if not p.requires_grad}
    optimiser = torch.optim.Adam(learning, lr=1e-2)
    seen = []
    for _ in range(60):
        made = terms()
        seen.append(sum(value.item() for value in made.values()))
        optimiser.zero_grad()
        torch.stack(list(made.values())).sum().backward()
        optimiser.step()
    assert set(made) == TERMS[stage]
    assert np.mean(seen[-3:]) < 0.7 * seen[0]
    assert all(torch.equal(value, dict(net.named_parameters())[name]) for name, value in frozen.items())


def test_every_weight_of_text2motion_learns() -> None:
    net, told = model(), material()
    net.freeze_all_but("text2motion")
    pairs = data.Pairs(data.mirrored(clips(1)), net.config, told.told, told.captions)
    terms = text2motion_losses(net, pairs.draw(np.random.default_rng(0), 10), torch.Generator(), 0.0, 1.0)
    torch.stack(list(terms.values())).sum().backward()
    reached = {name for name, p in net.named_parameters() if p.grad is not None and p.grad.abs().sum() > 0}
    expected = {name for name, _ in net.named_parameters() if name.startswith(("text2motion.", "autoencoder.decoder."))}
    assert reached == expected


def test_shares_of_a_batch_make_the_whole() -> None:
    net, told = model(), material()
    pairs = data.Pairs(data.mirrored(clips(2)), net.config, told.told, told.captions)

    def everything(share: Share) -> dict[str, torch.Tensor]:
        rng, generator = np.random.default_rng(3), torch.Generator().manual_seed(1)
        batch, texts = pairs.draw(rng, 8, share), pairs.draw_texts(rng, share)
        return {**text2length_losses(net, texts), **text2motion_losses(net, batch, generator, 0.5, 0.1, share)}

    whole, parts = everything(Share()), [everything(Share(rank, 2)) for rank in range(2)]
    for name, value in whole.items():
        torch.testing.assert_close(value, (parts[0][name] + parts[1][name]) / 2, rtol=1e-4, atol=1e-6)


def test_padding_means_nothing() -> None:
    """A motion and its sentence are worth the same in any batch."""
    net, told = model(), material()
    pairs = data.Pairs(data.mirrored(clips(2)), net.config, told.told, told.captions)
    batch = pairs.draw(np.random.default_rng(1), 10)
    assert len(set(batch.count.tolist())) > 1
    spoiled = batch.features.clone()
    for row, count in enumerate(batch.count.tolist()):
        spoiled[row, 4 * count :] = 1e3
    vectors = batch.words.vectors.clone()
    for row, length in enumerate(batch.words.lengths.tolist()):
        vectors[row, length:] = 1e3
    other = batch._replace(features=spoiled, words=batch.words._replace(vectors=vectors))
    made = [text2motion_losses(net, one, torch.Generator().manual_seed(0), 0.5, 0.1) for one in (batch, other)]
    for name, value in made[0].items():
        torch.testing.assert_close(value, made[1][name], msg=name)


def test_a_batch_is_what_the_clips_show() -> None:
    net, told = model(), material()
    both = data.mirrored([clip("throw", 31), clip("walk", 39)])
    pairs = data.Pairs(both, net.config, told.told, told.captions)
    batch = pairs.draw(np.random.default_rng(0), 10)
    assert len(batch.words.vectors) == 2 * len(batch.features)
    assert batch.steps == 2 * float(batch.count.sum())
    frames = {row.tobytes() for place in range(len(both)) for row in pairs.windows.clip(place)}
    for features, count, whole in zip(batch.features, batch.count.tolist(), batch.whole.tolist(), strict=True):
        assert count == whole
        assert all(row.numpy().astype(np.float16).tobytes() in frames for row in features[: 4 * count])
    said = [FakeEncoder().encode([sentence]).tokens[0] for sentence in Said().sentences]
    for vectors, length in zip(batch.words.vectors, batch.words.lengths.tolist(), strict=True):
        assert any(len(one) == length and torch.allclose(one, vectors[:length], atol=2e-3) for one in said)
    assert (batch.words.marks[..., :15].sum(-1) == 1).all()


def test_all_stages_by_one_command(tmp_path: Path) -> None:
    settings = config(**CHANGES)
    options = {"clips": clips(1), "prepare": prepare, "plan": PLAN}
    state = train.fit_all(settings, tmp_path, **options)
    assert train.model_of(state).config.parts == STAGES
    times = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("config.json")}
    assert len(times) == 3
    again = train.fit_all(settings, tmp_path, **options)
    assert all(torch.equal(value, again.averaged[name]) for name, value in state.averaged.items())
    assert again.step == 4


def test_presets() -> None:
    assert preset("small") is SMALL
    assert all(made.checked() == made for made in PRESETS.values())
    assert Text2MotionConfig.from_json(PAPER.to_json()) == PAPER
    assert PAPER.with_steps("text2length", 7).steps_of("text2length") == 7
    with pytest.raises(UnknownLabelError, match="'paper'"):
        preset("papers")
