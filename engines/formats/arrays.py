"""Zip archives of NumPy arrays (.npz), read with nothing believed and nothing unpickled, written reproducibly."""

from __future__ import annotations

import io
import struct
import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np

from engines.errors import FormatError
from engines.formats.files import atomic_path, existing_file

MAX_ARRAY_BYTES = 512 * 2**20
"""No array that unpacks to more than this is read."""
MAX_DIRECTORY_BYTES = 2**20
"""No archive with a longer table of contents than this (some ten thousand entries) is opened."""
_MAX_HEADER = 10_000
_KINDS = "biufSU"
_END = b"PK\x05\x06"


def is_zip(head: bytes) -> bool:
    """Does a file that begins with `head` look like a zip archive?"""
    return head.startswith((b"PK\x03\x04", _END))


def names(path: Path) -> set[str]:
    """Names of the arrays in an archive; empty for anything else. Never raises."""
    try:
        with _opened(path) as archive:
            return {name.removesuffix(".npy") for name in archive.namelist() if name.endswith(".npy")}
    except FormatError:
        return set()


def load(path: Path, wanted: Iterable[str], data: bytes | None = None) -> dict[str, np.ndarray]:
    """Those of the wanted arrays that the archive holds; `data` is its content, where that is here already.

    Raises:
        FormatError: no zip archive, cut short, or an array that is damaged, pickled, or larger than
            `MAX_ARRAY_BYTES`.
    """
    with _opened(path, data) as archive:
        held = set(archive.namelist())
        return {name: _array(path, archive, name) for name in wanted if f"{name}.npy" in held}


def save(path: Path, arrays: Mapping[str, np.ndarray]) -> Path:
    """Write arrays to a compressed .npz, beside and renamed; the same arrays always give the same bytes.

    Raises:
        FormatError: the file cannot be written.
    """
    with atomic_path(path) as temporary, zipfile.ZipFile(temporary, "w") as archive:
        _fill(archive, arrays)
    return path


def pack(arrays: Mapping[str, np.ndarray]) -> bytes:
    """The bytes of the file that `save` writes."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        _fill(archive, arrays)
    return buffer.getvalue()


def _fill(archive: zipfile.ZipFile, arrays: Mapping[str, np.ndarray]) -> None:
    for name, values in arrays.items():
        buffer = io.BytesIO()
        np.lib.format.write_array(buffer, np.asarray(values), allow_pickle=False)
        entry = zipfile.ZipInfo(f"{name}.npy")  # dated 1980, unlike what numpy.savez writes
        entry.external_attr = 0o644 << 16
        archive.writestr(entry, buffer.getvalue(), zipfile.ZIP_DEFLATED, compresslevel=1)


def _opened(path: Path, data: bytes | None = None) -> zipfile.ZipFile:
    """The archive, once its table of contents is known to be small."""
    tail = _tail(path) if data is None else data[-(2**16) - 22 :]
    at = tail.rfind(_END)
    if at < 0 or len(tail) < at + 22:
        raise FormatError(path, "is no .npz, or is cut short: the table of contents at its end is missing.")
    (directory,) = struct.unpack_from("<I", tail, at + 12)
    if directory > MAX_DIRECTORY_BYTES:
        raise FormatError(path, f"its table of contents claims {directory:,} bytes; accepted: an .npz of arrays.")
    try:
        return zipfile.ZipFile(path if data is None else io.BytesIO(data))
    except Exception as error:  # zipfile raises what the damage happens to lead to
        raise FormatError(path, f"is no .npz that can be opened ({error}).") from error


def _tail(path: Path) -> bytes:
    """The end of a file, where a zip archive has its table of contents."""
    size = existing_file(path).stat().st_size
    try:
        with path.open("rb") as file:
            file.seek(max(size - 2**16 - 22, 0))
            return file.read()
    except OSError as error:
        raise FormatError(path, f"cannot be read: {error.strerror}.") from error


def _array(path: Path, archive: zipfile.ZipFile, name: str) -> np.ndarray:
    """One array; its claims about its size are checked against what is there."""
    claimed = archive.getinfo(f"{name}.npy").file_size
    if claimed > MAX_ARRAY_BYTES:
        raise FormatError(
            path, f"array {name!r} claims {claimed:,} bytes unpacked; accepted: at most {MAX_ARRAY_BYTES:,}."
        )
    try:
        return _decode(archive.read(f"{name}.npy"))
    except Exception as error:  # zlib, lzma, zipfile and NumPy's header parser each raise kinds of their own
        raise FormatError(path, f"array {name!r} cannot be read: {error}.") from error


def _decode(raw: bytes) -> np.ndarray:
    """An array from the bytes of a .npy file; never unpickles, never allocates more than is there."""
    version = np.lib.format.read_magic(io.BytesIO(raw[:8]))
    start = 10 if version == (1, 0) else 12
    length = int.from_bytes(raw[8:start], "little")
    if version not in ((1, 0), (2, 0), (3, 0)) or length > _MAX_HEADER:
        raise ValueError("an unknown .npy version, or a header too long")
    parse = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    shape, fortran, dtype = parse(io.BytesIO(raw[8 : start + length]), max_header_size=_MAX_HEADER)
    if dtype.kind not in _KINDS:
        raise ValueError(f"it holds {dtype}, not numbers or text (pickled objects are never read)")
    count = 1
    for size in shape:
        count *= size
    held = len(raw) - start - length
    if any(size < 0 for size in shape) or count * dtype.itemsize != held:
        raise ValueError(f"it claims shape {shape} of {dtype}, but holds {held:,} bytes")
    values = np.frombuffer(raw, dtype, count, start + length) if held else np.empty(count, dtype)
    return values.reshape(shape, order="F" if fortran else "C")
