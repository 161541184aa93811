"""`motionloom render`: a motion file as a video."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from engines.errors import OutOfRangeError
from studio.commands.console import (
    CameraOption,
    FpsOption,
    HeightOption,
    SettingsOption,
    WidthOption,
    progress_bar,
    settings_from,
)  # fmt: skip
from studio.settings import VIDEO_FORMATS, format_of


def render(  # noqa: PLR0913, PLR0917 (one parameter an option)
    file: Annotated[Path, typer.Argument(help="Motion file: .bvh, .glb, .npz, .mat")],
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", "-o", metavar="FILE", help="Video: .mp4, .gif, .webm; a new folder: its pictures. [FILE with .mp4]"
        ),
    ] = None,
    settings: SettingsOption = None,
    width: WidthOption = None,
    height: HeightOption = None,
    fps: FpsOption = None,
    camera: CameraOption = None,
) -> None:
    """Render a motion file as a video, without a screen.

    [bold]Examples[/bold]

    motionloom render walk.bvh -o walk.mp4 --camera follow

    motionloom render walk.npz -o walk.gif --width 480 --height 480 --fps 15

    motionloom render walk.bvh -o frames/
    """
    out = out or Path(file.with_suffix(".mp4").name)
    pictures = not out.suffix
    if not pictures and format_of(out) not in VIDEO_FORMATS:
        raise OutOfRangeError("--out", str(out), "a file ending in " + " or ".join(f".{f}" for f in VIDEO_FORMATS))
    wanted = settings_from(settings, width=width, height=height, fps=fps, camera=camera)
    import engines
    from studio import tasks

    motion = engines.read(file)
    out.parent.mkdir(parents=True, exist_ok=True)
    with progress_bar(out.name) as progress:
        write = tasks.export_pictures if pictures else tasks.export
        written = write(motion, out, wanted.export, progress)
    typer.echo(written)
