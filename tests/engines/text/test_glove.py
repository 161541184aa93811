"""GloVe vectors in both layouts, kept after the first reading, and what is said where there are none."""

from __future__ import annotations

import pickle
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import torch

from engines import datasets, text
from engines.errors import CheckpointError
from engines.text import glove

LINES = "the 0.5 -1 2\nwalk 1 2 3\n. . . 4 5 6\nunk 9 9 9\n"


@pytest.fixture(autouse=True)
def cache(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[Path]:
    monkeypatch.setenv("MOTIONLOOM_CACHE", str(tmp_path / "cache"))
    monkeypatch.delenv("MOTIONLOOM_GLOVE", raising=False)
    text.load.cache_clear()
    yield tmp_path / "cache"
    text.load.cache_clear()


def test_a_text_file_is_read_once_and_kept(cache: Path, tmp_path: Path, monkeypatch) -> None:
    file = tmp_path / "glove.3d.txt"
    file.write_text(LINES, encoding="utf-8")
    made = glove.load(file)
    assert (made.size, made.words) == (3, ("the", "walk", ". . .", "unk"))
    np.testing.assert_array_equal(made.vector("walk"), [1, 2, 3])
    np.testing.assert_array_equal(made.vector("gallop"), [9, 9, 9])
    assert "walk" in made and "gallop" not in made
    monkeypatch.setattr(glove, "_read_text", lambda path: pytest.fail("read again"))
    again = glove.load(file)
    assert again.words == made.words
    np.testing.assert_array_equal(again.vectors, made.vectors)


def test_sentences_are_vectors_of_words_between_marks() -> None:
    made = glove.GloVe(["sos", "eos", "unk", "walk", "on"], np.eye(5)[:, :4])
    encoded = made.encode(["Walk on!", "walk"])
    assert encoded.tokens.shape == (2, 5, 4)
    assert encoded.mask.sum(1).tolist() == [5, 3]
    expected = np.stack([made.vector(word) for word in ("sos", "walk", "eos")])
    np.testing.assert_array_equal(encoded.tokens[1, :3], expected)
    assert (encoded.tokens[1, 3:] == 0).all()
    torch.testing.assert_close(encoded.sentences.norm(dim=-1), torch.ones(2))
    assert made.pieces(["Walk on!"]) == [["walk", "on", "!"]]
    plain = glove.GloVe(["unk", "walk"], np.ones((2, 3)))
    assert plain.encode(["walk"]).tokens[0, :, 0].tolist() == [0, 1, 0]  # marks that plain GloVe does not have


def test_it_is_found_by_name(cache: Path, tmp_path: Path, monkeypatch) -> None:
    with pytest.raises(CheckpointError, match="MOTIONLOOM_GLOVE"):
        text.load("glove")
    place = datasets.cache_folder() / "glove"
    assert place.is_relative_to(cache)
    place.mkdir(parents=True)
    (place / "glove.3d.txt").write_text(LINES, encoding="utf-8")
    assert text.load("glove").size == 3
    text.load.cache_clear()
    folder = tmp_path / "papers"
    folder.mkdir()
    np.save(folder / "our_vab_data.npy", np.zeros((2, 5)))
    (folder / "our_vab_words.pkl").write_bytes(pickle.dumps(["unk", "walk"]))
    monkeypatch.setenv("MOTIONLOOM_GLOVE", str(folder))
    assert text.load("glove").size == 5


def test_what_cannot_be_read_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "glove.txt"
    for content in ("", "walk\n", "walk 1 2\nrun 1 2 x\n", "walk 1 2\nrun 1\n"):
        file.write_text(content, encoding="utf-8")
        with pytest.raises(CheckpointError, match=r"glove\.txt"):
            glove.load(file)
    (tmp_path / "our_vab_words.pkl").write_bytes(pickle.dumps([print]))
    with pytest.raises(CheckpointError, match=r"builtins\.print"):
        glove.load(tmp_path)
    (tmp_path / "our_vab_words.pkl").write_bytes(pickle.dumps({"walk": 1}))
    with pytest.raises(CheckpointError, match="a dict"):
        glove.load(tmp_path)
    (tmp_path / "our_vab_words.pkl").write_bytes(pickle.dumps(["walk"]))
    with pytest.raises(CheckpointError, match=r"our_vab_data\.npy"):
        glove.load(tmp_path)
    np.save(tmp_path / "our_vab_data.npy", np.zeros((2, 5)))
    with pytest.raises(CheckpointError, match="1 words do not go with"):
        glove.load(tmp_path)
