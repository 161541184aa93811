"""Training TM2T: each stage on from the one before, resuming exactly, one batch learned by heart."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch

import engines
from engines.errors import Cancelled, CheckpointError, MotionloomError, OutOfRangeError, UnknownLabelError
from engines.text import token_vectors
from engines.tm2t import data, train
from engines.tm2t.engine import TM2TEngine
from engines.tm2t.losses import m2t_losses, t2m_losses, vq_losses
from engines.training.devices import Share
from tests.engines.tm2t.tiny import SIZES, FakeEncoder, Said, clip, clips, config, material, model

PLAN = {"log_every": 1, "validate_every": 3, "save_every_seconds": 1e9}
CHANGES = {"steps": 4, "words": (), "parts": (), "texts_each": 2}


def fit(stage: str, folder: Path, base: Path | None = None, **options):
    settings = config(**{**CHANGES, **options.pop("changes", {})})

    def prepare(_config, stage: str) -> train.Material | None:
        return None if stage == "vq" else material()

    return train.fit(
        settings, stage, folder, clips(), base=base, prepare=prepare, validation=clips(1), plan=PLAN, **options
    )


@pytest.fixture(scope="module")
def stages(tmp_path_factory) -> dict[str, Path]:
    """Weights after a few steps of each stage."""
    folder = tmp_path_factory.mktemp("stages")
    made: dict[str, Path] = {}
    before = None
    for stage in ("vq", "m2t", "t2m"):
        state = fit(stage, folder / stage, before)
        assert [line["step"] for line in state.history] == [1, 2, 3, 4]
        assert [line["step"] for line in state.validation] == [3, 4]
        assert all(np.isfinite(value) for line in state.history + state.validation for value in line.values())
        before = made[stage] = folder / f"{stage}.safetensors"
        train.export(state, before)
        train.model_of(state)
    return made


def test_each_stage_learns_its_part_and_keeps_the_others(stages) -> None:
    nets = {stage: train.load(path) for stage, path in stages.items()}
    assert nets["vq"].config.parts == ("tokenizer",)
    assert nets["m2t"].config.parts == ("tokenizer", "motion2text")
    assert nets["t2m"].config.parts == ("tokenizer", "motion2text", "text2motion")
    for earlier, later in (("vq", "m2t"), ("m2t", "t2m")):
        kept = nets[later].state_dict()
        for name, value in nets[earlier].state_dict().items():
            assert torch.equal(value, kept[name]), name
    assert nets["m2t"].config.words == nets["t2m"].config.words != ()
    assert set(nets["t2m"].config.extra) == {f"{s}_{n}" for s in ("vq", "m2t", "t2m") for n in ("step", "seconds")}


def test_what_the_tokenizer_was_trained_with_goes_along(stages) -> None:
    told = config(movement_weight=9.0)
    state, _ = train.start(told, "m2t", clips(1), base=stages["vq"], material=material())
    assert train.model_of(state).config.movement_weight == train.load(stages["vq"]).config.movement_weight != 9.0


def test_weights_make_an_engine(stages) -> None:
    engine = engines.load("tm2t", checkpoint=stages["t2m"])
    engine._encoder = FakeEncoder()
    assert engine.capabilities == {"text", "lengths", "caption", "word_attention", "tokens", "variants"}
    assert len(engine.generate(prompt="a person does throw", frames=10)) == 10
    assert engine.caption(clips(1)[0].motion)[0].sentence
    alone = engines.load("tm2t", checkpoint=stages["m2t"])
    assert alone.capabilities == {"caption", "tokens", "variants"}
    by_transformer = TM2TEngine(model(backbone="transformer"), "")
    assert "text" in by_transformer.capabilities
    assert "word_attention" not in by_transformer.capabilities
    with pytest.raises(MotionloomError, match="no text2motion"):
        alone.generate(prompt="a person walks")
    with pytest.raises(MotionloomError, match="no motion2text"):
        engines.load("tm2t", checkpoint=stages["vq"]).caption(clips(1)[0].motion)


@pytest.mark.parametrize("stage", ["vq", "m2t", "t2m"])
def test_a_training_that_was_stopped_goes_on_as_if_it_had_not_been(stages, stage: str, tmp_path: Path) -> None:
    base = {"vq": None, "m2t": stages["vq"], "t2m": stages["m2t"]}[stage]
    whole = fit(stage, tmp_path / "whole", base)
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
        fit("m2t", tmp_path)
    with pytest.raises(CheckpointError, match="holds no motion2text"):
        fit("t2m", tmp_path, stages["vq"])
    with pytest.raises(UnknownLabelError, match="did you mean 'm2t'"):
        fit("m2", tmp_path)
    with pytest.raises(OutOfRangeError, match="vq_window"):
        fit("vq", tmp_path, changes={"vq_window": 18})
    with pytest.raises(MotionloomError, match="data prepare"):
        train.start(config(), "vq", [])
    state = fit("t2m", tmp_path / "alone", stages["vq"], changes={"alignment": 0.0, "steps": 1})
    assert "inverse_alignment" not in state.history[0]
    assert train.model_of(state).config.words  # to say of a prompt which of its words are not known
    other = tmp_path / "other.safetensors"
    train.export(fit("vq", tmp_path / "other", changes={"steps": 1}, seed=1), other)
    with pytest.raises(CheckpointError, match="base was"):
        fit("t2m", tmp_path / "alone", other, changes={"alignment": 0.0, "steps": 1})


@pytest.mark.parametrize(("stage", "changes"), [
    ("vq", {}), ("vq", {"codebook_update": "gradient"}), ("m2t", {}), ("t2m", {}), ("t2m", {"backbone": "transformer"}),
])  # fmt: skip
def test_one_batch_is_learned_by_heart(stage: str, changes: dict) -> None:
    net = model(**{"dropout": 0.0, "label_smoothing": 0.0, "alignment": 0.3, "codebook_decay": 0.9, **changes})
    net.freeze_all_but({"vq": "tokenizer", "m2t": "motion2text", "t2m": "text2motion"}[stage])
    net.train()
    both = data.mirrored(clips(1))
    told = material()
    rng, generator = np.random.default_rng(0), torch.Generator().manual_seed(0)
    window = data.Windows(both, net.config).draw(rng)
    batch = data.Pairs(both, net, told.told, told.vectors).draw(rng)

    def terms() -> dict[str, torch.Tensor]:
        if stage == "vq":
            return vq_losses(net, window)
        return m2t_losses(net, batch) if stage == "m2t" else t2m_losses(net, batch, True, generator)

    optimiser = torch.optim.Adam([p for p in net.parameters() if p.requires_grad], lr=1e-2)
    frozen = {name: p.clone() for name, p in net.named_parameters() if not p.requires_grad and "codebook" not in name}
    watched = {"vq": "reconstruction", "m2t": "words", "t2m": "tokens"}[stage]
    seen = []
    for _ in range(60 if stage == "vq" else 25):
        made = terms()
        seen.append(float(made[watched].detach()))
        optimiser.zero_grad()
        torch.stack(list(made.values())).sum().backward()
        optimiser.step()
    assert np.mean(seen[-3:]) < (0.85 if stage == "vq" else 0.7) * seen[0]
    assert all(torch.equal(value, dict(net.named_parameters())[name]) for name, value in frozen.items())
    if stage == "t2m":
        assert set(made) == {"tokens", "inverse_alignment"}
        assert net.motion2text is not None
        assert not net.motion2text.training


def test_inverse_alignment_teaches_text2motion() -> None:
    """Gradients of the sentence reach every weight of text2motion, and none of motion2text."""
    net = model()
    net.freeze_all_but("text2motion")
    net.train()
    told = material()
    pairs = data.Pairs(data.mirrored(clips(1)), net, told.told, told.vectors)
    terms = t2m_losses(net, pairs.draw(np.random.default_rng(0)), True, torch.Generator().manual_seed(0))
    terms["inverse_alignment"].backward()
    assert net.text2motion is not None
    assert net.motion2text is not None
    reached = [name for name, p in net.text2motion.named_parameters() if p.grad is not None and p.grad.abs().sum() > 0]
    assert set(reached) == {name for name, _ in net.text2motion.named_parameters()}
    assert all(p.grad is None for p in net.motion2text.parameters())


def test_shares_of_a_batch_make_the_whole() -> None:
    net = model(dropout=0.0).eval()
    told = material()
    pairs = data.Pairs(data.mirrored(clips(2)), net, told.told, told.vectors)
    windows = data.Windows(data.mirrored(clips(2)), net.config)

    def everything(share: Share) -> dict[str, torch.Tensor]:
        rng, generator = np.random.default_rng(3), torch.Generator().manual_seed(1)
        batch = pairs.draw(rng, share)
        return {**m2t_losses(net, batch), **t2m_losses(net, batch, True, generator, share)}

    whole, parts = everything(Share()), [everything(Share(rank, 2)) for rank in range(2)]
    for name, value in whole.items():
        torch.testing.assert_close(value, (parts[0][name] + parts[1][name]) / 2, rtol=1e-4, atol=1e-6)
    rows = windows.draw(np.random.default_rng(3))
    assert torch.equal(windows.draw(np.random.default_rng(3), Share(1, 2)), rows[1::2])


def test_windows_and_tokens_are_what_the_clips_show() -> None:
    net = model()
    both = data.mirrored(clips(2))
    windows = data.Windows(both, net.config)
    assert len(windows) == 2 * len(clips(2))
    rows = windows.draw(np.random.default_rng(0))
    assert rows.shape == (SIZES["vq_batch_size"], SIZES["vq_window"], 263)
    firsts = {windows.clip(place)[:, 0].tobytes() for place in range(len(windows))}
    assert any(rows[0, :, 0].numpy().astype(np.float16).tobytes() in first for first in firsts)
    coded = data.tokens_of(windows.clip(0), net)
    assert coded.shape[0] == data.OFFSETS
    features = torch.from_numpy(windows.clip(0).astype(np.float32))
    for offset in range(data.OFFSETS):
        cut = features[offset : offset + 4 * coded.shape[1]]
        assert net.tokenizer.encode(net.normalised(cut)[None])[0].tolist() == coded[offset].tolist()


def test_a_batch_has_several_captions_of_each_motion() -> None:
    net, told = model(), material()
    pairs = data.Pairs(data.mirrored([clip("throw"), clip("walk", 30)]), net, told.told, told.vectors)
    batch = pairs.draw(np.random.default_rng(0))
    assert len(batch.words) == len(batch.vectors) == 2 * len(batch.tokens)
    said = Said().sentences
    for row, length, vectors in zip(batch.words, batch.lengths.tolist(), batch.vectors, strict=True):
        sentence = net.words.sentence(row.tolist())
        assert sentence in said
        expected = FakeEncoder().encode([sentence]).tokens[0]
        torch.testing.assert_close(vectors[:length], expected[:length], atol=1e-3, rtol=1e-2)
        assert (vectors[length:] == 0).all()
    for first, second in batch.words.unflatten(0, (-1, 2)):
        assert not torch.equal(first, second)
    assert batch.steps == (batch.tokens != net.tokens.pad).sum() * 2 - len(batch.words)
    assert batch.said == (batch.words != net.words.pad).sum() - len(batch.words)


def test_clips_too_long_for_their_caption_are_left_out() -> None:
    net, told = model(), material()
    both = data.mirrored([clip("walk", 30), clip("throw", 80)])
    assert len(data.Pairs(both, net, told.told)) == 2
    with pytest.raises(MotionloomError, match="length"):
        data.Pairs(both[2:], net, told.told)


def test_token_vectors_are_kept(tmp_path: Path) -> None:
    said = Said().sentences
    made = token_vectors.load(said, FakeEncoder(), tmp_path)
    again = token_vectors.load(said, FakeEncoder(), tmp_path)
    np.testing.assert_array_equal(made.vectors, again.vectors)
    assert len(list(tmp_path.iterdir())) == 2
    token_vectors.load(said[:2], FakeEncoder(), tmp_path)
    assert len(list(tmp_path.iterdir())) == 4
    with pytest.raises(Cancelled):
        token_vectors.load(said[:1], FakeEncoder(), tmp_path, cancel=lambda: True)
    assert len(list(tmp_path.iterdir())) == 4
