"""Slow and fast ways to the same thing, side by side: the figures and the code of docs/performance.md.

    python benchmarks/habits.py [--rounds 3] [--markdown]

Each pair serves the same end. What is measured is processor time (programs that are started included), the least of
some rounds, so that a busy machine changes little; the first call of each is not counted.
"""

from __future__ import annotations

import argparse
import inspect
import os
import subprocess
import sys
import tempfile
import textwrap
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from subprocess import DEVNULL

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import engines
import viewers
from engines import features
from viewers import bodies

engine = engines.load("loom")
takes = engine.generate_many("walk", count=16, frames=60, seed=1)
walk = takes[0]
folder = Path(tempfile.mkdtemp())
MOTIONLOOM = (sys.executable, "-m", "studio.cli")
codec = features.get("humanml3d")
values = codec.encode(walk)


def fresh(motion: engines.Motion) -> engines.Motion:
    """The motion as if nobody had asked it for anything yet."""
    return engines.Motion(motion.skeleton, motion.rotations, motion.translation, motion.fps)


@dataclass(frozen=True)
class Habit:
    """Two ways to one thing."""

    title: str
    why: str
    slow: Callable[[], object]
    fast: Callable[[], object]


def one_by_one():
    [engine.generate("walk", frames=60, seed=seed) for seed in range(16)]


def in_one_pass():
    engine.generate_many("walk", count=16, frames=60, seed=0)


def program_each():
    for action in ("walk", "run", "jump"):
        subprocess.run([*MOTIONLOOM, "generate", action, "-n", "1", "-o", str(folder)], check=True, stdout=DEVNULL)


def one_program():
    loom = engines.load("loom")
    for action in ("walk", "run", "jump"):
        loom.generate(action, frames=60).write(folder / f"{action}.bvh")


def as_video():
    viewers.render(walk, folder / "walk.mp4")


def as_skin_and_keys():
    walk.write(folder / "walk.glb", skin=bodies.get("anny"))


def full_size():
    viewers.render(walk, folder / "walk.mp4")


def small_first():
    viewers.render(walk, folder / "walk.mp4", width=480, fps=20)


def shaped_each():
    for take in takes:
        viewers.Scene.of(take, body=bodies.get("anny").shaped(weight=0.7))


def shaped_once():
    heavy = bodies.get("anny").shaped(weight=0.7)
    for take in takes:
        viewers.Scene.of(take, body=heavy)


def frame_by_frame():
    for frame in range(len(walk)):
        walk[frame : frame + 1].positions[0]


def all_frames():
    fresh(walk).positions  # noqa: B018


def codec_by_positions():
    codec.decode(values, source="positions", start=codec.start(walk))


def codec_by_rotations():
    codec.decode(values, source="rotations", start=codec.start(walk))


HABITS = (
    Habit("Many takes: one pass, not a loop",
          "A network spends its time on being called. Sixteen takes of one draw go through it together. (A take of "
          "another size of draw differs in its last bits: keep the size where bits matter.)", one_by_one, in_one_pass),
    Habit("Stay in one program", "A program that starts reads PyTorch and the weights first.",
          program_each, one_program),
    Habit("Send skin and keys, not pictures",
          "A `.glb` holds the body once and a few numbers a frame; any browser, Blender or engine draws it. A video "
          "draws and packs every frame.", as_video, as_skin_and_keys),
    Habit("Look at a small video first", "The usual size is 1280 × 720 at 30 pictures a second; far less shows whether "
          "it is the right one.", full_size, small_first),
    Habit("Shape a body once", "Sliders move every point of the body and work out its normals anew; any number of "
          "takes can wear the same body.", shaped_each, shaped_once),
    Habit("Ask a motion for all frames", "Positions of all frames are one array operation, worked out when first "
          "asked for and kept with the motion.", frame_by_frame, all_frames),
    Habit("Decode by rotations", "By positions, every pose is fitted by inverse kinematics, and twists are guessed.",
          codec_by_positions, codec_by_rotations),
)  # fmt: skip


def spent(act: Callable[[], object], rounds: int) -> float:
    """Processor seconds of the cheapest round, those of programs it starts included."""
    act()
    best = float("inf")
    for _ in range(rounds):
        before = os.times()
        began = time.process_time()
        act()
        after = os.times()
        children = after.children_user + after.children_system - before.children_user - before.children_system
        best = min(best, time.process_time() - began + children)
    return best


def words(seconds: float) -> str:
    """A time for a person."""
    return (
        f"{seconds:.2g} s"
        if seconds >= 1
        else f"{seconds * 1e3:.2g} ms"
        if seconds < 0.1
        else f"{seconds * 1e3:.0f} ms"
    )


def code(act: Callable[[], object]) -> str:
    """What a function does, as text."""
    lines = [line.split("  # noqa")[0] for line in inspect.getsource(act).splitlines()[1:]]
    return textwrap.dedent("\n".join(lines)).strip()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--markdown", action="store_true", help="as in docs/performance.md")
    asked = parser.parse_args()
    for habit in HABITS:
        slow, fast = spent(habit.slow, asked.rounds), spent(habit.fast, asked.rounds)
        if asked.markdown:
            print(f"## {habit.title}\n\n{habit.why}\n")
            for name, act, seconds in (("slow", habit.slow, slow), ("fast", habit.fast, fast)):
                print(f"```python\n# {name}: {words(seconds)}\n{code(act)}\n```\n")
            print(f"{slow / fast:.2g} times as fast.\n")
        else:
            print(f"{habit.title:42}{words(slow):>10}{words(fast):>10}{slow / fast:8.2g} times")


if __name__ == "__main__":
    main()
