"""`motionloom train text2motion`: its three stages, one after another or each by itself."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from engines.errors import OutOfRangeError, UnknownLabelError
from studio.commands.console import progress_bar
from studio.commands.training import (
    DataOption,
    DeviceOption,
    ExportOption,
    ResumeOption,
    RunOption,
    SeedOption,
    SetOption,
    StepsOption,
    ThreadsOption,
    WhichOption,
    bar,
    check_options,
    corpora,
    first,
    remembered,
    settings,
    stoppable,
    tell,
    use_threads,
)  # fmt: skip

if TYPE_CHECKING:
    from engines.training.state import TrainingState

_STAGES = ("autoencoder", "text2length", "text2motion")
_ALL = "all"


def text2motion(  # noqa: PLR0913, PLR0917 (one parameter an option)
    run: RunOption,
    stage: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="all (default), or autoencoder (snippet codes), text2length (how long), text2motion (the motion).",
        ),
    ] = None,
    base: Annotated[
        Path | None, typer.Option("--from", metavar="FILE", help="Weights of the stage before, as --export wrote them.")
    ] = None,
    preset: Annotated[
        str | None, typer.Option(metavar="NAME", help="small (what ships, default) or paper (the thesis; needs GloVe).")
    ] = None,
    data: DataOption = None,
    steps: StepsOption = None,
    changes: SetOption = None,
    export: ExportOption = None,
    which: WhichOption = None,
    resume: ResumeOption = None,
    device: DeviceOption = "auto",
    threads: ThreadsOption = None,
    seed: SeedOption = 0,
) -> None:
    """Train Text2Motion, or go on with a training that was stopped.

    [bold]Examples[/bold]

    motionloom train text2motion --run runs/t2m --export text2motion.safetensors

    motionloom train text2motion --stage autoencoder --run runs/ae --export ae.safetensors

    motionloom train text2motion --stage text2length --from ae.safetensors --run runs/length --export length.safetensors

    motionloom train text2motion --stage text2motion --from length.safetensors --run runs/t2m --export t2m.safetensors

    motionloom train text2motion --stage text2motion --from length.safetensors --set attention=false --run runs/no-att

    All stages leave their weights in the run's folder. The paper's ablations are --set with snippet_codes, attention,
    tags or position and the value false. Use weights with engines.load("text2motion", checkpoint="t2m.safetensors").
    """
    check_options(steps, threads, export, which)
    before = {} if resume is False else remembered(run)
    stage = stage or before.get("stage") or _ALL
    if stage not in {*_STAGES, _ALL}:
        raise UnknownLabelError("stage of text2motion", stage, (*_STAGES, _ALL))
    if stage == _ALL and base is not None:
        raise OutOfRangeError("--from", str(base), "none where all stages are trained; say which one (--stage)")
    folder = run / _STAGES[0] if stage == _ALL else run
    if stage == _ALL and resume is not False:
        before = remembered(folder)
    corpora_asked = before.get("corpora") if data is None else corpora(data)
    base = base or (Path(before["base"]) if before.get("base") else None)
    use_threads(threads)
    from engines.text2motion import config, train

    chosen, plan = settings(folder, before, preset, changes or [], config)
    for name in _STAGES if steps is not None else ():
        chosen = chosen.with_steps(name, steps)
    with stoppable() as stopped:

        def captions(of: config.Text2MotionConfig, stage: str) -> train.Material | None:
            with progress_bar("captions", unit="") as told:
                return train.prepared(of, stage, told, stopped)

        def one(of: config.Text2MotionConfig, name: str, where: Path, **options: Any) -> TrainingState:
            # of all stages only the first must have been begun
            go_on = None if resume and where != folder else resume
            with bar() as tick:
                return train.fit(of, name, where, prepare=captions, cancel=stopped, tick=tick, resume=go_on, **options)

        options = {"seed": seed, "corpora": corpora_asked, "plan": plan, "device": device}
        if stage == _ALL:
            state = train.fit_all(chosen, run, one, **options)
        else:
            state = one(chosen, stage, run, base=base, **options)
    if first():
        tell(state, run, export, which, train.export)
