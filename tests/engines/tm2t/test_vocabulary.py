"""Sentences as indices and back; marks."""

from __future__ import annotations

import numpy as np
import pytest

from engines.text.words import Words, split
from engines.tm2t.vocabulary import MotionTokens

SENTENCES = (
    "A person walks forward, taking about two seconds.",
    "Somebody dances with a turning jeté.",
    "The giant's step is heavy.",
    "A 90-degree turn to the left.",
)


@pytest.mark.parametrize("sentence", SENTENCES)
def test_there_and_back(sentence: str) -> None:
    words = Words.of(SENTENCES)
    assert words.sentence(words.indices(sentence).tolist()) == sentence


def test_frequent_words_come_first() -> None:
    words = Words.of(["walk walk run", "walk"])
    assert words.known == ("walk", "run")
    assert words.indices("run, walk home").tolist() == [1, 0]
    assert "walk" in words
    assert "home" not in words


def test_rows_have_marks_and_padding() -> None:
    tokens = MotionTokens(4)
    assert tokens.rows([np.array([2, 3]), np.array([1])]).tolist() == [[4, 2, 3, 5], [4, 1, 5, 6]]
    words = Words(("a", "b"))
    assert words.rows([np.array([1]), np.array([], dtype=int)]).tolist() == [[2, 1, 3], [2, 3, 4]]
    assert (tokens.size, words.size) == (7, 5)


def test_split_takes_digits_one_by_one() -> None:
    assert split("A 12-step Jeté!") == ["a", "1", "2", "-", "step", "jeté", "!"]
