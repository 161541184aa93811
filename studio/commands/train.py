"""`motionloom train`: train an engine on the prepared data."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from engines.errors import OutOfRangeError, UnknownLabelError
from studio.commands.console import progress_bar

app = typer.Typer(
    no_args_is_help=True,
    help="""Train an engine on the prepared data (`motionloom data prepare`).

[bold]Examples[/bold]

motionloom train action2motion --run runs/glmi-m --export my.safetensors""",
)


@app.command("action2motion")
def action2motion(  # noqa: PLR0913, PLR0917 (one parameter an option)
    run: Annotated[Path, typer.Option("--run", metavar="DIR", help="Folder of checkpoint and history; goes on there.")],
    decoder: Annotated[str, typer.Option(metavar="NAME", help="plain, lie, glmi-m or glmi-r.")] = "glmi-m",
    preset: Annotated[str, typer.Option(metavar="NAME", help="small (what ships) or paper (the thesis).")] = "small",
    steps: Annotated[
        int | None, typer.Option(metavar="N", help="Optimiser steps in all; the preset's if none.")
    ] = None,
    export: Annotated[
        Path | None, typer.Option("--export", metavar="FILE", help="Write the weights here (.safetensors) at the end.")
    ] = None,
    threads: Annotated[int | None, typer.Option(metavar="N", help="Processor threads; as torch likes if none.")] = None,
    seed: Annotated[int, typer.Option(metavar="N", help="Of first weights and everything drawn.")] = 0,
) -> None:
    """Train Action2Motion, or go on with a training that was stopped.

    [bold]Examples[/bold]

    motionloom train action2motion --run runs/glmi-m --export my.safetensors

    motionloom train action2motion --decoder lie --preset paper --steps 20000 --run runs/lie --threads 2

    Ctrl+C saves and stops; the same command goes on from there, as if it had not been stopped. Use the weights with
    engines.load("action2motion", checkpoint="my.safetensors").
    """
    from engines.action2motion.config import DECODERS
    from engines.action2motion.config import preset as settings_of

    if decoder not in DECODERS:
        raise UnknownLabelError("decoder", decoder, DECODERS)
    settings = settings_of(preset).replaced(decoder=decoder)
    _check("--steps", steps)
    _check("--threads", threads)
    if export is not None and export.suffix != ".safetensors":
        raise OutOfRangeError("--export", str(export), "a file ending in .safetensors")
    _use_threads(threads)
    from engines.action2motion import train

    settings = settings.replaced(steps=steps or settings.steps)
    with _stoppable() as stopped, progress_bar("train", unit="step") as progress:
        state = train.fit(
            settings,
            run,
            seed=seed,
            progress=lambda now: progress(now.step, now.plan.steps),
            cancel=stopped,
        )
    typer.echo(f"{run}: {state.step:,} steps, {state.seconds / 60:.1f} minutes")
    if export is not None:
        export.parent.mkdir(parents=True, exist_ok=True)
        digest = train.export(state, export)
        typer.echo(f"{export}\nsha256 {digest}")


@contextmanager
def _stoppable() -> Iterator[Callable[[], bool]]:
    """Ctrl+C asks for a stop after the step at hand, which saves; a second Ctrl+C stops at once.

    Yields a function that says whether it was asked for.
    """
    asked = False

    def ask(_signal: int, _frame: object) -> None:
        nonlocal asked
        asked = True
        signal.signal(signal.SIGINT, before)

    before = signal.signal(signal.SIGINT, ask)
    try:
        yield lambda: asked
    finally:
        signal.signal(signal.SIGINT, before)


def _use_threads(threads: int | None) -> None:
    if threads is not None:
        import torch

        torch.set_num_threads(threads)


def _check(name: str, value: int | None) -> None:
    if value is not None and value < 1:
        raise OutOfRangeError(name, value, "1 or more")
