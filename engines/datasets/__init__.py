"""Real motion: corpora, the cache of house motions made from them, and the clips in it."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Literal

import numpy as np

from engines.datasets.corpus import HOUSE_FPS
from engines.datasets.prepare import CORPORA, VERSION, cache_folder, prepare
from engines.errors import FormatError
from engines.motion import Motion, Provenance, Segment
from engines.skeletons import SMPL22

Split = Literal["train", "val", "test"]


@dataclass(frozen=True)
class Clip:
    """A prepared clip: a house motion and what is known of it."""

    corpus: str
    name: str
    action: str | None
    style: str | None
    subject: str | None
    text: str | None
    split: Split
    motion: Motion


def load(
    split: Split | None = None, corpora: Iterable[str] | None = None, actions: Iterable[str] | None = None
) -> list[Clip]:
    """Prepared clips from the cache, all or some.

    Raises:
        FormatError: there is no cache yet; the message says which command makes it.
    """
    wanted = set(corpora or CORPORA)
    path = cache_folder() / f"house-v{VERSION}.npz"
    if not path.is_file():
        raise FormatError(path, "no prepared data; run: motionloom data prepare --source FOLDER_WITH_THE_ARCHIVES")
    names = set(actions) if actions is not None else None
    return [
        clip
        for clip in _all_clips(path, path.stat().st_mtime_ns)
        if clip.corpus in wanted and (split is None or clip.split == split) and (names is None or clip.action in names)
    ]


@lru_cache(maxsize=2)
def _all_clips(path: Path, _written: int) -> tuple[Clip, ...]:
    # a cache made anew has another time of writing and is read again
    with np.load(path, allow_pickle=False) as stored:
        turns, places = stored["rotations"], stored["translation"]
        index = json.loads(stored["index"].tobytes())
    return tuple(_clip(row, turns, places) for row in index["clips"])


def _clip(row: dict, turns: np.ndarray, places: np.ndarray) -> Clip:
    frames = slice(row["start"], row["start"] + row["frames"])
    labels = [Segment(0, row["frames"], kind, row[kind]) for kind in ("action", "style") if row[kind]]
    motion = Motion(
        SMPL22, turns[frames], places[frames], HOUSE_FPS, tuple(labels), Provenance(f"{row['corpus']}/{row['name']}")
    )
    facts = {key: row[key] for key in ("corpus", "name", "action", "style", "subject", "text", "split")}
    return Clip(**facts, motion=motion)


__all__ = ["CORPORA", "HOUSE_FPS", "Clip", "cache_folder", "load", "prepare"]
