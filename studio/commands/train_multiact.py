"""`motionloom train multiact`: MACVAE on triplets of real clips."""

from __future__ import annotations

from typing import Annotated

import typer

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


def multiact(  # noqa: PLR0913, PLR0917 (one parameter an option)
    run: RunOption,
    preset: Annotated[
        str | None, typer.Option(metavar="NAME", help="small (what ships, default) or paper (its sizes).")
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
    """Train MultiAct, or go on with a training that was stopped.

    [bold]Examples[/bold]

    motionloom train multiact --run runs/multiact --threads 1 --export multiact.safetensors

    motionloom train multiact --set free_nats=12 --set pairs=20000 --run runs/calm

    The first run makes triplets of the prepared clips, which takes some minutes, and keeps them beside the clips. Use
    the weights with engines.load("multiact", checkpoint="multiact.safetensors").
    """
    check_options(steps, threads, export, which)
    before = {} if resume is False else remembered(run)
    corpora_asked = before.get("corpora") if data is None else corpora(data)
    use_threads(threads)
    from engines.multiact import config, train
    from engines.training.run import RunOptions

    chosen, plan = settings(run, before, preset, changes or [], config)
    chosen = chosen if steps is None else chosen.replaced(steps=steps)
    with stoppable() as stopped, bar() as tick:
        state = train.fit(
            chosen,
            run,
            seed=seed,
            corpora=corpora_asked,
            plan=plan,
            device=device,
            options=RunOptions(resume=resume, cancel=stopped, tick=tick),
        )
    if first():
        tell(state, run, export, which, train.export)
