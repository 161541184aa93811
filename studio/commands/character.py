"""`motionloom character`: somebody of one's own, from a picture, a mesh or a rigged file, performs a motion."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from engines.errors import OutOfRangeError
from studio.commands.console import CameraOption, FpsOption, WidthOption, progress_bar, settings_from
from studio.commands.making import SeedOption, StyleOption
from studio.settings import VIDEO_FORMATS, format_of

if TYPE_CHECKING:
    from engines import Motion
    from viewers.bodies import Body

SECONDS = 4.0
"""Of a motion, unless told."""
WRITTEN = (*VIDEO_FORMATS, "glb", "png", "html")
"""Endings of what is written of a character that performs."""


def character(  # noqa: PLR0913, PLR0917 (one parameter an option)
    source: Annotated[
        str,
        typer.Argument(
            metavar="SOURCE",
            help="Picture of one standing person; mesh (.obj, .ply, .glb, .zip); rigged .glb; or character:NAME.",
        ),
    ],
    action: Annotated[str | None, typer.Option(metavar="NAME", help="What it does. [walk]")] = None,
    prompt: Annotated[str | None, typer.Option(metavar="TEXT", help="What it does, in words.")] = None,
    style: StyleOption = None,
    motion: Annotated[Path | None, typer.Option(metavar="FILE", help="A motion file that it performs instead.")] = None,
    seconds: Annotated[float, typer.Option(metavar="N", help="Length of the motion.")] = SECONDS,
    seed: SeedOption = None,
    engine: Annotated[str | None, typer.Option(metavar="NAME", help="Engine; `motionloom info` lists them.")] = None,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", metavar="FILE", help="Video, .html, .glb, or .png (poses).")
    ] = None,
    save: Annotated[str | None, typer.Option(metavar="NAME", help="Keep it, for the studio and for --body.")] = None,
    height: Annotated[float | None, typer.Option(metavar="METRES", help="How tall the person is.")] = None,
    four_views: Annotated[bool, typer.Option("--four-views", help="Video from all four sides in one.")] = False,
    camera: CameraOption = None,
    width: WidthOption = None,
    fps: FpsOption = None,
    body: Annotated[str, typer.Option(metavar="NAME", help="Body that is fitted: anny, or your own SMPL's.")] = "anny",
) -> None:
    """Make a character of a picture or a mesh, and have it perform.

    [bold]Examples[/bold]

    motionloom character me.jpg --action walk -o walk.mp4

    motionloom character me.jpg --height 1.75 --save me        (then it is among the studio's bodies)

    motionloom character character:me --prompt "a person waves" --four-views -o wave.mp4

    motionloom character scan.obj --action sit -o sit.glb

    motionloom render walk.bvh --body character:me -o walk.mp4

    Pictures and meshes are looked at on this machine and never leave it. Paths of the files written are printed.
    """
    if out is None and save is None:
        out = Path(f"{_bare(source)}-{(action or 'motion') if action or prompt or motion else 'walk'}.mp4")
    if out is not None and _kind(out) not in WRITTEN:
        accepted = "a file ending in " + ", ".join(f".{kind}" for kind in WRITTEN)
        raise OutOfRangeError("--out", str(out), accepted)
    worn = _worn(source, save, height, body)
    if out is None:
        return
    played = _motion(motion, action, prompt, seconds, style=style, seed=seed, engine=engine)
    out.parent.mkdir(parents=True, exist_ok=True)
    typer.echo(_write(played, worn, out, camera=camera, width=width, fps=fps, views="around" if four_views else "one"))


def _worn(source: str, save: str | None, height: float | None, body: str) -> Body:
    """The character as a body; kept where it is to be."""
    from studio import likeness
    from viewers import bodies
    from viewers.bodies.character import PREFIX, body_of, file_of
    from viewers.bodies.character import save as keep

    if source.startswith(PREFIX) or Path(source).suffix.lower() == ".npz":
        return bodies.get(source)
    if save is not None:
        file_of(save)  # a name that cannot be is refused before anything is done
    with progress_bar(f"character {Path(source).name}", "%") as bar:
        file = Path(source)
        found = likeness.find(file, file.name, height)
        made = likeness.make(
            found, bodies.get(body), file.name, height=height,
            progress=lambda share, _words: bar(round(100 * share), 100),
        )  # fmt: skip
    for remark in made.provenance.get("remarks", ()):
        typer.echo(f"note: {remark}", err=True)
    if save is not None:
        typer.echo(keep(made, save))
    return body_of(made)


def _motion(file: Path | None, action: str | None, prompt: str | None, seconds: float, **told: Any) -> Motion:
    """What it performs: the motion of a file, or one that an engine makes."""
    import engines
    from studio import tasks

    if file is not None:
        return engines.read(file)
    words_alone = prompt is not None and action is None
    wanted = settings_from(None, action="" if words_alone else action, prompt=prompt, count=1, **told)
    rate = tasks.load_engine(wanted.generate.engine).fps
    recipe = wanted.changed(frames=round(seconds * rate)).generate
    with progress_bar(f"generate {recipe.subject[:60]}") as progress:
        return tasks.generate(recipe, progress)[0]


def _write(motion: Motion, body: Body, out: Path, camera: str | None, **video: Any) -> Path:
    """The character's performance as the file asked for."""
    from studio import tasks
    from viewers import Camera, Scene
    from viewers import video as videos
    from viewers.web.standalone import save_html

    kind = _kind(out)
    if kind == "html":
        return save_html(motion, out, body=body, title=out.stem, camera=camera or "orbit")
    if kind in ("glb", "png"):
        return (tasks.write_skinned if kind == "glb" else tasks.write_strip)(motion, out, body)
    scene = Scene.of(motion, body=body, camera=Camera(camera or "follow"))  # type: ignore[arg-type]
    with progress_bar(out.name) as progress:
        return videos.render(scene, out, progress=progress, **video)


def _kind(out: Path) -> str | None:
    return "html" if out.suffix.lower() == ".html" else format_of(out)


def _bare(source: str) -> str:
    """A source's name without folder, ending and prefix."""
    return Path(source.rpartition(":")[2]).stem
