"""Real clips as training batches for Action2Motion."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import torch

from engines import actions as vocabulary
from engines.action2motion.config import Action2MotionConfig
from engines.action2motion.losses import Batch
from engines.action2motion.representation import Features, encode
from engines.datasets import Clip
from engines.errors import FormatError, MotionloomError, UnknownLabelError
from engines.geometry.mirror import mirror_words
from engines.training.devices import ALONE, Share


class Sequences:
    """All clips of a split at the model's rate, drawn from as balanced random windows.

    A clip longer than the window gives a random crop; of a shorter one the last pose is held (as in the paper).
    Clips that may be mirrored come a second time, mirrored. Frames of all clips lie in one array each, so that a batch
    is one gather.
    """

    def __init__(self, clips: Sequence[Clip], config: Action2MotionConfig) -> None:
        self.config = config
        known = set(config.actions)
        parts: list[Features] = []
        labels: list[int] = []
        for clip in clips:
            if clip.action not in known:
                continue
            parts.append(encode(clip.motion.resample(config.fps)))
            labels.append(config.actions.index(clip.action))
            mirrored = mirror_words(clip.action)
            if vocabulary.get(clip.action).mirrors and mirrored in known:
                parts.append(encode(clip.motion.mirror().resample(config.fps)))
                labels.append(config.actions.index(mirrored))
        if not parts:
            raise MotionloomError("no clip shows any of the actions to be trained; prepare data that does.")
        self.labels = np.array(labels)
        self.lengths = np.array([len(part.height) for part in parts])
        self.starts = np.concatenate([[0], np.cumsum(self.lengths)[:-1]])
        self.frames = {
            name: torch.from_numpy(np.concatenate([getattr(part, name) for part in parts]))
            for name in ("height", "lie", "positions", "matrices", "velocity", "contacts")
        }
        progress = [np.arange(length) / max(1, length - 1) for length in self.lengths]
        self.progress = torch.from_numpy(np.concatenate(progress)).float()
        weight = np.bincount(self.labels, minlength=len(config.actions))[self.labels] ** (config.label_balance - 1.0)
        self.probability = weight / weight.sum()

    def __len__(self) -> int:
        return len(self.labels)

    def vectors(self, frames: torch.Tensor | slice = slice(None)) -> torch.Tensor:
        """Pose vectors (..., D) of stored frames."""
        if self.config.decoder == "plain":
            return self.frames["positions"][frames].flatten(-2)
        return torch.cat([self.frames["height"][frames], self.frames["lie"][frames].flatten(-2)], dim=-1)

    def statistics(self) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        """Mean and deviation of pose vectors (D,), and deviation of velocities (3,); deviations have a floor."""
        vectors = self.vectors()
        spread = vectors.std(0)
        return vectors.mean(0), spread.clamp_min(0.1 * float(spread.mean())), self.frames["velocity"].std(0)

    def to(self, device: torch.device) -> Sequences:
        """Keep all frames on a device."""
        self.frames = {name: value.to(device) for name, value in self.frames.items()}
        self.progress = self.progress.to(device)
        return self

    def draw(self, rng: np.random.Generator, size: int | None = None, share: Share = ALONE) -> Batch:
        """A random batch, or this process's share of it."""
        picks = rng.choice(len(self), size=size or self.config.batch_size, p=self.probability)
        begin = self._beginnings(picks, rng)
        return self.windows(picks[share.rows], begin[share.rows])

    def each(self, rng: np.random.Generator, share: Share = ALONE) -> Iterator[Batch]:
        """Every sequence once, in batches of the usual size, the last filled up from the front."""
        size = self.config.batch_size
        picks = np.resize(np.arange(len(self)), -(-len(self) // size) * size)
        begin = self._beginnings(picks, rng)
        for first in range(0, len(picks), size):
            part = slice(first + share.rank, first + size, share.world)
            yield self.windows(picks[part], begin[part])

    def _beginnings(self, picks: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        room = np.maximum(1, self.lengths[picks] - self.config.window + 1)
        return (rng.random(len(picks)) * room).astype(int)

    def windows(self, picks: np.ndarray, begin: np.ndarray) -> Batch:
        """The windows of the picked clips that begin at the given frames."""
        at = begin + np.arange(self.config.window)[:, None]
        device = self.progress.device
        real = torch.from_numpy(at < self.lengths[picks]).to(device)
        index = torch.from_numpy(self.starts[picks] + np.minimum(at, self.lengths[picks] - 1)).to(device)
        velocity = self.frames["velocity"][index] * real[..., None]
        velocity[0] = 0.0
        return Batch(
            vectors=self.vectors(index),
            conditions=conditions(torch.from_numpy(self.labels[picks]).to(device), self.progress[index], self.config),
            positions=self.frames["positions"][index],
            matrices=self.frames["matrices"][index],
            velocity=velocity,
            contacts=self.frames["contacts"][index],
            mask=real.float(),
        )


def conditions(labels: torch.Tensor, progress: torch.Tensor, config: Action2MotionConfig) -> torch.Tensor:
    """One-hot actions and time counter (T, B, C) from labels (B,) or (T, B) and progress (T, B) in 0..1."""
    hot = torch.nn.functional.one_hot(labels, len(config.actions)).float().expand(len(progress), -1, -1)
    return torch.cat([hot, progress[..., None]], dim=-1) if config.time_counter else hot


def vocabulary_of(
    clips: Sequence[Clip], fps: float, wanted: Sequence[str] = ()
) -> tuple[tuple[str, ...], tuple[int, ...]]:
    """The actions that occur (mirrored ones included), in vocabulary order, and the usual length of each in frames.

    Args:
        clips: labelled or not; those without an action are passed over.
        fps: frames of the lengths.
        wanted: only these actions; all if none.

    Raises:
        FormatError: a clip's label is not in the vocabulary; the message names the clip.
        UnknownLabelError: no clip shows a wanted action.
    """
    frames: dict[str, list[float]] = {}
    for clip in clips:
        if clip.action is None:
            continue
        try:
            mirrors = vocabulary.get(clip.action).mirrors
        except UnknownLabelError as error:
            raise FormatError(f"{clip.corpus}/{clip.name}", str(error)) from error
        frames.setdefault(clip.action, []).append(clip.motion.duration)
        if mirrors:
            frames.setdefault(mirror_words(clip.action), []).append(clip.motion.duration)
    for name in wanted:
        if name not in frames:
            raise UnknownLabelError("action among the clips", name, frames)
    names = tuple(a.name for a in vocabulary.VOCABULARY if a.name in frames and (not wanted or a.name in wanted))
    return names, tuple(round(float(np.median(frames[name])) * fps) for name in names)
