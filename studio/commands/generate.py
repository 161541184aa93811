"""`motionloom generate`: motions from an action or from words, written to files."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from engines.errors import MotionloomError, OutOfRangeError
from studio.commands.console import (
    CameraOption,
    EditOption,
    FpsOption,
    HeightOption,
    SettingsOption,
    WidthOption,
    parse_factors,
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
from studio.commands.pins import FPS, parse_pins
from studio.settings import USUAL_FRAMES, GenerateSettings, write_settings


def generate(  # noqa: PLR0913, PLR0917 (one parameter an option)
    action: Annotated[
        str | None, typer.Argument(metavar="ACTION", help="What the person does: walk, jump, ...")
    ] = None,
    count: CountOption = None,
    frames: Annotated[
        int | None, typer.Option(metavar="N", help="Length, frames (20 a second); of a prompt as it takes, or 60.")
    ] = None,
    seed: SeedOption = None,
    take: TakeOption = None,
    out: OutOption = Path(),
    formats: FormatsOption = None,
    settings: SettingsOption = None,
    save_settings: SaveSettingsOption = None,
    engine: Annotated[str | None, typer.Option(metavar="NAME", help="Engine; `motionloom info` lists them.")] = None,
    variant: VariantOption = None,
    bone_scale: Annotated[
        list[str] | None, typer.Option(metavar="JOINT=FACTOR", help="Longer or shorter bones; may be repeated.")
    ] = None,
    prompt: Annotated[str | None, typer.Option(metavar="TEXT", help="What is to be seen, in words.")] = None,
    style: StyleOption = None,
    guidance: Annotated[
        float | None, typer.Option(metavar="X", help="How closely the request is followed, 0-10.")
    ] = None,
    best_of: Annotated[int | None, typer.Option(metavar="N", help="Draw N for each one and keep the best.")] = None,
    then: Annotated[
        list[str] | None, typer.Option(metavar="ACTION:FRAMES", help="What follows in the same motion; repeatable.")
    ] = None,
    path: Annotated[str | None, typer.Option(metavar='"X,Z X,Z ..."', help="Way on the floor, metres.")] = None,
    begin_with: Annotated[
        str | None, typer.Option(metavar="FILE[:FRAMES]", help="Begin with the frames of a file and go on.")
    ] = None,
    pose: Annotated[
        list[str] | None, typer.Option(metavar="FILE:FRAME@FRAME", help="A pose of a file at a frame; repeatable.")
    ] = None,
    loop: Annotated[bool, typer.Option("--loop", help="End as it began.")] = False,
    width: WidthOption = None,
    height: HeightOption = None,
    fps: FpsOption = None,
    edit: EditOption = None,
    camera: CameraOption = None,
    list_actions: Annotated[bool, typer.Option("--list-actions", help="Print the actions known, and exit.")] = False,
) -> None:
    """Generate motions of an action, or of what a prompt says, and write them.

    [bold]Examples[/bold]

    motionloom generate walk -n 4 --frames 60 --seed 7 -o out/ --format bvh,npz,mp4

    motionloom generate jump -o jump.mp4 --camera front

    motionloom generate --prompt "a person walks and waves" --style happy --best-of 4

    motionloom generate walk --path "0,0 0,2 2,3" --begin-with walk.bvh:20 --pose sit.bvh:0@90 --frames 100

    motionloom generate walk --frames 40 --then "turn left:40" --then run:60

    motionloom generate --settings take-2.json     (a take from the app, once more)

    motionloom generate --list-actions

    Paths of the files written are printed, one a line.
    """
    words_alone = prompt is not None and action is None
    wanted = settings_from(
        settings, action="" if words_alone else action, prompt=prompt, style=style, guidance=guidance,
        best_of=best_of, count=count, frames=frames, seed=seed, take=take, engine=engine, variant=variant,
        bone_scale=parse_factors(bone_scale), formats=parse_formats(formats), width=width, height=height, fps=fps,
        camera=camera, then=parse_then(then), edits=tuple(edit) if edit else None,
    )  # fmt: skip
    if engine is not None:  # what is said here goes before what a file says of who makes the actions of a sequence
        wanted = wanted.changed(sequence=replace(wanted.generate.sequence, engine=""))
    if list_actions:
        _print_actions(wanted.generate)
        return
    if action is None and prompt is None and settings is None:
        raise typer.BadParameter("give an ACTION, --prompt or --settings FILE; --list-actions shows what is known")
    wanted = wanted.changed(constraints=parse_pins(path, begin_with, pose, loop, wanted.generate.constraints))
    if words_alone and frames is None and settings is None and not wanted.generate.constraints:
        wanted = replace(wanted, generate=replace(wanted.generate, frames=None))
    _fits(wanted.generate)
    wanted, folder, name = destination(wanted, out, one_by_default=count is None and settings is None)
    make_and_write(wanted, folder, name)
    if save_settings is not None:
        typer.echo(write_settings(wanted, save_settings))


def parse_then(items: list[str] | None) -> tuple[tuple[str, int], ...] | None:
    """`["run:40"]` -> (("run", 40),); nothing given stays None."""
    parts = []
    for item in items or ():
        action, colon, frames = item.rpartition(":")
        if not colon or not frames.strip().isdigit():
            raise OutOfRangeError("--then", item, "ACTION:FRAMES, as in run:40")
        parts.append((" ".join(action.lower().split()), int(frames)))
    return tuple(parts) or None


def _fits(recipe: GenerateSettings) -> None:
    """Is what is pinned within the motion?"""
    problem = recipe.constraints.problem(recipe.frames or USUAL_FRAMES, FPS)
    if problem:
        raise MotionloomError(problem[:1].lower() + problem[1:])


def _print_actions(recipe: GenerateSettings) -> None:
    from studio import tasks

    groups: dict[str, list] = {}
    for known in tasks.load_engine(recipe.engine, recipe.variant).actions:
        groups.setdefault(known.group, []).append(known)
    for group, members in groups.items():
        typer.secho(group, bold=True)
        for known in members:
            typer.echo(f"  {known.name:<28}{known.description}")
