"""One training loop for all engines: steps, logging, checkpoints that resume exactly, cancel.

An engine brings its model, a function that draws a batch and one that gives named loss terms; everything random comes
from two generators whose states are part of the checkpoint, so a run that was cut off goes on as if it had not been.
"""

from __future__ import annotations

import json
import logging
import math
import time
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from pickle import UnpicklingError
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from engines.errors import Cancelled, CheckpointError

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class TrainingPlan:
    """How long and how fast to train."""

    steps: int
    """Optimiser steps in all, counted over resumed runs."""
    learning_rate: float
    final_learning_rate: float
    """Reached along a cosine at the last step."""
    weight_decay: float = 0.0
    warmup: int = 200
    """Steps over which the learning rate rises from zero."""
    clip_norm: float = 1.0
    """Gradients longer than this are shortened to it."""
    average: float = 0.999
    """Decay of the moving average of the weights, which is what gets used; 0 keeps none."""
    seed: int = 0
    save_every_seconds: float = 180.0
    log_every: int = 100


@dataclass
class TrainingState:
    """Everything that resuming needs."""

    model: nn.Module
    plan: TrainingPlan
    step: int = 0
    seconds: float = 0.0
    history: list[dict[str, float]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.optimiser = torch.optim.Adam(
            self.model.parameters(), lr=self.plan.learning_rate, weight_decay=self.plan.weight_decay, fused=True
        )
        self.rng = np.random.default_rng(self.plan.seed)
        self.generator = torch.Generator().manual_seed(self.plan.seed)
        self.averaged = {name: value.detach().clone() for name, value in self.model.state_dict().items()}

    def learning_rate(self) -> float:
        """Of the coming step: linear warm-up, then a cosine to the final value."""
        plan = self.plan
        done = min(1.0, self.step / max(1, plan.steps))
        rate = plan.final_learning_rate + (plan.learning_rate - plan.final_learning_rate) * 0.5 * (
            1 + math.cos(math.pi * done)
        )
        return rate * min(1.0, (self.step + 1) / max(1, plan.warmup))

    def save(self, path: Path) -> None:
        """Write the checkpoint beside the old one and put it in its place."""
        temporary = path.with_suffix(".partial")
        torch.save(
            {
                "model": self.model.state_dict(),
                "averaged": self.averaged,
                "optimiser": self.optimiser.state_dict(),
                "generator": self.generator.get_state(),
                "rest": json.dumps(
                    {
                        "rng": self.rng.bit_generator.state,
                        "step": self.step,
                        "seconds": self.seconds,
                        "history": self.history,
                    }
                ),
            },
            temporary,
        )
        temporary.replace(path)

    def restore(self, path: Path) -> None:
        """Go on from a checkpoint written by `save`.

        Raises:
            CheckpointError: the file is missing, damaged or of another model.
        """
        try:
            stored = torch.load(path, weights_only=True)
            self.model.load_state_dict(stored["model"])
            self.optimiser.load_state_dict(stored["optimiser"])
        except (OSError, RuntimeError, KeyError, TypeError, EOFError, ValueError, UnpicklingError) as error:
            raise CheckpointError(f"{path}: cannot resume from this checkpoint: {error}") from error
        self.averaged = stored["averaged"]
        self.generator.set_state(stored["generator"])
        rest = json.loads(stored["rest"])
        self.rng.bit_generator.state = rest["rng"]
        self.step, self.seconds, self.history = rest["step"], rest["seconds"], rest["history"]


def train(
    state: TrainingState,
    losses: Callable[[TrainingState], dict[str, Tensor]],
    checkpoint: Path | None = None,
    progress: Callable[[TrainingState], None] | None = None,
    cancel: Callable[[], bool] | None = None,
) -> TrainingState:
    """Minimise the sum of the loss terms until the plan's last step.

    Args:
        state: new or restored.
        losses: draws a batch with `state.rng` and `state.generator` and returns named terms.
        checkpoint: written every `save_every_seconds`, at the end and on cancel.
        progress: called each time a line is logged.
        cancel: asked each step.
    """
    plan, sums, saved = state.plan, defaultdict(float), time.monotonic()
    began = time.monotonic() - state.seconds
    counted = 0
    while state.step < plan.steps:
        terms = _step(state, losses)
        counted += 1
        for name, value in terms.items():
            sums[name] += float(value.detach())
        state.seconds = time.monotonic() - began
        if state.step % plan.log_every == 0:
            _record(state, {name: total / counted for name, total in sums.items()})
            sums.clear()
            counted = 0
            if progress:
                progress(state)
        stop = bool(cancel and cancel())
        if checkpoint and (stop or time.monotonic() - saved > plan.save_every_seconds):
            state.save(checkpoint)
            saved = time.monotonic()
        if stop:
            raise Cancelled(f"training was cancelled after step {state.step}")
    if checkpoint:
        state.save(checkpoint)
    return state


def _step(state: TrainingState, losses: Callable[[TrainingState], dict[str, Tensor]]) -> dict[str, Tensor]:
    for group in state.optimiser.param_groups:
        group["lr"] = state.learning_rate()
    terms = losses(state)
    total = torch.stack(list(terms.values())).sum()
    if not torch.isfinite(total):
        bad = {name: float(value.detach()) for name, value in terms.items()}
        raise CheckpointError(f"the loss is not finite at step {state.step}: {bad}")
    state.optimiser.zero_grad(set_to_none=True)
    total.backward()
    nn.utils.clip_grad_norm_(state.model.parameters(), state.plan.clip_norm)
    state.optimiser.step()
    state.step += 1
    _average(state)
    return terms


def _average(state: TrainingState) -> None:
    """Moving average of the weights; early steps count less so that the start is forgotten."""
    decay = min(state.plan.average, (1 + state.step) / (10 + state.step))
    with torch.no_grad():
        for name, value in state.model.state_dict().items():
            if value.dtype.is_floating_point:
                state.averaged[name].lerp_(value, 1 - decay)
            else:
                state.averaged[name].copy_(value)


def _record(state: TrainingState, means: dict[str, float]) -> None:
    line: dict[str, Any] = {"step": state.step, "seconds": round(state.seconds, 1), **means}
    state.history.append(line)
    log.info("%s", "  ".join(f"{k} {v:.4g}" for k, v in line.items()))
