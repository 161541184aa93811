"""Recognisers: which action, content or style a motion shows, and the features that FID and diversity compare.

A small convolutional network over bone directions in the body's own heading: it sees neither where the body stands nor
which way it faces nor how long its bones are. The released evaluators are GRU classifiers on joint positions (thesis
section 3.3); theirs cannot be used here, as they know other skeletons and other actions.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np
import torch
from safetensors.torch import load_file
from torch import Tensor, nn

from engines.action2motion.representation import encode
from engines.errors import CheckpointError, UnknownLabelError
from engines.metrics.recognition import Recognised
from engines.motion import Motion
from engines.skeletons import SMPL22

Task = Literal["action", "content", "style"]
TASKS: tuple[Task, ...] = ("action", "content", "style")
FPS = 20.0
BONES = 3 * (len(SMPL22) - 1)
CHANNELS = 2 * BONES + 4
"""Bone directions, how they change from frame to frame, root height and root velocity."""
STRIDES = (2, 1, 2, 1, 1)
"""Of the convolutions over time: half and quarter rate."""
LONGEST = 160
"""Frames looked at, 8 seconds; of a longer motion the middle."""
WEIGHTS = Path(__file__).resolve().parents[2] / "weights"


@dataclass(frozen=True)
class RecogniserConfig:
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
    smoothing: float = 0.1
    """Of the labels."""
    extra: dict[str, Any] = field(default_factory=dict)
    """Notes that travel with the weights."""

    def to_json(self) -> str:
        """Readable JSON."""
        return json.dumps(asdict(self), indent=1)

    @classmethod
    def from_json(cls, text: str) -> RecogniserConfig:
        """The settings of a saved file."""
        values = json.loads(text)
        return cls(**{**values, "labels": tuple(values["labels"])})


class RecogniserNet(nn.Module):
    """Convolutions over time at half and quarter rate, pooled over the frames there are."""

    mean: Tensor
    std: Tensor

    def __init__(self, config: RecogniserConfig) -> None:
        super().__init__()
        self.config = config
        width = config.width
        sizes = [CHANNELS, *[width] * (len(STRIDES) - 1)]
        self.convolutions = nn.ModuleList(
            nn.Conv1d(size, width, 5, stride=stride, padding=2) for size, stride in zip(sizes, STRIDES, strict=True)
        )
        self.norms = nn.ModuleList(nn.BatchNorm1d(width) for _ in STRIDES)
        self.features = nn.Linear(2 * width, config.features)
        self.output = nn.Linear(config.features, len(config.labels))
        self.register_buffer("mean", torch.zeros(CHANNELS))
        self.register_buffer("std", torch.ones(CHANNELS))

    def forward(self, frames: Tensor, mask: Tensor) -> tuple[Tensor, Tensor]:
        """Frames (B, T, C) and which of them are there (B, T) -> logits (B, L) and features (B, F)."""
        x = ((frames - self.mean) / self.std).mT
        there = mask[:, None].to(x)
        x = x * there
        for convolution, norm, stride in zip(self.convolutions, self.norms, STRIDES, strict=True):
            there = there[:, :, ::stride]
            made = nn.functional.gelu(norm(convolution(x))) * there
            x = made + x if made.shape == x.shape else made
            x = nn.functional.dropout(x, self.config.dropout / 2, self.training)
        mean = x.sum(-1) / there.sum(-1)
        top = x.masked_fill(there == 0, -1e4).amax(-1)
        features = self.features(torch.cat([mean, top], dim=-1))
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
                made = self.net(*pad([describe(motion) for motion in motions[start : start + 256]]))
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


def describe(motion: Motion) -> np.ndarray:
    """(T, C) what the network sees of a motion, float32; brought to smpl22 and 20 fps where it is not."""
    house = motion if motion.skeleton is SMPL22 else motion.retarget(SMPL22)
    house = house if house.fps == FPS else house.resample(FPS)
    if len(house) > LONGEST:
        start = (len(house) - LONGEST) // 2
        house = house[start : start + LONGEST]
    found = encode(house)
    bones = found.positions[:, 1:] - found.positions[:, list(SMPL22.parents[1:])]
    bones = bones / np.linalg.norm(bones, axis=-1, keepdims=True)
    flat = bones.reshape(len(bones), -1)
    change = np.diff(flat, axis=0, prepend=flat[:1])
    return np.concatenate([flat, change, found.height, found.velocity], axis=-1).astype(np.float32)


def pad(rows: Sequence[np.ndarray]) -> tuple[Tensor, Tensor]:
    """Descriptions of different lengths as one batch (B, T, C), the last frame held, and a mask (B, T)."""
    longest = max(len(row) for row in rows)
    frames = np.stack([row[np.minimum(np.arange(longest), len(row) - 1)] for row in rows])
    mask = np.arange(longest) < np.array([len(row) for row in rows])[:, None]
    return torch.from_numpy(frames), torch.from_numpy(mask)


def load(task: Task = "action", path: Path | None = None) -> Recogniser:
    """A recogniser with the weights that ship, or with others.

    Raises:
        UnknownLabelError: no such task.
        CheckpointError: missing or damaged weights.
    """
    if task not in TASKS:
        raise UnknownLabelError("recogniser", task, TASKS)
    path = path or WEIGHTS / f"evaluator-{task}.safetensors"
    if not path.is_file():
        raise CheckpointError(
            f"{path}: no such weights; train them: motionloom train evaluator --task {task} --run DIR --export FILE"
        )
    net = RecogniserNet(RecogniserConfig.from_json(path.with_suffix(".json").read_text(encoding="utf-8")))
    try:
        net.load_state_dict({k: v.float() if v.is_floating_point() else v for k, v in load_file(path).items()})
    except Exception as error:  # safetensors and torch raise many kinds; each means the file does not fit
        raise CheckpointError(f"{path}: these weights do not fit their settings: {error}") from error
    return Recogniser(net)
