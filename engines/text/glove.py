"""GloVe word vectors (Pennington et al. 2014), which the papers' networks read words as: brought by the user.

Two layouts are read: GloVe's own text files (a line a word: the word and its numbers; nlp.stanford.edu/projects/glove),
and the papers' (`our_vab_words.pkl` beside `our_vab_data.npy`, with the words sos, eos and unk among them). A text file
is read once, which takes a minute where it is large, and kept as arrays that load at once.

Where they are looked for: `$MOTIONLOOM_GLOVE`, else the folder `glove` beside the cache of clips.
"""

from __future__ import annotations

import hashlib
import logging
import os
import pickle
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch

from engines.errors import CheckpointError
from engines.formats.files import atomic_path
from engines.text.encoder import EncodedText
from engines.text.tags import words_of

log = logging.getLogger(__name__)

START, END, UNKNOWN = "sos", "eos", "unk"
"""Marks among the papers' words."""
LONGEST = 126
"""Words read of a sentence, the rest is cut off."""
_VARIABLE = "MOTIONLOOM_GLOVE"
_WORDS, _VECTORS = "our_vab_words.pkl", "our_vab_data.npy"
_ACCEPTED = f"accepted: a GloVe text file (word and numbers on a line), or a folder with {_WORDS} and {_VECTORS}"


class GloVe:
    """A `TextEncoder`: a vector a word, the same whatever stands beside it, between a start and an end mark.

    Args:
        words: the vocabulary.
        vectors: (V, E), in the same order.

    Raises:
        CheckpointError: there are not as many vectors as words.
    """

    name = "glove"

    def __init__(self, words: Sequence[str], vectors: np.ndarray) -> None:
        if vectors.ndim != 2 or len(words) != len(vectors) or len(words) == 0:
            raise CheckpointError(f"{len(words)} words do not go with vectors of shape {vectors.shape}")
        self.words, self.vectors = tuple(words), vectors
        self.size = vectors.shape[1]
        self._places = {word: place for place, word in reversed(list(enumerate(words)))}

    def __contains__(self, word: str) -> bool:
        return word in self._places

    def vector(self, word: str) -> np.ndarray:
        """(E,) float32 of a word; of "unk" for one that is not known, zeros where there is no "unk" either."""
        place = self._places.get(word, self._places.get(UNKNOWN))
        found = np.zeros(self.size) if place is None else self.vectors[place]
        return found.astype(np.float32)

    def pieces(self, sentences: Sequence[str]) -> list[list[str]]:
        """The words that tokens stand for, without start and end marks."""
        return [words_of(sentence)[:LONGEST] for sentence in sentences]

    def encode(self, sentences: Sequence[str]) -> EncodedText:
        """Mean vectors of sentences, made unit (B, E), of their tokens (B, L, E), and which tokens are there (B, L)."""
        rows = [[START, *words, END] for words in self.pieces(sentences)]
        longest = max(map(len, rows), default=0)
        tokens = torch.zeros(len(rows), longest, self.size)
        mask = torch.zeros(len(rows), longest, dtype=torch.bool)
        for place, row in enumerate(rows):
            tokens[place, : len(row)] = torch.from_numpy(np.stack([self._mark_or_word(word) for word in row]))
            mask[place, : len(row)] = True
        mean = tokens.sum(1) / mask.sum(1, keepdim=True).clamp_min(1)
        return EncodedText(torch.nn.functional.normalize(mean, dim=-1), tokens, mask)

    def _mark_or_word(self, word: str) -> np.ndarray:
        """Marks that plain GloVe does not have are zeros, not unknown words."""
        if word in {START, END} and word not in self._places:
            return np.zeros(self.size, dtype=np.float32)
        return self.vector(word)


def load(path: Path | None = None) -> GloVe:
    """The vectors of a file or folder.

    Args:
        path: see the module; where they are looked for if none.

    Raises:
        CheckpointError: there are none, or they cannot be read; the message says what to bring and where to.
    """
    where = path or _usual_place()
    if not where.exists():
        raise CheckpointError(f"{where}: GloVe word vectors are not there; {_ACCEPTED}, or set ${_VARIABLE}.")
    if where.is_dir():
        files = sorted(where.glob("*.txt"), key=lambda file: -file.stat().st_size)
        if (where / _WORDS).is_file() or not files:
            return GloVe(read_words(where / _WORDS), read_array(where / _VECTORS))
        where = files[0]
    return _kept(where)


def read_words(path: Path) -> list[str]:
    """A pickled list of words. No code in the file is run.

    Raises:
        CheckpointError: missing, or anything else than a list of words.
    """
    try:
        with path.open("rb") as file:
            words = _TextOnly(file).load()
    except (OSError, EOFError, ValueError, IndexError, KeyError, AttributeError, pickle.UnpicklingError) as error:
        raise CheckpointError(f"{path}: cannot be read as a list of words: {error}; {_ACCEPTED}.") from error
    if not isinstance(words, list) or not all(isinstance(word, str) for word in words):
        raise CheckpointError(f"{path}: holds a {type(words).__name__}, not a list of words")
    return words


def read_array(path: Path) -> np.ndarray:
    """An array of numbers.

    Raises:
        CheckpointError: missing, or no array.
    """
    try:
        return np.load(path, allow_pickle=False)
    except (OSError, ValueError, EOFError) as error:
        raise CheckpointError(f"{path}: cannot be read as an array: {error}; {_ACCEPTED}.") from error


class _TextOnly(pickle.Unpickler):
    """Reads lists of words; anything that would run code is refused."""

    def find_class(self, module: str, name: str) -> Any:
        """No class is wanted."""
        raise pickle.UnpicklingError(f"it asks for {module}.{name}")


def _usual_place() -> Path:
    from engines.datasets import cache_folder

    named = os.environ.get(_VARIABLE)
    return Path(named) if named else cache_folder() / "glove"


def _kept(path: Path) -> GloVe:
    """A text file, from the arrays made of it; made if they are missing or of another file."""
    from engines.datasets import cache_folder

    about = path.stat()
    mark = hashlib.sha256(f"{path.resolve()}/{about.st_size}/{about.st_mtime_ns}".encode()).hexdigest()[:16]
    words, vectors = (cache_folder() / f"glove-{mark}.{ending}" for ending in ("txt", "npy"))
    try:
        return GloVe(words.read_text(encoding="utf-8").split("\n"), np.load(vectors, mmap_mode="r"))
    except (OSError, ValueError) as error:
        log.info("word vectors are read anew: %s", error)
    made = _read_text(path)
    words.parent.mkdir(parents=True, exist_ok=True)
    with atomic_path(vectors) as temporary, temporary.open("wb") as file:
        np.save(file, made.vectors)
    with atomic_path(words) as temporary:
        temporary.write_text("\n".join(made.words), encoding="utf-8")
    return made


def _read_text(path: Path) -> GloVe:
    words: list[str] = []
    rows: list[np.ndarray] = []
    try:
        with path.open(encoding="utf-8", newline="\n") as file:
            for number, line in enumerate(file, start=1):
                # some words have spaces in them
                word, *numbers = line.rstrip("\r\n").rsplit(" ", len(rows[0]) if rows else -1)
                row = np.array(numbers, dtype=np.float16)
                if len(row) != len(rows[0] if rows else row) or len(row) == 0:
                    raise ValueError(f"line {number} has {len(row)} numbers")
                words.append(word)
                rows.append(row)
    except (OSError, ValueError) as error:
        raise CheckpointError(f"{path}: cannot be read as GloVe vectors: {error}; {_ACCEPTED}.") from error
    if not rows:
        raise CheckpointError(f"{path}: holds no words; {_ACCEPTED}.")
    return GloVe(words, np.stack(rows))
