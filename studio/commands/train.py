"""`motionloom train`: train an engine on the prepared data."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from engines.errors import OutOfRangeError, UnknownLabelError
from studio.commands import train_multiact, train_stylization, train_text2motion
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
    check,
    check_options,
    corpora,
    first,
    remembered,
    settings,
    stoppable,
    tell,
    use_threads,
)  # fmt: skip

app = typer.Typer(
    no_args_is_help=True,
    help="""Train an engine on the prepared data (`motionloom data prepare`).

[bold]Examples[/bold]

motionloom train action2motion --run runs/glmi-m --export my.safetensors""",
)


@app.command("loom")
def loom(  # noqa: PLR0913, PLR0917 (one parameter an option)
    run: RunOption,
    preset: Annotated[
        str | None, typer.Option(metavar="NAME", help="small (what ships, default) or large (for GPUs).")
    ] = None,
    data: DataOption = None,
    words: Annotated[bool, typer.Option(help="Learn from captions as well.")] = True,
    base: Annotated[
        Path | None, typer.Option("--from", metavar="FILE", help="Weights to begin from, as --export wrote them.")
    ] = None,
    steps: StepsOption = None,
    changes: SetOption = None,
    export: ExportOption = None,
    which: WhichOption = None,
    resume: ResumeOption = None,
    device: DeviceOption = "auto",
    threads: ThreadsOption = None,
    seed: SeedOption = 0,
) -> None:
    """Train Loom, our own engine, or go on with a training that was stopped.

    [bold]Examples[/bold]

    motionloom train loom --run runs/loom --export loom.safetensors

    motionloom train loom --run runs/more --from loom.safetensors --set "emphasised=kick,wave left hand" --steps 5000

    torchrun --nproc-per-node 2 -m -- studio.cli train loom --run runs/loom --threads 1

    Use the weights with engines.load("loom", checkpoint="loom.safetensors").
    """
    check_options(steps, threads, export, which)
    before = {} if resume is False else remembered(run)
    corpora_asked = before.get("corpora") if data is None else corpora(data)
    use_threads(threads)
    from engines.loom import config, train

    chosen, plan = settings(run, before, preset, changes or [], config)
    chosen = chosen if steps is None else chosen.replaced(steps=steps)
    with stoppable() as stopped, bar() as tick:
        state = train.fit(
            chosen,
            run,
            captions=train.told_in_words if words else None,
            base=base,
            seed=seed,
            corpora=corpora_asked,
            plan=plan,
            device=device,
            resume=resume,
            cancel=stopped,
            tick=tick,
        )
    if first():
        tell(state, run, export, which, train.export)


@app.command("tm2t")
def tm2t(  # noqa: PLR0913, PLR0917 (one parameter an option)
    run: RunOption,
    stage: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="vq (motion tokens), m2t (motion to text) or t2m (text to motion)."),
    ] = None,
    base: Annotated[
        Path | None, typer.Option("--from", metavar="FILE", help="Weights of the stage before, as --export wrote them.")
    ] = None,
    preset: Annotated[
        str | None, typer.Option(metavar="NAME", help="small (what ships, default) or paper (the thesis).")
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
    """Train TM2T, one of its three stages, or go on with a training that was stopped.

    [bold]Examples[/bold]

    motionloom train tm2t --stage vq --run runs/vq --export vq.safetensors

    motionloom train tm2t --stage m2t --from vq.safetensors --run runs/m2t --export m2t.safetensors

    motionloom train tm2t --stage t2m --from m2t.safetensors --run runs/t2m --export tm2t.safetensors

    motionloom train tm2t --stage t2m --from m2t.safetensors --set alignment=0 --run runs/plain

    motionloom train tm2t --stage t2m --from m2t.safetensors --set backbone=transformer --run runs/transformer

    Each file holds all parts trained so far: use it with engines.load("tm2t", checkpoint="tm2t.safetensors").
    """
    check_options(steps, threads, export, which)
    before = {} if resume is False else remembered(run)
    corpora_asked = before.get("corpora") if data is None else corpora(data)
    stage = stage or before.get("stage")
    if stage is None:
        raise OutOfRangeError("--stage", stage, "vq, then m2t, then t2m")
    base = base or (Path(before["base"]) if before.get("base") else None)
    use_threads(threads)
    from engines.tm2t import config, train

    chosen, plan = settings(run, before, preset, changes or [], config)
    chosen = chosen if steps is None else chosen.replaced(steps=steps)
    with stoppable() as stopped, bar() as tick:

        def captions(of: config.TM2TConfig, stage: str) -> train.Material | None:
            with progress_bar("captions", unit="") as told:
                return train.prepared(of, stage, told, stopped)

        state = train.fit(
            chosen,
            stage,
            run,
            base=base,
            prepare=captions,
            seed=seed,
            corpora=corpora_asked,
            plan=plan,
            device=device,
            resume=resume,
            cancel=stopped,
            tick=tick,
        )
    if first():
        tell(state, run, export, which, train.export)


@app.command("action2motion")
def action2motion(  # noqa: PLR0913, PLR0917 (one parameter an option)
    run: RunOption,
    decoder: Annotated[str | None, typer.Option(metavar="NAME", help="plain, lie, glmi-m (default) or glmi-r.")] = None,
    preset: Annotated[
        str | None, typer.Option(metavar="NAME", help="small (what ships, default) or paper (the thesis).")
    ] = None,
    data: DataOption = None,
    trunk: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Take all but the velocity unit from these weights, and train only that."),
    ] = None,
    steps: StepsOption = None,
    changes: SetOption = None,
    export: ExportOption = None,
    which: WhichOption = None,
    resume: ResumeOption = None,
    device: DeviceOption = "auto",
    threads: ThreadsOption = None,
    seed: SeedOption = 0,
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
    check_options(steps, threads, export, which)
    before = {} if resume is False else remembered(run)
    corpora_asked = before.get("corpora") if data is None else corpora(data)
    use_threads(threads)
    from engines.action2motion import config, train

    chosen, plan = settings(run, before, preset, changes or [], config)
    named = {"decoder": decoder, "steps": steps}
    chosen = chosen.replaced(**{name: value for name, value in named.items() if value is not None})
    if chosen.decoder not in config.DECODERS:
        raise UnknownLabelError("decoder", chosen.decoder, config.DECODERS)
    with stoppable() as stopped, bar() as tick:
        state = train.fit(
            chosen,
            run,
            seed=seed,
            cancel=stopped,
            corpora=corpora_asked,
            plan=plan,
            trunk=trunk,
            device=device,
            resume=resume,
            tick=tick,
        )
    if first():
        tell(state, run, export, which, train.export)


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
    check("--steps", steps)
    check("--threads", threads)
    if export is not None and export.suffix != ".safetensors":
        raise OutOfRangeError("--export", str(export), "a file ending in .safetensors")
    from studio.commands import train_evaluator

    if task not in train_evaluator.TASKS:
        raise UnknownLabelError("evaluator", task, train_evaluator.TASKS)
    use_threads(threads)
    run.mkdir(parents=True, exist_ok=True)
    with stoppable() as stopped:
        train_evaluator.train(task, train_evaluator.Wanted(run / "checkpoint.pt", export, steps, seed, stopped))


app.command("multiact")(train_multiact.multiact)
app.command("stylization")(train_stylization.stylization)
app.command("text2motion")(train_text2motion.text2motion)
