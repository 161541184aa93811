"""Real clips as training windows for latent stylization."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import torch
from torch import Tensor

from engines.datasets import Clip
from engines.errors import MotionloomError
from engines.features.layout import Statistics
from engines.features.style import STYLE
from engines.stylization.config import StylizationConfig
from engines.training.devices import ALONE, Share

SHORTEST = 16
"""Frames at 30 fps; shorter clips are left out."""
_BALANCE = 0.75
"""A style with n clips is drawn with a chance proportional to n ** (1 - _BALANCE)."""


class Windows:
    """Clips and their mirror images as features at 30 fps, drawn from as windows.

    Of a clip that is too short the window goes back and forth.

    Args:
        clips: to draw from.
        config: window and style labels; clips without a label are drawn for the autoencoder only.
        statistics: of the features; measured on these clips if none.
    """

    def __init__(self, clips: Sequence[Clip], config: StylizationConfig, statistics: Statistics | None = None) -> None:
        self.config = config
        rows, labels = [], []
        for clip in (made for original in clips for made in (original, original.mirror())):
            features = STYLE.encode(clip.motion)
            if len(features) >= SHORTEST:
                rows.append(features)
                labels.append(config.styles.index(clip.style) if clip.style in config.styles else -1)
        if not rows:
            raise MotionloomError(f"no clip of {SHORTEST} frames or more; run: motionloom data prepare.")
        self.statistics = statistics or Statistics.measure(rows, STYLE.layout).emphasised(STYLE.layout)
        self.lengths = np.array([len(row) for row in rows])
        self.starts = np.concatenate([[0], np.cumsum(self.lengths)[:-1]])
        self.frames = torch.from_numpy(self.statistics.normalise(np.concatenate(rows)))
        self.labels = np.array(labels)
        self.labelled = np.flatnonzero(self.labels >= 0)
        counts = np.bincount(self.labels[self.labelled], minlength=len(config.styles))
        weight = counts[self.labels[self.labelled]] ** -_BALANCE
        self._chance = weight / weight.sum() if len(weight) else weight
        self._of_style = {label: np.flatnonzero(self.labels == label) for label in np.unique(self.labels)}

    def __len__(self) -> int:
        return len(self.lengths)

    def draw(self, rng: np.random.Generator, share: Share = ALONE) -> Tensor:
        """(B, T, D) of any clips, longer ones more often."""
        picks = rng.choice(len(self), size=self.config.batch_size, p=self.lengths / self.lengths.sum())
        return self._windows(picks, rng)[share.rows].to(share.device)

    def pairs(self, rng: np.random.Generator, share: Share = ALONE) -> tuple[Tensor, Tensor, Tensor]:
        """Two windows (B, T, D) each in one style, and their labels (B, S) one-hot.

        The thesis cuts both out of one long recording, in which a performer does many things in one manner. Clips here
        hold a single thing each, so the second window is of any clip of the same style: what both share, which is what
        homo-style alignment lets into the style code, is then the manner and not the content.

        Raises:
            MotionloomError: no clip has a style.
        """
        if not len(self.labelled):
            raise MotionloomError("no clip has one of the styles to be learned; choose corpora that do (bandai-namco).")
        size = 2 * (self.config.batch_size // 2)
        picks = self.labelled[rng.choice(len(self.labelled), size=size, p=self._chance)]
        others = np.array([rng.choice(self._of_style[self.labels[pick]]) for pick in picks])
        first, second = self._windows(picks, rng), self._windows(others, rng)
        labels = torch.nn.functional.one_hot(torch.from_numpy(self.labels[picks]), len(self.config.styles)).float()
        # consecutive rows are exchanged with each other, so each process takes whole pairs
        rows = np.arange(size).reshape(-1, 2)[share.rank :: share.world].ravel()
        return tuple(value[rows].to(share.device) for value in (first, second, labels))  # type: ignore[return-value]

    def each(self, share: Share = ALONE) -> Iterator[Tensor]:
        """The first window of every clip, in batches, the last filled up from the front."""
        size = self.config.batch_size
        picks = np.resize(np.arange(len(self)), -(-len(self) // size) * size)
        for first in range(0, len(picks), size):
            yield self._windows(picks[first : first + size], None)[share.rows].to(share.device)

    def _windows(self, picks: np.ndarray, rng: np.random.Generator | None) -> Tensor:
        lengths, window = self.lengths[picks], self.config.window
        room = np.maximum(1, lengths - window + 1)
        begin = np.zeros(len(picks), dtype=int) if rng is None else (rng.random(len(picks)) * room).astype(int)
        at = begin[:, None] + np.arange(window)
        period = np.maximum(1, 2 * (lengths - 1))[:, None]
        at = np.abs((at + lengths[:, None] - 1) % period - (lengths[:, None] - 1))  # back and forth past the end
        at = np.where(begin[:, None] + window <= lengths[:, None], begin[:, None] + np.arange(window), at)
        return self.frames[torch.from_numpy(self.starts[picks][:, None] + at)]
