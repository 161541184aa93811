"""Settings of Action2Motion, saved as JSON beside its weights."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any, Literal

from engines.config import Config
from engines.config import preset as named
from engines.errors import OutOfRangeError

Decoder = Literal["plain", "lie", "glmi-m", "glmi-r"]
DECODERS: tuple[Decoder, ...] = ("plain", "lie", "glmi-m", "glmi-r")


@dataclass(frozen=True)
class Action2MotionConfig(Config):
    """Sizes, schedules and vocabulary. The defaults are the preset `paper` (thesis section 3.3)."""

    decoder: Decoder = "glmi-m"
    """Pose decoding: joint positions, Lie parameters, or Lie parameters with a GLMI unit (MLP or GRU)."""
    actions: tuple[str, ...] = ()
    """Labels in one-hot order."""
    nominal_frames: tuple[int, ...] = ()
    """Usual length of each action in model frames: how long one performance takes."""
    fps: float = 20.0
    """Rate at which the networks run; motions come out at the house rate."""
    window: int = 60
    """Frames of a training sequence."""
    joints: int = 22
    """J; the skeleton is smpl22."""

    embed_size: int = 128
    """Width of prior and posterior."""
    generator_size: int = 128
    """Width of the generator."""
    latent_size: int = 30
    """Z, dimensions of the noise at each frame."""
    movement_size: int = 20
    """Width of h°, what the GLMI unit hears from upstream besides the two poses."""
    prior_layers: int = 1
    posterior_layers: int = 1
    generator_layers: int = 2
    time_counter: bool = True
    """Feed c_t, how much of the action is done, in 0..1."""

    batch_size: int = 128
    learning_rate: float = 2e-4
    final_learning_rate: float = 2e-4
    """Reached along a cosine at the last step."""
    weight_decay: float = 1e-5
    teacher_forcing: float = 0.6
    """Share of what the networks are fed that is real: of whole sequences, or with `feed_rounds` of single poses."""
    feed_rounds: int = 0
    """0: a sequence that is not forced feeds itself frame by frame (thesis). n > 0: what it would feed itself is
    worked out in n fused passes instead, and stands in for real poses here and there (parallel scheduled sampling)."""
    pose_noise: float = 0.0
    """With `feed_rounds`: largest deviation of the noise on what is fed, in deviations of the pose."""
    label_balance: float = 1.0
    """A label with n clips is drawn with a chance proportional to n ** label_balance: 1 as they come, 0 even."""
    kl_weight: tuple[float, float] = (0.001, 0.01)
    """lambda_kl at the first and from the last step of its linear rise."""
    kl_rise: float = 1.0
    """Share of the training over which it rises."""
    alignment_weight: float = 10.0
    """lambda_align on the root velocity, metres and radians a frame; all decoders learn it the same way."""
    rotation_weight: float = 0.0
    """On rotation matrices: fixes the twists that joint positions leave free."""
    velocity_weight: float = 0.0
    """On how joints move from frame to frame, metres."""
    contact_weight: float = 0.0
    """On the world speed of feet that stand, metres a frame."""
    normalise: bool = False
    """Scale inputs to zero mean and unit variance."""
    steps: int = 50_000
    """Training steps that the schedules span."""

    extra: Mapping[str, Any] = field(default_factory=dict)
    """Notes that travel with the weights."""

    @property
    def pose_size(self) -> int:
        """D, a pose as the networks are fed it: root height and a 3-vector a joint (plain: without height)."""
        return 3 * self.joints + (self.decoder != "plain")

    @property
    def condition_size(self) -> int:
        """Action one-hot and time counter."""
        return len(self.actions) + self.time_counter

    def checked(self) -> Action2MotionConfig:
        """Itself, once every number is in its range.

        Raises:
            OutOfRangeError: one is not; the message says which and what would be accepted.
        """
        for name, value in vars(self).items():
            numbers = [n for n in (value if isinstance(value, tuple) else (value,)) if isinstance(n, int | float)]
            if not all(math.isfinite(n) and n >= 0 for n in numbers):
                raise OutOfRangeError(name, value, "0 or more")
            if name in _AT_LEAST_ONE and min(numbers) < 1:
                raise OutOfRangeError(name, value, "1 or more")
            if name in _SHARES and max(numbers) > 1:
                raise OutOfRangeError(name, value, "0 to 1")
        if self.window < 2:
            raise OutOfRangeError("window", self.window, "2 frames or more")
        if self.fps <= 0:
            raise OutOfRangeError("fps", self.fps, "a rate above 0")
        return self


_AT_LEAST_ONE = frozenset(
    f.name
    for f in fields(Action2MotionConfig)
    if f.name.endswith(("_size", "_layers")) or f.name in {"joints", "steps"}
)
_SHARES = frozenset({"teacher_forcing", "label_balance", "kl_rise"})


PAPER = Action2MotionConfig()
"""Sizes, losses and schedule of the thesis."""

SMALL = Action2MotionConfig(
    fps=10.0,
    window=32,
    generator_size=192,
    batch_size=128,
    learning_rate=1e-3,
    final_learning_rate=5e-5,
    teacher_forcing=0.6,
    feed_rounds=1,
    pose_noise=0.15,
    label_balance=0.5,
    kl_weight=(0.02, 0.1),
    kl_rise=0.3,
    rotation_weight=1.0,
    velocity_weight=1.0,
    contact_weight=2.0,
    normalise=True,
    steps=16_000,
)
"""What ships: half the frame rate and a wider generator, more terms in the loss."""

PRESETS = {"paper": PAPER, "small": SMALL}


def preset(name: str) -> Action2MotionConfig:
    """A named preset; `UnknownLabelError` if there is no such one."""
    return named(name, PRESETS)
