"""What every reader and writer needs: bounded reading, and writing beside and renaming.

A file from elsewhere may claim anything. Nothing here or in the readers allocates memory on a file's word alone:
the file itself is at most `MAX_FILE_BYTES`, and what it unpacks to at most `MAX_JOINT_FRAMES` poses of joints.
"""

from __future__ import annotations

import os
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from engines.errors import FormatError

MAX_FILE_BYTES = 256 * 2**20
"""No motion file larger than this is read; as BVH text, three quarters of an hour of 31 joints at 120 fps."""
MAX_JOINTS = 2_000
"""No skeleton with more joints than this is read."""
MAX_JOINT_FRAMES = 12_000_000
"""Frames times joints a motion may have when read: over an hour of 22 joints at 120 fps (384 MB of quaternions)."""
HEAD_BYTES = 4096
"""How much of a file's beginning is looked at to tell its format."""


def _umask() -> int:
    """The process's file mode mask, which can only be read by setting it."""
    mask = os.umask(0o077)
    os.umask(mask)
    return mask


_UMASK = _umask()  # once, before there are threads that create files


def existing_file(path: str | Path, limit: int = MAX_FILE_BYTES) -> Path:
    """The path, once it is known to be a readable file of 1 to `limit` bytes.

    Raises:
        FormatError: missing, a directory, empty, too large, or not allowed to be read.
    """
    path = Path(path)
    try:
        found = path.stat()
    except FileNotFoundError:
        raise FormatError(path, "there is no such file.") from None
    except (OSError, ValueError) as error:
        raise FormatError(path, f"cannot be opened: {_reason(error)}.") from error
    if stat.S_ISDIR(found.st_mode):
        raise FormatError(path, "is a directory; accepted: one motion file.")
    if not stat.S_ISREG(found.st_mode):
        raise FormatError(path, "is not an ordinary file; accepted: one motion file.")
    if found.st_size == 0:
        raise FormatError(path, "the file is empty.")
    if found.st_size > limit:
        raise FormatError(path, f"has {found.st_size:,} bytes; accepted: at most {limit:,}.")
    return path


def read_bytes(path: str | Path, limit: int = MAX_FILE_BYTES) -> bytes:
    """All bytes of an existing file of at most `limit` bytes.

    Raises:
        FormatError: as `existing_file`.
    """
    path = existing_file(path, limit)
    try:
        with path.open("rb") as file:
            return file.read(path.stat().st_size)  # not `limit`, all of which would be set aside
    except OSError as error:
        raise FormatError(path, f"cannot be read: {_reason(error)}.") from error


def read_head(path: str | Path) -> bytes:
    """The first `HEAD_BYTES` bytes of an existing file.

    Raises:
        FormatError: as `existing_file`.
    """
    path = existing_file(path)
    try:
        with path.open("rb") as file:
            return file.read(HEAD_BYTES)
    except OSError as error:
        raise FormatError(path, f"cannot be read: {_reason(error)}.") from error


def check_size(path: str | Path, frames: int, joints: int, line: int | None = None) -> None:
    """Refuse a motion too large to hold, before anything is allocated for it.

    Raises:
        FormatError: more than `MAX_JOINTS` joints, or more than `MAX_JOINT_FRAMES` frames times joints.
    """
    if joints > MAX_JOINTS:
        raise FormatError(path, f"has {joints:,} joints; accepted: at most {MAX_JOINTS:,}.", line)
    if frames * joints > MAX_JOINT_FRAMES:
        most = MAX_JOINT_FRAMES // max(joints, 1)
        raise FormatError(
            path, f"claims {frames:,} frames of {joints} joints; accepted: at most {most:,} frames.", line
        )


@contextmanager
def atomic_path(path: str | Path) -> Iterator[Path]:
    """A temporary file beside `path` to write to: it takes the name on success and is removed on failure.

        with atomic_path("walk.bvh") as temporary:
            temporary.write_text(...)

    The temporary name ends like the real one, so that libraries that go by the extension do the right thing.

    Raises:
        FormatError: the folder is missing or cannot be written to, or `path` is a directory.
    """
    path = Path(path)
    if path.is_dir():
        raise FormatError(path, "is a directory; accepted: the name of a file.")
    try:
        handle, name = tempfile.mkstemp(prefix=f".{path.stem[:80]}-", suffix=path.suffix, dir=path.parent)
    except (OSError, ValueError) as error:
        raise FormatError(path, f"cannot be written: {_reason(error)}; accepted: a folder you may write to.") from error
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        temporary.chmod(0o666 & ~_UMASK)  # mkstemp makes private files; this one should be as any other
        temporary.replace(path)
    except OSError as error:
        raise FormatError(path, f"cannot be written: {_reason(error)}.") from error
    finally:
        temporary.unlink(missing_ok=True)


def _reason(error: Exception) -> str:
    """What the operating system said, without Python's decoration."""
    return (getattr(error, "strerror", None) or str(error)).lower().rstrip(".")
