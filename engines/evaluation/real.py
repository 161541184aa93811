"""Real motions to compare with: stretches of clips by action, drawn with replacement, each looked at once."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from engines.datasets import Clip
from engines.metrics import physical
from engines.metrics.evaluators import Recogniser
from engines.metrics.recognition import Recognised
from engines.motion import Motion

STEP = 20
"""Frames from one stretch of a clip to the next, a second."""


@dataclass(frozen=True)
class Stretch:
    """Some frames of a clip."""

    clip: Clip
    start: int
    frames: int

    @property
    def motion(self) -> Motion:
        """These frames, the body at the origin and facing +Z at their first, as generated ones are."""
        return self.clip.motion[self.start : self.start + self.frames].face_front()


class RealMotions:
    """Clips of some actions as stretches of one length.

    A clip that is longer gives a stretch every second, a shorter one is one stretch as it is. What the recogniser and
    the physical measures say of a stretch is found when it is first drawn, and kept.

    Args:
        clips: of any actions; those of others are left aside.
        actions: what the labels of `draw` count.
        frames: length of a stretch, at the house rate.
        recogniser: looks at them.
    """

    def __init__(self, clips: Sequence[Clip], actions: Sequence[str], frames: int, recogniser: Recogniser) -> None:
        self.actions, self.recogniser = tuple(actions), recogniser
        self.stretches: list[Stretch] = []
        self.by_action: list[list[range]] = [[] for _ in actions]
        """Of each action, the stretches of each of its clips."""
        for clip in clips:
            if clip.action in self.actions:
                first = len(self.stretches)
                self.stretches += _cut(clip, frames)
                self.by_action[self.actions.index(clip.action)].append(range(first, len(self.stretches)))
        self._own = {i: clip for clips in self.by_action for clip in clips for i in clip}
        self._seen: dict[int, tuple[np.ndarray, np.ndarray]] = {}
        self._measured: dict[int, dict[str, float]] = {}

    @property
    def complete(self) -> bool:
        """Whether every action has a clip."""
        return all(self.by_action)

    @property
    def clips(self) -> int:
        """How many clips there are."""
        return sum(len(clips) for clips in self.by_action)

    @property
    def short(self) -> int:
        """How many of them are shorter than a stretch."""
        longest = max((stretch.frames for stretch in self.stretches), default=0)
        return sum(self.stretches[clip.start].frames < longest for clips in self.by_action for clip in clips)

    def draw(self, labels: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """A stretch for each label (N,), as indices (N,): first a clip of the action, then one of its stretches."""
        clip, place = rng.random((2, len(labels)))
        chosen = np.empty(len(labels), dtype=np.int64)
        for i, label in enumerate(labels):
            stretches = self.by_action[label][int(clip[i] * len(self.by_action[label]))]
            chosen[i] = stretches[int(place[i] * len(stretches))]
        return chosen

    def firsts(self) -> np.ndarray:
        """The first stretch of every clip, as indices."""
        return np.array([clip.start for clips in self.by_action for clip in clips], dtype=np.int64)

    def recognised(self, chosen: np.ndarray) -> Recognised:
        """The recogniser's view of stretches (N,).

        It looks at all stretches of a clip together: what it says of one then never depends, not even in the last
        digit, on what else was drawn before.
        """
        for i in map(int, np.unique(chosen)):
            if i not in self._seen:
                own = self._own[i]
                seen = self.recogniser.recognised([self.stretches[k].motion for k in own])
                self._seen |= {k: (seen.features[j], seen.logits[j]) for j, k in enumerate(own)}
        features, logits = zip(*(self._seen[int(i)] for i in chosen), strict=True)
        return Recognised(np.stack(features), np.stack(logits))

    def physical(self, chosen: np.ndarray) -> dict[str, float]:
        """Means of the physical measures over stretches (N,), in the units of a table."""
        for i in map(int, np.unique(chosen)):
            if i not in self._measured:
                self._measured[i] = physical.table(self.stretches[i].motion)
        return means([self._measured[int(i)] for i in chosen])

    def fingerprint(self) -> str:
        """Changes with the clips, their order or their frames."""
        digest = hashlib.blake2b(digest_size=8)
        for stretch in self.stretches:
            clip = stretch.clip
            digest.update(f"{clip.corpus}/{clip.name}/{clip.action}/{stretch.start}+{stretch.frames};".encode())
            digest.update(clip.motion.translation[stretch.start].tobytes())
        return digest.hexdigest()


def means(rows: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """Mean of each figure over rows that all have the same."""
    return {name: float(np.mean([row[name] for row in rows])) for name in rows[0]} if rows else {}


def _cut(clip: Clip, frames: int) -> list[Stretch]:
    length = len(clip.motion)
    if length <= frames:
        return [Stretch(clip, 0, length)]
    return [Stretch(clip, start, frames) for start in range(0, length - frames + 1, STEP)]
