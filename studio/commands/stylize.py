"""`motionloom stylize`: a motion in another manner, written to files."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from engines.errors import MotionloomError
from studio.commands.console import (
    CameraOption,
    EditOption,
    FpsOption,
    HeightOption,
    SettingsOption,
    WidthOption,
    parse_formats,
    settings_from,
)  # fmt: skip
from studio.commands.making import (
    CountOption,
    FormatsOption,
    OutOption,
    SaveSettingsOption,
    SeedOption,
    StyleOption,
    TakeOption,
    VariantOption,
    destination,
    make_and_write,
)  # fmt: skip
from studio.settings import Settings, write_settings


def stylize(  # noqa: PLR0913, PLR0917 (one parameter an option)
    source: Annotated[
        Path | None, typer.Argument(metavar="INPUT", help="Motion file: .bvh, .glb, .npz, .amc, .mat")
    ] = None,
    style: StyleOption = None,
    like: Annotated[Path | None, typer.Option(metavar="FILE", help="A motion whose manner to take.")] = None,
    strength: Annotated[
        float | None, typer.Option(metavar="X", help="0: as it is, 1: the manner as it was learned, up to 1.5.")
    ] = None,
    tempo: Annotated[bool | None, typer.Option("--tempo/--no-tempo", help="Also as fast as the style is.")] = None,
    count: CountOption = None,
    seed: SeedOption = None,
    take: TakeOption = None,
    variant: VariantOption = None,
    out: OutOption = Path(),
    formats: FormatsOption = None,
    settings: SettingsOption = None,
    save_settings: SaveSettingsOption = None,
    feet: Annotated[
        bool | None, typer.Option("--feet/--no-feet", help="Hold standing feet; so unless said otherwise.")
    ] = None,
    edit: EditOption = None,
    width: WidthOption = None,
    height: HeightOption = None,
    fps: FpsOption = None,
    camera: CameraOption = None,
    list_styles: Annotated[bool, typer.Option("--list-styles", help="Print the styles known, and exit.")] = False,
) -> None:
    """Put a motion in another manner: in a style, like another motion, or, where neither is said, by chance.

    [bold]Examples[/bold]

    motionloom stylize walk.bvh --style old -o old.bvh

    motionloom stylize walk.bvh --like proud-dance.bvh --strength 0.7 -o proud.mp4

    motionloom stylize walk.bvh -n 4 --seed 7 -o surprises/ --format bvh,mp4

    motionloom stylize --settings take-5.json      (a take from the app, once more)

    motionloom stylize --list-styles

    Paths of the files written are printed, one a line.
    """
    if like is not None and style is not None:
        raise typer.BadParameter("give --style or --like, not both")
    if source is None and settings is None and not list_styles:
        raise typer.BadParameter("give an INPUT or --settings FILE; --list-styles shows what is known")
    edits = (*(edit or ()), *(["feet"] if feet or (feet is None and settings is None) else []))
    wanted = settings_from(
        settings, engine=None if settings else _engine(), action=None if settings else "", variant=variant, style=style,
        strength=strength, tempo=tempo, count=count if count or settings else 1, seed=seed, take=take,
        formats=parse_formats(formats), width=width, height=height, fps=fps, camera=camera,
        edits=edits if edits or feet is False else None,
    )  # fmt: skip
    if list_styles:
        _print_styles(wanted)
        return
    wanted = _with_motions(wanted, source, like)
    wanted, folder, name = destination(wanted, out, one_by_default=count is None and settings is None)
    make_and_write(wanted, folder, name)
    if save_settings is not None:
        typer.echo(write_settings(wanted, save_settings))


def _engine() -> str:
    """The engine asked.

    Raises:
        MotionloomError: none has weights.
    """
    from engines import registry

    known = registry.stylisers()
    if not known:
        raise MotionloomError("no engine that puts motions in another manner has weights here; train one first.")
    return next(iter(known))


def _with_motions(wanted: Settings, source: Path | None, like: Path | None) -> Settings:
    """The settings with what the files hold."""
    import engines
    from studio import tasks
    from studio.given import Given

    rate = tasks.load_engine(wanted.generate.engine, wanted.generate.variant).fps
    if source is not None:
        motion = engines.read(source)
        given = Given.of(motion, source.name, rate)
        wanted = wanted.changed(given=given, frames=given.frames, action=motion.label_at(0) or "")
    if like is not None:
        wanted = wanted.changed(like=Given.of(engines.read(like), like.name, rate), style="")
    return wanted


def _print_styles(wanted: Settings) -> None:
    from studio import tasks

    for style in tasks.load_engine(wanted.generate.engine, wanted.generate.variant).styles:
        typer.echo(style)
