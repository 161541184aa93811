"""Motion files in and out: one file a format, one registry.

    motion = formats.read("walk.bvh")
    formats.write(motion, "walk.npz")
    for kind in formats.formats(): ...

A file's kind is told by its content first and its extension second, so a wrong extension does no harm. A format is
a module with a `FORMAT`; to add one, write it and name it in `_FORMATS`.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from engines.errors import FormatError
from engines.formats import amass, amc, bvh, csv_table, fbx, glb, npz, usd, utd_mat
from engines.formats.files import atomic_path
from engines.formats.registry import Format, by_name, check_options, find_reader, find_writer
from engines.motion import Motion

_FORMATS: tuple[Format, ...] = (
    npz.FORMAT,
    amass.FORMAT,
    bvh.FORMAT,
    glb.FORMAT,
    usd.FORMAT,
    fbx.FORMAT,
    csv_table.FORMAT,
    amc.FORMAT,
    utd_mat.FORMAT,
)


def formats() -> tuple[Format, ...]:
    """All known formats: names, extensions, descriptions, and whether each reads and writes."""
    return _FORMATS


def read(path: str | Path, *, format: str | None = None, **options: Any) -> Motion:
    """Read a motion file.

    Args:
        path: the file.
        format: name of the format, where it is not to be told from the file.
        **options: those of the format's own reader, e.g. `scale` and `up` for BVH.

    Raises:
        FormatError: missing, damaged or of no known kind; the message says where and what is accepted.
        UnknownLabelError: no format is called `format`.
    """
    path = Path(path)
    kind = by_name(format, _FORMATS) if format else find_reader(path, _FORMATS)
    if kind.read is None:
        raise FormatError(path, f"format {kind.name!r} is written but not read.")
    check_options(path, kind, kind.read, options, given=1)
    return kind.read(path, **options)


def write(motion: Motion, path: str | Path, *, format: str | None = None, **options: Any) -> Path:
    """Write a motion to a file, beside and renamed, so that a failure leaves nothing and harms nothing.

    Args:
        motion: what to write.
        path: the file; its extension says the format.
        format: name of the format, where the extension does not say it (`"amass"` for an .npz).
        **options: those of the format's own writer.

    Returns:
        The path.

    Raises:
        FormatError: the extension is not known, or the file cannot be written.
        UnknownLabelError: no format is called `format`.
    """
    path = Path(path)
    kind = by_name(format, _FORMATS) if format else find_writer(path, _FORMATS)
    if kind.write is None:
        raise FormatError(path, f"format {kind.name!r} is read but not written.")
    check_options(path, kind, kind.write, options, given=2)
    return kind.write(motion, path, **options)


__all__ = ["Format", "atomic_path", "formats", "read", "write"]
