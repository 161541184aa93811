"""What `generate` and `stylize` share: options, where files go, and motions made by settings and written."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from engines import Motion
from engines.errors import OutOfRangeError
from studio.commands.console import progress_bar
from studio.settings import FORMATS, VIDEO_FORMATS, ExportSettings, Settings, ending, format_of

CountOption = Annotated[int | None, typer.Option("--count", "-n", metavar="N", help="How many motions to draw.")]
SeedOption = Annotated[int | None, typer.Option(metavar="N", help="Same seed and settings: identical motions.")]
TakeOption = Annotated[int | None, typer.Option(metavar="N", help="Keep only the N-th of the draw.")]
OutOption = Annotated[
    Path, typer.Option("--out", "-o", metavar="PATH", help="Folder; or, for one motion, a file such as walk.mp4.")
]
FormatsOption = Annotated[
    str | None, typer.Option("--format", "-f", metavar="LIST", help="Comma between: bvh, npz, amass, mp4, gif.")
]
SaveSettingsOption = Annotated[Path | None, typer.Option(metavar="FILE", help="Also save the settings used.")]
VariantOption = Annotated[str | None, typer.Option(metavar="NAME", help="Variant of the engine.")]
StyleOption = Annotated[str | None, typer.Option(metavar="NAME", help="In which manner; `info ENGINE` lists.")]


def destination(wanted: Settings, out: Path, one_by_default: bool) -> tuple[Settings, Path, str | None]:
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


def make_and_write(wanted: Settings, folder: Path, name: str | None) -> None:
    """Make motions by settings and write them; the paths are printed."""
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


def _write(motion: Motion, path: Path, how: ExportSettings) -> None:
    from studio import tasks

    if format_of(path) in VIDEO_FORMATS:
        with progress_bar(path.name) as progress:
            typer.echo(tasks.export(motion, path, how, progress))
    else:
        typer.echo(tasks.export(motion, path, how))
