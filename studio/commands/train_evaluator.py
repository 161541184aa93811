"""`motionloom train evaluator`: what is trained for a task, and what is said of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from studio.commands.console import progress_bar

if TYPE_CHECKING:
    from engines.metrics.evaluators.recogniser import Task
    from engines.metrics.evaluators.train_co_embedding import Measured
    from engines.training.state import TrainingState

TASKS = ("action", "content", "style", "text")


@dataclass(frozen=True)
class Wanted:
    """What a person asked for."""

    checkpoint: Path
    """Gone on from, if it is there."""
    export: Path | None
    steps: int | None
    seed: int
    stopped: Callable[[], bool]
    """Whether to stop, after saving."""


def train(task: str, wanted: Wanted) -> None:
    """Train for a task of `TASKS`, tell how good it is on held-out clips, and write the weights."""
    if wanted.export is not None:
        wanted.export.parent.mkdir(parents=True, exist_ok=True)
    if task == "text":
        _co_embedding(wanted)
    else:
        _recogniser(task, wanted)  # pyright: ignore[reportArgumentType] (one of the other tasks)
    if wanted.export is not None:
        typer.echo(str(wanted.export))


def _recogniser(task: Task, wanted: Wanted) -> None:
    from engines import datasets
    from engines.metrics.evaluators import recogniser, train

    settings = recogniser.RecogniserConfig(task=task)
    settings = replace(settings, steps=wanted.steps or settings.steps)
    trained = train.fit(settings, datasets.load("train"), wanted.checkpoint, wanted.seed, _tell_losses, wanted.stopped)
    for split in ("val", "test"):
        found = train.accuracy(trained, datasets.load(split))
        told = ", ".join(f"{name} {share:.1%} of {count}" for name, (share, count) in found.items())
        typer.echo(f"{split}: {told or 'no clip with such a label'}")
    if wanted.export is not None:
        train.export(trained, wanted.export, step=settings.steps)


def _co_embedding(wanted: Wanted) -> None:
    from engines import datasets
    from engines.datasets.captions import encoded
    from engines.metrics.evaluators import co_embedding, train_co_embedding
    from engines.metrics.retrieval import POOL

    settings = co_embedding.CoEmbeddingConfig()
    settings = replace(settings, steps=wanted.steps or settings.steps)
    with progress_bar("captions", unit="") as bar:
        told = encoded.load(settings.encoder, lambda done, total, _what: bar(done, total), wanted.stopped)
    trained = train_co_embedding.fit(
        settings, datasets.load("train"), told, wanted.checkpoint, wanted.seed, _tell_losses, wanted.stopped
    )
    for split in ("val", "test"):
        clips = datasets.load(split)
        if len(clips) < POOL:
            typer.echo(f"{split}: {len(clips)} clips, too few to measure on ({POOL} needed)")
            continue
        found = train_co_embedding.measure(trained, clips)
        typer.echo(f"{split}: {_figures(found)}")
    if wanted.export is not None:
        train_co_embedding.export(trained, wanted.export, step=settings.steps, prepared_data=datasets.VERSION)


def _figures(found: Measured) -> str:
    from engines.metrics.protocol import METRICS

    names = ("r_precision_top1", "r_precision_top2", "r_precision_top3", "multimodal_distance")
    told = [f"{METRICS[name].title} {found.figures[name]}" for name in names]
    return ", ".join([*told, f"sides right in {found.sides:.1%} of {found.sided:,} captions"])


def _tell_losses(state: TrainingState) -> None:
    terms = {name: value for name, value in state.history[-1].items() if name not in _NOT_LOSSES}
    told = ", ".join(f"{name.replace('_', ' ')} {value:.3f}" for name, value in terms.items())
    typer.echo(f"step {state.step:,} of {state.plan.steps:,}: {told}")


_NOT_LOSSES = {"step", "seconds", "learning_rate", "gradient_norm"}
