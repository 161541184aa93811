"""Sentences as the networks are told them: a vector and a tag for every token."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import torch
from jaxtyping import Float, Int
from torch import Tensor

from engines.text import TextEncoder
from engines.text.tags import OTHER, one_hot, tags_of_pieces
from engines.tm2t.sentences import TokenVectors


class WordBatch(NamedTuple):
    """Sentences, padded."""

    vectors: Float[Tensor, "R N E"]
    tags: Float[Tensor, "R N K"]
    """One-hot."""
    lengths: Int[Tensor, " R"]
    """Tokens of each."""

    def to(self, device: torch.device) -> WordBatch:
        """There."""
        return WordBatch(*(part.to(device) for part in self))

    def rows(self, places: Tensor) -> WordBatch:
        """Some of them, cut to the longest."""
        longest = int(self.lengths[places].max())
        return WordBatch(self.vectors[places, :longest], self.tags[places, :longest], self.lengths[places])


def read(sentences: Sequence[str], encoder: TextEncoder) -> WordBatch:
    """Sentences that a person typed."""
    encoded = encoder.encode(list(sentences))
    lengths = encoded.mask.sum(1)
    found = tags_of(sentences, encoder)
    return WordBatch(encoded.tokens, _one_hot(found, encoded.tokens.shape[1]), lengths)


def tags_of(sentences: Sequence[str], encoder: TextEncoder) -> list[np.ndarray]:
    """(N,) int8 places in `engines.text.tags.TAGS` of each sentence's tokens, start and end marks included."""
    return [
        np.array([OTHER, *tags_of_pieces(pieces), OTHER], dtype=np.int8) for pieces in encoder.pieces(list(sentences))
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
        self._tags: dict[int, np.ndarray] = {}

    def batch(self, places: np.ndarray) -> WordBatch:
        """Sentences at places (R,)."""
        new = sorted({int(place) for place in places} - self._tags.keys())
        self._tags |= dict(zip(new, tags_of([self.sentences[place] for place in new], self.encoder), strict=True))
        vectors, lengths = self.vectors.rows(places)
        found = [self._tags[int(place)] for place in places]
        return WordBatch(vectors, _one_hot(found, vectors.shape[1]), lengths)


def _one_hot(found: Sequence[np.ndarray], width: int) -> Tensor:
    """(R, width, K); what is past a sentence is OTHER."""
    rows = np.full((len(found), width), OTHER, dtype=np.int64)
    for row, places in zip(rows, found, strict=True):
        row[: len(places)] = places[:width]
    return torch.from_numpy(one_hot(rows))
