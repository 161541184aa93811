"""Triplets of the prepared data, made once and kept, and batches of them."""

from __future__ import annotations

import hashlib
import json
import logging
import zipfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from engines import datasets
from engines.datasets.corpus import Split
from engines.errors import MotionloomError
from engines.formats.files import atomic_path
from engines.multiact import triplets as making
from engines.multiact.triplets import PREVIOUS, Triplets
from engines.training.devices import ALONE, Share

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Batch:
    """Triplets of about the same length."""

    x: Tensor
    """(B, P + T, D) features, not normalised; the last frame stands for what is beyond the end."""
    labels: Tensor
    """(B, 2) previous and current action."""
    frames: Tensor
    """(B, 2) of transition and current action."""


class Windows:
    """Triplets as batches.

    Args:
        triplets: to draw from.
        names: actions in the order of the labels.
        size: of a batch.
    """

    def __init__(self, triplets: Triplets, names: Sequence[str], size: int) -> None:
        self.triplets, self.size = triplets, size
        # -1: an action that is not among the names has no label
        place = np.array([names.index(name) if name in names else -1 for name in triplets.names])
        self.labels = place[triplets.actions]
        self.usable = np.flatnonzero(self.labels[:, 1] >= 0)
        if not len(self.usable):
            raise MotionloomError("no clip shows an action to be learned; run: motionloom data prepare.")

    def statistics(self) -> tuple[Tensor, Tensor]:
        """Mean and deviation (D,) of the features."""
        frames = torch.from_numpy(self.triplets.frames[:: max(1, len(self.triplets.frames) // 100_000)]).float()
        return frames.mean(0), frames.std(0).clamp_min(1e-2)

    def draw(self, rng: np.random.Generator, share: Share = ALONE) -> Batch:
        """A batch of about the same length, so that little is padded."""
        picks = self.usable[rng.integers(len(self.usable), size=4 * self.size)]
        quarter = int(rng.integers(4))
        order = np.argsort(self.triplets.lengths[picks].sum(1), kind="stable")
        return self.batch(picks[order[quarter * self.size : (quarter + 1) * self.size]], share)

    def each(self, share: Share = ALONE) -> Iterator[Batch]:
        """Every triplet once, the last batch filled up from the front."""
        order = self.usable[np.argsort(self.triplets.lengths[self.usable].sum(1), kind="stable")]
        order = np.resize(order, -(-len(order) // self.size) * self.size)
        for first in range(0, len(order), self.size):
            yield self.batch(order[first : first + self.size], share)

    def batch(self, picks: np.ndarray, share: Share = ALONE) -> Batch:
        """The chosen triplets, or this process's share of them."""
        picks = picks[share.rows]
        lengths = self.triplets.lengths[picks]
        total = PREVIOUS + lengths.sum(1)
        at = np.minimum(np.arange(total.max()), total[:, None] - 1)
        x = torch.from_numpy(self.triplets.frames[self.triplets.starts[picks][:, None] + at])
        values = x.float(), torch.from_numpy(self.labels[picks]), torch.from_numpy(lengths)
        return Batch(*(value.to(share.device) for value in values))


def prepared(split: Split, count: int, corpora: Sequence[str] | None = None, balance: float = 0.3) -> Triplets:
    """Triplets of a split of the prepared data, from the cache; made on first use, which takes a minute or two.

    Raises:
        FormatError: no prepared data; or the cache cannot be written.
    """
    clips = datasets.load(split, corpora)
    known = [[clip.corpus, clip.name, clip.action, len(clip.motion)] for clip in clips]
    told = json.dumps([making.VERSION, datasets.VERSION, count, balance, known])
    mark = hashlib.sha256(told.encode()).hexdigest()[:16]
    path = datasets.cache_folder() / f"triplets-{split}-{mark}.npz"
    try:
        return _read(path, path.stat().st_mtime_ns)
    except (OSError, ValueError, KeyError, zipfile.BadZipFile) as error:
        log.info("triplets are made anew: %s", error)
    made = making.make(clips, count, balance=balance)
    path.parent.mkdir(parents=True, exist_ok=True)
    with atomic_path(path) as temporary:
        np.savez(
            temporary, frames=made.frames, starts=made.starts, lengths=made.lengths, actions=made.actions,
            captured=made.captured, names=np.array(made.names),
        )  # fmt: skip
    for other in path.parent.glob(f"triplets-{split}-*.npz"):
        if other != path:  # of other clips or settings: large, and as soon made again
            other.unlink(missing_ok=True)
    return made


@lru_cache(maxsize=2)
def _read(path: Path, _written: int) -> Triplets:
    with np.load(path, allow_pickle=False) as stored:
        names = tuple(map(str, stored["names"]))
        return Triplets(**{k: stored[k] for k in stored.files if k != "names"}, names=names)
