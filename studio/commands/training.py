"""What every `motionloom train ...` does: options read and checked, a run gone on with, a bar, a stop, a last word."""

from __future__ import annotations

import json
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from engines.errors import CheckpointError, OutOfRangeError, UnknownLabelError
from studio.commands.console import parse_formats

if TYPE_CHECKING:
    from engines.training.state import TrainingState

Plan = dict[str, Any]
Export = Callable[["TrainingState", Path, str | None], str]

RunOption = Annotated[Path, typer.Option("--run", metavar="DIR", help="Folder of checkpoint and logs; goes on there.")]
DataOption = Annotated[str | None, typer.Option("--data", metavar="LIST", help="Corpora, comma between; all if none.")]
StepsOption = Annotated[int | None, typer.Option(metavar="N", help="Optimiser steps in all; the preset's if none.")]
SetOption = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Any other setting, of the engine or the training; repeatable."),
]
ExportOption = Annotated[
    Path | None, typer.Option("--export", metavar="FILE", help="Write the weights here (.safetensors) at the end.")
]
WhichOption = Annotated[
    str | None, typer.Option("--weights", metavar="NAME", help="To export: last, or best by validation.")
]
ResumeOption = Annotated[
    bool | None,
    typer.Option("--resume/--fresh", help="Demand a checkpoint, or begin anew; goes on if there is one if neither."),
]
DeviceOption = Annotated[str, typer.Option(metavar="NAME", help="auto, cpu or cuda.")]
ThreadsOption = Annotated[int | None, typer.Option(metavar="N", help="Processor threads; as torch likes if none.")]
SeedOption = Annotated[int, typer.Option(metavar="N", help="Of first weights and everything drawn.")]

_OF_THE_SETTINGS = ("steps", "learning_rate", "final_learning_rate", "weight_decay", "seed")
"""Fields of the plan that the engine's settings, or an option, give."""


def check_options(steps: int | None, threads: int | None, export: Path | None, which: str | None) -> None:
    """Refuse what cannot be, before anything is loaded."""
    check("--steps", steps)
    check("--threads", threads)
    if export is not None and export.suffix != ".safetensors":
        raise OutOfRangeError("--export", str(export), "a file ending in .safetensors")
    if which not in {None, "best", "last"}:
        raise UnknownLabelError("weights", which, ("best", "last"))


def tell(state: TrainingState, run: Path, export: Path | None, which: str | None, write: Export) -> None:
    """What was reached, and the weights if they are wanted."""
    early = ", stopped early" if state.step < state.plan.steps else ""
    typer.echo(f"{run}: {state.step:,} steps, {state.seconds / 60:.1f} minutes{early}")
    if export is not None:
        export.parent.mkdir(parents=True, exist_ok=True)
        digest = write(state, export, which)
        typer.echo(f"{export}\nsha256 {digest}")


def settings(run: Path, before: dict[str, Any], preset: str | None, changes: list[str], kind: Any) -> tuple[Any, Plan]:
    """The engine's settings and the plan's fields: the run's own or a preset's, with changes on top.

    Args:
        run: its folder.
        before: what is written down of it.
        preset: name of one, or none.
        changes: KEY=VALUE each.
        kind: the engine's config module.
    """
    from engines.training.overrides import overrides
    from engines.training.plan import TrainingPlan

    if before and preset is None:
        settings = read(run / "config.json", type(kind.preset("small")).from_json)
        known = {**before.get("plan", {})}
    else:
        settings, known = kind.preset(preset or "small"), {}
    of_engine, of_plan = overrides(changes, type(kind.preset("small")), TrainingPlan)
    seed = of_plan.pop("seed", None)
    if seed is not None:
        raise OutOfRangeError("--set seed", seed, f"the option --seed {seed}")
    fields = TrainingPlan.__dataclass_fields__
    plan = {name: value for name, value in known.items() if name in fields and name not in _OF_THE_SETTINGS}
    return settings.replaced(**of_engine), {**plan, **of_plan}


def remembered(run: Path) -> dict[str, Any]:
    """What is written down of a run that can be gone on with; nothing if there is none."""
    if not (run / "checkpoint.pt").exists() or not (run / "training.json").exists():
        return {}
    return read(run / "training.json", json.loads)


def read(path: Path, parse: Callable[[str], Any]) -> Any:
    """A file of a run, parsed.

    Raises:
        CheckpointError: it cannot be.
    """
    try:
        return parse(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, TypeError) as error:
        raise CheckpointError(f"{path}: cannot be read: {error}; --fresh begins anew.") from error


def corpora(text: str) -> list[str]:
    """Names with commas between, checked."""
    from engines.datasets import CORPORA

    names = parse_formats(text) or ()
    for name in names:
        if name not in CORPORA:
            raise UnknownLabelError("corpus", name, CORPORA)
    if not names:
        raise OutOfRangeError("--data", text, "names of corpora with commas between: " + ", ".join(CORPORA))
    return list(names)


@contextmanager
def bar() -> Iterator[Callable[[TrainingState], None]]:
    """A progress bar with the time to go and the losses, on a terminal and in the first process only."""
    from tqdm import tqdm

    from engines.training.report import total_of

    bar: tqdm | None = None

    def tick(state: TrainingState) -> None:
        nonlocal bar
        if bar is None:  # what was done before a resume took none of this run's time
            bar = tqdm(
                desc="train", unit="step", total=state.plan.steps, initial=state.step - 1, disable=None, leave=False
            )
        if state.step % state.plan.log_every == 0:
            shown = {"loss": total_of(state.history[-1])}
            if state.validation:
                shown["held back"] = state.validation[-1]["total"]
            bar.set_postfix({name: f"{value:.3f}" for name, value in shown.items()}, refresh=False)
        bar.update(state.step - bar.n)

    try:
        yield tick if first() else lambda _state: None
    finally:
        if bar is not None:
            bar.close()


@contextmanager
def stoppable() -> Iterator[Callable[[], bool]]:
    """Ctrl+C, or a polite kill, asks for a stop after the step at hand, which saves; a second Ctrl+C stops at once.

    Among many processes there is no second one: their launcher passes on what the terminal has told them already.
    Yields a function that says whether it was asked for.
    """
    from engines.training.devices import processes

    asked = False

    def ask(number: int, _frame: object) -> None:
        nonlocal asked
        asked = True
        if processes()[1] == 1:
            signal.signal(number, before[signal.Signals(number)])

    before = {number: signal.signal(number, ask) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield lambda: asked
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def first() -> bool:
    """Whether this is the process that speaks."""
    from engines.training.devices import processes

    return processes()[0] == 0


def use_threads(threads: int | None) -> None:
    """So many, if it is said."""
    if threads is not None:
        import torch

        torch.set_num_threads(threads)


def check(name: str, value: int | None) -> None:
    """Refuse a number below one."""
    if value is not None and value < 1:
        raise OutOfRangeError(name, value, "1 or more")
