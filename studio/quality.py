"""Quality measures in words: a take's numbers beside those of real motion capture."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Literal

Level = Literal["good", "fair", "poor"]


@dataclass(frozen=True)
class Measure:
    """One measure of one take, ready to show."""

    key: str
    """Name in `engines.metrics.physical.summary`."""
    name: str
    """Name for a person."""
    text: str
    """Value with its unit: "0.3 cm/s"."""
    real: str
    """The same of real clips; empty when not known."""
    level: Level
    """good: at most 1.5 times real motion capture; fair: at most 3 times; poor: more (of words: see `fit`)."""
    word: str
    """Short form for a gallery card."""


@dataclass(frozen=True)
class _Kind:
    name: str
    short: str
    unit: str
    scale: float
    floor: float  # below this much, in SI units, nobody sees a difference: always good


_KINDS = {
    "foot_skate": _Kind("Foot skate", "skate", "cm/s", 100.0, 0.02),
    "jitter": _Kind("Jitter", "jitter", "m/s³", 1.0, 1.0),
    "ground_penetration": _Kind("Ground penetration", "floor", "cm", 100.0, 0.005),
}


@cache
def _real() -> Mapping[str, float]:
    from engines.metrics import physical

    return physical.REAL


def measures(metrics: Mapping[str, float], real: Mapping[str, float] | None = None) -> list[Measure]:
    """What to show of a take's metrics, in a fixed order; metrics not known here are left out.

    Args:
        metrics: SI values by name, from `engines.metrics.physical.summary`.
        real: the same of real clips; those shipped unless given.
    """
    real = _real() if real is None else real
    found = []
    for key, kind in _KINDS.items():
        value = metrics.get(key)
        if value is None or not math.isfinite(value):
            continue
        level = level_of(value, real.get(key), kind.floor)
        typical = _number(real[key] * kind.scale) if real.get(key) else ""
        text = f"{_number(value * kind.scale)} {kind.unit}"
        found.append(Measure(key, kind.name, text, typical, level, f"{kind.short} {_number(value * kind.scale)}"))
    return found


def fit(similarity: float, key: str = "fit", name: str = "Fits the motion", short: str = "fits") -> Measure:
    """What to show of how well words and a motion fit: real pairs are good; poor is what words of other motions reach.

    Args:
        similarity: -1 to 1; see `engines.metrics.evaluators.co_embedding`.
        key: what it is of.
        name: the same for a person.
        short: the same on a card.
    """
    from engines.metrics.retrieval import REAL

    level: Level = "good" if similarity >= REAL["low"] else "fair" if similarity >= REAL["other"] else "poor"
    text = f"{similarity:.2f}"
    return Measure(key, name, text, f"{REAL['mean']:.2f}", level, f"{short} {text}")


def level_of(value: float, real: float | None, floor: float) -> Level:
    """How a value compares with real motion capture: lower is better."""
    base = max(real or 0.0, floor)
    if value <= 1.5 * base:
        return "good"
    return "fair" if value <= 3.0 * base else "poor"


def _number(value: float) -> str:
    return f"{value:.1f}" if abs(value) < 10 else f"{value:.0f}"
