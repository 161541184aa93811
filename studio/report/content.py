"""What the page of an evaluation holds, whatever was evaluated."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import cycle

from engines.motion import Motion
from viewers.web.payload import Actor

_FIGURES = 5
"""Bodies in one player, about."""
_COLOURS = ("#56b4e9", "#e69f00", "#2fb98f", "#cc79a7", "#f0e442", "#d55e00", "#7d8ff0")
"""Of the generated rows in the player, as in the page's charts (`--s1` and so on, in the dark)."""


@dataclass(frozen=True)
class Part:
    """A section of the page."""

    key: str
    """Its address on the page."""
    heading: str
    short: str
    """In the list of sections."""
    html: str


@dataclass(frozen=True)
class Content:
    """A page."""

    title: str
    summary: str
    parts: Sequence[Part]
    casts: Sequence[Sequence[Actor]]
    """Who is seen in the player, for each of its buttons."""


def cast(real: Motion, made: Mapping[str, Sequence[Motion]]) -> list[Actor]:
    """A real motion, and as many motions of each row as fit beside it."""
    each = max(1, (_FIGURES - 1) // max(1, len(made)))
    actors = [Actor(real, "real")]
    for (name, motions), colour in zip(made.items(), cycle(_COLOURS), strict=False):
        some = motions[:each]
        short = name.partition(":")[2] or name
        actors += [Actor(m, short if len(some) == 1 else f"{short}, {k}", colour) for k, m in enumerate(some, start=1)]
    return actors
