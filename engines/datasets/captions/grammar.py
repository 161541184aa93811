"""English, as far as captions need it: verb forms, articles, numbers, and a sentence's capital and full stop.

A verb phrase is written with its verbs in brackets and in their base form, "[raise] the left hand and [lower] it", and
is put into a form by `inflect`.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Literal

Form = Literal["s", "ing", "base"]

_VERB = re.compile(r"\[([a-z]+)\]")
_ARTICLE = re.compile(r"\b([Aa])n? (?=([A-Za-z]+))")
_DOUBLED = re.compile(r"\b(\w+) \1\b", re.IGNORECASE)
_DOUBLING = frozenset({
    "run", "sit", "jog", "hop", "squat", "clap", "grab", "drop", "step", "put", "get", "set", "stop", "hit", "pat",
    "signal", "jab", "cut", "skip", "spin", "bat", "begin", "swim", "dip", "tip", "slip", "scrub", "rub", "stab",
    "trot", "drag",
})  # fmt: skip
_VOWEL_SOUND = ("hour", "honest", "heir", "x")
_CONSONANT_SOUND = ("one", "uni", "use", "usu", "eu", "ut")
_NUMBERS = (
    "zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve",
)  # fmt: skip


def third_person(verb: str) -> str:
    """walk -> walks, push -> pushes, carry -> carries, be -> is."""
    if verb in {"be", "have"}:
        return {"be": "is", "have": "has"}[verb]
    if verb.endswith("y") and verb[-2] not in "aeiou":
        return verb[:-1] + "ies"
    return verb + ("es" if verb.endswith(("s", "x", "z", "ch", "sh", "o")) else "s")


def ing(verb: str) -> str:
    """walk -> walking, wave -> waving, run -> running, lie -> lying."""
    if verb in _DOUBLING:
        return verb + verb[-1] + "ing"
    if verb.endswith("ie"):
        return verb[:-2] + "ying"
    drops = verb.endswith("e") and not verb.endswith(("ee", "oe", "ye")) and len(verb) > 2
    return (verb[:-1] if drops else verb) + "ing"


def inflect(phrase: str, form: Form) -> str:
    """A verb phrase with all its bracketed verbs in one form: "s" (waves), "ing" (waving) or "base" (wave)."""
    change = {"s": third_person, "ing": ing, "base": str}[form]
    return _VERB.sub(lambda match: change(match[1]), phrase)


def articles(text: str) -> str:
    """Every "a" and "an" as the sound of the next word wants it."""

    def fitting(match: re.Match[str]) -> str:
        word = match[2].lower()
        vowel = word.startswith(_VOWEL_SOUND) or (word[0] in "aeiou" and not word.startswith(_CONSONANT_SOUND))
        return f"{match[1]}{'n' if vowel else ''} "

    return _ARTICLE.sub(fitting, text)


def sentence(text: str) -> str:
    """One blank between words, none before commas, fitting articles, a capital and a full stop."""
    text = articles(re.sub(r"\s+", " ", text).replace(" ,", ",").strip(" ,"))
    text = re.sub(r",+", ",", text)
    return text[:1].upper() + text[1:] + ("" if text.endswith((".", "!", "?")) else ".")


def doubled(text: str) -> str | None:
    """A word that stands twice in a row ("the the"), or None."""
    match = _DOUBLED.search(text)
    return match[1] if match else None


def listed(items: Sequence[str]) -> str:
    """a; a and b; a, b and c."""
    return items[0] if len(items) == 1 else f"{', '.join(items[:-1])} and {items[-1]}"


def number(value: int) -> str:
    """Numbers up to twelve as words."""
    return _NUMBERS[value] if 0 <= value < len(_NUMBERS) else str(value)


def times(count: int) -> str:
    """once, twice, three times."""
    return {1: "once", 2: "twice"}.get(count, f"{number(count)} times")
