"""Recognisers: which action, content or style a motion shows, and the features that FID and diversity compare.

A small convolutional network over bone directions in the body's own heading (`trunk`). The released evaluators are GRU
classifiers on joint positions (thesis section 3.3); theirs cannot be used here, as they know other skeletons and other
actions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np
import torch
from torch import Tensor, nn

from engines.config import Config
from engines.errors import UnknownLabelError
from engines.metrics.evaluators.trunk import CHANNELS, HANDS, Trunk, describe, pad
from engines.metrics.recognition import Recognised
from engines.motion import Motion
from engines.weights_file import SHIPPED, fill, read_settings

Task = Literal["action", "content", "style"]
TASKS: tuple[Task, ...] = ("action", "content", "style")


@dataclass(frozen=True)
class RecogniserConfig(Config):
    """Settings, saved as JSON beside the weights."""

    task: Task = "action"
    """What the labels are: actions, contents of the style sets, or styles."""
    labels: tuple[str, ...] = ()
    width: int = 192
    """Channels of the convolutions."""
    features: int = 128
    """Size of the features that FID compares."""
    dropout: float = 0.2
    steps: int = 1_500
    batch_size: int = 64
    learning_rate: float = 2e-3
    weight_decay: float = 1e-2
    smoothing: float = 0.05
    """Of the labels."""
    extra: dict[str, Any] = field(default_factory=dict)
    """Notes that travel with the weights."""


class RecogniserNet(Trunk):
    """The trunk, features, and a score a label."""

    def __init__(self, config: RecogniserConfig) -> None:
        super().__init__(config.width, config.dropout / 2, CHANNELS + 2 * HANDS)
        self.config = config
        self.features = nn.Linear(3 * config.width, config.features)
        self.output = nn.Linear(config.features, len(config.labels))

    def forward(self, frames: Tensor, mask: Tensor) -> tuple[Tensor, Tensor]:
        """Frames (B, T, C) and which of them are there (B, T) -> logits (B, L) and features (B, F)."""
        features = self.features(self.pooled(frames, mask))
        kept = nn.functional.dropout(nn.functional.gelu(features), self.config.dropout, self.training)
        return self.output(kept), features


class Recogniser:
    """A trained network with its labels."""

    def __init__(self, net: RecogniserNet) -> None:
        self.net = net.eval()
        self.config = net.config
        self.labels = net.config.labels

    def recognised(self, motions: Sequence[Motion]) -> Recognised:
        """Logits (N, L) over `labels`, and features (N, F), which FID, diversity and multimodality compare; float64."""
        logits, features = [], []
        with torch.inference_mode():
            for start in range(0, len(motions), 256):
                made = self.net(*pad([describe(motion, hands=True) for motion in motions[start : start + 256]]))
                logits.append(made[0].double().numpy())
                features.append(made[1].double().numpy())
        return Recognised(features=np.concatenate(features), logits=np.concatenate(logits))

    def recognise(self, motions: Sequence[Motion]) -> list[str]:
        """The likeliest label of each."""
        return [self.labels[int(i)] for i in self.recognised(motions).logits.argmax(-1)]

    def index(self, label: str) -> int:
        """Place of a label.

        Raises:
            UnknownLabelError: this recogniser was not trained on it.
        """
        if label not in self.labels:
            raise UnknownLabelError(self.config.task, label, self.labels)
        return self.labels.index(label)


def load(task: Task = "action", path: Path | None = None) -> Recogniser:
    """A recogniser with the weights that ship, or with others.

    Raises:
        UnknownLabelError: no such task.
        CheckpointError: missing or damaged weights.
    """
    if task not in TASKS:
        raise UnknownLabelError("recogniser", task, TASKS)
    path = path or SHIPPED / f"evaluator-{task}.safetensors"
    how = f"train them: motionloom train evaluator --task {task} --run DIR --export FILE"
    net = RecogniserNet(RecogniserConfig.from_json(read_settings(path, how)))
    fill(net, path)
    return Recogniser(net)
