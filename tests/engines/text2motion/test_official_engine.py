"""The engine on a folder with the authors' files: made here under their names, as their code would write them."""

from __future__ import annotations

import pickle
import re
from pathlib import Path

import numpy as np
import pytest
import torch

import engines
from engines.errors import Cancelled, CheckpointError, MotionloomError, OutOfRangeError
from engines.features import get
from engines.skeletons import SMPL22
from engines.text import tags
from engines.text2motion import official
from engines.text2motion.model import Autoencoder, Sizes, TemporalVAE
from engines.text2motion.networks import LengthEstimator
from engines.text2motion.official_weights import from_official, lengths_of, parts_of, vae_of
from tests.engines.text2motion.tiny import movement

WORD = 6
WORDS = ["a", "person", "walk", "run", "wave", "left", "hand", "with", "the", "unk", "sos", "eos"]
VAE_BACK = (
    (r"^reader\.", "text_enc."), (r"^attention\.query\.", "att_layer.W_q."), (r"^attention\.key\.", "att_layer.W_k."),
    (r"^attention\.value\.", "att_layer.W_v."), (r"^prior\.", "seq_pri."), (r"^posterior\.", "seq_post."),
    (r"^generator\.", "seq_dec."), (r"\.tag\.", ".pos_emb."), (r"\.input\.", ".input_emb."), (r"\.start$", ".hidden"),
    (r"\.embed\.", ".emb."), (r"\.first\.", ".z2init."), (r"\.cells\.", ".gru."), (r"\.mean\.", ".mu_net."),
    (r"\.logvar\.", ".logvar_net."), (r"\.head\.", ".output."),
)  # fmt: skip
AUTOENCODER_BACK = (
    (r"^encoder\.first\.", "mov_enc.main.0."), (r"^encoder\.second\.", "mov_enc.main.3."),
    (r"^encoder\.out\.", "mov_enc.out_net."), (r"^decoder\.first\.", "mov_dec.main.0."),
    (r"^decoder\.second\.", "mov_dec.main.2."), (r"^decoder\.out\.", "mov_dec.out_net."),
)  # fmt: skip
LENGTHS_BACK = (
    (r"^reader\.", ""), (r"^tag\.", "pos_emb."), (r"^input\.", "input_emb."), (r"^start$", "hidden"),
    (r"^head\.", "output."),
)  # fmt: skip


def renamed(state: dict, back) -> dict[str, torch.Tensor]:
    made = {}
    for ours, value in state.items():
        name = ours
        for pattern, theirs in back:
            name = re.sub(pattern, theirs, name)
        made[name] = value
    return made


def sections(state: dict) -> dict[str, dict[str, torch.Tensor]]:
    made: dict[str, dict[str, torch.Tensor]] = {}
    for name, value in state.items():
        section, _, rest = name.partition(".")
        made.setdefault(section, {})[rest] = value
    return made


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """As the release keeps its files."""
    torch.manual_seed(0)
    folder = tmp_path_factory.mktemp("official")
    features = get("humanml3d-official").encode(movement(60))
    vae = renamed(TemporalVAE(Sizes(WORD, 15, 5, 8, 4, 10, 12, 7, 1, release=True)).state_dict(), VAE_BACK)
    tables = {f"{name}.positional_encoder.pe": torch.zeros(300, 10) for name in ("seq_pri", "seq_post", "seq_dec")}
    first, tuned = (renamed(Autoencoder(263, 4, (9, 11), 7).state_dict(), AUTOENCODER_BACK) for _ in range(2))
    alone = {name.replace("mov_", "movement_"): value for name, value in first.items()}
    lengths = renamed(LengthEstimator(WORD, 15, 5, 50).state_dict(), LENGTHS_BACK)
    for name, content in {
        "Decomp/model/latest.tar": {**sections(alone), "ep": 3},
        "Comp/model/latest.tar": {**sections({**vae, **tables, **tuned}), "ep": 3, "opt_seq_pri": {"state": {}}},
        "length_est/model/latest.tar": {"estimator": lengths, "ep": 3},
    }.items():
        (folder / name).parent.mkdir(parents=True)
        torch.save(content, folder / name)
    (folder / "Comp" / "meta").mkdir()
    np.save(folder / "Comp" / "meta" / "mean.npy", features.mean(0))
    np.save(folder / "Comp" / "meta" / "std.npy", np.full(263, 0.1, dtype=np.float32))
    np.save(folder / "our_vab_data.npy", np.random.default_rng(0).normal(size=(len(WORDS), WORD)))
    (folder / "our_vab_words.pkl").write_bytes(pickle.dumps(WORDS))
    return folder


def test_names_go_there_and_back(folder: Path) -> None:
    parts = parts_of(folder / "Comp/model/latest.tar")
    assert parts.vae is not None and parts.autoencoder is not None and parts.lengths is None
    state = renamed(parts.vae.state_dict(), VAE_BACK)
    assert set(from_official(state)) == set(parts.vae.state_dict())
    assert parts.vae.sizes == Sizes(WORD, 15, 5, 8, 4, 10, 12, 7, 1, release=True)
    alone = parts_of(folder / "Decomp/model/latest.tar")
    assert alone.autoencoder is not None and alone.vae is None
    assert parts_of(folder / "length_est/model/latest.tar").lengths is not None


def test_a_folder_makes_an_engine(folder: Path) -> None:
    engine = engines.load("text2motion", checkpoint=folder)
    assert (engine.name, engine.variant, engine.fps) == ("text2motion", "official", 20.0)
    assert engine.capabilities == {"text", "lengths"}
    tuned = parts_of(folder / "Comp/model/latest.tar").autoencoder
    assert tuned is not None
    assert torch.equal(engine.autoencoder.decoder.first.weight, tuned.decoder.first.weight)
    many = engine.generate_many(prompt="A person gallops", count=2, frames=18, seed=3)
    again = engine.generate_many(prompt="A person gallops", count=2, frames=18, seed=3)
    for index, (motion, same) in enumerate(zip(many, again, strict=True)):
        assert (motion.skeleton, len(motion)) == (SMPL22, 18)
        np.testing.assert_array_equal(motion.rotations, same.rotations)
        assert motion.provenance.index == index
        assert motion.provenance.parameters["unmet"] == ["The released words have no 'gallops'."]
        assert motion.label_at(0, "text") == "A person gallops"
    free = engine.generate("a person walks with the left hand")
    assert 4 <= len(free) <= engine.max_frames
    assert "unmet" not in free.provenance.parameters
    told = engine.lengths("a person walks")
    assert told.frames.tolist() == list(range(4, 200, 4))
    assert told.chances.sum() == pytest.approx(1)


def test_words_are_looked_up_as_the_release_has_them(folder: Path) -> None:
    engine = engines.load("text2motion", checkpoint=folder)
    read, unknown = engine.read("Persons walked, waving the left hands quickly")
    expected = ["sos", "person", "walk", "wave", "the", "left", "hand", "unk", "eos"]
    np.testing.assert_allclose(read.vectors[0], np.stack([engine.words.vector(word) for word in expected]))
    assert unknown == ["quickly"]
    kinds = [tags.TAGS[place] for place in read.marks[0].argmax(-1).tolist()]
    assert kinds == ["OTHER", "NOUN", "action", "VERB", "DET", "direction", "body part", "OTHER", "OTHER"]
    long, _ = engine.read("walk " * 40)
    assert long.vectors.shape[1] == official.SENTENCE + 2


def test_few_codes_are_drawn_anew() -> None:
    logits = torch.full((50,), -torch.inf)
    logits[[2, 20]] = 0.0
    low, high = 0.1, 0.9
    assert official.drawn_length(logits, torch.tensor([low, high, low]), 10) == 20
    assert official.drawn_length(logits, torch.tensor([low, low, low]), 10) == 2
    assert official.drawn_length(logits, torch.tensor([low, high, low]), 1) == 2
    logits[0], logits[2], logits[20] = 9.0, -torch.inf, -torch.inf
    assert official.drawn_length(logits, torch.tensor([low, low, low]), 10) == 1


def test_what_is_refused(folder: Path) -> None:
    engine = engines.load("text2motion", checkpoint=folder)
    for wrong in ({"count": 0}, {"frames": 0}, {"frames": 197}, {"seed": -1}):
        with pytest.raises(OutOfRangeError):
            engine.generate_many(prompt="walk", **wrong)
    with pytest.raises(MotionloomError, match="empty"):
        engine.generate_many()
    with pytest.raises(Cancelled):
        engine.generate_many(prompt="walk", cancel=lambda: True)


def copied(folder: Path, to: Path, *left_out: str) -> Path:
    for path in folder.rglob("*.*"):
        if path.is_file() and path.relative_to(folder).as_posix() not in left_out:
            (to / path.relative_to(folder)).parent.mkdir(parents=True, exist_ok=True)
            (to / path.relative_to(folder)).write_bytes(path.read_bytes())
    return to


def test_without_an_estimator_lengths_must_be_said(folder: Path, tmp_path: Path) -> None:
    engine = engines.load("text2motion", checkpoint=copied(folder, tmp_path, "length_est/model/latest.tar"))
    assert engine.capabilities == {"text"}
    assert len(engine.generate("walk", seconds=1)) == 20
    for ask in (engine.generate, engine.lengths):
        with pytest.raises(MotionloomError, match="say it"):
            ask("walk")


def test_damaged_folders_are_refused(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    with pytest.raises(CheckpointError, match="no checkpoint"):
        engines.load("text2motion", checkpoint=tmp_path / "empty")
    for name in ("Comp/meta/mean.npy", "our_vab_words.pkl"):
        short = Path(name).name
        with pytest.raises(CheckpointError, match=short):
            engines.load("text2motion", checkpoint=copied(folder, tmp_path / f"without-{short}", name))
    evil = copied(folder, tmp_path / "evil")
    (evil / "our_vab_words.pkl").write_bytes(pickle.dumps([print]))
    with pytest.raises(CheckpointError, match=r"builtins\.print"):
        engines.load("text2motion", checkpoint=evil)
    with pytest.raises(CheckpointError, match="text2motion and its autoencoder"):
        engines.load("text2motion", checkpoint=copied(folder, tmp_path / "alone", "Comp/model/latest.tar"))
    other = copied(folder, tmp_path / "other")
    np.save(other / "our_vab_data.npy", np.zeros((len(WORDS), WORD + 1)))
    with pytest.raises(CheckpointError, match="the words have 7"):
        engines.load("text2motion", checkpoint=other)
    wide = copied(folder, tmp_path / "wide")
    np.save(wide / "Comp" / "meta" / "std.npy", np.zeros(260))
    with pytest.raises(CheckpointError, match="263 or 251"):
        engines.load("text2motion", checkpoint=wide)
    broken = copied(folder, tmp_path / "broken")
    (broken / "Comp/model/latest.tar").write_bytes(b"no checkpoint")
    with pytest.raises(CheckpointError, match="cannot be read"):
        engines.load("text2motion", checkpoint=broken)
    with pytest.raises(CheckpointError, match="not the weights"):
        vae_of({"seq_pri.emb.0.weight": torch.zeros(2, 2)})
    with pytest.raises(CheckpointError, match="not the weights"):
        lengths_of({"pos_emb.weight": torch.zeros(2, 2)})


def test_packed_steps_make_what_the_release_makes(folder: Path) -> None:
    engine = engines.load("text2motion", checkpoint=folder)
    quick = engine.generate_many(prompt="a person walks", count=3, seed=1)
    assert len({len(motion) for motion in quick}) > 1
    engine._packed = None
    for motion, same in zip(quick, engine.generate_many(prompt="a person walks", count=3, seed=1), strict=True):
        np.testing.assert_allclose(motion.positions, same.positions, atol=1e-4)
