"""Settings of Loom, saved as JSON beside its weights."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from engines.config import Config
from engines.config import preset as named
from engines.errors import OutOfRangeError


@dataclass(frozen=True)
class LoomConfig(Config):
    """Sizes, schedules and vocabulary; the defaults are the preset `small`, which ships."""

    actions: tuple[str, ...] = ()
    """Labels, in the order of their embeddings (after "not told")."""
    styles: tuple[str, ...] = ()
    usual_frames: tuple[tuple[int, int, int], ...] = ()
    """Of each action, how long it takes in the training clips: 5th, 50th and 95th percentile, frames."""
    text_encoder: str = "minilm"
    """Of `engines.text`; its pooled sentence vector is the condition."""

    width: int = 320
    """H, of the transformer."""
    depth: int = 6
    """Its blocks."""
    heads: int = 5
    inner: int = 960
    """Width inside a block's feed-forward part."""
    patch: int = 8
    """Frames that make one token."""
    frame_width: int = 128
    """Width of the convolutions that turn tokens back into frames."""
    longest: int = 200
    """Frames of the longest window, 10 s."""

    batch_size: int = 64
    learning_rate: float = 6e-4
    final_learning_rate: float = 2e-5
    weight_decay: float = 1e-2
    average: float = 0.999
    """Decay of the moving average of the weights."""
    label_balance: float = 0.3
    """A label with n clips is drawn with a chance proportional to n ** label_balance."""
    style_balance: float = 0.3
    """A clip of a style that n clips have is drawn with a chance proportional to n ** -style_balance besides."""
    emphasised: tuple[str, ...] = ()
    """Actions whose clips are drawn `emphasis` times as often: those that a training before did not learn well."""
    emphasis: float = 3.0
    unconditional: float = 0.1
    """Share of training windows that are told nothing of what they show."""
    wordy: float = 0.4
    """Share told a caption and no label."""
    both: float = 0.1
    """Share told a caption and the labels."""
    constrained: float = 0.6
    """Share of which something is known beforehand (poses, paths, joints, parts of the body)."""
    joint_weight: float = 5.0
    """On joint positions after forward kinematics, square metres summed over joints."""
    movement_weight: float = 50.0
    """On how joints move over the ground from frame to frame."""
    contact_weight: float = 50.0
    """On how far standing feet move over the ground from frame to frame."""
    steps: int = 40_000
    """Training steps that the schedules span."""

    extra: Mapping[str, Any] = field(default_factory=dict)
    """Notes that travel with the weights."""

    def checked(self) -> LoomConfig:
        """Itself, once every number is in its range.

        Raises:
            OutOfRangeError: one is not; the message says which and what would be accepted.
        """
        sizes = ("width", "depth", "heads", "inner", "patch", "frame_width", "longest", "batch_size", "steps")
        for name in sizes:
            if getattr(self, name) < 1:
                raise OutOfRangeError(name, getattr(self, name), "1 or more")
        if self.width % (2 * self.heads):
            raise OutOfRangeError("width", self.width, f"a multiple of {2 * self.heads}, twice the heads")
        if self.longest % self.patch:
            raise OutOfRangeError("longest", self.longest, f"a multiple of the patch, {self.patch}")
        for name in ("unconditional", "wordy", "both", "constrained"):
            if not 0 <= getattr(self, name) <= 1:
                raise OutOfRangeError(name, getattr(self, name), "0 to 1")
        if self.emphasis <= 0:
            raise OutOfRangeError("emphasis", self.emphasis, "above 0")
        if self.unconditional + self.wordy + self.both > 1:
            raise OutOfRangeError("unconditional + wordy + both", self.unconditional + self.wordy + self.both, "0 to 1")
        return self


SMALL = LoomConfig()
LARGE = LoomConfig(width=768, depth=12, heads=12, inner=3072, batch_size=512, steps=200_000, learning_rate=3e-4)
"""For GPUs and larger data; nothing of it was trained here."""
PRESETS = {"small": SMALL, "large": LARGE}


def preset(name: str) -> LoomConfig:
    """A named preset; `UnknownLabelError` if there is no such one."""
    return named(name, PRESETS)
