"""Numbers that change while training goes on: learning rates, loss weights, teacher forcing, lengths.

A schedule is a small frozen dataclass that gives a number for a step, so that it can be written down as JSON and asked
anywhere. A curriculum moves on by what validation says; where it stands is part of the checkpoint.

What the papers state, and what says it here:

- Action2Motion: lambda_kl rises with training (thesis 3.2.1, "Training Strategy"): `Linear`; teacher forcing of whole
  sequences with chance 0.6 and a learning rate of 2e-4 (thesis 3.3): `Constant`.
- Text2Motion: a target of 8 codes, one more each time the validation's loss rises, up to 50 (thesis 4.2.3, 4.4):
  `LengthCurriculum`; the motion decoder learns at a tenth of the rate: the groups of `TrainingState`.
- Text2Motion and TM2T: teacher forcing with chance 0.4 (thesis 4.4, 6.3.3): `Constant`.
- MultiAct: AdamW at 5e-5 (Lee et al. 2023, implementation details): `Constant`, `TrainingPlan.optimiser`.
- Scheduled sampling, on which they build (Bengio et al. 2015, section 2.4): teacher forcing that decays, `Linear`,
  `Exponential` or `InverseSigmoid`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Protocol

import numpy as np

from engines.errors import CheckpointError, OutOfRangeError


class Schedule(Protocol):
    """A number for every step, counted from 0."""

    def __call__(self, step: int) -> float:
        """Its value at a step."""
        ...


@dataclass(frozen=True)
class Constant:
    """Always the same."""

    value: float

    def __call__(self, step: int) -> float:
        """Its value at a step."""
        return self.value


@dataclass(frozen=True)
class Linear:
    """`first` until `begin`, then along a line to `last`, reached after `steps` more, then `last`: a KL ramp."""

    first: float
    last: float
    steps: float
    begin: int = 0

    def __call__(self, step: int) -> float:
        """Its value at a step."""
        return self.first + (self.last - self.first) * _done(step - self.begin, self.steps)


@dataclass(frozen=True)
class Cosine:
    """From `first` along half a cosine to `last`, reached after `steps`, then `last`."""

    first: float
    last: float
    steps: float

    def __call__(self, step: int) -> float:
        """Its value at a step."""
        return self.last + (self.first - self.last) * 0.5 * (1 + math.cos(math.pi * _done(step, self.steps)))


@dataclass(frozen=True)
class Steps:
    """Multiplied by `factor` each time `every` steps are done: step decay."""

    first: float
    factor: float
    every: int

    def __call__(self, step: int) -> float:
        """Its value at a step."""
        return self.first * self.factor ** (step // max(1, self.every))


@dataclass(frozen=True)
class Exponential:
    """Comes down from `first` to `last`, nearer by half every `half_life` steps."""

    first: float
    last: float
    half_life: float

    def __call__(self, step: int) -> float:
        """Its value at a step."""
        return self.last + (self.first - self.last) * 0.5 ** (step / self.half_life)


@dataclass(frozen=True)
class InverseSigmoid:
    """Teacher forcing that stays near 1 and then falls to 0: k / (k + exp(step / k)), Bengio et al. 2015, section 2.4.

    Half of it is left after about k ln k steps.
    """

    steepness: float
    """k >= 1."""

    def __call__(self, step: int) -> float:
        """Its value at a step."""
        # the exponential would overflow long after nothing is left
        return self.steepness / (self.steepness + math.exp(min(step / self.steepness, 700.0)))


def _done(step: float, steps: float) -> float:
    """Share of a stretch that is behind, 0..1."""
    return min(1.0, max(0.0, step / max(1.0, steps)))


class Curriculum(Protocol):
    """Something that grows harder when validation says so; lives in `TrainingState.curricula`."""

    def validated(self, terms: Mapping[str, float]) -> bool:
        """Hear a validation's terms; True if a new stage begins, which makes earlier validations incomparable."""
        ...

    def state(self) -> dict[str, Any]:
        """Where it stands, as JSON."""
        ...

    def restore(self, state: Mapping[str, Any]) -> None:
        """Stand where `state()` was asked."""
        ...


@dataclass
class LengthCurriculum:
    """Short sequences first, one frame (or code) more each time the validation's loss starts rising.

    Source: Guo et al. 2022, section 3.3 "Training Scheme"; thesis section 4.2.3, with T_cur = 8 and T_max = 50.
    """

    length: int = 8
    """T_cur, what is aimed for now."""
    longest: int = 50
    """T_max."""
    term: str = "reconstruction"
    """The validation's loss that is watched."""
    best: float = math.inf
    """Lowest value seen at this length."""

    def __post_init__(self) -> None:
        if not 1 <= self.length <= self.longest:
            raise OutOfRangeError("length", self.length, f"1 to {self.longest}")

    def long_enough(self, lengths: np.ndarray) -> np.ndarray:
        """(N,) which sequences of these lengths are trained on now: those that are as long as the target, or longer."""
        return np.asarray(lengths) >= self.length

    def validated(self, terms: Mapping[str, float]) -> bool:
        """Hear a validation's terms; True if the target grew."""
        if self.term not in terms:
            raise OutOfRangeError("term", self.term, ", ".join(terms))
        if terms[self.term] <= self.best:
            self.best = terms[self.term]
            return False
        if self.length == self.longest:
            return False
        self.length, self.best = self.length + 1, math.inf
        return True

    def state(self) -> dict[str, Any]:
        """Where it stands, as JSON."""
        values = asdict(self)
        return {**values, "best": None if math.isinf(self.best) else self.best}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Stand where `state()` was asked.

        Raises:
            CheckpointError: it is the state of something else.
        """
        try:
            best = state["best"]
            self.length, self.best = int(state["length"]), math.inf if best is None else float(best)
        except (KeyError, TypeError, ValueError) as error:
            raise CheckpointError(f"no state of a length curriculum: {dict(state)}") from error
