"""What the networks are told, frame by frame: from (action, frames) at the house rate to labels and time counter."""

from __future__ import annotations

import copy
from itertools import pairwise

import numpy as np
import torch

from engines import actions as vocabulary
from engines.action2motion.config import Action2MotionConfig
from engines.action2motion.progress import progress_of
from engines.motion import Segment

HOUSE_FPS = 20.0


class Plan:
    """Which action, how far along, at each of the model's frames.

    Args:
        config: of the model.
        parts: (label, frames at the house rate), in order.
    """

    def __init__(self, config: Action2MotionConfig, parts: tuple[tuple[int, int], ...]) -> None:
        self.name = " > ".join(config.actions[label] for label, _ in parts)
        self.frames = sum(frames for _, frames in parts)
        ratio = HOUSE_FPS / config.fps
        edges = np.cumsum([0] + [frames for _, frames in parts])
        self.segments = tuple(
            Segment(int(a), int(b), "action", config.actions[label])
            for (label, _), a, b in zip(parts, edges[:-1], edges[1:], strict=True)
        )
        steps = max(1, int(np.ceil((self.frames - 1) / ratio)) + 1)
        bounds = [min(steps, round(edge / ratio)) for edge in edges[:-1]] + [steps]
        labels, progress = [], []
        for (label, _), a, b in zip(parts, bounds[:-1], bounds[1:], strict=True):
            labels.append(np.full(b - a, label))
            action = vocabulary.get(config.actions[label])
            progress.append(progress_of(b - a, config.nominal_frames[label], action.repeats))
        self.labels = torch.from_numpy(np.concatenate(labels))
        self.progress = torch.from_numpy(np.concatenate(progress)).float()

    @property
    def steps(self) -> int:
        """Number of the model's frames."""
        return len(self.labels)

    @property
    def performances(self) -> list[range]:
        """The model's frames of each time an action is done; where one action passes into another, memory goes on."""
        again = (self.progress[1:] < self.progress[:-1]) & (self.labels[1:] == self.labels[:-1])
        bounds = [0, *(int(frame) + 1 for frame in torch.nonzero(again)), self.steps]
        return [range(a, b) for a, b in pairwise(bounds)]

    def until(self, steps: int) -> Plan:
        """The plan cut, or held at its end, to so many of the model's frames."""
        other = copy.copy(self)
        index = torch.arange(steps).clamp(max=self.steps - 1)
        other.labels, other.progress = self.labels[index], self.progress[index]
        return other
