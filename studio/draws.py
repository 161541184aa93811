"""A draw: takes made by settings, measured, and handed to where they are kept. Runs off the UI thread."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from engines import Motion
from studio import tasks
from studio.jobs import Cancel, Progress
from studio.settings import GenerateSettings
from studio.takes import Held, TakeStore


@dataclass(frozen=True)
class Drawn:
    """What came of a draw."""

    asked: GenerateSettings
    held: Sequence[Motion | Held]
    """The motions, as their store holds them."""
    metrics: Sequence[Mapping[str, float]]
    """Quality measures of each."""
    seconds: float
    """It took the engine so long."""
    note: str
    """What of the things pinned could not be met, in a line."""

    @property
    def rate(self) -> float:
        """Frames a second."""
        return self.asked.best_of * sum(motion.frames for motion in self.held) / max(self.seconds, 1e-3)


def draw(asked: GenerateSettings, store: TakeStore, progress: Progress, cancel: Cancel) -> Drawn:
    """Make takes by settings; errors as `tasks.generate`."""
    began = time.perf_counter()
    motions = tasks.generate(asked, progress, cancel)
    seconds = time.perf_counter() - began
    metrics = [dict(tasks.measure(motion)) for motion in motions]
    return Drawn(asked, store.hold(motions), metrics, seconds, note_of(motions))


def note_of(motions: list) -> str:
    """One line on what of the things pinned could not be met."""
    each = [tasks.unmet(motion) for motion in motions]
    said = next(filter(None, each), [])
    if not said:
        return ""
    more = f" And {len(said) - 1} more." if len(said) > 1 else ""
    if all(other == said for other in each):
        return said[0] + more
    touched = sum(map(bool, each))
    return f"{said[0]}{more} So in {touched} of {len(motions)} takes, more or less; see Details."
