"""What a sentence is to networks: the encoder's numbers, and the sides it names."""

from __future__ import annotations

import numpy as np
import pytest

from engines.text import sides

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
    assert set(np.flatnonzero(sides.named([sentence])[0])) == named


def test_they_stand_beside_what_the_encoder_makes() -> None:
    vectors = np.random.default_rng(0).normal(size=(2, sides.ENCODED)).astype(np.float16)
    made = sides.joined(vectors, ["go left", "stand"])
    assert made.shape == (2, sides.SIZE)
    assert made.dtype == np.float16
    assert (made[:, : sides.ENCODED] == vectors).all()
    assert made[0, sides.ENCODED :].any()
    assert not made[1, sides.ENCODED :].any()
    assert sides.joined(vectors[:0], []).shape == (0, sides.SIZE)
