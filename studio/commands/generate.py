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
    progress_bar,
    settings_from,
)  # fmt: skip
from studio.commands.pins import FPS, parse_pins
from studio.settings import (
    FORMATS,
    VIDEO_FORMATS,
    ExportSettings,
    GenerateSettings,
    Settings,
    ending,
    format_of,
    write_settings,
)


def generate(  # noqa: PLR0913, PLR0917 (one parameter an option)
    action: Annotated[
        str | None, typer.Argument(metavar="ACTION", help="What the person does: walk, jump, ...")
    ] = None,
    count: Annotated[int | None, typer.Option("--count", "-n", metavar="N", help="How many motions to draw.")] = None,
    frames: Annotated[int | None, typer.Option(metavar="N", help="Length of each, frames (20 a second).")] = None,
    seed: Annotated[int | None, typer.Option(metavar="N", help="Same seed and settings: identical motions.")] = None,
    take: Annotated[int | None, typer.Option(metavar="N", help="Keep only the N-th of the draw.")] = None,
    out: Annotated[
        Path, typer.Option("--out", "-o", metavar="PATH", help="Folder; or, for one motion, a file such as walk.mp4.")
    ] = Path(),
    formats: Annotated[
        str | None, typer.Option("--format", "-f", metavar="LIST", help="Comma between: bvh, npz, amass, mp4, gif.")
    ] = None,
    settings: SettingsOption = None,
    save_settings: Annotated[Path | None, typer.Option(metavar="FILE", help="Also save the settings used.")] = None,
    engine: Annotated[str | None, typer.Option(metavar="NAME", help="Engine; `motionloom info` lists them.")] = None,
    variant: Annotated[str | None, typer.Option(metavar="NAME", help="Variant of the engine.")] = None,
    bone_scale: Annotated[
        list[str] | None, typer.Option(metavar="JOINT=FACTOR", help="Longer or shorter bones; may be repeated.")
    ] = None,
    prompt: Annotated[str | None, typer.Option(metavar="TEXT", help="What is to be seen, in words.")] = None,
    style: Annotated[str | None, typer.Option(metavar="NAME", help="In which manner; `info ENGINE` lists.")] = None,
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
    if list_actions:
        _print_actions(wanted.generate)
        return
    if action is None and prompt is None and settings is None:
        raise typer.BadParameter("give an ACTION, --prompt or --settings FILE; --list-actions shows what is known")
    wanted = wanted.changed(constraints=parse_pins(path, begin_with, pose, loop, wanted.generate.constraints))
    _fits(wanted.generate)
    wanted, folder, name = _destination(wanted, out, one_by_default=count is None and settings is None)
    _generate_and_write(wanted, folder, name)
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


def _destination(wanted: Settings, out: Path, one_by_default: bool) -> tuple[Settings, Path, str | None]:
    """`-o walk.mp4` names one file and its format; anything else is a folder."""
    if not out.suffix or out.is_dir():
        return wanted, out, None
    kind = format_of(out)
    if kind is None:
        raise OutOfRangeError("--out", str(out), f"a folder, or a file ending in {', '.join(map(ending, FORMATS))}")
    recipe = replace(wanted.generate, count=1) if one_by_default else wanted.generate
    if recipe.count > 1 and recipe.take is None:
        raise OutOfRangeError("--out", str(out), f"a folder for {recipe.count} motions, or --take to keep one of them")
    name = out.name[: -len(ending(kind))]
    return Settings(recipe, replace(wanted.export, formats=(kind,))), out.parent, name


def _fits(recipe: GenerateSettings) -> None:
    """Is what is pinned within the motion?"""
    problem = recipe.constraints.problem(recipe.frames, FPS)
    if problem:
        raise MotionloomError(problem[:1].lower() + problem[1:])


def _generate_and_write(wanted: Settings, folder: Path, name: str | None) -> None:
    from studio import tasks

    recipe = wanted.generate
    with progress_bar(f"generate {recipe.subject[:60]}") as progress:
        motions = tasks.generate(recipe, progress)
    for sentence in dict.fromkeys(sentence for motion in motions for sentence in tasks.unmet(motion)):
        typer.echo(f"not met: {sentence}", err=True)
    folder.mkdir(parents=True, exist_ok=True)
    first = recipe.take or 1
    for place, motion in enumerate(motions, first):
        stem = name or f"{tasks.slug(recipe.subject)}-seed{recipe.seed}-{place}"
        for kind in wanted.export.formats:
            _write(motion, folder / f"{stem}{ending(kind)}", wanted.export)


def _write(motion, path: Path, how: ExportSettings) -> None:
    from studio import tasks

    if format_of(path) in VIDEO_FORMATS:
        with progress_bar(path.name) as progress:
            typer.echo(tasks.export(motion, path, how, progress))
    else:
        typer.echo(tasks.export(motion, path, how))


def _print_actions(recipe: GenerateSettings) -> None:
    from studio import tasks

    groups: dict[str, list] = {}
    for known in tasks.load_engine(recipe.engine, recipe.variant).actions:
        groups.setdefault(known.group, []).append(known)
    for group, members in groups.items():
        typer.secho(group, bold=True)
        for known in members:
            typer.echo(f"  {known.name:<28}{known.description}")
