"""What the tests kill: a program that works in a library, or writes exports, and says what is done.

    python -m tests.studio.library.worker steps FILE KEY       one line a step, once it is saved
    python -m tests.studio.library.worker exports FOLDER       one line a file, once it is written

The steps are the same each time, so that the state after any number of them is known.
"""

from __future__ import annotations

import itertools
import sys
from pathlib import Path

import numpy as np

from studio import tasks
from studio.library import open_library
from studio.settings import ExportSettings, GenerateSettings
from studio.takes import Take, TakeList
from tests.studio.fakes import METRICS, sway

FORMATS = ("bvh", "npz", "csv", "amass.npz")


def step(takes: TakeList, number: int) -> None:
    """The `number`-th step."""
    known = [take.id for take in takes]
    some = known[number * 7 % len(known)] if known else ""
    what = number % 8
    if what in (0, 4) or not known:
        motions = [sway("walk", 40, number, index) for index in range(3)]
        asked = GenerateSettings(engine="loom", count=3, seed=number)
        takes.add(takes.store.hold(motions), group=f"g{number}", settings=asked, metrics=[METRICS] * 3)
    elif what in (1, 5):
        takes.mark(some, tags=(f"tag {number}",), favourite=not takes.get(some).favourite)
    elif what == 2:
        takes.remove(some)
    elif what == 3:
        takes.undo()
    elif what == 6:
        takes.redo() or takes.mark(some, accepted=True)
    else:
        takes.clear()


def state(takes: TakeList) -> list[tuple]:
    """All that matters, motions aside."""
    shown = [(t.id, t.group, t.favourite, t.accepted, t.tags, t.settings.seed) for t in takes]
    return [*shown, (takes.undo_name, takes.redo_name)]


def right(take: Take) -> bool:
    """Whether the motion of a take is the one that was put in, to the last bit."""
    made = take.settings
    motion = sway("walk", 40, made.seed, made.take - 1)
    return np.array_equal(take.motion.rotations, motion.rotations) and take.motion.provenance == motion.provenance


def steps(file: str, key: str) -> None:
    takes = TakeList(open_library(file).shelf(key))
    for number in itertools.count():
        step(takes, number)
        assert takes.store.saved, takes.store.problem
        print(number, flush=True)


def exports(folder: str) -> None:
    motion = sway(frames=400)
    for number in itertools.count():
        kind = FORMATS[number % len(FORMATS)]
        path = Path(folder) / f"{number}.{kind}"
        tasks.export(motion, path, ExportSettings(("amass" if kind.startswith("amass") else kind,)))
        print(path.name, flush=True)


if __name__ == "__main__":
    {"steps": steps, "exports": exports}[sys.argv[1]](*sys.argv[2:])
