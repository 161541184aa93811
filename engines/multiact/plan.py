"""What a person asks for, step by step: blocks of an action and its seconds, and the recurrent steps they take."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from engines.errors import MotionloomError, OutOfRangeError, UnknownLabelError
from engines.multiact.cell import Cell
from engines.multiact.representation import FPS
from engines.multiact.triplets import CHUNK, goes_on

BlockLike = str | tuple[str, float | None]
"""An action, which lasts as long as it usually does, or (action, seconds)."""
LONGEST_BLOCK = 600.0
"""Seconds."""
SHORTEST_BLOCK = 0.1
_STAYS = frozenset({"sit down", "stand up"})
"""Actions that end elsewhere than they begin: done once, however long their block."""


@dataclass(frozen=True)
class Block:
    """An action for some time, the transition into it included."""

    name: str
    action: int
    """Place among the cell's names."""
    frames: int


@dataclass(frozen=True)
class Step:
    """A part of a block that is made at once."""

    frames: int
    held: bool = False
    """The last pose stays instead."""


def blocks(cell: Cell, asked: Iterable[BlockLike]) -> Iterator[Block]:
    """What is asked for, read one by one.

    Raises:
        MotionloomError: a block is neither a name nor (name, seconds).
        UnknownLabelError: an action is not known; the message lists the nearest.
        OutOfRangeError: seconds out of range.
    """
    for number, block in enumerate(asked, start=1):
        name, seconds = _parts(block, number)
        action = find(cell.names, name)
        if seconds is None:
            frames = cell.usual[action][1]
        elif isinstance(seconds, bool) or not isinstance(seconds, int | float | np.number):
            raise MotionloomError(f"block {number} lasts {seconds!r}; accepted: seconds, a number.")
        elif not SHORTEST_BLOCK <= seconds <= LONGEST_BLOCK:  # nor NaN
            accepted = f"{SHORTEST_BLOCK:g} to {LONGEST_BLOCK:g} (more is several blocks)"
            raise OutOfRangeError(f"seconds of block {number}, {name!r}", seconds, accepted)
        else:
            frames = round(float(seconds) * FPS)
        yield Block(cell.names[action], action, frames)


def find(names: Sequence[str], name: str) -> int:
    """The place of an action; of a beginning ("sit", "wave"), of the first action that begins so.

    Raises:
        UnknownLabelError: none does; the nearest known are listed.
    """
    cleaned = " ".join(str(name).lower().split())
    if cleaned in names:
        return names.index(cleaned)
    begun = [place for place, known in enumerate(names) if cleaned and known.startswith(f"{cleaned} ")]
    if not begun:
        raise UnknownLabelError("action", name, names)
    return begun[0]


def steps(cell: Cell, block: Block) -> list[Step]:
    """How a block is made: an action that goes on in parts, one that is done as often as it fits, or once and held."""
    few, usual, many = cell.usual[block.action]
    if block.name in _STAYS:
        done = min(block.frames, many, cell.longest)
        held = [Step(length, held=True) for length in _parts_of(block.frames - done, cell.longest)]
        return [Step(done), *held]
    if goes_on(block.name):
        count = math.ceil(block.frames / min(CHUNK, cell.longest))
    else:
        count = max(1, round(block.frames / min(usual, cell.longest)), math.ceil(block.frames / cell.longest))
        if block.frames / count < few:  # a performance that is hurried more than any was
            count = max(1, count - 1, math.ceil(block.frames / cell.longest))
    edges = [round(block.frames * i / count) for i in range(count + 1)]
    return [Step(b - a) for a, b in pairwise(edges)]


def _parts_of(frames: int, most: int) -> list[int]:
    return [min(most, frames - first) for first in range(0, frames, most)]


def _parts(block: object, number: int) -> tuple[str, object]:
    if isinstance(block, str):
        return block, None
    if isinstance(block, tuple | list) and len(block) == 2 and isinstance(block[0], str):
        return block[0], block[1]
    raise MotionloomError(f"block {number} is {block!r}; accepted: an action's name, or (name, seconds).")
