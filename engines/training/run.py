"""A training in a folder: begin or go on, write down the settings, keep the logs. What each engine's `fit` calls."""

from __future__ import annotations

import json
import platform
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import torch

from engines.errors import CheckpointError
from engines.training import devices
from engines.training.files import write_beside
from engines.training.loop import Listener, Losses, Terms, train
from engines.training.report import write_reports
from engines.training.state import TrainingState

if TYPE_CHECKING:
    from lightning_fabric import Fabric

CHECKPOINT = "checkpoint.pt"


@dataclass(frozen=True)
class RunOptions:
    """How a run in a folder goes; nothing here changes what is learned."""

    resume: bool | None = None
    """True: there must be a checkpoint to go on from. False: begin anew; a checkpoint that is there is kept as
    `checkpoint.old.pt`. None: go on if there is one."""
    progress: Listener | None = None
    """Called each time a line is logged."""
    tick: Listener | None = None
    """Called each step."""
    cancel: Callable[[], bool] | None = None
    """Asked each step; the checkpoint is written before `Cancelled` is raised."""


def run(  # noqa: PLR0913 - what a run is made of
    state: TrainingState,
    losses: Losses,
    folder: Path,
    settings: str,
    *,
    validate: Callable[[TrainingState], Iterator[Terms]] | None = None,
    facts: dict[str, Any] | None = None,
    fabric: Fabric | None = None,
    options: RunOptions = RunOptions(),
) -> TrainingState:
    """Train in a folder, or go on there.

    Args:
        state: new; restored here if there is a checkpoint.
        losses: as in `train`.
        folder: gets `checkpoint.pt`, `config.json`, `training.json` and the logs.
        settings: the engine's, JSON for `config.json`.
        validate: as in `train`.
        facts: what else should be known later, such as the data; for `training.json`.
        fabric: from `devices.launch`; one process on the processor if none.
        options: how.

    Raises:
        CheckpointError: there is none to go on from though there must be, or it is of another training.
        Everything that `train` raises.
    """
    fabric = devices.launch("cpu", "32") if fabric is None else fabric
    state.to(devices.share_of(fabric))
    checkpoint = folder / CHECKPOINT
    first = fabric.is_global_zero
    if first:
        folder.mkdir(parents=True, exist_ok=True)
        if options.resume is False and checkpoint.exists():
            checkpoint.replace(checkpoint.with_name("checkpoint.old.pt"))
    fabric.barrier()
    if options.resume and not checkpoint.exists():
        raise CheckpointError(f"{checkpoint}: there is no checkpoint to go on from; leave out --resume to begin.")
    if checkpoint.exists():
        state.restore(checkpoint)
    if first:
        write_beside(folder / "config.json", settings)
        write_beside(folder / "training.json", json.dumps(_about(state, facts or {}), indent=1))

    def report(now: TrainingState) -> None:
        if first:
            write_reports(now, folder, folder.resolve().name)
        if options.progress:
            options.progress(now)

    fabric.barrier()
    done = train(state, losses, checkpoint, report, options.cancel, validate=validate, tick=options.tick, fabric=fabric)
    if first:
        write_reports(done, folder, folder.resolve().name)
    return done


def _about(state: TrainingState, facts: dict[str, Any]) -> dict[str, Any]:
    """What the settings do not say of a training."""
    return {
        **facts,
        "plan": asdict(state.plan),
        "parameters": sum(p.numel() for p in state.model.parameters()),
        "processes": state.share.world,
        "device": state.share.device.type,
        "resumed_at": state.step,
        "torch": torch.__version__,
        "python": platform.python_version(),
    }
