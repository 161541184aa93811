"""What every text encoder gives, and which there are."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple, Protocol

from jaxtyping import Bool, Float
from torch import Tensor

from engines.errors import UnknownLabelError


class EncodedText(NamedTuple):
    """Sentences as an encoder sees them."""

    sentences: Float[Tensor, "B D"]
    """A unit vector a sentence."""
    tokens: Float[Tensor, "B L D"]
    """A vector a token (words or pieces of words, start and end marks included); zero past a sentence's end."""
    mask: Bool[Tensor, "B L"]
    """Which tokens are there."""


class TextEncoder(Protocol):
    """Sentences -> vectors, frozen: nothing of it is trained here."""

    name: str
    size: int
    """D."""

    def encode(self, sentences: Sequence[str]) -> EncodedText:
        """Vectors of sentences and of their tokens."""
        ...

    def pieces(self, sentences: Sequence[str]) -> list[list[str]]:
        """What the tokens of each sentence stand for, start and end marks left out."""
        ...


NAMES = ("minilm", "glove")


@lru_cache(maxsize=2)
def load(name: str = "minilm") -> TextEncoder:
    """A text encoder, loaded once.

    Raises:
        UnknownLabelError: no such encoder.
        CheckpointError: the package with its weights is not installed, or there are no word vectors.
    """
    if name not in NAMES:
        raise UnknownLabelError("text encoder", name, NAMES)
    if name == "glove":
        from engines.text import glove

        return glove.load()
    from engines.text.minilm import MiniLM

    return MiniLM()


@lru_cache(maxsize=256)
def sentence_vector(sentence: str, name: str = "minilm") -> Float[Tensor, " D"]:
    """The unit vector of one sentence, worked out once for all who ask for it.

    Raises:
        UnknownLabelError: no such encoder.
        CheckpointError: as `load`.
    """
    return load(name).encode([sentence]).sentences[0]
