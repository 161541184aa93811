"""Loom: how fast a request becomes Motions, and what it costs to be told more.

    python benchmarks/loom.py [--threads 2] [--repeats 5]

With the weights that ship: from the request to finished Motions, forward kinematics not included (positions are found
on demand). Ways take turns; medians of wall time, and the ratio to the first.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable

import numpy as np
import torch

import engines
from engines.loom.constraints import Constraints, Path, Pin


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--repeats", type=int, default=5)
    options = parser.parse_args()
    torch.set_num_threads(options.threads)
    began = time.perf_counter()
    engine = engines.load("loom")
    loading = time.perf_counter() - began
    line = Path(np.array([[0.0, 0.0], [1.0, 3.0], [-1.0, 6.0]]))
    pin = Pin("left_wrist", 60, (0.4, 1.5, 0.3))
    ways: dict[str, Callable[[], object]] = {
        "6 s, 6 steps": lambda: engine.generate("walk", 120, seed=1),
        "6 s, 6 steps, no guidance": lambda: engine.generate("walk", 120, seed=1, guidance=1.0),
        "6 s, 4 steps": lambda: engine.generate("walk", 120, seed=1, steps=4),
        "6 s, styled": lambda: engine.generate("walk", 120, seed=1, style=engine.styles[0]),
        "6 s, from a sentence": lambda: engine.generate(prompt="A person walks slowly.", frames=120, seed=1),
        "6 s, along a path": lambda: engine.generate("walk", 120, seed=1, constraints=Constraints(path=line)),
        "6 s, a wrist pinned": lambda: engine.generate("walk", 120, seed=1, constraints=Constraints(pins=(pin,))),
        "10 s": lambda: engine.generate("walk", 200, seed=1),
        "30 s": lambda: engine.generate("walk", 600, seed=1),
        "16 x 3 s": lambda: engine.generate_many("walk", 16, 60, seed=1),
        "300 x 3 s": lambda: engine.generate_many("walk", 300, 60, seed=1),
    }
    spent: dict[str, list[float]] = {name: [] for name in ways}
    for turn in range(options.repeats + 1):
        for name, way in ways.items():
            began = time.perf_counter()
            way()
            if turn:
                spent[name].append(time.perf_counter() - began)
    first = statistics.median(next(iter(spent.values())))
    print(f"load {loading * 1e3:.0f} ms; {options.threads} threads, medians of {options.repeats}")
    for name, times in spent.items():
        took = statistics.median(times)
        print(f"{name:28} {took * 1e3:8.1f} ms   {took / first:6.2f} x")


if __name__ == "__main__":
    main()
