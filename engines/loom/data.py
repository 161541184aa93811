"""Real clips as training windows for Loom."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from engines import actions as vocabulary
from engines.datasets import Clip
from engines.errors import MotionloomError
from engines.loom import known
from engines.loom.config import LoomConfig
from engines.loom.networks import Wanted
from engines.loom.representation import JOINTS, KNOWN, LAYOUT, Frames, frames_of, from_start, joints_from_start
from engines.text import sides
from engines.training.devices import ALONE, Share

Captions = Callable[[Sequence[Clip]], np.ndarray]
"""Clips (N) -> (N, K, `sides.SIZE`) float16: K captions of each."""
_WHOLE_ONCE, _WHOLE_REPEATING = 0.9, 0.6
"""Share of windows that hold a whole clip, where it is not too long."""
_SHORTEST = 16
_NAMES = ("height", "turns", "velocity", "contacts", "ground", "yaw", "joints")


@dataclass(frozen=True)
class Batch:
    """Windows of real motion; B of them, T frames."""

    x: Tensor
    """(B, T, D) normalised features."""
    mask: Tensor
    """(B, T) bool: frames that are there."""
    wanted: Wanted
    known: Tensor
    """(B, T, K) as `KNOWN` has it."""
    joints: Tensor
    """(B, T, J, 3) in the heading frame."""


class Windows:
    """All clips of a split and their mirror images, drawn from as balanced windows of any length.

    Args:
        clips: to draw from.
        config: with its vocabulary.
        captions: gives each clip's sentence vectors; nothing is told in words without.
    """

    def __init__(self, clips: Sequence[Clip], config: LoomConfig, captions: Captions | None = None) -> None:
        self.config = config
        clips = [clip for original in clips for clip in (original, original.mirror())]
        if not clips:
            raise MotionloomError("no clip to train on; run: motionloom data prepare, or choose other corpora.")
        parts = [frames_of(clip.motion) for clip in clips]
        self.lengths = np.array([len(part.yaw) for part in parts])
        self.starts = np.concatenate([[0], np.cumsum(self.lengths)[:-1]])
        self.arrays = {name: torch.from_numpy(np.concatenate([getattr(p, name) for p in parts])) for name in _NAMES}
        self.actions = np.array([_label(action_of(clip), config.actions) for clip in clips])
        self.styles = np.array([_label(clip.style, config.styles) for clip in clips])
        self.repeats = np.array([bool(c.action) and vocabulary.get(c.action or "").repeats for c in clips])
        self.captions = None if captions is None else torch.from_numpy(captions(clips))
        self.probability = _balanced(clips, config)

    def __len__(self) -> int:
        return len(self.lengths)

    def statistics(self) -> tuple[Tensor, Tensor]:
        """Mean and deviation (D,) of the features; small deviations are raised towards their part's average."""
        rng = np.random.default_rng(0)
        batches = [self.windows(*self._choose(rng, 256)) for _ in range(16)]
        rows = torch.cat([x[mask] for x, _, mask in batches])
        mean, std = rows.mean(0), rows.std(0)
        for part in LAYOUT:
            held = std[LAYOUT[part.name]]
            std[LAYOUT[part.name]] = held.clamp_min(0.3 * float(held.mean()))
        for name in ("ground", "facing", "contacts"):
            std[LAYOUT[name]] = std[LAYOUT[name]].mean()
        mean[LAYOUT["ground"]] = 0.0
        return mean, std.clamp_min(1e-3)

    def draw(
        self, rng: np.random.Generator, mean: Tensor, std: Tensor, size: int | None = None, share: Share = ALONE
    ) -> Batch:
        """A random batch, or this process's share of it: windows of about the same length, so that few are padded."""
        size = size or self.config.batch_size
        picks, begin, length = self._choose(rng, 4 * size)
        quarter = int(rng.integers(4))
        rows = np.argsort(length, kind="stable")[quarter * size : (quarter + 1) * size]
        return self.batch(picks[rows], begin[rows], length[rows], rng, mean, std, share)

    def each(self, mean: Tensor, std: Tensor, share: Share = ALONE) -> Iterator[Batch]:
        """Every clip once, at its beginning, told what it is and some of itself, the same each time."""
        rng = np.random.default_rng(1)
        order = np.argsort(self.lengths, kind="stable")
        size = self.config.batch_size
        order = np.resize(order, -(-len(order) // size) * size)
        for first in range(0, len(order), size):
            picks = order[first : first + size]
            length = np.minimum(self.lengths[picks], self.config.longest)
            yield self.batch(picks, np.zeros(size, dtype=int), length, rng, mean, std, share)

    def _choose(self, rng: np.random.Generator, size: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Clips, first frames and lengths of windows."""
        picks = rng.choice(len(self), size=size, p=self.probability)
        most = np.minimum(self.lengths[picks], self.config.longest)
        whole = rng.random(size) < np.where(self.repeats[picks], _WHOLE_REPEATING, _WHOLE_ONCE)
        least = np.minimum(most, _SHORTEST)
        length = np.where(whole, most, least + (rng.random(size) * (most - least + 1)).astype(int))
        begin = (rng.random(size) * (self.lengths[picks] - length + 1)).astype(int)
        return picks, begin, length

    def windows(self, picks: np.ndarray, begin: np.ndarray, length: np.ndarray) -> tuple[Tensor, Tensor, Tensor]:
        """Features (B, T, D), not normalised, joints (B, T, J, 3) and frames that are there (B, T)."""
        frames = -(-int(length.max()) // self.config.patch) * self.config.patch
        at = np.arange(frames)
        mask = torch.from_numpy(at < length[:, None])
        index = torch.from_numpy((self.starts[picks] + begin)[:, None] + np.minimum(at, length[:, None] - 1))
        held = {name: value[index] for name, value in self.arrays.items()}
        ground, facing = from_start(held["ground"], held["yaw"])
        velocity = held["velocity"] * mask[..., None]
        velocity[:, 0] = 0.0
        parts = [held["height"], held["turns"].flatten(2), velocity, held["contacts"], ground, facing]
        return torch.cat(parts, dim=-1), held["joints"], mask

    def batch(  # noqa: PLR0913, PLR0917 - which windows, how they are scaled, whose share
        self, picks: np.ndarray, begin: np.ndarray, length: np.ndarray, rng: np.random.Generator, mean: Tensor,
        std: Tensor, share: Share = ALONE,
    ) -> Batch:  # fmt: skip
        """The chosen windows, what they are told, and what is known of them."""
        wanted = self._wanted(picks, begin, length, rng)
        x, joints, mask = self.windows(picks, begin, length)
        drawn = known.draw(rng, length, x.shape[1], self.config.constrained)
        normal = (x - mean) / std * mask[..., None]
        facts = reveal(normal, joints, x, drawn)

        def mine(value: Tensor) -> Tensor:
            return value[share.rows].to(share.device)

        told = Wanted(*(mine(value) for value in wanted))
        return Batch(mine(normal), mine(mask), told, mine(facts), mine(joints))

    def _wanted(self, picks: np.ndarray, begin: np.ndarray, length: np.ndarray, rng: np.random.Generator) -> Wanted:
        config, count = self.config, len(picks)
        chance = rng.random(count)
        silent = chance < config.unconditional
        worded = (chance >= config.unconditional) & (chance < config.unconditional + config.wordy + config.both)
        labelled = ~silent & (chance >= config.unconditional + config.wordy)
        styled = labelled & (rng.random(count) < 0.9)
        which = rng.integers(1 << 30, size=count)
        text = torch.zeros(count, sides.SIZE)
        if self.captions is not None:
            # a caption speaks of the whole clip
            worded &= length >= 0.6 * self.lengths[picks]
            chosen = self.captions[torch.from_numpy(picks), torch.from_numpy(which % self.captions.shape[1])]
            text = chosen.float() * torch.from_numpy(worded)[:, None]
        span = 1 + (begin == 0) + 2 * (begin + length == self.lengths[picks])
        span = np.where(rng.random(count) < 0.15, 0, span)
        return Wanted(
            torch.from_numpy(np.where(labelled, self.actions[picks], 0)),
            torch.from_numpy(np.where(styled, self.styles[picks], 0)),
            text,
            torch.from_numpy(span),
            torch.from_numpy(length),
        )


def reveal(x: Tensor, joints: Tensor, raw: Tensor, masks: known.Masks) -> Tensor:
    """(B, T, K) what is known: normalised features, joints as seen from the start, and the masks.

    Args:
        x: (B, T, D) normalised.
        joints: (B, T, J, 3) in the heading frame, metres.
        raw: (B, T, D) not normalised.
        masks: which of it is known.
    """
    facts = x.new_zeros(*x.shape[:2], KNOWN.size)
    seen = joints_from_start(joints, LAYOUT.read(raw, "ground"), LAYOUT.read(raw, "facing"))[..., 1:, :]
    values = {name: LAYOUT.read(x, name) for name in ("turns", "height", "ground", "facing")}
    values["joints"] = seen
    for name, value in values.items():
        mask = torch.from_numpy(getattr(masks, name)).to(x)
        per_joint = mask.ndim == 3
        KNOWN.read(facts, name)[...] = value * mask[..., None]
        KNOWN.read(facts, f"{name}_known")[...] = mask if per_joint else mask[..., None]
    return facts


def action_of(clip: Clip) -> str | None:
    """The action a window of the clip may be told; none for the mirror image of an action with a side."""
    if clip.action is None or (clip.name.startswith("M") and not vocabulary.get(clip.action).mirrors):
        return None
    return clip.action


def vocabulary_of(clips: Sequence[Clip]) -> tuple[tuple[str, ...], tuple[str, ...], tuple[tuple[int, int, int], ...]]:
    """Actions and styles that occur (mirrored ones too), and each action's usual lengths in frames."""
    lengths: dict[str, list[int]] = {}
    for clip in (c for original in clips for c in (original, original.mirror())):
        if name := action_of(clip):
            lengths.setdefault(name, []).append(len(clip.motion))
    names = tuple(action.name for action in vocabulary.VOCABULARY if action.name in lengths)
    usual = tuple(tuple(int(n) for n in np.percentile(lengths[name], [5, 50, 95])) for name in names)
    return names, tuple(sorted({clip.style for clip in clips if clip.style})), usual  # type: ignore[return-value]


def _label(name: str | None, names: Sequence[str]) -> int:
    return 1 + names.index(name) if name in names else 0


def _balanced(clips: Sequence[Clip], config: LoomConfig) -> np.ndarray:
    """(N,) chance of each clip: labels and styles even out, long clips are drawn more often, and emphasised ones."""
    actions, styles = Counter(clip.action for clip in clips), Counter(clip.style for clip in clips)
    weight = np.array([actions[clip.action] ** (config.label_balance - 1.0) for clip in clips])
    weight *= np.array([styles[clip.style] ** -config.style_balance for clip in clips])
    weight *= np.sqrt(np.maximum(1.0, np.array([len(clip.motion) for clip in clips]) / 200))
    weight *= np.where(np.isin([clip.action or "" for clip in clips], config.emphasised), config.emphasis, 1.0)
    return weight / weight.sum()


__all__ = ["JOINTS", "Batch", "Frames", "Windows", "reveal", "vocabulary_of"]
