"""A space that motions and sentences share: near each other where one describes the other.

R-precision and multimodal distance are measured in it, and FID and diversity of motions made for sentences. On one side
the convolutions of the recognisers (`trunk`), on the other a small network over a frozen sentence encoder; they are
trained against each other (`train_co_embedding`). The released evaluators (Text2Motion, section 5.1) are GRUs over
their features and word vectors; theirs know other skeletons and rates.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from engines import text
from engines.config import Config
from engines.metrics.evaluators.trunk import InRow, Trunk, describe, in_row
from engines.motion import Motion
from engines.weights_file import SHIPPED, fill, read_settings

_BATCH = 256


@dataclass(frozen=True)
class CoEmbeddingConfig(Config):
    """Settings, saved as JSON beside the weights."""

    encoder: str = "minilm"
    """Of sentences, a name of `engines.text`; frozen."""
    encoder_size: int = 384
    """Of its vectors."""
    width: int = 192
    """Channels of the convolutions."""
    hidden: int = 512
    """Between trunk or sentence and the space."""
    size: int = 128
    """D, of the space."""
    longest: int = 240
    """Frames looked at, 12 seconds; of a longer motion the middle."""
    dropout: float = 0.2
    steps: int = 2_000
    batch_size: int = 128
    """Motions, every second one the mirror image of the one before it."""
    learning_rate: float = 1e-3
    weight_decay: float = 1e-2
    extra: dict[str, Any] = field(default_factory=dict)
    """Notes that travel with the weights."""


class MotionSide(Trunk):
    """Frames -> a point of the space; how long a motion lasts counts too."""

    def __init__(self, config: CoEmbeddingConfig) -> None:
        super().__init__(config.width, config.dropout / 2)
        self.head = _head(2 * config.width + 1, config)

    def forward(self, row: InRow) -> Tensor:
        """Motions in a row -> unit vectors (B, D)."""
        length = torch.bincount(row.owner[row.owner >= 0], minlength=row.count)[:, None].log() - 4.0  # about 0, of 3 s
        return nn.functional.normalize(self.head(torch.cat([self.pooled_in_row(row), length], dim=-1)), dim=-1)


class CoEmbeddingNet(nn.Module):
    """Both sides, and how sharply distances in the space are judged while training."""

    def __init__(self, config: CoEmbeddingConfig) -> None:
        super().__init__()
        self.config = config
        self.motions = MotionSide(config)
        self.words = _head(config.encoder_size, config)
        self.sharpness = nn.Parameter(torch.tensor(np.log(1 / 0.07), dtype=torch.float32))
        """Logarithm of what cosines are multiplied with: the inverse of the temperature."""

    def texts(self, sentences: Tensor) -> Tensor:
        """The encoder's sentence vectors (B, E) -> unit vectors (B, D)."""
        return nn.functional.normalize(self.words(sentences), dim=-1)


class CoEmbedding:
    """A trained co-embedding."""

    def __init__(self, net: CoEmbeddingNet) -> None:
        self.net = net.eval()
        self.config = net.config

    def motions(self, motions: Sequence[Motion]) -> np.ndarray:
        """(N, D) float64, a unit vector a motion."""
        parts = [np.zeros((0, self.config.size))]
        with torch.inference_mode():
            for start in range(0, len(motions), _BATCH):
                rows = [describe(motion, self.config.longest) for motion in motions[start : start + _BATCH]]
                parts.append(self.net.motions(in_row(rows)).double().numpy())
        return np.concatenate(parts)

    def texts(self, sentences: Sequence[str]) -> np.ndarray:
        """(N, D) float64, a unit vector a sentence.

        Raises:
            CheckpointError: the sentence encoder is not installed.
        """
        with torch.inference_mode():
            found = text.load(self.config.encoder).encode(sentences).sentences
            return self.net.texts(found).double().numpy()

    def similarity(self, sentences: Sequence[str], motions: Sequence[Motion]) -> np.ndarray:
        """(N,) float64 how well each sentence describes the motion at its place: the cosine, -1 to 1.

        What real pairs have is `engines.metrics.retrieval.REAL`.

        Raises:
            CheckpointError: the sentence encoder is not installed.
        """
        return (self.texts(sentences) * self.motions(motions)).sum(axis=1)


def load(path: Path | None = None) -> CoEmbedding:
    """The co-embedding with the weights that ship, or with others.

    Raises:
        CheckpointError: missing or damaged weights.
    """
    path = path or SHIPPED / "evaluator-text.safetensors"
    how = "train them: motionloom train evaluator --task text --run DIR --export FILE"
    net = CoEmbeddingNet(CoEmbeddingConfig.from_json(read_settings(path, how)))
    fill(net, path)
    return CoEmbedding(net)


def _head(size: int, config: CoEmbeddingConfig) -> nn.Sequential:
    return nn.Sequential(
        nn.Linear(size, config.hidden),
        nn.GELU(),
        nn.Dropout(config.dropout),
        nn.Linear(config.hidden, config.size),
    )
