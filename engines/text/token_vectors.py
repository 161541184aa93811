"""A vector for every token of every caption: what text2motion reads while it is trained, made once and kept on disk."""

from __future__ import annotations

import hashlib
import json
import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from jaxtyping import Float, Int
from torch import Tensor

from engines.errors import Cancelled
from engines.formats.files import atomic_path
from engines.text import TextEncoder

log = logging.getLogger(__name__)

_CHUNK = 512
"""Sentences encoded between two reports of progress."""

Progress = Callable[[int, int], None]


@dataclass(frozen=True, eq=False)
class TokenVectors:
    """Tokens of sentences, one sentence after another."""

    vectors: np.ndarray
    """(P, E) float16."""
    starts: np.ndarray
    """(S + 1,) where each sentence begins."""

    def rows(self, sentences: np.ndarray) -> tuple[Float[Tensor, "B N E"], Int[Tensor, " B"]]:
        """Token vectors of sentences by their places (B,), zero past a sentence's end, and how many each has."""
        lengths = self.starts[sentences + 1] - self.starts[sentences]
        made = np.zeros((len(sentences), int(lengths.max(initial=1)), self.vectors.shape[1]), dtype=np.float32)
        for row, (place, length) in enumerate(zip(sentences, lengths, strict=True)):
            first = self.starts[place]
            made[row, :length] = self.vectors[first : first + length]
        return torch.from_numpy(made), torch.from_numpy(lengths.astype(np.int64))


def encode(
    sentences: Sequence[str],
    encoder: TextEncoder,
    progress: Progress | None = None,
    cancel: Callable[[], bool] | None = None,
) -> TokenVectors:
    """Token vectors of sentences.

    Raises:
        Cancelled: `cancel` said so.
    """
    parts, lengths = [np.zeros((0, encoder.size), dtype=np.float16)], []
    for start in range(0, len(sentences), _CHUNK):
        if cancel and cancel():
            raise Cancelled("the encoding of captions was cancelled; nothing was written")
        made = encoder.encode(sentences[start : start + _CHUNK])
        parts.append(made.tokens[made.mask].numpy().astype(np.float16))
        lengths.append(made.mask.sum(1).numpy())
        if progress:
            progress(min(start + _CHUNK, len(sentences)), len(sentences))
    counts = np.concatenate([np.zeros(1, dtype=np.int64), *lengths])
    return TokenVectors(np.concatenate(parts), counts.cumsum())


def load(
    sentences: Sequence[str],
    encoder: TextEncoder,
    folder: Path,
    progress: Progress | None = None,
    cancel: Callable[[], bool] | None = None,
) -> TokenVectors:
    """Token vectors of sentences, from the cache; made if it is missing or of other sentences.

    Args:
        sentences: in the order they are asked for by.
        encoder: of `engines.text`.
        folder: of the cache.
        progress: hears (sentences done, of how many) while they are made.
        cancel: asked while they are made.

    Raises:
        FormatError: the cache cannot be written.
        Cancelled: `cancel` said so; nothing was written.
    """
    mark = hashlib.sha256(json.dumps([encoder.name, list(sentences)]).encode()).hexdigest()[:16]
    vectors, starts = (folder / f"tokens-{encoder.name}-{mark}-{kind}.npy" for kind in ("vectors", "starts"))
    try:
        return TokenVectors(np.load(vectors, mmap_mode="r"), np.load(starts))
    except (OSError, ValueError) as error:
        log.info("captions are encoded anew: %s", error)
    made = encode(sentences, encoder, progress, cancel)
    folder.mkdir(parents=True, exist_ok=True)
    for path, array in ((vectors, made.vectors), (starts, made.starts)):
        with atomic_path(path) as temporary, temporary.open("wb") as file:
            np.save(file, array)
    # what lies on the disk need not lie in memory as well
    return TokenVectors(np.load(vectors, mmap_mode="r"), made.starts)
