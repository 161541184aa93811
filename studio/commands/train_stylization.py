"""`motionloom train stylization`: the three stages of latent stylization."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from engines.errors import OutOfRangeError, UnknownLabelError
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

_STEPS = {"autoencoder": "autoencoder_steps", "regressor": "regressor_steps", "style": "steps"}
"""Each stage, and the setting that says how long it is trained."""


def stylization(  # noqa: PLR0913, PLR0917 (one parameter an option)
    run: RunOption,
    stage: Annotated[
        str, typer.Option(metavar="NAME", help="autoencoder, then regressor, then style; all in one folder.")
    ],
    preset: Annotated[
        str | None, typer.Option(metavar="NAME", help="small (what ships, default) or paper (the thesis).")
    ] = None,
    latent: Annotated[str | None, typer.Option(metavar="NAME", help="ae (default) or vae.")] = None,
    supervised: Annotated[
        bool | None, typer.Option("--supervised/--unsupervised", help="Whether style labels are told; they are.")
    ] = None,
    base: Annotated[
        Path | None, typer.Option("--from", metavar="DIR", help="Run with the stages before this one, if another.")
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
    """Train generative stylization, one of its three stages, or go on with a training that was stopped.

    [bold]Examples[/bold]

    motionloom train stylization --stage autoencoder --run runs/ae

    motionloom train stylization --stage regressor --run runs/ae

    motionloom train stylization --stage style --run runs/ae --export stylization-ae.safetensors

    motionloom train stylization --stage style --unsupervised --run runs/ae-u --from runs/ae

    The autoencoder and the regressor do not see labels: both settings share them (--from). Use
    the weights with engines.load("stylization", checkpoint="stylization-ae.safetensors").
    """
    check_options(steps, threads, export, which)
    if stage not in _STEPS:
        raise UnknownLabelError("stage of stylization", stage, _STEPS)
    if export is not None and stage != "style":
        raise OutOfRangeError("--export", str(export), "none before the last stage, style, which has all networks")
    folder = run / stage
    before = {} if resume is False else remembered(folder)
    corpora_asked = before.get("corpora") if data is None else corpora(data)
    use_threads(threads)
    from engines.stylization import config, train
    from engines.training.run import RunOptions

    chosen, plan = settings(folder, before, preset, changes or [], config)
    if supervised is not None and supervised != chosen.supervised:
        weights = config.preset(preset or "small", supervised)
        names = ("supervised", "hsa_weight", "cycle_weight", "kl_weight")
        chosen = chosen.replaced(**{name: getattr(weights, name) for name in names})
    named = {"latent": latent, _STEPS[stage]: steps}
    chosen = chosen.replaced(**{name: value for name, value in named.items() if value is not None})
    with stoppable() as stopped, bar() as tick:
        state = train.fit(
            chosen,
            stage,  # pyright: ignore[reportArgumentType] (checked above)
            run,
            base=base,
            seed=seed,
            corpora=corpora_asked,
            plan=plan,
            device=device,
            options=RunOptions(resume=resume, cancel=stopped, tick=tick),
        )
    if first():
        tell(state, folder, export, which, train.export)
