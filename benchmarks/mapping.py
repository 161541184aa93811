"""The map of an action: how long its draws, its places and one way between two draws take.

    python benchmarks/mapping.py [--engine loom] [--action walk] [--frames 60] [--threads 2] [--repeats 3]

Medians of wall time; the ratio is to one draw of four, as the studio makes them.
"""

from __future__ import annotations

import argparse
import statistics
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import torch

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))  # before this folder, which has a studio.py

from studio import tasks, variations
from studio.mapping import DRAWS, Plane
from studio.settings import GenerateSettings


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--engine", default="loom")
    parser.add_argument("--action", default="walk")
    parser.add_argument("--frames", type=int, default=60)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--repeats", type=int, default=3)
    options = parser.parse_args()
    torch.set_num_threads(options.threads)
    engine = tasks.load_engine(options.engine)
    four = GenerateSettings(engine=options.engine, action=options.action, frames=options.frames)
    many = replace(four, count=DRAWS // 2)
    between = replace(four, take=1, blend={"seed": 8, "take": 2, "share": 0.5})
    drawn = tasks.generate(many) + tasks.generate(replace(many, seed=8))
    ways: dict[str, Callable[[], object]] = {
        "four takes": lambda: tasks.generate(four),
        f"{DRAWS} draws": lambda: (tasks.generate(many), tasks.generate(replace(many, seed=8))),
        "their places": lambda: Plane([motion.replaced(fps=motion.fps) for motion in drawn]),
        "one way between two draws": lambda: variations.between(between, engine),
    }
    took: dict[str, list[float]] = {name: [] for name in ways}
    for _ in range(options.repeats):
        for name, way in ways.items():
            began = time.perf_counter()
            way()
            took[name].append(time.perf_counter() - began)
    first = statistics.median(took["four takes"])
    print(f"{options.engine}, {options.action}, {options.frames} frames, {options.threads} threads")
    for name, times in took.items():
        middle = statistics.median(times)
        print(f"{name:<28}{middle:8.2f} s {middle / first:8.2f} x")


if __name__ == "__main__":
    main()
