"""How long, how fast and how carefully to train: what every engine's training has in common."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Any, Literal

from engines.errors import OutOfRangeError
from engines.training.schedules import Constant, Cosine, Schedule, Steps


@dataclass(frozen=True)
class TrainingPlan:
    """How long and how fast to train."""

    steps: int
    """Optimiser steps in all, counted over resumed runs."""
    learning_rate: float
    final_learning_rate: float
    """Reached along a cosine at the last step."""
    weight_decay: float = 0.0
    warmup: int = 200
    """Steps over which the learning rate rises from zero."""
    rate_schedule: Literal["cosine", "constant", "steps"] = "cosine"
    """After the warm-up: a cosine to the final rate, no change, or `rate_factor` every `rate_every` steps."""
    rate_factor: float = 0.5
    rate_every: int = 10_000
    optimiser: Literal["adam", "adamw"] = "adam"
    """adamw takes the weight decay out of the gradient (Loshchilov and Hutter 2018)."""
    clip_norm: float = 1.0
    """Gradients longer than this are shortened to it; 0 leaves them as they are."""
    average: float = 0.999
    """Decay of the moving average of the weights, which is what gets used; 0 keeps none."""
    seed: int = 0
    save_every_seconds: float = 180.0
    log_every: int = 100
    validate_every: int = 500
    """Steps from one validation, of the averaged weights, to the next; 0: none. The best weights are kept."""
    patience: int = 0
    """Stop after so many validations in a row without a new best; 0: never."""
    precision: Literal["auto", "32", "bf16"] = "auto"
    """32: single precision. bf16: products in bfloat16 under autocast. auto: bf16 on a GPU that has it, else 32."""

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            least = 1 if name in ("log_every", "rate_every") else 0
            if not isinstance(value, str) and not (math.isfinite(value) and value >= least):
                raise OutOfRangeError(name, value, f"{least} or more")
        if not 0.0 <= self.average < 1.0:
            raise OutOfRangeError("average", self.average, "0 up to, but not, 1")

    @classmethod
    def of(cls, config: Any, seed: int = 0, **changes: Any) -> TrainingPlan:
        """The plan that an engine's settings describe.

        Args:
            config: each field of a plan that it has by the same name is taken.
            seed: see `seed`.
            changes: fields that are otherwise.
        """
        told = {field.name: getattr(config, field.name) for field in fields(cls) if hasattr(config, field.name)}
        return cls(**{**told, "seed": seed, **changes})

    def rate(self, step: int) -> float:
        """Learning rate of a step: linear warm-up, times the schedule."""
        schedules: dict[str, Schedule] = {
            "cosine": Cosine(self.learning_rate, self.final_learning_rate, self.steps),
            "constant": Constant(self.learning_rate),
            "steps": Steps(self.learning_rate, self.rate_factor, self.rate_every),
        }
        return schedules[self.rate_schedule](step) * min(1.0, (step + 1) / max(1, self.warmup))
