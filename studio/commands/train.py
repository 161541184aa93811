"""`motionloom train`: train an engine on the prepared data."""

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
    from engines.action2motion.config import Action2MotionConfig
    from engines.training.state import TrainingState

app = typer.Typer(
    no_args_is_help=True,
    help="""Train an engine on the prepared data (`motionloom data prepare`).

[bold]Examples[/bold]

motionloom train action2motion --run runs/glmi-m --export my.safetensors""",
)

_OF_THE_SETTINGS = ("steps", "learning_rate", "final_learning_rate", "weight_decay", "seed")
"""Fields of the plan that the engine's settings, or an option, give."""


@app.command("action2motion")
def action2motion(  # noqa: PLR0913, PLR0917 (one parameter an option)
    run: Annotated[Path, typer.Option("--run", metavar="DIR", help="Folder of checkpoint and logs; goes on there.")],
    decoder: Annotated[str | None, typer.Option(metavar="NAME", help="plain, lie, glmi-m (default) or glmi-r.")] = None,
    preset: Annotated[
        str | None, typer.Option(metavar="NAME", help="small (what ships, default) or paper (the thesis).")
    ] = None,
    data: Annotated[
        str | None, typer.Option("--data", metavar="LIST", help="Corpora, comma between; all if none.")
    ] = None,
    trunk: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Take all but the velocity unit from these weights, and train only that."),
    ] = None,
    steps: Annotated[
        int | None, typer.Option(metavar="N", help="Optimiser steps in all; the preset's if none.")
    ] = None,
    changes: Annotated[
        list[str] | None,
        typer.Option(
            "--set", metavar="KEY=VALUE", help="Any other setting, of the engine or the training; repeatable."
        ),
    ] = None,
    export: Annotated[
        Path | None, typer.Option("--export", metavar="FILE", help="Write the weights here (.safetensors) at the end.")
    ] = None,
    which: Annotated[
        str | None, typer.Option("--weights", metavar="NAME", help="To export: last, or best by validation.")
    ] = None,
    resume: Annotated[
        bool | None,
        typer.Option(
            "--resume/--fresh", help="Demand a checkpoint, or begin anew; goes on if there is one if neither."
        ),
    ] = None,
    device: Annotated[str, typer.Option(metavar="NAME", help="auto, cpu or cuda.")] = "auto",
    threads: Annotated[int | None, typer.Option(metavar="N", help="Processor threads; as torch likes if none.")] = None,
    seed: Annotated[int, typer.Option(metavar="N", help="Of first weights and everything drawn.")] = 0,
) -> None:
    """Train Action2Motion, or go on with a training that was stopped.

    [bold]Examples[/bold]

    motionloom train action2motion --run runs/glmi-m --export my.safetensors

    motionloom train action2motion --decoder lie --preset paper --steps 20000 --run runs/lie --threads 2

    motionloom train action2motion --data cmu,bandai-namco --set learning_rate=0.0005 --set patience=10 --run runs/a

    motionloom train action2motion --decoder lie --trunk my.safetensors --steps 500 --run runs/lie

    torchrun --nproc-per-node 2 -m -- studio.cli train action2motion --run runs/b

    Watch runs/.../losses.html in a browser. Ctrl+C saves and stops; the same command goes on from there, as if it had
    not been stopped, also after a crash (from the last checkpoint), and remembers settings that are not given again.
    Use the weights with engines.load("action2motion", checkpoint="my.safetensors").
    """
    _check("--steps", steps)
    _check("--threads", threads)
    if export is not None and export.suffix != ".safetensors":
        raise OutOfRangeError("--export", str(export), "a file ending in .safetensors")
    if which not in {None, "best", "last"}:
        raise UnknownLabelError("weights", which, ("best", "last"))
    before = {} if resume is False else _remembered(run)
    corpora = before.get("corpora") if data is None else _corpora(data)
    settings, plan = _settings(run, before, preset, changes or [])
    named = {"decoder": decoder, "steps": steps}
    settings = settings.replaced(**{name: value for name, value in named.items() if value is not None})
    _check_decoder(settings.decoder)
    _use_threads(threads)
    from engines.action2motion import train

    with _stoppable() as stopped, _bar() as tick:
        state = train.fit(
            settings,
            run,
            seed=seed,
            cancel=stopped,
            corpora=corpora,
            plan=plan,
            trunk=trunk,
            device=device,
            resume=resume,
            tick=tick,
        )
    if _first():
        _tell(state, run, export, which)


@app.command("evaluator")
def evaluator(  # noqa: PLR0913, PLR0917 (one parameter an option)
    task: Annotated[str, typer.Option(metavar="NAME", help="action, content, style or text.")],
    run: Annotated[Path, typer.Option("--run", metavar="DIR", help="Folder of the checkpoint; goes on there.")],
    export: Annotated[
        Path | None, typer.Option("--export", metavar="FILE", help="Write the weights here (.safetensors) at the end.")
    ] = None,
    steps: Annotated[
        int | None, typer.Option(metavar="N", help="Optimiser steps in all; 1,500, or 2,000 for text, if none.")
    ] = None,
    threads: Annotated[int | None, typer.Option(metavar="N", help="Processor threads; as torch likes if none.")] = None,
    seed: Annotated[int, typer.Option(metavar="N", help="Of first weights and everything drawn.")] = 0,
) -> None:
    """Train a judge of motions on the real clips, and say how good it is on those held out.

    For action, content and style a recogniser, which says what it sees; for text the space that motions share with
    sentences, in which R-precision is measured (the sentences are encoded first, once, which takes some minutes).

    [bold]Examples[/bold]

    motionloom train evaluator --task style --run runs/style --export evaluator-style.safetensors

    motionloom train evaluator --task text --run runs/text --export evaluator-text.safetensors
    """
    _check("--steps", steps)
    _check("--threads", threads)
    if export is not None and export.suffix != ".safetensors":
        raise OutOfRangeError("--export", str(export), "a file ending in .safetensors")
    from studio.commands import train_evaluator

    if task not in train_evaluator.TASKS:
        raise UnknownLabelError("evaluator", task, train_evaluator.TASKS)
    _use_threads(threads)
    run.mkdir(parents=True, exist_ok=True)
    with _stoppable() as stopped:
        train_evaluator.train(task, train_evaluator.Wanted(run / "checkpoint.pt", export, steps, seed, stopped))


def _tell(state: TrainingState, run: Path, export: Path | None, which: str | None) -> None:
    """What was reached, and the weights if they are wanted."""
    from engines.action2motion import train

    early = ", stopped early" if state.step < state.plan.steps else ""
    typer.echo(f"{run}: {state.step:,} steps, {state.seconds / 60:.1f} minutes{early}")
    if export is not None:
        export.parent.mkdir(parents=True, exist_ok=True)
        digest = train.export(state, export, which)
        typer.echo(f"{export}\nsha256 {digest}")


def _settings(
    run: Path, before: dict[str, Any], preset: str | None, changes: list[str]
) -> tuple[Action2MotionConfig, dict[str, Any]]:
    """The engine's settings and the plan's fields: the run's own or a preset's, with changes on top."""
    from engines.action2motion.config import Action2MotionConfig
    from engines.action2motion.config import preset as settings_of
    from engines.training.overrides import overrides
    from engines.training.plan import TrainingPlan

    if before and preset is None:
        settings = _read(run / "config.json", Action2MotionConfig.from_json)
        known = {**before.get("plan", {})}
    else:
        settings, known = settings_of(preset or "small"), {}
    of_engine, of_plan = overrides(changes, Action2MotionConfig, TrainingPlan)
    seed = of_plan.pop("seed", None)
    if seed is not None:
        raise OutOfRangeError("--set seed", seed, f"the option --seed {seed}")
    fields = TrainingPlan.__dataclass_fields__
    plan = {name: value for name, value in known.items() if name in fields and name not in _OF_THE_SETTINGS}
    return settings.replaced(**of_engine), {**plan, **of_plan}


def _remembered(run: Path) -> dict[str, Any]:
    """What is written down of a run that can be gone on with; nothing if there is none."""
    if not (run / "checkpoint.pt").exists() or not (run / "training.json").exists():
        return {}
    return _read(run / "training.json", json.loads)


def _read(path: Path, parse: Callable[[str], Any]) -> Any:
    try:
        return parse(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, TypeError) as error:
        raise CheckpointError(f"{path}: cannot be read: {error}; --fresh begins anew.") from error


def _corpora(text: str) -> list[str]:
    from engines.datasets import CORPORA

    names = parse_formats(text) or ()
    for name in names:
        if name not in CORPORA:
            raise UnknownLabelError("corpus", name, CORPORA)
    if not names:
        raise OutOfRangeError("--data", text, "names of corpora with commas between: " + ", ".join(CORPORA))
    return list(names)


def _check_decoder(decoder: str) -> None:
    from engines.action2motion.config import DECODERS

    if decoder not in DECODERS:
        raise UnknownLabelError("decoder", decoder, DECODERS)


@contextmanager
def _bar() -> Iterator[Callable[[TrainingState], None]]:
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
        yield tick if _first() else lambda _state: None
    finally:
        if bar is not None:
            bar.close()


@contextmanager
def _stoppable() -> Iterator[Callable[[], bool]]:
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


def _first() -> bool:
    """Whether this is the process that speaks."""
    from engines.training.devices import processes

    return processes()[0] == 0


def _use_threads(threads: int | None) -> None:
    if threads is not None:
        import torch

        torch.set_num_threads(threads)


def _check(name: str, value: int | None) -> None:
    if value is not None and value < 1:
        raise OutOfRangeError(name, value, "1 or more")
