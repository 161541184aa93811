"""Numeric arrays from MATLAB 5 files (.mat as MATLAB 5 to 7.2 save them).

Written here because `scipy.io.loadmat` crashes the whole process on some damaged files, which a program that takes
files from anyone cannot have. Only dense real numeric arrays are read; nothing is allocated on a file's word.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from math import prod

import numpy as np

HEADER_BYTES = 128
_MATRIX, _COMPRESSED = 14, 15
_STORED = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
_CLASSES = {
    1: "cell", 2: "struct", 3: "object", 4: "char", 5: "sparse", 6: "double", 7: "single", 8: "int8", 9: "uint8",
    10: "int16", 11: "uint16", 12: "int32", 13: "uint32", 14: "int64", 15: "uint64", 16: "function", 17: "opaque",
}  # fmt: skip
_NUMERIC = set(range(6, 16))
_COMPLEX = 0x0800
_PREAMBLE = 4096
"""Bytes of a packed variable that are unpacked to learn its name and shape."""
_MOST_VARIABLES = 1000


@dataclass(frozen=True)
class Variable:
    """What a file says of one of its variables; `array` reads it."""

    name: str
    shape: tuple[int, ...]
    kind: str
    """MATLAB's class: double, single, char, cell, ..."""
    is_complex: bool
    _body: bytes = field(repr=False)
    _packed: bool
    _order: str

    def __str__(self) -> str:
        return f"{self.name} {' x '.join(map(str, self.shape))} {self.kind}"

    def array(self) -> np.ndarray:
        """The values, float64 for "double" and so on; the caller has judged `shape`.

        Raises:
            ValueError: no real numeric array, damaged, or not as large as its shape.
        """
        code = next(code for code, kind in _CLASSES.items() if kind == self.kind)
        if code not in _NUMERIC or self.is_complex:
            raise ValueError(f"{self.name} is {'complex' if self.is_complex else self.kind}, not real numbers")
        count = prod(self.shape)
        body = self._body
        if self._packed:
            body = _unpack(body, count * 8 + _PREAMBLE, whole=True)[8:]
        parts = list(_elements(body, self._order, most=4))
        if len(parts) < 4 or parts[3][0] not in _STORED:
            raise ValueError(f"the values of {self.name} are missing")
        stored = np.dtype(self._order + _STORED[parts[3][0]])
        if len(parts[3][1]) != count * stored.itemsize:
            raise ValueError(f"{self} holds {len(parts[3][1]):,} bytes of {stored.name} values")
        values = np.frombuffer(parts[3][1], stored, count)
        return values.astype(np.dtype(self.kind), copy=False).reshape(self.shape, order="F")


def variables(data: bytes) -> list[Variable]:
    """The named variables of a file.

    Raises:
        ValueError: no MATLAB 5 file, or damaged.
    """
    order = {b"IM": "<", b"MI": ">"}.get(data[126:128])
    if not data.startswith(b"MATLAB 5.0 MAT-file") or order is None or len(data) <= HEADER_BYTES:
        newer = " (a 7.3 file; save it with -v7)" if data.startswith(b"MATLAB 7.3") else ""
        raise ValueError(f"it does not begin as a MATLAB 5 file{newer}")
    found = []
    for kind, body in _elements(data[HEADER_BYTES:], order, most=_MOST_VARIABLES):
        if kind == _COMPRESSED:
            found.append(_variable(body, order, packed=True))
        elif kind == _MATRIX:
            found.append(_variable(body, order, packed=False))
    return found


def _variable(body: bytes, order: str, packed: bool) -> Variable:
    """Name, shape and class from the first three parts of a matrix."""
    start = body
    if packed:
        start = _unpack(body, _PREAMBLE)
        if len(start) < 8 or struct.unpack_from(order + "I", start)[0] != _MATRIX:
            raise ValueError("a packed variable is no matrix")
        start = start[8:]
    parts = list(_elements(start[:_PREAMBLE], order, most=3))
    if len(parts) < 3 or len(parts[0][1]) != 8 or [part[0] for part in parts] != [6, 5, 1]:
        raise ValueError("a variable's name and shape are damaged")
    flags = struct.unpack_from(order + "I", parts[0][1])[0]
    shape = tuple(int(size) for size in np.frombuffer(parts[1][1][: len(parts[1][1]) // 4 * 4], order + "i4"))
    kind = _CLASSES.get(flags & 0xFF)
    if kind is None or not 2 <= len(shape) <= 32 or min(shape) < 0:
        raise ValueError("a variable's class or shape is damaged")
    name = parts[2][1].decode("latin-1")
    return Variable(name[:64], shape, kind, bool(flags & _COMPLEX), body, packed, order)


def _elements(data: bytes, order: str, most: int) -> Iterator[tuple[int, bytes]]:
    """(type, bytes) of the data elements one after the other, at most `most`; short ones sit in their own tag."""
    at = 0
    for _ in range(most):
        if at + 8 > len(data):
            return
        kind, size = struct.unpack_from(order + "II", data, at)
        if kind >> 16:
            kind, size, start, at = kind & 0xFFFF, kind >> 16, at + 4, at + 8
            if size > 4:
                raise ValueError("a short element is longer than four bytes")
        else:
            start = at + 8
            at = start + size if kind == _COMPRESSED else start + size + -size % 8
        if start + size > len(data):
            raise ValueError("it is cut short")
        yield kind, data[start : start + size]


def _unpack(body: bytes, most: int, whole: bool = False) -> bytes:
    """At most `most` bytes of what is packed in `body`; if `whole`, that must be all of it."""
    unpacker = zlib.decompressobj()
    try:
        data = unpacker.decompress(body, most)
    except zlib.error as error:
        raise ValueError(f"a packed variable is damaged: {error}") from error
    if whole and not unpacker.eof:
        raise ValueError("a packed variable is cut short, or longer than its shape says")
    return data
