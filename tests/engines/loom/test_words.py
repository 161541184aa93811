"""What a sentence is to Loom: the encoder's numbers, and the sides it names."""

from __future__ import annotations

import numpy as np
import pytest

from engines.loom import words

LEFT, RIGHT, BOTH, AHEAD, BACK, CLOCKWISE, COUNTER = range(7)


@pytest.mark.parametrize(
    ("sentence", "named"),
    [
        ("A person waves.", set()),
        ("Raise the LEFT hand", {LEFT}),
        ("turns right, then waves with both hands", {RIGHT, BOTH}),
        ("walk ahead and swing round to the left.", {AHEAD, LEFT}),
        ("steps backwards", {BACK}),
        ("draws a circle counter-clockwise", {COUNTER}),
        ("draws a circle clockwise", {CLOCKWISE}),
        ("a bright leftover", set()),
    ],
)
def test_sides_that_are_named(sentence: str, named: set[int]) -> None:
    assert set(np.flatnonzero(words.sides([sentence])[0])) == named


def test_they_stand_beside_what_the_encoder_makes() -> None:
    vectors = np.random.default_rng(0).normal(size=(2, words.ENCODED)).astype(np.float16)
    made = words.joined(vectors, ["go left", "stand"])
    assert made.shape == (2, words.SIZE)
    assert made.dtype == np.float16
    assert (made[:, : words.ENCODED] == vectors).all()
    assert made[0, words.ENCODED :].any()
    assert not made[1, words.ENCODED :].any()
    assert words.joined(vectors[:0], []).shape == (0, words.SIZE)
