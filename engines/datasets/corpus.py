"""What every corpus offers: a list of clips, each read on demand into a house motion."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from engines.motion import Motion

HOUSE_FPS = 20.0
"""Rate of every prepared clip, frames a second."""


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


class Corpus(Protocol):
    """A data set on disk."""

    name: str
    archive: str
    licence: str

    def clips(self, folder: Path) -> Iterator[ClipInfo]:
        """The clips under an unpacked folder, in a fixed order."""
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
