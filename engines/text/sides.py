"""The words of sides and ways in a sentence, as numbers beside what the frozen encoder makes of it.

The encoder puts "raises the left hand" and "raises the right hand" nearly in the same place (cosine 0.9 and more),
since most of what sentences are about does not depend on the side. Motions do.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

SIDES: tuple[tuple[str, ...], ...] = (
    ("left", "leftward", "leftwards"),
    ("right", "rightward", "rightwards"),
    ("both",),
    ("forward", "forwards", "ahead", "onward", "onwards"),
    ("back", "backward", "backwards", "reverse", "retreats", "retreat"),
    ("clockwise",),
    ("counterclockwise", "anticlockwise"),
)
"""Words that mean the same side or way, a number of the sentence each."""
ENCODED = 384
"""Numbers of the frozen encoder's sentence vector, whose length is one."""
SIZE = ENCODED + len(SIDES)
"""Numbers of a sentence."""
WEIGHT = 1 / 16
"""Of a side that is named: about as large as the other numbers, of which each is 1/20 on average."""
_WORD = re.compile(r"[a-z]+")


def named(sentences: Sequence[str]) -> np.ndarray:
    """(N, 7) 0 or 1: which of `SIDES` each sentence names."""
    words = [set(_WORD.findall(sentence.lower().replace("-", ""))) for sentence in sentences]
    return np.array([[not said.isdisjoint(side) for side in SIDES] for said in words], np.float32)


def joined(vectors: np.ndarray, sentences: Sequence[str]) -> np.ndarray:
    """(N, `SIZE`) of sentences and their vectors (N, `ENCODED`), in the vectors' type."""
    sides = named(sentences).reshape(-1, len(SIDES)) * WEIGHT
    return np.concatenate([vectors, sides.astype(vectors.dtype)], axis=-1)
