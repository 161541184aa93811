"""What every corpus offers: a list of clips, each read on demand into a house motion."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, Protocol

from engines.motion import LabelKind, Motion, Segment

HOUSE_FPS = 20.0
"""Rate of every prepared clip, frames a second."""

Split = Literal["train", "val", "test"]


@dataclass(frozen=True)
class Timed:
    """Something said of a stretch of a clip, in seconds from its start."""

    kind: LabelKind
    """A sentence ("text"), an action, a transition or a style."""
    value: str
    """The label or sentence itself."""
    start: float = 0.0
    """Seconds."""
    end: float | None = None
    """Seconds; None for the end of the clip."""


@dataclass(frozen=True)
class ClipInfo:
    """One recording and what is known of it."""

    corpus: str
    """Name of the data set."""
    name: str
    """Unique within the corpus."""
    path: Path
    """The file it is read from."""
    action: str | None
    """A name of `engines.actions`, or None where the clip shows none of them."""
    style: str | None = None
    """Manner ("elderly"), where the corpus says."""
    subject: str | None = None
    """Who performed it, where the corpus says."""
    text: str | None = None
    """The corpus' own description."""
    label: str | None = None
    """The corpus' own class ("drink"), where it has classes."""
    fine: str | None = None
    """... and subclass ("drink bottle, left hand")."""
    split: Split | None = None
    """The corpus' official part; None where it has none, and parts are drawn here."""
    timed: tuple[Timed, ...] = ()
    """Sentences and labels, each with its time."""


class Corpus(Protocol):
    """A data set on disk."""

    name: str
    archive: str
    """The file or folder looked for, as its owner calls it."""
    licence: str
    download: str
    """The page it is had from."""
    layout: str
    """What to put where, one line."""

    def clips(self, folder: Path) -> Iterator[ClipInfo]:
        """The clips under an unpacked folder, in a fixed order; none where the folder holds another data set.

        Raises:
            FormatError: the folder is this data set's, but an index file of it is missing or damaged.
        """
        ...

    def read(self, clip: ClipInfo) -> Motion:
        """A clip on `smpl22` at `HOUSE_FPS`, on the ground, facing +Z at its first frame.

        Raises:
            MotionloomError: the clip is broken; the message says how.
        """
        ...


def to_house(motion: Motion) -> Motion:
    """Resampled to the house rate, feet on the ground, facing +Z above the origin at the first frame."""
    return motion.resample(HOUSE_FPS).on_ground().face_front()


def labelled(motion: Motion, clip: ClipInfo) -> Motion:
    """The motion under everything known of the clip: its action, its style, and what is said of parts of it."""
    labels = [Segment(0, len(motion), "action", clip.action)] if clip.action else []
    if clip.style:
        labels.append(Segment(0, len(motion), "style", clip.style))
    for item in clip.timed:
        end = motion.duration if item.end is None else min(item.end, motion.duration)
        first, last = round(item.start * motion.fps), math.ceil(end * motion.fps - 1e-6)
        if 0 <= first < last:
            labels.append(Segment(first, min(last, len(motion)), item.kind, item.value))
    return motion.replaced(labels=tuple(labels))
