"""Sentences as the networks are told them: a vector, a tag and a side for every token."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import torch
from jaxtyping import Float, Int
from torch import Tensor

from engines.text import TextEncoder
from engines.text.tags import OTHER, SIDES, one_hot, sides_of_pieces, tags_of_pieces
from engines.text.token_vectors import TokenVectors


class WordBatch(NamedTuple):
    """Sentences, padded."""

    vectors: Float[Tensor, "R N E"]
    marks: Float[Tensor, "R N K"]
    """Ones and zeros: which of `TAGS` a token is, then which of `SIDES` it names, if one."""
    lengths: Int[Tensor, " R"]
    """Tokens of each."""

    def to(self, device: torch.device) -> WordBatch:
        """There."""
        return WordBatch(*(part.to(device) for part in self))

    def rows(self, places: Tensor) -> WordBatch:
        """Some of them, cut to the longest."""
        longest = int(self.lengths[places].max())
        return WordBatch(self.vectors[places, :longest], self.marks[places, :longest], self.lengths[places])


def read(sentences: Sequence[str], encoder: TextEncoder) -> WordBatch:
    """Sentences that a person typed."""
    encoded = encoder.encode(list(sentences))
    lengths = encoded.mask.sum(1)
    return WordBatch(encoded.tokens, _marked(marks_of(sentences, encoder), encoded.tokens.shape[1]), lengths)


def marks_of(sentences: Sequence[str], encoder: TextEncoder) -> list[np.ndarray]:
    """(2, N) int8 places in `TAGS` and in `SIDES` (-1: none) of each sentence's tokens, start and end included."""
    return [
        np.array(
            [[OTHER, *tags_of_pieces(pieces), OTHER], [-1, *sides_of_pieces(pieces), -1]],
            dtype=np.int8,
        )
        for pieces in encoder.pieces(list(sentences))
    ]


class Captions:
    """Sentences of a training, asked for by their places.

    Args:
        sentences: all of them.
        encoder: whose tokens they are made of.
        vectors: of their tokens.
    """

    def __init__(self, sentences: Sequence[str], encoder: TextEncoder, vectors: TokenVectors) -> None:
        self.sentences, self.encoder, self.vectors = sentences, encoder, vectors
        self._marks: dict[int, np.ndarray] = {}

    def batch(self, places: np.ndarray) -> WordBatch:
        """Sentences at places (R,)."""
        new = sorted({int(place) for place in places} - self._marks.keys())
        self._marks |= dict(zip(new, marks_of([self.sentences[place] for place in new], self.encoder), strict=True))
        vectors, lengths = self.vectors.rows(places)
        found = [self._marks[int(place)] for place in places]
        return WordBatch(vectors, _marked(found, vectors.shape[1]), lengths)


def _marked(found: Sequence[np.ndarray], width: int) -> Tensor:
    """(R, width, K); what is past a sentence is OTHER and names no side."""
    rows = np.full((len(found), 2, width), -1, dtype=np.int64)
    rows[:, 0] = OTHER
    for row, places in zip(rows, found, strict=True):
        row[:, : places.shape[1]] = places[:, :width]
    named = rows[:, 1, :, None] == np.arange(len(SIDES))
    return torch.from_numpy(np.concatenate([one_hot(rows[:, 0]), named.astype(np.float32)], axis=-1))
