"""What the evaluators cost, beside the plainer way that gives the same numbers.

Run: OMP_NUM_THREADS=1 python benchmarks/evaluators.py. Milliseconds of processor time, which a busy machine changes
less than a clock, the best of several runs; both columns of a row are taken one after the other. Lengths are those of
the prepared clips (half of them between 45 and 117 frames, one in twenty over 161).
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
import torch
from clock import best

from engines.action2motion.representation import encode
from engines.metrics.evaluators import trunk
from engines.motion import Motion
from engines.skeletons import SMPL22

RUNS, MOTIONS = 4, 64
RNG = np.random.default_rng(0)


def row(name: str, plain: Callable[[], object], ours: Callable[[], object]) -> None:
    slow, quick = best(plain, RUNS, time.process_time), best(ours, RUNS, time.process_time)
    print(f"{name:<44}{slow:>10.1f}{quick:>10.1f}{slow / quick:>8.1f}")


def motions() -> list[Motion]:
    """Random poses of real lengths."""
    made = []
    for length in np.clip(np.exp(RNG.normal(4.3, 0.6, MOTIONS)), 25, 300).astype(int):
        turns = RNG.normal(size=(length, len(SMPL22), 4)) * 0.2 + np.array([1.0, 0.0, 0.0, 0.0])
        made.append(Motion(SMPL22, turns, np.cumsum(RNG.normal(size=(length, 3)) * 0.01, axis=0), 20.0))
    return made


def main() -> None:
    """Print the table."""
    taken = motions()
    rows = [trunk.describe(motion, 240) for motion in taken]
    net = trunk.Trunk(192, 0.1).train()

    def padded() -> None:
        net.pooled(*trunk.pad(rows)).sum().backward()

    def in_row() -> None:
        net.pooled_in_row(trunk.in_row(rows)).sum().backward()

    print(f"{'':<44}{'plain':>10}{'ours':>10}{'ratio':>8}")
    row("training pass: padded, in a row", padded, in_row)
    with torch.inference_mode():
        net.eval()
        row(
            "looking: padded, in a row",
            lambda: net.pooled(*trunk.pad(rows)),
            lambda: net.pooled_in_row(trunk.in_row(rows)),
        )
    row(  # a motion made anew has nothing derived yet
        "describing: with all features, only those seen",
        lambda: [encode(motion.replaced(rotations=motion.rotations)) for motion in taken],
        lambda: [trunk.describe(motion.replaced(rotations=motion.rotations), 400) for motion in taken],
    )


if __name__ == "__main__":
    main()
