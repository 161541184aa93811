"""The exceptions this project raises on purpose, each phrased for the person who sees it.

Every message answers three questions: what was wrong, where, and what would be accepted.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from numbers import Integral
from pathlib import Path

LONGEST = 1000
"""Characters of a problem with a file that are told."""


class MotionloomError(Exception):
    """Base of every error a person can cause and can mend."""


class FormatError(MotionloomError):
    """A file could not be read or written.

    Args:
        path: the file.
        problem: what is wrong with it, and what would be accepted.
        line: 1-based line for text formats.
    """

    def __init__(self, path: str | Path, problem: str, line: int | None = None) -> None:
        if len(problem) > LONGEST:  # a library's complaint may quote a damaged file at length
            problem = problem[:LONGEST] + "…"
        self.path, self.problem, self.line = Path(path), problem, line
        where = f"{path}:{line}" if line is not None else f"{path}"
        super().__init__(f"{where}: {problem}")


class OutOfRangeError(MotionloomError, ValueError):
    """A length, count, seed or other number lies outside what is accepted."""

    def __init__(self, name: str, value: object, accepted: str) -> None:
        super().__init__(f"{name} is {value!r}; accepted: {accepted}.")


def demand_whole(name: str, value: object, low: int, high: int) -> None:
    """Refuse what is no whole number from `low` to `high`; integers of NumPy count, True and False do not.

    Raises:
        OutOfRangeError: it is none; the message names it and the range.
    """
    if isinstance(value, bool) or not isinstance(value, Integral) or not low <= value <= high:  # type: ignore[operator]
        raise OutOfRangeError(name, value, f"a whole number from {low:,} to {high:,}")


class UnknownLabelError(MotionloomError, ValueError):
    """A name (action, style, engine, skeleton, ...) is not known; the nearest known ones are listed."""

    def __init__(self, kind: str, value: object, known: Iterable[str]) -> None:
        self.kind, self.value, self.known = kind, value, sorted(known)
        self.nearest = nearest(str(value), self.known)
        hint = ", ".join(repr(name) for name in self.nearest)
        super().__init__(f"unknown {kind} {value!r}; did you mean {hint}? ({len(self.known)} known)")


class SkeletonError(MotionloomError, ValueError):
    """A skeleton is malformed, or lacks the joints an operation needs."""


class MeshError(MotionloomError, ValueError):
    """A triangle mesh is malformed, empty or too large."""


class CheckpointError(MotionloomError):
    """A checkpoint is missing, damaged or of another architecture."""


class TrainingError(MotionloomError):
    """Training cannot go on: a loss or a gradient is not a number any more."""


class MissingDependencyError(MotionloomError, ImportError):
    """An optional package is needed; the message names the extra that brings it."""

    def __init__(self, package: str, extra: str, purpose: str) -> None:
        super().__init__(f"{purpose} needs the package {package!r}: pip install 'motionloom[{extra}]'")


class Cancelled(MotionloomError):
    """A long task was stopped because the person asked for it."""


def nearest(value: str, known: Iterable[str], count: int = 3) -> list[str]:
    """The `count` known names most like `value`: names holding it first, then by edit similarity."""
    wanted = value.strip().lower()

    def score(name: str) -> float:
        holds = bool(wanted) and (wanted in name.lower() or name.lower() in wanted)
        return difflib.SequenceMatcher(None, wanted, name.lower()).ratio() + holds

    return sorted(known, key=score, reverse=True)[:count]
