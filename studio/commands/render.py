"""`motionloom render`: a motion file as a video, pictures, a page, or in a window."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from engines.errors import OutOfRangeError
from studio.commands.console import (
    CameraOption,
    FpsOption,
    HeightOption,
    SettingsOption,
    WidthOption,
    parse_numbers,
    progress_bar,
    settings_from,
)  # fmt: skip
from studio.settings import VIDEO_FORMATS, ExportSettings, format_of

if TYPE_CHECKING:
    from engines import Motion


class Show(StrEnum):
    """What is drawn of a figure."""

    body = "body"
    skeleton = "skeleton"
    both = "both"


class Views(StrEnum):
    """How many pictures stand in one."""

    one = "one"
    four = "four"
    around = "around"


class Backdrop(StrEnum):
    """What is behind the figure."""

    dark = "dark"
    light = "light"
    none = "none"


def render(  # noqa: PLR0913, PLR0917 (one parameter an option)
    file: Annotated[Path, typer.Argument(help="Motion file: .bvh, .glb, .npz, .mat")],
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            "-o",
            metavar="FILE",
            help="Video: .mp4, .gif, .webm; page: .html; a new folder: its pictures. [FILE with .mp4]",
        ),
    ] = None,
    settings: SettingsOption = None,
    width: WidthOption = None,
    height: HeightOption = None,
    fps: FpsOption = None,
    camera: CameraOption = None,
    views: Annotated[
        Views | None, typer.Option(help="four: front, side, top and orbit in one picture; around: all sides. [one]")
    ] = None,
    show: Annotated[Show, typer.Option(help="Skin, stick figure, or both.")] = Show.body,
    body: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Body: anny, mannequin, stick, character:NAME, or a SMPL model file (.npz)."),
    ] = None,
    shape: Annotated[
        list[str] | None,
        typer.Option("--shape", metavar="NAME=VALUE", help="Of the body, repeatable: weight=0.7, gender=1, beta1=2."),
    ] = None,
    backdrop: Annotated[
        Backdrop, typer.Option(help="none: transparent, for .webm, .gif and pictures.")
    ] = Backdrop.dark,
    contacts: Annotated[bool, typer.Option("--contacts", help="Mark where feet stand.")] = False,
    trail: Annotated[bool, typer.Option("--trail", help="Dots on the floor under the root.")] = False,
    ghosts: Annotated[int, typer.Option(metavar="FRAMES", help="A fainter copy every so many frames; 0 for none.")] = 0,
    label: Annotated[str | None, typer.Option(metavar="TEXT", help="Text by the feet.")] = None,
    window: Annotated[bool, typer.Option("--window", help="Show it in a window instead of writing a file.")] = False,
) -> None:
    """Render a motion file as a video, without a screen.

    [bold]Examples[/bold]

    motionloom render walk.bvh -o walk.mp4 --camera follow

    motionloom render walk.bvh -o walk.mp4 --views four --contacts --trail

    motionloom render walk.bvh -o walk.webm --backdrop none --body anny --shape weight=0.8

    motionloom render walk.npz -o walk.gif --width 480 --height 480 --fps 15

    motionloom render walk.bvh -o frames/

    motionloom render walk.bvh --window
    """
    out = out or Path(file.with_suffix(".mp4").name)
    if out.suffix and out.suffix.lower() != ".html" and format_of(out) not in VIDEO_FORMATS:
        accepted = [f".{f}" for f in VIDEO_FORMATS] + [".html"]
        raise OutOfRangeError("--out", str(out), "a file ending in " + " or ".join(accepted) + ", or a folder")
    wanted = settings_from(
        settings, width=width, height=height, fps=fps, camera=camera, views=views.value if views else None
    )
    import engines
    from viewers import bodies

    motion = engines.read(file)
    drawn: dict[str, Any] = {
        "show": show.value, "contacts": contacts, "trail": trail, "ghosts": ghosts, "label": label,
        "body": bodies.wanted(body, parse_numbers("--shape", shape)),
    }  # fmt: skip
    if window:
        _open_window(motion, drawn, backdrop, wanted.export)
        return
    out.parent.mkdir(parents=True, exist_ok=True)
    if out.suffix.lower() == ".html":
        typer.echo(_write_page(motion, out, drawn, backdrop, wanted.export))
        return
    with progress_bar(out.name) as progress:
        typer.echo(_write(motion, out, drawn, backdrop, wanted.export, progress))


def _scene(motion: Motion, drawn: dict[str, Any], backdrop: Backdrop, export: ExportSettings) -> Any:
    """The scene that the options describe."""
    from viewers import Camera, Scene

    scene = Scene.of(motion, camera=Camera(export.camera), **drawn)  # type: ignore[arg-type]
    if backdrop is Backdrop.none:
        return scene.replaced(transparent=True)
    return scene.replaced(backdrop=backdrop.value)


def _write(  # noqa: PLR0913, PLR0917 (what the command was told)
    motion: Motion,
    out: Path,
    drawn: dict[str, Any],
    backdrop: Backdrop,
    export: ExportSettings,
    progress: Any,
) -> Path:
    """A video, or a folder of pictures."""
    from viewers import video

    scene = _scene(motion, drawn, backdrop, export)
    video_settings = {name: getattr(export, name) for name in ("width", "height", "fps", "views")}
    write = video.render if out.suffix else video.render_pngs
    return write(scene, out, progress=progress, **video_settings)


def _write_page(motion: Motion, out: Path, drawn: dict[str, Any], backdrop: Backdrop, export: ExportSettings) -> Path:
    """A page that plays the motion in any browser, offline."""
    from viewers.web.standalone import save_html

    shown = {name: drawn[name] for name in ("show", "contacts", "trail", "ghosts")}
    return save_html(
        motion, out, body=drawn["body"], labels=[drawn["label"]] if drawn["label"] else None,
        title=drawn["label"] or out.stem, camera=export.camera,
        theme="light" if backdrop is Backdrop.light else "dark", **shown,
    )  # fmt: skip


def _open_window(motion: Motion, drawn: dict[str, Any], backdrop: Backdrop, export: ExportSettings) -> None:
    from viewers import window

    scene = _scene(motion, drawn, Backdrop.dark if backdrop is Backdrop.none else backdrop, export)
    window.show(scene, export.width or 1280, export.height or 720)
