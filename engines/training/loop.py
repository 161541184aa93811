"""One training loop for all engines: steps, validation, logging, checkpoints that resume exactly, cancel.

An engine brings its model, a function that draws a batch and gives named loss terms, and one that does so for clips
held back. Everything random comes from two generators whose states are part of the checkpoint (and torch's own, set
anew each step), so a run that was cut off goes on as if it had not been. See `engines.training.devices` for how the
same loop runs in many processes.
"""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import torch
from torch import Tensor, nn

from engines.errors import Cancelled, TrainingError
from engines.training import devices
from engines.training.plan import TrainingPlan
from engines.training.state import TrainingState

if TYPE_CHECKING:
    from lightning_fabric import Fabric

log = logging.getLogger(__name__)

Terms = dict[str, Tensor]
Losses = Callable[[TrainingState], Terms]
Listener = Callable[[TrainingState], None]


def train(  # noqa: PLR0913 - who wants to hear of it
    state: TrainingState,
    losses: Losses,
    checkpoint: Path | None = None,
    progress: Listener | None = None,
    cancel: Callable[[], bool] | None = None,
    *,
    validate: Callable[[TrainingState], Iterator[Terms]] | None = None,
    tick: Listener | None = None,
    fabric: Fabric | None = None,
) -> TrainingState:
    """Minimise the sum of the loss terms until the plan's last step, or until validation stops getting better.

    Args:
        state: new or restored.
        losses: draws a batch with `state.rng` and `state.generator`, keeps `state.share` of it, and returns named
            terms, each a mean over sequences.
        checkpoint: written every `save_every_seconds`, at the end and on cancel.
        progress: called each time a line is logged or validated.
        cancel: asked each step.
        validate: gives terms of one batch held back after another, always the same ones, with generators of its own;
            called without gradients while the model has its averaged weights.
        tick: called each step.
        fabric: from `devices.launch`; one process on the processor if none.

    Raises:
        Cancelled: `cancel` said so; the checkpoint is written.
        TrainingError: a loss or a gradient is not finite; the last checkpoint stands.
        CheckpointError: a checkpoint cannot be written; the last one stands.
    """
    return _Run(state, losses, validate, fabric or devices.launch("cpu", "32"), checkpoint).go(progress, cancel, tick)


class _Objective(nn.Module):
    """A step's terms as a forward pass, so that Fabric can wrap it: autocast, and gradients of all processes."""

    def __init__(self, state: TrainingState, losses: Losses) -> None:
        super().__init__()
        self.model = state.model
        self._terms = lambda: losses(state)

    def forward(self) -> Terms:
        return self._terms()


class _Run:
    """One call of `train`."""

    def __init__(
        self,
        state: TrainingState,
        losses: Losses,
        validate: Callable[[TrainingState], Iterator[Terms]] | None,
        fabric: Fabric,
        checkpoint: Path | None,
    ) -> None:
        self.state, self.validate, self.fabric, self.checkpoint = state, validate, fabric, checkpoint
        state.to(devices.share_of(fabric))
        self.objective, self.optimiser = fabric.setup(_Objective(state, losses), state.optimiser)
        self.began = time.monotonic() - state.seconds
        self.saved = time.monotonic()

    def go(self, progress: Listener | None, cancel: Callable[[], bool] | None, tick: Listener | None) -> TrainingState:
        """Step after step."""
        state, plan = self.state, self.state.plan
        self.state.model.train()
        while not state.finished:
            self._step()
            state.seconds = time.monotonic() - self.began
            logged = state.step % plan.log_every == 0
            if logged:
                _record(state)
            if self.validate and plan.validate_every and self._validation_is_due():
                self._validate()
                logged = True
            if logged and progress:
                progress(state)
            if tick:
                tick(state)
            self._save_or_stop(cancel)
        self._save()
        return state

    def _step(self) -> None:
        state = self.state
        for group in state.optimiser.param_groups:
            group["lr"] = state.learning_rate() * group["scale"]
        devices.reseed(state.plan.seed, state.step, state.share)
        terms = self.objective()
        total = torch.stack(list(terms.values())).sum()
        values = self._everywhere(terms)
        _demand_finite(values, f"the loss is not finite at step {state.step}", state)
        self.optimiser.zero_grad(set_to_none=True)
        self.fabric.backward(total)
        norm = float(nn.utils.clip_grad_norm_(state.model.parameters(), state.plan.clip_norm or math.inf))
        _demand_finite({"gradient_norm": norm}, f"the gradient is not finite at step {state.step}", state)
        self.optimiser.step()
        state.step += 1
        state.average()
        for name, value in {"gradient_norm": norm, **values}.items():
            state.sums[name] = state.sums.get(name, 0.0) + value
        state.counted += 1

    def _everywhere(self, terms: Terms) -> dict[str, float]:
        """Terms of the whole batch."""
        values = torch.stack([value.detach().float() for value in terms.values()])
        means = devices.mean_over_processes(self.fabric, values).tolist()
        return dict(zip(terms, means, strict=True))

    def _validation_is_due(self) -> bool:
        step, plan = self.state.step, self.state.plan
        return step % plan.validate_every == 0 or step == plan.steps

    def _validate(self) -> None:
        state, sums, count = self.state, {}, 0
        assert self.validate is not None
        devices.reseed(state.plan.seed, 0, state.share)
        with _averaged(state), torch.no_grad(), self.fabric.autocast():
            for terms in self.validate(state):
                for name, value in self._everywhere(terms).items():
                    sums[name] = sums.get(name, 0.0) + value
                count += 1
        means = {name: value / max(1, count) for name, value in sums.items()}
        _demand_finite(means, f"the loss of the clips held back is not finite at step {state.step}", state)
        state.judge(means)
        log.info("validation: %s", "  ".join(f"{k} {v:.4g}" for k, v in state.validation[-1].items()))

    def _save_or_stop(self, cancel: Callable[[], bool] | None) -> None:
        stop = devices.anywhere(self.fabric, bool(cancel and cancel()))
        if stop or time.monotonic() - self.saved > self.state.plan.save_every_seconds:
            self._save()
        if stop:
            raise Cancelled(f"training was cancelled after step {self.state.step}")

    def _save(self) -> None:
        if self.checkpoint and self.fabric.is_global_zero:
            self.state.save(self.checkpoint)
        self.saved = time.monotonic()


@contextmanager
def _averaged(state: TrainingState) -> Iterator[None]:
    """The model with its averaged weights, evaluating; afterwards as it was, bit by bit."""
    now = {name: value.clone() for name, value in state.model.state_dict().items()}
    state.model.load_state_dict(state.averaged)
    state.model.eval()
    try:
        yield
    finally:
        state.model.load_state_dict(now)
        state.model.train()


def _demand_finite(values: dict[str, float], problem: str, state: TrainingState) -> None:
    if not all(math.isfinite(value) for value in values.values()):
        shown = {name: float(f"{value:.4g}") for name, value in values.items()}
        raise TrainingError(
            f"{problem}: {shown}; a lower learning_rate or clip_norm helps (now {state.learning_rate():.3g} and "
            f"{state.plan.clip_norm:.3g}). The last checkpoint stands."
        )


def _record(state: TrainingState) -> None:
    means = {name: total / state.counted for name, total in state.sums.items()}
    state.sums, state.counted = {}, 0
    rate = state.plan.rate(state.step - 1)
    line = {"step": state.step, "seconds": round(state.seconds, 1), "learning_rate": rate, **means}
    state.history.append(line)
    log.info("%s", "  ".join(f"{k} {v:.4g}" for k, v in line.items()))


__all__ = ["TrainingPlan", "TrainingState", "train"]
