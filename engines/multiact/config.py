"""Settings of MultiAct, saved as JSON beside its weights."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from engines.config import Config
from engines.config import preset as named
from engines.errors import OutOfRangeError


@dataclass(frozen=True)
class MultiActConfig(Config):
    """Sizes, loss weights and vocabulary. The defaults are the preset `paper` (supplement, implementation details)."""

    actions: tuple[str, ...] = ()
    """Labels, in the order of their tokens."""
    usual_frames: tuple[tuple[int, int, int], ...] = ()
    """Of each action, how long it takes in the training clips: 5th, 50th and 95th percentile, frames."""

    width: int = 512
    """d: inner size of both Transformers, and size of each latent."""
    heads: int = 4
    inner: int = 2048
    """Width of the Transformers' feed-forward parts."""
    encoder_layers: int = 8
    decoder_layers: int = 8
    dropout: float = 0.1

    pairs: int = 10_000
    """Triplets that are made of the training clips (`data`)."""
    label_balance: float = 0.3
    """An action with n clips takes part with a chance proportional to n ** label_balance."""
    noise: float = 0.0
    """Deviation of the noise on the previous motion, in deviations of the features: what it will see of its own."""

    batch_size: int = 16
    learning_rate: float = 5e-5
    final_learning_rate: float = 5e-5
    weight_decay: float = 1e-2
    average: float = 0.999
    """Decay of the moving average of the weights."""
    pose_weight: float = 1.0
    """L_P, on rotations (6-D) and the root's height and steps."""
    joint_weight: float = 1.0
    """L_V, with joints for vertices: metres from the root's place on the floor."""
    acceleration_weight: float = 1.0
    """lambda_acc, on joints."""
    movement_weight: float = 0.0
    """On how joints move over the ground from frame to frame."""
    contact_weight: float = 0.0
    """On how far standing feet move over the ground from frame to frame."""
    place_weight: float = 1.0
    """On where on the floor the root is, metres from the end of the previous motion."""
    kl_weight: float = 1e-5
    """lambda_KL, on nats a sequence."""
    free_nats: float = 0.0
    """So much divergence costs nothing (Kingma et al. 2016): what the latents may know that nobody can foresee."""
    length_weight: float = 0.1
    """On the logarithm of the transition's length."""
    steps: int = 86_000
    """1,300 epochs of 1,060 motions."""

    extra: Mapping[str, Any] = field(default_factory=dict)
    """Notes that travel with the weights."""

    def checked(self) -> MultiActConfig:
        """Itself, once every number is in its range.

        Raises:
            OutOfRangeError: one is not; the message says which and what would be accepted.
        """
        for name in ("width", "heads", "inner", "encoder_layers", "decoder_layers", "pairs", "batch_size", "steps"):
            if getattr(self, name) < 1:
                raise OutOfRangeError(name, getattr(self, name), "1 or more")
        if self.width % 4 or self.width % self.heads:
            raise OutOfRangeError("width", self.width, f"a multiple of 4 and of the {self.heads} heads")
        for name in ("noise", "free_nats", *(name for name in vars(self) if name.endswith("_weight"))):
            if not getattr(self, name) >= 0:
                raise OutOfRangeError(name, getattr(self, name), "0 or more")
        if not 0 <= self.dropout < 1:
            raise OutOfRangeError("dropout", self.dropout, "0 up to, but not, 1")
        return self


PAPER = MultiActConfig()
SMALL = MultiActConfig(
    width=192, inner=384, encoder_layers=2, decoder_layers=4, dropout=0.0, noise=0.03, batch_size=16,
    learning_rate=4e-4, final_learning_rate=1e-5, joint_weight=2.0, acceleration_weight=5.0, movement_weight=5.0,
    contact_weight=5.0, place_weight=0.1, kl_weight=0.02, free_nats=24.0, steps=40_000,
)  # fmt: skip
"""What ships."""
PRESETS = {"paper": PAPER, "small": SMALL}


def preset(name: str) -> MultiActConfig:
    """A named preset; `UnknownLabelError` if there is no such one."""
    return named(name, PRESETS)
