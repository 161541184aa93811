"""What `motionloom generate` pins: a path, a beginning, poses, a loop, read from options."""

from __future__ import annotations

import re
from pathlib import Path

from engines import Motion
from engines.errors import MotionloomError, OutOfRangeError
from studio.pinned import NOTHING, Kept, Pinned
from studio.pinning import parse_path

FPS = 20.0
"""Rate at which the frames of the motion to come are counted."""


def parse_pins(
    path: str | None, begin_with: str | None, poses: list[str] | None, loop: bool, before: Pinned = NOTHING
) -> Pinned | None:
    """What the options pin, on top of what a settings file pinned; None where they pin nothing.

    Args:
        path: "x,z x,z ...", metres.
        begin_with: "FILE" or "FILE:frames".
        poses: each "FILE:FRAME@FRAME", a frame of the file and the frame of the motion where it is to be seen.
        loop: the motion ends as it began.
        before: of the settings file.

    Raises:
        OutOfRangeError: an option that is not written so, or frames that a file does not have.
        FormatError: a file cannot be read.
    """
    if path is None and begin_with is None and not poses and not loop:
        return None
    pinned = Pinned(
        before.kept, parse_path(path) if path is not None else before.path, before.pins, before.loop or loop
    )
    if begin_with is not None:
        pinned = pinned.with_kept(_beginning(begin_with))
    for text in poses or ():
        pinned = pinned.with_kept(_pose(text))
    return pinned


def _beginning(text: str) -> Kept:
    file, frames = text, ""
    found = re.fullmatch(r"(.+):(\d+)", text)
    if found and not Path(text).exists():
        file, frames = found[1], found[2]
    motion = _read("--begin-with", text, file)
    length = len(motion.resample(FPS))
    if frames and not 1 <= int(frames) <= length:
        raise OutOfRangeError(f"--begin-with {file}: frames", int(frames), f"1 to {length}, at 20 a second")
    return Kept.of(motion, 0, int(frames) if frames else length, 0, Path(file).name, FPS)


def _pose(text: str) -> Kept:
    found = re.fullmatch(r"(.+):(\d+)@(\d+)", text)
    if not found:
        raise OutOfRangeError("--pose", text, "FILE:FRAME@FRAME, as in walk.bvh:12@40: its frame 12 as frame 40")
    file, own, at = found[1], int(found[2]), int(found[3])
    motion = _read("--pose", text, file)
    if own >= len(motion):
        raise OutOfRangeError(f"--pose {file}: frame", own, f"0 to {len(motion) - 1}")
    # a frame of the file at the file's own rate: cut out first, so that it is that frame and not one between two
    return Kept.of(motion[own : own + 1], 0, 1, at, f"{Path(file).name}, frame {own},", FPS)


def _read(option: str, text: str, file: str) -> Motion:
    import engines

    if not Path(file).is_file():
        raise MotionloomError(f"{option} {text}: there is no file {file}")
    return engines.read(file)
