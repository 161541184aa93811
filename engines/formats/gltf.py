"""The container of glTF 2.0 binary files (.glb): a JSON document and one buffer, in and out, bounded and checked.

Written here rather than taken from a library: trimesh, which is at hand, knows neither skins nor animations, and the
container is 20 bytes of header. Nothing here knows what a motion is; `glb` and `glb_writer` do.
"""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np

from engines.errors import FormatError
from engines.formats.files import atomic_path

MAGIC = b"glTF"
_JSON, _BIN = 0x4E4F534A, 0x004E4942
_KINDS = {5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
"""Component types of accessors, by their numbers in the standard."""
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
MAX_TEXT_BYTES = 16 * 2**20
"""No longer description is read: Python's objects take twenty times the text."""
MAX_VALUES = 48_000_000
"""No more numbers are unpacked of one file, however often it refers to the same ones."""
VERTICES, INDICES = 34962, 34963
"""What a buffer view is for: vertex attributes, vertex indices."""


class Builder:
    """A glTF document in the making: append objects to `document`, arrays with `accessor`, then `save`."""

    def __init__(self) -> None:
        self.document: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": "motionloom"}, "bufferViews": [], "accessors": [],
        }  # fmt: skip
        self._binary = bytearray()

    def accessor(
        self, values: np.ndarray, kind: str, target: int | None = None, bounds: bool = False, normalised: bool = False
    ) -> int:
        """Append an array to the buffer.

        Args:
            values: (N,) or (N, width) of one of glTF's component types; (N, 16) column-major for MAT4.
            kind: SCALAR, VEC2, VEC3, VEC4 or MAT4.
            target: `VERTICES`, `INDICES`, or None.
            bounds: state the least and largest values, as the standard asks of times and vertex positions.
            normalised: integers that stand for 0 to 1.

        Returns:
            The accessor's index.
        """
        component = next(number for number, dtype in _KINDS.items() if values.dtype == dtype)
        data = np.ascontiguousarray(values)
        view = self.view(data.astype(data.dtype.newbyteorder("<"), copy=False).tobytes())
        if target is not None:
            self.document["bufferViews"][view]["target"] = target
        made: dict[str, Any] = {"bufferView": view, "componentType": component, "count": len(data), "type": kind}
        if normalised:
            made["normalized"] = True
        if bounds:
            rows = data.reshape(len(data), -1)
            made |= {"min": rows.min(axis=0).tolist(), "max": rows.max(axis=0).tolist()}
        self.document["accessors"].append(made)
        return len(self.document["accessors"]) - 1

    def view(self, data: bytes) -> int:
        """Append bytes to the buffer (a picture's, say); returns the index of the view of them."""
        self.document["bufferViews"].append({"buffer": 0, "byteOffset": len(self._binary), "byteLength": len(data)})
        self._binary += data + bytes(-len(data) % 4)
        return len(self.document["bufferViews"]) - 1

    def save(self, path: Path) -> Path:
        """Write the file, beside and renamed.

        Raises:
            FormatError: it cannot be written.
        """
        document = {**self.document, "buffers": [{"byteLength": len(self._binary)}]}
        text = json.dumps(document, ensure_ascii=False, separators=(",", ":"), allow_nan=False).encode("utf-8")
        text += b" " * (-len(text) % 4)
        total = 12 + 8 + len(text) + 8 + len(self._binary)
        with atomic_path(path) as temporary, temporary.open("wb") as file:
            file.write(MAGIC + struct.pack("<II", 2, total))
            file.write(struct.pack("<II", len(text), _JSON) + text)
            file.write(struct.pack("<II", len(self._binary), _BIN))
            file.write(self._binary)
        return path


class Gltf:
    """The content of a .glb file: its document, and the arrays that the document describes.

    Raises:
        FormatError: no .glb, of another version, or damaged.
    """

    def __init__(self, path: Path, data: bytes) -> None:
        self.path, self._unpacked = path, 0
        self._checked: dict[str, list[dict[str, Any]]] = {}
        text, self._binary = _chunks(path, data)
        if len(text) > MAX_TEXT_BYTES:
            raise FormatError(path, f"has a description of {len(text):,} bytes; accepted: {MAX_TEXT_BYTES:,}.")
        try:
            self.document = json.loads(text.decode("utf-8"))
        except (ValueError, RecursionError) as error:
            raise FormatError(path, f"its description is no JSON ({str(error)[:200]}).") from error
        if not isinstance(self.document, dict):
            raise FormatError(path, "its description is no JSON object.")

    def items(self, name: str) -> list[dict[str, Any]]:
        """One of the document's lists of objects ("nodes", "skins", ...); empty where there is none.

        Raises:
            FormatError: it is no list of objects.
        """
        if name not in self._checked:  # once: files have been seen that refer to theirs a hundred thousand times
            found = self.document.get(name, [])
            if not isinstance(found, list) or not all(isinstance(item, dict) for item in found):
                raise FormatError(self.path, f"its {name!r} are no list of objects.")
            self._checked[name] = found
        return self._checked[name]

    def item(self, name: str, index: object) -> dict[str, Any]:
        """One object of such a list.

        Raises:
            FormatError: there is none of that number.
        """
        found = self.items(name)
        if not isinstance(index, int) or isinstance(index, bool) or not 0 <= index < len(found):
            raise FormatError(self.path, f"refers to number {index!r:.40} of {len(found)} {name}.")
        return found[index]

    def stored(self, view: object) -> bytes:
        """The bytes of a buffer view: a picture, say.

        Raises:
            FormatError: there is no such view in this file.
        """
        held = self._view(view)
        start, length = _natural(held, "byteOffset"), _natural(held, "byteLength")
        if start + length > len(self._binary):
            raise FormatError(self.path, f"has {length:,} bytes of something that reach beyond the file's data.")
        return self._binary[start : start + length]

    def array(self, index: object) -> np.ndarray:
        """The values of an accessor, (N,) or (N, width) float64; integers that stand for fractions are these.

        Raises:
            FormatError: it does not exist, reaches beyond the buffer, or is of a form that is not read.
        """
        accessor = self.item("accessors", index)
        component, width = accessor.get("componentType"), _WIDTHS.get(str(accessor.get("type")), 0)
        if not isinstance(component, int) or component not in _KINDS or not width:
            raise FormatError(self.path, "has an array of a type that glTF does not have.")
        dtype = np.dtype(_KINDS[component]).newbyteorder("<")
        if "sparse" in accessor or "bufferView" not in accessor:
            raise FormatError(self.path, "has sparse or compressed arrays; accepted: plain ones. Export without them.")
        values = self._values(accessor, self._view(accessor["bufferView"]), dtype, width)
        if accessor.get("normalized") and dtype.kind in "iu":
            values = np.maximum(values / float(np.iinfo(dtype).max), -1.0)
        return values[:, 0] if width == 1 else values

    def _view(self, index: object) -> dict[str, Any]:
        """A view of the file's own buffer."""
        view = self.item("bufferViews", index)
        if view.get("buffer") != 0 or "uri" in self.item("buffers", 0) or "extensions" in view:
            raise FormatError(self.path, "keeps its data outside the file or compressed; accepted: one plain .glb.")
        return view

    def _values(self, accessor: dict, view: dict, dtype: np.dtype, width: int) -> np.ndarray:
        """(N, width) float64, once it is known that all of it lies in the buffer."""
        start, count, row = _natural(view, "byteOffset"), _natural(accessor, "count"), dtype.itemsize * width
        start, stride = start + _natural(accessor, "byteOffset"), _natural(view, "byteStride") or row
        end = min(_natural(view, "byteOffset") + _natural(view, "byteLength"), len(self._binary))
        if stride < row or count == 0 or start + stride * (count - 1) + row > end:
            raise FormatError(self.path, f"has an array of {count:,} values that reaches beyond the file's data.")
        self._unpacked += count * width
        if self._unpacked > MAX_VALUES:
            raise FormatError(self.path, f"holds too much to read; accepted: {MAX_VALUES:,} numbers in its animation.")
        shaped = np.ndarray((count, width), dtype, self._binary, start, (stride, dtype.itemsize))
        return shaped.astype(np.float64)


def _natural(held: dict, key: str) -> int:
    """A count or place; what is none counts as beyond every buffer, so that it is refused there."""
    value = held.get(key, 0)
    good = isinstance(value, int) and not isinstance(value, bool) and 0 <= value < 2**40
    return value if good else 2**40


def _chunks(path: Path, data: bytes) -> tuple[bytes, bytes]:
    """The JSON text and the buffer of a .glb."""
    if len(data) < 20 or data[:4] != MAGIC:
        raise FormatError(path, "is no .glb; accepted: glTF 2.0 in its binary form, which begins with 'glTF'.")
    version, total = struct.unpack_from("<II", data, 4)
    if version != 2:
        raise FormatError(path, f"is glTF of version {version}; accepted: 2.")
    if total > len(data):
        raise FormatError(path, f"breaks off after {len(data):,} of {total:,} bytes.")
    at, found = 12, {}
    while at + 8 <= total:
        length, kind = struct.unpack_from("<II", data, at)
        if at + 8 + length > total:
            raise FormatError(path, f"has a part of {length:,} bytes that reaches beyond the file's end.")
        found.setdefault(kind, data[at + 8 : at + 8 + length])
        at += 8 + length
    if _JSON not in found:
        raise FormatError(path, "has no description (JSON) in it.")
    return found[_JSON], found.get(_BIN, b"")
