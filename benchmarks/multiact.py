"""MultiAct, its shipped weights and random ones of preset paper: milliseconds of a recurrent step, and of ten actions.

python benchmarks/multiact.py [threads]
"""

from __future__ import annotations

import os
import statistics
import sys
import time
from collections.abc import Callable

import numpy as np
import torch

import engines
from engines.motion import Motion
from engines.multiact import config
from engines.multiact.cell import MACVAECell
from engines.multiact.engine import MultiActEngine
from engines.multiact.model import MACVAE
from engines.multiact.networks import SEEN
from engines.multiact.representation import LAYOUT, D

ACTIONS = ("walk", "wave left hand", "run", "turn left", "throw", "sit down", "stand up", "bow", "jump", "kick")
STEP, TRANSITION, REPEATS = 60, 10, 15
"""Frames of a step; frames of its transition; times each is measured."""


def times(work: Callable[[], object]) -> str:
    """Median and least of some times, and the processor's own, which other programs lengthen less; milliseconds."""
    work()
    taken, busy = [], []
    for _ in range(REPEATS):
        began, before = time.perf_counter(), time.process_time()
        work()
        taken.append(1000 * (time.perf_counter() - began))
        busy.append(1000 * (time.process_time() - before))
    return f"{statistics.median(taken):9.1f} ms (least {min(taken):7.1f}; of the processor {min(busy):7.1f})"


def model_of(preset: str) -> MACVAE:
    """The shipped weights of `small`; random ones around a standing body of another preset."""
    if preset == "small":
        return engines.load("multiact").cell.model
    torch.manual_seed(0)
    sizes = config.preset(preset).replaced(actions=ACTIONS, usual_frames=((30, 50, 80),) * len(ACTIONS))
    model = MACVAE(sizes)
    model.mean[LAYOUT["rotations"]] = torch.tensor([1.0, 0, 0, 0, 1, 0]).repeat(D // 6)
    model.mean[LAYOUT["height"]] = 0.95
    model.std.fill_(0.05)
    return model.eval().requires_grad_(False)


def rows(preset: str, start: Motion, beginning: Callable[..., Motion]) -> dict[str, Callable[[], object]]:
    """What is measured."""
    model = model_of(preset)
    cell, rng = MACVAECell(model), np.random.default_rng(0)
    last, label = torch.randn(1, SEEN, D), torch.tensor([cell.names.index("walk")])
    frames, noise = torch.tensor([[TRANSITION, STEP - TRANSITION]]), torch.randn(1, 2, model.config.width)
    engine, blocks = MultiActEngine(cell, "0" * 64, beginning), [(name, STEP / 20) for name in ACTIONS]
    return {
        "one step, networks alone": lambda: model.generate(last, label, frames, noise),
        "one step, Motion to Motion": lambda: cell.advance(start[-cell.sees :], int(label), STEP, TRANSITION, rng),
        "ten actions after a motion": lambda: engine.sequence(blocks, 1, start=start),
        "ten actions from nothing": lambda: engine.sequence(blocks, 1),
    }


def main() -> None:
    """Print the table."""
    if len(sys.argv) > 1:
        torch.set_num_threads(int(sys.argv[1]))
    beginning = engines.load("action2motion").generate
    start = beginning("walk", 40, 1)
    load = os.getloadavg()[0]
    print(
        f"{torch.get_num_threads()} threads, load {load:.1f}; a step is {STEP} frames, {TRANSITION} of them transition"
    )
    for preset in ("small", "paper"):
        for name, work in rows(preset, start, beginning).items():
            print(f"{preset:<6} {name:<28} {times(work)}")


if __name__ == "__main__":
    main()
