"""The words of captions, as they are written, with marks of a sentence's start and end.

The thesis leaves tense and plural out of captions "to ease the learning process" (6.3.5); ours are read by people.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import torch
from torch import Tensor

_PIECE = re.compile(r"[^\W\d_]+(?:'[^\W\d_]+)?|\d|[^\w\s]")
_UNSPACED = frozenset(",.;:!?")
_HYPHEN = "-"


@dataclass(frozen=True)
class Words:
    """Words 0 ... N - 1, then start, end and padding."""

    known: tuple[str, ...]
    """Lower case, punctuation among them."""

    @classmethod
    def of(cls, sentences: Iterable[str]) -> Words:
        """All words of sentences, the frequent ones first."""
        counts = Counter(word for sentence in sentences for word in split(sentence))
        return cls(tuple(sorted(counts, key=lambda word: (-counts[word], word))))

    @property
    def begin(self) -> int:
        """Start of a sentence."""
        return len(self.known)

    @property
    def end(self) -> int:
        """End of a sentence."""
        return len(self.known) + 1

    @property
    def pad(self) -> int:
        """Past the end."""
        return len(self.known) + 2

    @property
    def size(self) -> int:
        """How many there are."""
        return len(self.known) + 3

    @cached_property
    def _places(self) -> dict[str, int]:
        return {word: place for place, word in enumerate(self.known)}

    def __contains__(self, word: str) -> bool:
        return word in self._places

    def indices(self, sentence: str) -> np.ndarray:
        """(N,) of a sentence, words that are not known left out."""
        return np.array([self._places[word] for word in split(sentence) if word in self._places], dtype=np.int64)

    def rows(self, sequences: Sequence[np.ndarray]) -> Tensor:
        """Indices of many sentences -> (B, N) each between its marks, padded."""
        return padded(sequences, self.begin, self.end, self.pad)

    def sentence(self, indices: Iterable[int]) -> str:
        """A sentence as one writes it: a capital, no space before a comma; marks are left out."""
        words = [self.known[index] for index in indices if index < len(self.known)]
        text = ""
        for word in words:
            joined = not text or word in _UNSPACED or word == _HYPHEN or text.endswith(_HYPHEN)
            digits = word.isdigit() and text[-1:].isdigit()
            text += word if joined or digits else f" {word}"
        return text[:1].upper() + text[1:]


def split(sentence: str) -> list[str]:
    """The words of a sentence in lower case; digits and punctuation marks each by themselves."""
    return _PIECE.findall(sentence.lower())


def padded(sequences: Sequence[np.ndarray], begin: int, end: int, pad: int) -> Tensor:
    """Sequences of different lengths -> (B, L), each between its marks, padded."""
    longest = max((len(row) for row in sequences), default=0) + 2
    rows = torch.full((len(sequences), longest), pad, dtype=torch.long)
    for place, row in enumerate(sequences):
        rows[place, 0] = begin
        rows[place, 1 : len(row) + 1] = torch.from_numpy(np.asarray(row, dtype=np.int64))
        rows[place, len(row) + 1] = end
    return rows
