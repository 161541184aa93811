"""How a request becomes windows that the network can make in one pass each."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

from engines import actions as vocabulary
from engines.loom.config import LoomConfig

OVERLAP = 20
"""Frames of the window before that a window which goes on with it is shown."""
AGAIN = 4
"""Frames shown of the last performance where an action done once is done again."""
UNTOLD, MIDDLE, BEGINNING, ENDING, WHOLE = range(5)
"""Which part of a performance a window is (`networks.Wanted.span`)."""
_STRETCH = 1.25
"""An action done once may take so many times its usual longest."""
_GOES_ON = 100
"""Frames at most of what goes on for as long as one likes, where nobody says how long."""


@dataclass(frozen=True)
class Window:
    """One pass of the network."""

    action: str | None
    frames: int
    """New ones."""
    shown: int
    """Frames of what comes before that it sees first."""
    span: int


def natural_length(config: LoomConfig, action: str | None) -> int:
    """Frames that an action takes where nobody says how long: what it usually takes, and no more than one window.

    What goes on for as long as one likes takes 5 s at most; so do words that mean no action.
    """
    _, usual, _ = _usual(config, action)
    return min(usual, config.longest if _once(action) else _GOES_ON)


def windows(
    config: LoomConfig, segments: Sequence[tuple[str | None, int]], given: int = 0, *, again: bool = True
) -> list[Window]:
    """The passes that make segments of (action, frames), one after the other.

    Args:
        config: of the model: how long its windows and how long actions are.
        segments: in order; no action means that words say it all.
        given: frames that are there before the first segment.
        again: whether an action done once is done again where there is time; else one window has it, however long.
    """
    made: list[Window] = []
    for action, frames in segments:
        before = bool(made) or given > 0
        for index, (count, span) in enumerate(_split(config, action, frames, before, again)):
            shown = AGAIN if index > 0 and _once(action) else OVERLAP
            held = given if not made else 10**6
            made.append(Window(action, count, min(shown, held) if before or index else 0, span))
    return made


def _split(config: LoomConfig, action: str | None, frames: int, before: bool, again: bool) -> list[tuple[int, int]]:
    """(frames, span) of the windows of one segment."""
    room = config.longest - (OVERLAP if before else 0)
    if again and _once(action):
        assert action is not None
        _, usual, longest = config.usual_frames[config.actions.index(action)]
        if frames > max(_STRETCH * longest, longest + 10):
            times = max(2, round(frames / min(usual, config.longest - OVERLAP)))
            return [(part, WHOLE) for part in _even(frames, times)]
    if frames <= room:
        short, _, longest = _usual(config, action)
        whole = not before and 0.8 * short <= frames <= _STRETCH * longest
        return [(frames, WHOLE if whole else (ENDING if before and _once(action) else UNTOLD))]
    later = config.longest - OVERLAP
    return [(room, UNTOLD), *((part, UNTOLD) for part in _even(frames - room, -(-(frames - room) // later)))]


def _usual(config: LoomConfig, action: str | None) -> tuple[int, int, int]:
    if action is None or action not in config.actions:
        return 30, 80, 160
    return config.usual_frames[config.actions.index(action)]


def _once(action: str | None) -> bool:
    return action is not None and not vocabulary.get(action).repeats


def _even(frames: int, parts: int) -> list[int]:
    """`frames` in so many whole numbers, as even as can be."""
    edges = [round(frames * i / parts) for i in range(parts + 1)]
    return [b - a for a, b in itertools.pairwise(edges)]
