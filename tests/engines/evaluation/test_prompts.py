"""The two lists of sentences, and what is made of the answers to one."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from itertools import combinations
from types import SimpleNamespace
from typing import Any, cast

import pytest

from engines.actions import VOCABULARY
from engines.evaluation.prompts import PROMPTS, Answer, answers
from engines.evaluation.prompts_more import MORE
from engines.metrics.evaluators import Recogniser

NAMES = {action.name for action in VOCABULARY}


class Fake:
    """Sees in a "motion" the name it carries, and notes how many motions it was shown at a time."""

    def __init__(self) -> None:
        self.shown: list[int] = []

    def recognise(self, motions: Sequence[Any]) -> list[str]:
        self.shown.append(len(motions))
        return [motion.name for motion in motions]


def words(sentence: str) -> list[str]:
    return re.findall(r"[a-z0-9]+", sentence.lower())


def within_one_word(one: Sequence[str], other: Sequence[str]) -> bool:
    """Whether one word put in, left out or changed makes the one the other."""
    first = next((i for i, (a, b) in enumerate(zip(one, other, strict=False)) if a != b), min(len(one), len(other)))
    one, other = one[first:], other[first:]
    return one[1:] == other[1:] or one[1:] == other or one == other[1:]


@pytest.mark.parametrize("prompts", [PROMPTS, MORE], ids=["sixty", "more"])
def test_accepted_actions_are_in_the_vocabulary(prompts):
    assert {name for _, accepted in prompts for name in accepted} <= NAMES
    assert all(accepted and len(set(accepted)) == len(accepted) for _, accepted in prompts)


def test_each_action_comes_first_three_times_in_the_longer_list():
    assert Counter(accepted[0] for _, accepted in MORE) == dict.fromkeys(NAMES, 3)


def test_sentences_have_at_most_twenty_words():
    assert [sentence for sentence, _ in MORE if not 1 <= len(words(sentence)) <= 20] == []


@pytest.mark.parametrize(
    ("one", "other", "near"),
    [
        ("sit down", "Sit down!", True),
        ("sit down", "sit down now", True),
        ("please sit down", "sit down", True),
        ("sit down now", "lie down now", True),
        ("sit down", "down sit", False),
        ("sit down", "now please sit down", False),
        ("dance", "sit down", False),
    ],
)
def test_one_word_apart(one, other, near):
    assert within_one_word(words(one), words(other)) is near
    assert within_one_word(words(other), words(one)) is near


def test_no_sentence_is_another_but_for_a_word():
    sixty, more = ([words(sentence) for sentence, _ in prompts] for prompts in (PROMPTS, MORE))
    assert [(old, new) for old in sixty for new in more if within_one_word(old, new)] == []
    # two bare keywords are always one word apart
    pairs = [pair for pair in combinations(more, 2) if max(map(len, pair)) > 2]
    assert [pair for pair in pairs if within_one_word(*pair)] == []
    assert len({tuple(sentence) for sentence in more}) == len(MORE)


def test_answers_are_to_the_list_given():
    asked: list[str] = []

    def generate(sentence: str) -> list[Any]:
        asked.append(sentence)
        return [SimpleNamespace(name=name) for name in ("walk", "run", "run", "bow")]

    fake = Fake()
    listed = (("go fast", ("run", "dash")), ("greet", ("bow",)))
    made = answers(generate, cast(Recogniser, fake), listed)
    seen = ("walk", "run", "run", "bow")
    assert made == [Answer("go fast", ("run", "dash"), seen), Answer("greet", ("bow",), seen)]
    assert [answer.share for answer in made] == [0.5, 0.25]
    assert asked == ["go fast", "greet"]
    assert fake.shown == [4, 4]


def test_answers_are_to_the_sixty_unless_told():
    made = answers(lambda _: cast(Any, [SimpleNamespace(name="bow")]), cast(Recogniser, Fake()))
    assert [(answer.prompt, answer.accepted) for answer in made] == list(PROMPTS)
