"""Real clips as training batches for Action2Motion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import torch

from engines import actions as vocabulary
from engines.action2motion.config import Action2MotionConfig
from engines.action2motion.losses import Batch
from engines.action2motion.representation import Features, encode
from engines.datasets import Clip
from engines.errors import MotionloomError
from engines.geometry.mirror import mirror_words


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

    def draw(self, rng: np.random.Generator, size: int | None = None) -> Batch:
        """A random batch."""
        picks = rng.choice(len(self), size=size or self.config.batch_size, p=self.probability)
        room = np.maximum(1, self.lengths[picks] - self.config.window + 1)
        return self.windows(picks, (rng.random(len(picks)) * room).astype(int))

    def windows(self, picks: np.ndarray, begin: np.ndarray) -> Batch:
        """The windows of the picked clips that begin at the given frames."""
        at = begin + np.arange(self.config.window)[:, None]
        real = torch.from_numpy(at < self.lengths[picks])
        index = torch.from_numpy(self.starts[picks] + np.minimum(at, self.lengths[picks] - 1))
        velocity = self.frames["velocity"][index] * real[..., None]
        velocity[0] = 0.0
        return Batch(
            vectors=self.vectors(index),
            conditions=conditions(torch.from_numpy(self.labels[picks]), self.progress[index], self.config),
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


def vocabulary_of(clips: Sequence[Clip], fps: float) -> tuple[tuple[str, ...], tuple[int, ...]]:
    """The actions that occur (mirrored ones included), in vocabulary order, and the usual length of each in frames."""
    frames: dict[str, list[float]] = {}
    for clip in clips:
        if clip.action is None:
            continue
        frames.setdefault(clip.action, []).append(clip.motion.duration)
        if vocabulary.get(clip.action).mirrors:
            frames.setdefault(mirror_words(clip.action), []).append(clip.motion.duration)
    names = tuple(action.name for action in vocabulary.VOCABULARY if action.name in frames)
    return names, tuple(round(float(np.median(frames[name])) * fps) for name in names)
