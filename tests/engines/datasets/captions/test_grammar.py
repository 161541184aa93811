"""English, as far as captions need it."""

from __future__ import annotations

import re

import pytest

from engines.datasets.captions import grammar, phrases


@pytest.mark.parametrize(
    ("verb", "third", "progressive"),
    [
        ("walk", "walks", "walking"), ("wave", "waves", "waving"), ("run", "runs", "running"), ("do", "does", "doing"),
        ("push", "pushes", "pushing"), ("carry", "carries", "carrying"), ("play", "plays", "playing"),
        ("throw", "throws", "throwing"), ("lie", "lies", "lying"), ("see", "sees", "seeing"), ("be", "is", "being"),
        ("box", "boxes", "boxing"), ("hold", "holds", "holding"), ("sit", "sits", "sitting"),
        ("hop", "hops", "hopping"), ("bow", "bows", "bowing"), ("raise", "raises", "raising"),
        ("dangle", "dangles", "dangling"),
        ("signal", "signals", "signalling"), ("practise", "practises", "practising"), ("catch", "catches", "catching"),
    ],
)  # fmt: skip
def test_verb_forms(verb: str, third: str, progressive: str) -> None:
    assert grammar.third_person(verb) == third
    assert grammar.ing(verb) == progressive


def test_every_verb_of_one_syllable_that_doubles_its_consonant_is_known() -> None:
    """Consonant, one vowel, consonant at the end (but w, x, y) doubles in words of one syllable: run, running."""
    written = [
        text for table in (phrases.PHRASES, phrases.LABELS, phrases.HELD) for row in table.values() for text in row
    ]
    verbs = {verb for text in (*written, *phrases.ANY) for verb in re.findall(r"\[(\w+)\]", text)}
    short = {v for v in verbs if re.fullmatch(r"(?:[^aeiou]|qu)*[aeiou][bdgklmnprt]", v)}
    assert {"run", "squat", "sit"} <= short
    for verb in short:
        assert grammar.ing(verb) == f"{verb}{verb[-1]}ing"


def test_all_verbs_of_a_phrase_take_one_form() -> None:
    phrase = "[raise] {hand} and [wave]".format(hand="both hands")
    assert grammar.inflect(phrase, "s") == "raises both hands and waves"
    assert grammar.inflect(phrase, "ing") == "raising both hands and waving"
    assert grammar.inflect(phrase, "base") == "raise both hands and wave"


@pytest.mark.parametrize(
    ("text", "right"),
    [
        ("a angry person", "an angry person"), ("an happy person", "a happy person"), ("draw a X", "draw an X"),
        ("A elderly human", "An elderly human"), ("a energetic figure", "an energetic figure"),
        ("in an youthful way", "in a youthful way"), ("a unsure way", "an unsure way"), ("in a hour", "in an hour"),
        ("a one-legged stand", "a one-legged stand"), ("a old banana, an pear", "an old banana, a pear"),
        ("a quarter turn", "a quarter turn"), ("a unicycle", "a unicycle"), ("a overhead serve", "an overhead serve"),
    ],
)  # fmt: skip
def test_articles_fit_the_next_sound(text: str, right: str) -> None:
    assert grammar.articles(text) == right


def test_a_sentence_has_a_capital_a_full_stop_and_single_blanks() -> None:
    assert grammar.sentence("  a  person walks , slowly ") == "A person walks, slowly."
    assert grammar.sentence("who is it?") == "Who is it?"


def test_doubled_words_are_seen() -> None:
    assert grammar.doubled("He walks to the The left") == "the"
    assert grammar.doubled("He walks to the left") is None


def test_lists_numbers_and_times() -> None:
    assert grammar.listed(["a"]) == "a"
    assert grammar.listed(["a", "b"]) == "a and b"
    assert grammar.listed(["a", "b", "c"]) == "a, b and c"
    assert [grammar.number(n) for n in (0, 7, 12, 13)] == ["zero", "seven", "twelve", "13"]
    assert [grammar.times(n) for n in (1, 2, 3)] == ["once", "twice", "three times"]
