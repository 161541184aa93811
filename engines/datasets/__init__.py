"""Real motion: corpora, the cache of house motions made from them, and the clips in it."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from engines.datasets.corpus import HOUSE_FPS, Split
from engines.datasets.prepare import CORPORA, VERSION, cache_folder, prepare
from engines.errors import FormatError
from engines.geometry.mirror import mirror_words
from engines.motion import Motion, Provenance, Segment
from engines.skeletons import SMPL22


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
    label: str | None = None
    """The data set's own class, where it has classes of its own."""
    fine: str | None = None
    """... and subclass."""
    sentences: tuple[str, ...] = ()
    """What people wrote about the whole clip. Sentences about parts of it are labels of the motion."""

    def mirror(self) -> Clip:
        """The clip seen in a mirror: its motion, and left and right in all that is said of it.

        An action whose name has no side keeps it, though not every such action is the same in a mirror
        (`engines.actions` says which are): a throw by the left arm is still a throw.
        """
        facts = {key: getattr(self, key) for key in ("action", "text", "label", "fine")}
        swapped = {key: mirror_words(value) if value else value for key, value in facts.items()}
        sentences = tuple(mirror_words(sentence) for sentence in self.sentences)
        return replace(self, name=f"M{self.name}", motion=self.motion.mirror(), sentences=sentences, **swapped)

    def pieces(self) -> tuple[Clip, ...]:
        """The parts of the clip that sentences with times speak of, each with its sentence, as the papers train on."""
        texts = [s for s in self.motion.labels if s.kind == "text" and s.end - s.start < len(self.motion)]
        return tuple(
            replace(
                self, name=f"{self.name}@{s.start}-{s.end}", text=s.value, sentences=(s.value,),
                motion=self.motion[s.start : s.end],
            )
            for s in texts
        )  # fmt: skip


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


def _clip(row: dict[str, Any], turns: np.ndarray, places: np.ndarray) -> Clip:
    frames = slice(row["start"], row["start"] + row["frames"])
    stored: list[Any] = row.get("labels") or [
        (0, row["frames"], kind, row[kind]) for kind in ("action", "style") if row[kind]
    ]
    labels = [Segment(start, end, kind, value) for start, end, kind, value in stored]
    motion = Motion(
        SMPL22, turns[frames], places[frames], HOUSE_FPS, tuple(labels), Provenance(f"{row['corpus']}/{row['name']}")
    )
    facts: dict[str, Any] = {key: row[key] for key in ("corpus", "name", "action", "style", "subject", "text", "split")}
    said = (item["value"] for item in row.get("timed", ()) if item["kind"] == "text" and item["end"] is None)
    own: dict[str, Any] = {key: row.get(key) for key in ("label", "fine")}
    return Clip(**facts, **own, sentences=tuple(dict.fromkeys(said)), motion=motion)


__all__ = ["CORPORA", "HOUSE_FPS", "Clip", "cache_folder", "load", "prepare"]
