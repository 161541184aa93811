"""Captions as vectors: made once, read again, made anew when what they rest on changes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch

from engines import datasets, text
from engines.datasets import Clip
from engines.datasets.captions import captions, encoded
from engines.errors import Cancelled, FormatError, UnknownLabelError
from tests.engines.action2motion.tiny import movement


class Letters:
    """A text encoder that needs no weights: how often each letter occurs."""

    name, size = "letters", 26

    def __init__(self) -> None:
        self.asked: list[str] = []

    def encode(self, sentences) -> text.EncodedText:
        self.asked += sentences
        counts = [[s.lower().count(chr(97 + k)) + 0.1 for k in range(26)] for s in sentences]
        rows = torch.nn.functional.normalize(torch.tensor(counts), dim=-1)
        return text.EncodedText(rows, rows[:, None], torch.ones(len(rows), 1, dtype=torch.bool))


def clips() -> list[Clip]:
    made = []
    for i, action in enumerate(("wave left hand", "walk", "walk")):
        made.append(Clip("cmu", f"{i}", action, None, None, None, "train", movement(50, seed=i)))
    return made


@pytest.fixture
def prepared(monkeypatch, tmp_path):
    """Clips as if prepared, an encoder as if installed, and a cache of their own."""
    known, encoder = clips(), Letters()
    monkeypatch.setenv("MOTIONLOOM_CACHE", str(tmp_path))
    monkeypatch.setattr(datasets, "load", lambda *_: known)
    monkeypatch.setattr(text, "load", lambda _name: encoder)
    return known, encoder


def test_each_clip_and_its_mirror_image_has_its_captions() -> None:
    known, encoder = clips(), Letters()
    made = encoded.make(known, encoder)
    for clip in (*known, *(clip.mirror() for clip in known)):
        assert [made.sentences[row] for row in made.of(clip)] == captions(clip, encoded.SEED, encoded.COUNT)
    assert len(set(made.sentences)) == len(made.sentences) == len(made.vectors) == len(encoder.asked)
    want = encoder.encode(made.sentences).sentences.numpy()
    np.testing.assert_allclose(made.vectors, want, atol=1e-3)
    assert made.vectors.dtype == np.float16


def test_what_was_kept_is_what_was_made(prepared) -> None:
    known, encoder = prepared
    made = encoded.load()
    asked = len(encoder.asked)
    again = encoded.load()
    assert len(encoder.asked) == asked  # nothing is encoded twice
    assert again.sentences == made.sentences
    np.testing.assert_array_equal(again.vectors, made.vectors)
    for clip in known:
        np.testing.assert_array_equal(again.of(clip), made.of(clip))
    with pytest.raises(ValueError, match="read-only"):
        again.vectors[0] = 0


@pytest.mark.parametrize("change", ["clip", "file"])
def test_made_anew_for_other_clips_and_from_a_damaged_file(prepared, change) -> None:
    known, _encoder = prepared
    encoded.load()
    if change == "clip":
        known[0] = replace(known[0], sentences=("He waves to a friend",))
        assert "He waves to a friend." in encoded.load().sentences
    else:
        path = next(datasets.cache_folder().glob("captions-*.npz"))
        path.write_bytes(path.read_bytes()[:-200])
        assert encoded.load().sentences


def test_stopping_writes_nothing(prepared) -> None:
    with pytest.raises(Cancelled):
        encoded.load(cancel=lambda: True)
    assert not list(datasets.cache_folder().glob("*"))


def test_a_clip_that_was_not_prepared(prepared) -> None:
    with pytest.raises(UnknownLabelError, match="cmu/0"):
        encoded.load().of(replace(clips()[0], name="00"))


def test_progress_is_told_and_ends_at_the_end(prepared) -> None:
    heard: list[tuple[int, int, str]] = []
    made = encoded.load(progress=lambda *now: heard.append(now))
    assert heard[2] == (3, 3, "clip")
    assert heard[-1] == (len(made.sentences), len(made.sentences), "sentence")


def test_no_prepared_data(monkeypatch, tmp_path) -> None:
    monkeypatch.setenv("MOTIONLOOM_CACHE", str(tmp_path))
    with pytest.raises(FormatError, match="motionloom data prepare"):
        encoded.load()
