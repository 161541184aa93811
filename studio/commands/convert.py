"""`motionloom convert`: one motion format into another."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from engines.errors import OutOfRangeError
from engines.motion import Motion
from studio.commands.console import EditOption, progress_bar


def convert(  # noqa: PLR0913, PLR0917 (one parameter an option)
    source: Annotated[Path, typer.Argument(metavar="IN", help="Motion file: .bvh, .glb, .npz, .amc, .mat; or a video")],
    target: Annotated[Path, typer.Argument(metavar="OUT", help="File to write: .bvh, .glb, .usdc, .fbx, .csv, .npz")],
    fps: Annotated[float | None, typer.Option(metavar="RATE", help="Resample to this many frames a second.")] = None,
    retarget: Annotated[
        str | None, typer.Option(metavar="SKELETON", help="Move onto a named skeleton, as smpl22.")
    ] = None,
    bones: Annotated[
        bool, typer.Option("--bones", help="Into .glb, .usdc, .fbx: joints alone, on the motion's own skeleton.")
    ] = False,
    edit: EditOption = None,
) -> None:
    """Convert a motion file, its formats told by the extensions.

    A .glb, .usdc or .fbx gets the default body over its joints unless --bones is given. A video of one person (.mp4,
    .mov, .webm ..., up to a minute) becomes a motion too: `make character` brings what that takes.

    [bold]Examples[/bold]

    motionloom convert walk.bvh walk.glb

    motionloom convert mocap.bvh house.bvh --fps 20 --retarget smpl22

    motionloom convert walk.bvh walk-here.bvh --edit feet --edit in_place

    motionloom convert telephone.mp4 walk.bvh
    """
    from engines import skeletons
    from studio import edits, tasks

    if fps is not None and not 1 <= fps <= 240:
        raise OutOfRangeError("--fps", fps, "1 to 240")
    wanted = skeletons.get(retarget) if retarget else None
    motion = _read(source)
    if wanted is not None:
        motion = motion.retarget(wanted)
    if fps is not None:
        motion = motion.resample(fps)
    motion = edits.apply(motion, edit or ())
    target.parent.mkdir(parents=True, exist_ok=True)
    skinned = target.suffix.lower() in (".glb", ".usdc", ".usda", ".usd", ".fbx") and not bones
    typer.echo(tasks.write_skinned(motion, target) if skinned else motion.write(target))


def _read(source: Path) -> Motion:
    """The motion in a file, or of the person in a video."""
    import engines
    from engines.character import video

    if source.suffix.lower() not in video.ENDINGS:
        return engines.read(source)
    with progress_bar(source.name) as progress:
        return video.read(source, progress)
