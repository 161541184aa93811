"""Pose strips: every k-th frame of a motion side by side in one picture, as the papers' figures show motions."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Protocol

import numpy as np
from jaxtyping import UInt8
from PIL import Image

from engines.errors import FormatError, OutOfRangeError
from engines.formats import atomic_path
from engines.motion import Motion
from viewers.bodies import Body, body_for
from viewers.camera import Camera
from viewers.scene import Actor, Scene


class Draws(Protocol):
    """What draws the poses: `moderngl_renderer.Renderer`, or `pv.pictures.Pictures`."""

    def pictures(self, scene: Scene, times: np.ndarray) -> Iterator[np.ndarray]:
        """(H, W, 3 or 4) uint8 pictures at `times` (N,) seconds."""
        ...


MOST = 64
"""No strip has more poses."""
LARGEST = 16384
"""No strip is wider, pixels."""
USUAL = 8
"""Poses where nobody says how many."""
YAW, PITCH = 0.6, 0.12
"""Whence a strip is seen, radians: a little above and to the side of the way the motion begins to face."""


def spread(motion: Motion, count: int = USUAL) -> list[int]:
    """`count` frames spread evenly from the first to the last; all of them where there are fewer.

    Raises:
        OutOfRangeError: fewer than one, or more than `MOST`.
    """
    if not 1 <= count <= MOST:
        raise OutOfRangeError("number of poses", count, f"1 to {MOST}")
    return np.unique(np.round(np.linspace(0, len(motion) - 1, count)).astype(int)).tolist()


def every(motion: Motion, step: int) -> list[int]:
    """Every `step`-th frame, from the first on.

    Raises:
        OutOfRangeError: a step below one, or one that gives more than `MOST` poses.
    """
    least = -(-len(motion) // MOST)
    if step < least:
        raise OutOfRangeError("step of frames", step, f"{least} or more, so that there are at most {MOST} poses")
    return list(range(0, len(motion), step))


def poses(
    renderer: Draws, motion: Motion, frames: list[int], body: str | Body = "anny", **view
) -> list[UInt8[np.ndarray, "H W 3"]]:
    """Pictures of the renderer's size of some frames of a motion, all from one place, the body kept in its middle.

    Args:
        renderer: draws them.
        motion: any motion; it is shown in place.
        frames: which of its frames.
        body: name of a body, or one.
        view: further fields of the Scene: `camera` (default: so that all these poses fit) and `backdrop`.

    Returns:
        (H, W, 3) uint8 sRGB pictures.

    Raises:
        OutOfRangeError: no frames, or one that the motion does not have.
        UnknownLabelError: no such body or backdrop.
    """
    if not frames or not all(0 <= frame < len(motion) for frame in frames):
        raise OutOfRangeError("frames", frames, f"one or more of 0 to {len(motion) - 1}")
    worn, played = body_for(motion, body)  # the camera frames the body that is seen
    still = played.in_place()
    chosen = still.replaced(
        rotations=still.rotations[frames], translation=still.translation[frames], fps=1.0, labels=()
    )
    if "camera" not in view:
        turned = float(chosen.heading[0]) if chosen.skeleton.feet else 0.0
        view["camera"] = Camera(yaw=turned + YAW, pitch=PITCH)
    scene = Scene((Actor(chosen, worn),), **view)
    return [picture[..., :3].copy() for picture in renderer.pictures(scene, np.arange(len(frames), dtype=float))]


def strip(
    motion: Motion,
    frames: list[int] | None = None,
    height: int = 360,
    width: int | None = None,
    draw: Callable[[int, int], AbstractContextManager[Draws]] | None = None,
    **options,
) -> UInt8[np.ndarray, "H W 3"]:
    """One picture of some frames of a motion side by side, time from left to right.

    Args:
        motion: any motion.
        frames: which frames (see `spread` and `every`); default: `USUAL` spread over all.
        height: of the picture, pixels.
        width: of the picture, pixels; default: as wide as the poses need, three quarters of the height each.
        draw: makes what draws pictures of so many pixels across and down; default: OpenGL by moderngl.
        options: body, camera and backdrop as in `poses`.

    Returns:
        (height, width, 3) uint8 sRGB; the width is made a multiple of the number of poses.

    Raises:
        OutOfRangeError: frames or sizes that cannot be.
        NoGraphicsError: no OpenGL here.
    """
    if draw is None:
        from viewers.moderngl_renderer import Renderer as draw
    frames = spread(motion) if frames is None else frames
    if not frames:
        raise OutOfRangeError("frames", frames, f"one or more of 0 to {len(motion) - 1}")
    cell = round(height * 0.75) if width is None else width // len(frames)
    if not 1 <= cell * len(frames) <= LARGEST:
        raise OutOfRangeError("width of the strip", cell * len(frames), f"1 to {LARGEST} pixels")
    with draw(cell, height) as renderer:
        return np.concatenate(poses(renderer, motion, frames, **options), axis=1)


def write_strip(motion: Motion, path: str | Path, frames: list[int] | None = None, **options) -> Path:
    """Write a strip as .png, beside and renamed; arguments as in `strip`.

    Returns:
        The path.

    Raises:
        FormatError: the ending is not .png, or the file cannot be written.
        OutOfRangeError: frames or sizes that cannot be.
        NoGraphicsError: no OpenGL here.
    """
    path = Path(path)
    if path.suffix.lower() != ".png":
        raise FormatError(path, f"strips end in .png, not in {path.suffix!r}.")
    picture = Image.fromarray(strip(motion, frames, **options))
    with atomic_path(path) as temporary:
        picture.save(temporary, format="PNG")
    return path


def as_png(motion: Motion, height: int = 200) -> bytes:
    """A strip as the bytes of a PNG: what a notebook shows of a Motion (entry point `motionloom.pictures`).

    Raises:
        NoGraphicsError: no OpenGL here.
    """
    file = io.BytesIO()
    Image.fromarray(strip(motion, height=height)).save(file, format="PNG")
    return file.getvalue()
