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
from engines.tm2t.attentive import AttentiveGRU, GRUSizes
from engines.tm2t.official_weights import from_official, parts_of, tokenizer_of, translator_of
from engines.tm2t.tokenizer import Codebook, MotionTokenizer
from engines.tm2t.transformer import Sizes, Translator
from tests.engines.tm2t.tiny import movement

CODES, TEXT = 12, 6
WORDS = ["a", "person", "walk", "run", "wave", "unk", "sos", "eos"]
BACK = (
    (r"^encoder\.embed\.", "encoder.src_word_emb."), (r"^decoder\.embed\.", "decoder.trg_word_emb."),
    (r"layers\.", "layer_stack."), (r"attention\.", "slf_attn."), (r"cross\.", "enc_attn."), (r"feed\.", "pos_ffn."),
    (r"query\.", "w_qs."), (r"key\.", "w_ks."), (r"value\.", "w_vs."), (r"\.out\.", ".fc."), (r"inner\.", "w_1."),
    (r"outer\.", "w_2."), (r"norm\.", "layer_norm."),
)  # fmt: skip
GRU_BACK = (
    (r"^reader\.start", "text_encoder.hidden"), (r"^reader\.input\.", "text_encoder.input_emb."),
    (r"^reader\.gru\.", "text_encoder.gru."), (r"^embed\.", "motion_decoder_step.input_emb."),
    (r"^first\.", "motion_decoder_step.z2init."), (r"^attention\.query\.", "motion_decoder_step.att_layer.W_q."),
    (r"^attention\.key\.", "motion_decoder_step.att_layer.W_k."),
    (r"^attention\.value\.", "motion_decoder_step.att_layer.W_v."), (r"^mix\.", "motion_decoder_step.att_linear."),
    (r"^cells\.", "motion_decoder_step.gru."),
)  # fmt: skip
VQ_BACK = (
    (r"^codebook\.", "quantizer.embedding."), (r"^encoder\.", "vq_encoder."), (r"^decoder\.", "vq_decoder."),
    (r"layers\.(\d+)\.layers\.", r"main.\1.model."), (r"layers\.", "main."),
)  # fmt: skip


def renamed(state: dict, back) -> dict[str, torch.Tensor]:
    made = {}
    for ours, value in state.items():
        name = ours
        for pattern, theirs in back:
            name = re.sub(pattern, theirs, name)
        made[name] = value
    return made


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """As the release keeps its files."""
    torch.manual_seed(0)
    folder = tmp_path_factory.mktemp("official")
    codec = get("humanml3d-official")
    features = codec.encode(movement(60))
    vq = renamed(MotionTokenizer(263, 4, [8, 8], [8, 8, 263], 2, Codebook(CODES, 8)).state_dict(), VQ_BACK)
    sections: dict[str, dict] = {}
    for name, value in vq.items():
        section, _, rest = name.partition(".")
        sections.setdefault(section, {})[rest] = value
    sections["quantizer"]["embedding.weight"] = torch.randn(CODES, 8)
    for name, content in {
        "VQVAE/model/finest.tar": {**sections, "ep": 3, "opt": {"state": {}}},
        "T2M/model/finest.tar": {"t2m_model": gru(), "ep": 3},
        "M2T/model/finest.tar": {"m2t_transformer": transformer(), "ep": 3},
    }.items():
        (folder / name).parent.mkdir(parents=True)
        torch.save(content, folder / name)
    (folder / "meta").mkdir()
    np.save(folder / "meta" / "mean.npy", features.mean(0))
    np.save(folder / "meta" / "std.npy", np.full(263, 0.1, dtype=np.float32))
    np.save(folder / "our_vab_data.npy", np.random.default_rng(0).normal(size=(len(WORDS), TEXT)).astype(np.float32))
    (folder / "our_vab_words.pkl").write_bytes(pickle.dumps(WORDS))
    return folder


def gru() -> dict[str, torch.Tensor]:
    made = renamed(AttentiveGRU(GRUSizes(TEXT, CODES + 3, 4, 6)).state_dict(), GRU_BACK)
    return {**made, "motion_decoder_step.trg_word_prj.weight": made["motion_decoder_step.input_emb.weight"]}


def transformer() -> dict[str, torch.Tensor]:
    sizes = Sizes(CODES + 3, len(WORDS) + 1, 16, 24, 2, 8, 2, 100, 50)
    made = renamed(Translator(sizes).state_dict(), BACK)
    tables = {
        f"{side}.position_enc.positional_encoding": torch.zeros(n, 16)
        for side, n in (("encoder", 100), ("decoder", 50))
    }
    return {**made, **tables, "trg_word_prj.weight": made["decoder.trg_word_emb.weight"]}


def test_names_go_there_and_back(folder: Path) -> None:
    parts = parts_of(folder / "VQVAE/model/finest.tar")
    assert parts.tokenizer is not None
    assert parts.text2motion is None
    assert set(renamed(from_official(gru()), GRU_BACK)) == set(gru()) - {"motion_decoder_step.trg_word_prj.weight"}
    net = translator_of(transformer())
    assert (net.sizes.layers, net.sizes.heads, net.sizes.source_places, net.sizes.tied) == (2, 8, 100, True)


def test_a_folder_makes_an_engine(folder: Path) -> None:
    engine = engines.load("tm2t", checkpoint=folder)
    assert (engine.name, engine.variant, engine.fps) == ("tm2t", "official", 20.0)
    assert engine.capabilities == {"text", "lengths", "caption"}
    many = engine.generate_many(prompt="A person gallops", count=2, frames=18, seed=3)
    again = engine.generate_many(prompt="A person gallops", count=2, frames=18, seed=3)
    for index, (motion, same) in enumerate(zip(many, again, strict=True)):
        assert (motion.skeleton, len(motion)) == (SMPL22, 18)
        np.testing.assert_array_equal(motion.rotations, same.rotations)
        assert motion.provenance.index == index
        assert motion.provenance.parameters["unmet"] == ["The released words have no 'gallops'."]
        assert motion.label_at(0, "text") == "A person gallops"
    free = engine.generate("a person walks, then runs")
    assert 4 <= len(free) <= engine.max_frames
    assert "unmet" not in engine.generate("walking person").provenance.parameters
    (told,) = engine.caption(movement(40), beams=3)
    assert isinstance(told.sentence, str)
    assert "sos" not in told.sentence.lower()


def test_what_is_refused(folder: Path) -> None:
    engine = engines.load("tm2t", checkpoint=folder)
    for wrong in ({"count": 0}, {"frames": 0}, {"frames": 197}):
        with pytest.raises(OutOfRangeError):
            engine.generate_many(prompt="walk", **wrong)
    with pytest.raises(MotionloomError, match="empty"):
        engine.generate_many()
    with pytest.raises(Cancelled):
        engine.generate_many(prompt="walk", cancel=lambda: True)
    with pytest.raises(OutOfRangeError, match="beams"):
        engine.caption(movement(20), beams=0)


def copied(folder: Path, to: Path, *left_out: str) -> Path:
    for path in folder.rglob("*.*"):
        if path.is_file() and path.name not in left_out:
            (to / path.relative_to(folder)).parent.mkdir(parents=True, exist_ok=True)
            (to / path.relative_to(folder)).write_bytes(path.read_bytes())
    return to


def test_damaged_folders_are_refused(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    with pytest.raises(CheckpointError, match="no checkpoint"):
        engines.load("tm2t", checkpoint=tmp_path / "empty")
    for name in ("mean.npy", "our_vab_words.pkl"):
        with pytest.raises(CheckpointError, match=name):
            engines.load("tm2t", checkpoint=copied(folder, tmp_path / f"without-{name}", name))
    evil = copied(folder, tmp_path / "evil")
    (evil / "our_vab_words.pkl").write_bytes(pickle.dumps([print]))
    with pytest.raises(CheckpointError, match=r"builtins\.print"):
        engines.load("tm2t", checkpoint=evil)
    alone = copied(folder, tmp_path / "alone")
    (alone / "VQVAE/model/finest.tar").unlink()
    with pytest.raises(CheckpointError, match="tokenizer"):
        engines.load("tm2t", checkpoint=alone)
    broken = copied(folder, tmp_path / "broken")
    (broken / "T2M/model/finest.tar").write_bytes(b"no checkpoint")
    with pytest.raises(CheckpointError, match="cannot be read"):
        engines.load("tm2t", checkpoint=broken)
    with pytest.raises(CheckpointError, match="not the weights"):
        tokenizer_of({"vq_encoder.main.0.weight": torch.zeros(2, 2, 4)})
