"""A few made-up clips, a recogniser with random weights and an engine of a few units: a bench in a second."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import torch

from engines.datasets import Clip
from engines.evaluation import ActionBench, Options
from engines.metrics.evaluators.recogniser import Recogniser, RecogniserConfig, RecogniserNet
from tests.engines.action2motion import tiny

OPTIONS = Options(motions=13, frames=12, seed=3)


def recogniser(labels: Sequence[str] = ("run", *tiny.ACTIONS)) -> Recogniser:
    torch.manual_seed(1)
    return Recogniser(RecogniserNet(RecogniserConfig(labels=tuple(labels), width=8, features=6)))


def clips(without: Sequence[str] = ("throw",)) -> list[Clip]:
    """Two training clips of every action, and a validation and a test clip of most."""
    training = tiny.clips(2)
    held = [
        replace(tiny.clip(action, 8 + 10 * i, 100 + i), split="val" if i % 2 else "test")
        for action in tiny.ACTIONS
        for i in range(3)
        if action not in without
    ]
    return [*training, *(tiny.clip(a, 20, 50 + i) for a in tiny.ACTIONS for i in range(2)), *held]


def bench(engines: dict, options: Options = OPTIONS) -> ActionBench:
    return ActionBench(engines, clips(), recogniser(), options)
