"""What a person typed: refused if it cannot be read, and told which of its words no caption of the training has."""

from __future__ import annotations

import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from engines.errors import MotionloomError, OutOfRangeError
from engines.errors import nearest as nearest_spelled
from engines.text import TextEncoder
from engines.text.words import Words, split

LONGEST = 1000
"""Characters of a prompt."""
_PLAIN = str.maketrans({"‘": "'", "’": "'", "“": '"', "”": '"', "–": "-", "—": "-", "…": "...", "\u00a0": " "})
_SHOWN = 5
_ALIKE = 0.6
"""Share of the letters in common from which a word is taken for one misspelt."""
_SMALL_WORDS = frozenset(
    split(
        "i me my we our you your he him his she her it its they them their who which that these those there here be am "
        "are was were been being do does did has have had will would can could should may might must no not so then "
        "than but or if as at by for from in into of off on onto out over to up down with and the a an s t"
    )
)
"""Words that say nothing of a movement."""


@dataclass(frozen=True)
class CheckedPrompt:
    """A prompt as the engine reads it."""

    sentence: str
    """White space and quotation marks in order."""
    unknown: tuple[tuple[str, tuple[str, ...]], ...] = ()
    """Words that no caption of the training has, each with the nearest that one has."""

    def notes(self) -> list[str]:
        """What the person should know, a sentence each."""
        return [
            f"No training caption has the word {word!r}; the nearest are {', '.join(map(repr, near))}."
            for word, near in self.unknown
        ]


def tidy(prompt: str) -> str:
    """A prompt with its white space and quotation marks in order.

    Raises:
        MotionloomError: it is empty, holds no word, or characters that are not of an English sentence.
        OutOfRangeError: it is too long.
    """
    if not isinstance(prompt, str):
        raise MotionloomError(f"the prompt is a {type(prompt).__name__}; accepted: a sentence in English.")
    if len(prompt) > LONGEST:
        raise OutOfRangeError("length of the prompt", len(prompt), f"up to {LONGEST:,} characters")
    sentence = " ".join(prompt.translate(_PLAIN).split())
    if not sentence:
        raise MotionloomError('the prompt is empty; accepted: a sentence in English, as "a person walks forward".')
    odd = list(dict.fromkeys(character for character in sentence if not _is_english(character)))
    if odd:
        shown = ", ".join(_named(character) for character in odd[:_SHOWN])
        more = f" and {len(odd) - _SHOWN} more" if len(odd) > _SHOWN else ""
        raise MotionloomError(
            f"the prompt holds {shown}{more}, which the engine cannot read; accepted: a sentence in English letters, "
            "digits and punctuation."
        )
    if not any(character.isalpha() for character in sentence):
        raise MotionloomError(f"the prompt {sentence[:40]!r} holds no word; accepted: a sentence in English.")
    return sentence


def _is_english(character: str) -> bool:
    """Latin letters, accents included, and what is on an English keyboard."""
    return (character.isascii() and character.isprintable()) or unicodedata.name(character, "").startswith("LATIN ")


def _named(character: str) -> str:
    kind = unicodedata.category(character)
    name = unicodedata.name(character, "").lower() or f"U+{ord(character):04X}"
    return f"a control character ({name})" if kind.startswith("C") else f"{character!r} ({name})"


class PromptCheck:
    """Reads prompts against the words of the training's captions.

    Args:
        words: of the captions; without any, every word passes.
        encoder: tells which words mean nearly the same.
    """

    def __init__(self, words: Words, encoder: TextEncoder) -> None:
        self.words, self.encoder = words, encoder
        self._candidates = [word for word in words.known if word.isalpha() and word not in _SMALL_WORDS]

    def read(self, prompt: str) -> CheckedPrompt:
        """A prompt, checked; see `tidy` for what is refused."""
        sentence = tidy(prompt)
        if not self._candidates:
            return CheckedPrompt(sentence)
        folded = unicodedata.normalize("NFKD", sentence)
        plain = "".join(character for character in folded if not unicodedata.combining(character))
        strange = [
            word
            for word in dict.fromkeys(split(plain))
            if word[0].isalpha() and word not in _SMALL_WORDS and not self._is_known(word)
        ][:_SHOWN]
        return CheckedPrompt(sentence, tuple(zip(strange, self._nearest(strange), strict=True)))

    def _is_known(self, word: str) -> bool:
        """As it is, or in another of its forms."""
        return any(form in self.words for form in forms(word))

    def _nearest(self, words: Sequence[str], count: int = 3) -> list[tuple[str, ...]]:
        """Of each word the nearest known: by spelling where it looks misspelt, else by meaning."""
        if not words:
            return []
        likeness = _unit(self.encoder, words) @ self._vectors.T
        found = []
        for word, row in zip(words, likeness, strict=True):
            spelled = [near for near in nearest_spelled(word, self._candidates, 1) if _share_in_common(word, near)]
            meant = [self._candidates[place] for place in np.argsort(-row)[:count]]
            found.append(tuple(dict.fromkeys([*spelled, *meant]))[:count])
        return found

    @cached_property
    def _vectors(self) -> np.ndarray:
        return _unit(self.encoder, self._candidates)


def _unit(encoder: TextEncoder, words: Sequence[str]) -> np.ndarray:
    return encoder.encode(list(words)).sentences.numpy()


def _share_in_common(word: str, other: str) -> bool:
    import difflib

    return difflib.SequenceMatcher(None, word, other).ratio() >= _ALIKE + 0.2 * (len(word) < 5)


def forms(word: str) -> list[str]:
    """A word, and what it could be a form of: walks, walked, walking, waving, hopping, tries."""
    forms = [word, word + "s", word + "ing", word.removesuffix("e") + "ing", word + word[-1:] + "ing"]
    for ending in ("s", "es", "ed", "d", "ing", "ly", "'s", "er"):
        stem = word.removesuffix(ending)
        if len(stem) >= 3 and stem != word:
            forms += [stem, stem + "e", stem + "s", stem + "es", stem + "ing", stem.removesuffix("e") + "ing"]
            forms += [stem[:-1]] if stem[-1] == stem[-2] else []
            forms += [stem[:-1] + "y"] if stem.endswith("i") else []
    return forms
