"""Stylization at the thesis's sizes and at those that ship: milliseconds, medians, ratios within one run.

python benchmarks/stylization.py [threads]

First the networks alone, features to features, on random weights; then, with shipped weights, what a person asks: a
Motion in, Motions out.
"""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Callable

import numpy as np
import torch

from engines import load
from engines.motion import Motion
from engines.skeletons import SMPL22
from engines.stylization import config
from engines.stylization.engine import shipped_variants
from engines.stylization.model import D, Stylizer

FRAMES, STYLES, REPEATS = 160, 17, 15


def median(work: Callable[[], object]) -> float:
    """Milliseconds."""
    work()
    taken = []
    for _ in range(REPEATS):
        began = time.perf_counter()
        work()
        taken.append(1000 * (time.perf_counter() - began))
    return statistics.median(taken)


def networks(preset: str, count: int) -> float:
    """By label: `count` motions encoded, taken apart, put together in a style and decoded."""
    chosen = config.preset(preset).replaced(styles=tuple(str(i) for i in range(STYLES)), critic_weight=0.0)
    model = Stylizer(chosen).eval().requires_grad_(False)
    motion, code = torch.randn(count, FRAMES, D), torch.randn(count, chosen.style_size)
    label = torch.eye(STYLES)[torch.arange(count) % STYLES]
    return median(lambda: model.assembled(motion, model.generate(model.content(model.encode(motion)), code, label)))


def requests(variant: str, count: int) -> float:
    """A Motion of 160 frames in the first style, `count` draws."""
    engine = load("stylization", variant=variant)
    rng = np.random.default_rng(0)
    turns = np.tile([1.0, 0.0, 0.0, 0.0], (FRAMES, len(SMPL22.joints), 1))
    turns[..., 1:] = 0.2 * np.cumsum(rng.normal(size=turns[..., 1:].shape), axis=0) / FRAMES**0.5
    turns /= np.linalg.norm(turns, axis=-1, keepdims=True)
    motion = Motion(SMPL22, turns, np.tile([0.0, 0.95, 0.0], (FRAMES, 1)), engine.fps)
    style = engine.styles[0] if engine.styles else None
    return median(lambda: engine.stylise(motion, style, count=count))


def main() -> None:
    """Print the table."""
    if len(sys.argv) > 1:
        torch.set_num_threads(int(sys.argv[1]))
    torch.manual_seed(0)
    rows = [
        (f"networks, {preset}, {n} x {FRAMES}", networks(preset, n)) for preset in ("paper", "small") for n in (1, 32)
    ]
    rows += [(f"request, {name}, {n} x {FRAMES}", requests(name, n)) for name in shipped_variants() for n in (1, 32)]
    print(f"{torch.get_num_threads()} threads")
    for name, took in rows:
        print(f"{name:32s} {took:8.1f} ms   {took / rows[0][1]:6.2f} x the first")


if __name__ == "__main__":
    main()
