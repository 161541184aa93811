"""Captions as vectors: what networks that learn from sentences are trained on, made once and kept.

    told = encoded.load()                    # made on first use, which takes some minutes
    rows = told.of(clip)                     # of a prepared clip, or of clip.mirror()
    told.vectors[rows], told.sentences[rows[0]]

Many clips have the same caption; each sentence is encoded and kept once, so that rows also say which captions are the
same. Sentences for judging must not be drawn from here: draw new ones, `captions(clip, seed=HELD_OUT_SEED)`.
"""

from __future__ import annotations

import hashlib
import json
import logging
import zipfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from engines.datasets.captions import captions
from engines.errors import Cancelled, UnknownLabelError
from engines.formats.files import atomic_path

if TYPE_CHECKING:
    from engines.datasets import Clip
    from engines.text import TextEncoder

log = logging.getLogger(__name__)

COUNT = 24
"""Captions a clip made by the grammar, beside those that people wrote."""
SEED = 0
"""Of the captions kept here."""
HELD_OUT_SEED = 1_000_003
"""Of captions that nothing is ever trained on."""
_CHUNK = 512
"""Sentences encoded between two reports of progress."""
_SAMPLES = 16
"""Clips whose captions are made again to see whether the grammar has changed."""

Progress = Callable[[int, int, str], None]
"""Called with what is done, what there is to do, and of what ("clip" or "sentence")."""


@dataclass(frozen=True, eq=False)
class EncodedCaptions:
    """Captions of clips and of their mirror images."""

    sentences: tuple[str, ...]
    """S different ones."""
    vectors: np.ndarray
    """(S, D) float16, a unit vector a sentence, as the encoder's `sentences`."""
    rows: Mapping[str, np.ndarray]
    """Key of a clip (`key`) -> (K,) which sentences describe it; K is 12 or more and differs from clip to clip."""

    def of(self, clip: Clip) -> np.ndarray:
        """(K,) which sentences describe a prepared clip, or the mirror image of one.

        Raises:
            UnknownLabelError: the clip is not among those prepared.
        """
        found = self.rows.get(key(clip))
        if found is None:
            raise UnknownLabelError("clip with captions", key(clip), self.rows)
        return found


def key(clip: Clip) -> str:
    """What a clip is called here: corpus/name; a mirror image's name begins with M."""
    return f"{clip.corpus}/{clip.name}"


def load(
    encoder: str = "minilm", progress: Progress | None = None, cancel: Callable[[], bool] | None = None
) -> EncodedCaptions:
    """Captions of all prepared clips and of their mirror images, from the cache; made if it is missing or out of date.

    Args:
        encoder: a name of `engines.text`.
        progress: hears how far the making is.
        cancel: asked while they are made.

    Raises:
        FormatError: no prepared data; or the cache cannot be written.
        UnknownLabelError: no such encoder.
        Cancelled: `cancel` said so; nothing was written.
    """
    from engines import datasets

    clips = datasets.load()
    path = datasets.cache_folder() / f"captions-{encoder}-v{datasets.VERSION}.npz"
    mark = fingerprint(clips)
    try:
        return _read(path, path.stat().st_mtime_ns, mark)
    except (OSError, ValueError, KeyError, zipfile.BadZipFile) as error:
        log.info("captions are made anew: %s", error)
    from engines import text

    made = make(clips, text.load(encoder), progress, cancel)
    _write(path, made, mark)
    return made


def make(
    clips: Sequence[Clip],
    encoder: TextEncoder,
    progress: Progress | None = None,
    cancel: Callable[[], bool] | None = None,
    count: int = COUNT,
) -> EncodedCaptions:
    """Captions of clips and of their mirror images, drawn and encoded.

    Raises:
        Cancelled: `cancel` said so.
    """

    def tell(done: int, total: int, what: str) -> None:
        if cancel and cancel():
            raise Cancelled("the making of captions was cancelled; nothing was written")
        if progress:
            progress(done, total, what)

    place: dict[str, int] = {}
    rows: dict[str, np.ndarray] = {}
    for done, clip in enumerate(clips, start=1):
        for seen in (clip, clip.mirror()):
            said = captions(seen, SEED, count)
            rows[key(seen)] = np.array([place.setdefault(text, len(place)) for text in said], dtype=np.int32)
        tell(done, len(clips), "clip")
    sentences = tuple(place)
    parts = [np.zeros((0, encoder.size), dtype=np.float16)]
    for start in range(0, len(sentences), _CHUNK):
        part = encoder.encode(sentences[start : start + _CHUNK]).sentences
        parts.append(part.numpy().astype(np.float16))
        tell(min(start + _CHUNK, len(sentences)), len(sentences), "sentence")
    return EncodedCaptions(sentences, np.concatenate(parts), rows)


def fingerprint(clips: Sequence[Clip]) -> str:
    """What changes when the clips do, or what the grammar says of some of them."""
    spread = clips[:: max(1, len(clips) // _SAMPLES)]
    said = [captions(clip, SEED, COUNT) for clip in spread]
    known = [[key(clip), len(clip.motion), clip.action, clip.style, clip.text, clip.sentences] for clip in clips]
    return hashlib.sha256(json.dumps([known, said, SEED, COUNT]).encode()).hexdigest()


def _write(path: Path, made: EncodedCaptions, mark: str) -> None:
    index = {"mark": mark, "sentences": made.sentences, "keys": list(made.rows)}
    path.parent.mkdir(parents=True, exist_ok=True)
    with atomic_path(path) as temporary:
        np.savez(
            temporary,
            vectors=made.vectors,
            rows=_joined(made.rows.values()),
            lengths=np.array([len(row) for row in made.rows.values()], dtype=np.int32),
            index=np.frombuffer(json.dumps(index).encode(), dtype=np.uint8),
        )


def _joined(rows: Iterable[np.ndarray]) -> np.ndarray:
    return np.concatenate([np.zeros(0, dtype=np.int32), *rows])


@lru_cache(maxsize=2)
def _read(path: Path, _written: int, mark: str) -> EncodedCaptions:
    """What is in the file; a KeyError says that it is of other clips or captions."""
    with np.load(path, allow_pickle=False) as stored:
        index = json.loads(stored["index"].tobytes())
        if index["mark"] != mark:
            raise KeyError(f"{path.name} is of other clips, or of an older grammar")
        vectors, rows, lengths = stored["vectors"], stored["rows"], stored["lengths"]
    vectors.setflags(write=False)
    parts = np.split(rows, np.cumsum(lengths)[:-1])
    return EncodedCaptions(tuple(index["sentences"]), vectors, dict(zip(index["keys"], parts, strict=True)))


__all__ = ["COUNT", "HELD_OUT_SEED", "SEED", "EncodedCaptions", "fingerprint", "key", "load", "make"]
