"""Acclaim skeletons (.asf), as the CMU and HDM05 motion capture sets have them: the text, parsed line by line.

A bone is a straight line that begins where its parent ends. `amc` makes a Motion of it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

from engines.errors import FormatError
from engines.formats.files import MAX_JOINTS, check_size, read_bytes

MAX_BYTES = 8 * 2**20
"""No longer skeleton is read."""
ROOT = "root"
"""Name of the root, which is no bone."""


@dataclass
class Bone:
    """One bone, in the file's units and degrees; the root is one of no length."""

    name: str
    """What the motion's lines begin with."""
    direction: tuple[float, ...] = (0.0, 0.0, 0.0)
    """(3,) unit vector from its start to its end, in the rest pose, world axes."""
    length: float = 0.0
    """From start to end."""
    axis: tuple[float, ...] = (0.0, 0.0, 0.0)
    """Angles of the frame in which it turns, against the world's axes."""
    axis_order: str = "XYZ"
    """Axes of these angles, the first turned about first."""
    channels: tuple[str, ...] = ()
    """What the motion gives for it, in order: tx, ty, tz, rx, ry, rz or l."""
    parent: str = ""
    """Name of the bone it hangs from; empty for the root."""


@dataclass(frozen=True)
class Acclaim:
    """An Acclaim skeleton: its bones by name, the root first, parents before children."""

    bones: dict[str, Bone]
    """By name."""
    radians: bool
    """Angles are in radians rather than degrees."""
    place: tuple[float, ...]
    """(3,) where the root stands before it moves."""


def parse(path: Path) -> Acclaim:
    """Parse an .asf.

    Raises:
        FormatError: missing, damaged or no .asf; the message names the line.
    """
    return _Reader(path).read()


class _Reader:
    """One pass over the lines; what a line means depends on the section it lies in."""

    def __init__(self, path: Path) -> None:
        self.path, self.number, self.section = path, 0, ""
        self.bones: dict[str, Bone] = {ROOT: Bone(ROOT)}
        self.radians, self.place = False, (0.0, 0.0, 0.0)
        self.bone: Bone | None = None
        self.parents: dict[str, str] = {}

    def read(self) -> Acclaim:
        sections = {
            "units": self._units, "root": self._root, "bonedata": self._bonedata, "hierarchy": self._hierarchy,
        }  # fmt: skip
        found = set()
        text = read_bytes(self.path, MAX_BYTES).decode("utf-8", "replace")
        for self.number, line in enumerate(text.splitlines(), start=1):
            words = line.split()
            if not words or words[0].startswith("#"):
                continue
            if words[0].startswith(":"):
                self.section = words[0][1:].lower()
                found.add(self.section)
            elif self.section in sections:
                sections[self.section](words)
            elif not found:
                raise self._wrong("is no .asf; accepted: an Acclaim skeleton, which begins with ':version'.")
        for needed in ("root", "bonedata", "hierarchy"):
            if needed not in found:
                raise FormatError(self.path, f"has no section ':{needed}'; accepted: a whole Acclaim skeleton.")
        return Acclaim(self._ordered(), self.radians, self.place)

    def _wrong(self, problem: str) -> FormatError:
        return FormatError(self.path, problem, self.number)

    def _numbers(self, words: list[str], count: int) -> tuple[float, ...]:
        try:
            values = tuple(float(word) for word in words[:count])
        except ValueError:
            values = ()
        if len(values) != count or not all(math.isfinite(value) for value in values):
            raise self._wrong(f"holds {' '.join(words)!r:.80}; accepted: {count} numbers.")
        return values

    def _order(self, word: str) -> str:
        order = word.upper()
        if sorted(order) != ["X", "Y", "Z"]:
            raise self._wrong(f"has the axes {word!r:.40}; accepted: X, Y and Z in some order.")
        return order

    def _channels(self, words: list[str]) -> tuple[str, ...]:
        channels = tuple(word.lower() for word in words)
        if len(set(channels)) != len(channels) or not set(channels) <= {"tx", "ty", "tz", "rx", "ry", "rz", "l"}:
            raise self._wrong(
                f"has the channels {' '.join(words)!r:.80}; accepted: tx, ty, tz, rx, ry, rz, l, each once."
            )
        return channels

    def _units(self, words: list[str]) -> None:
        if words[0].lower() == "angle" and len(words) > 1:
            self.radians = words[1].lower().startswith("rad")

    def _root(self, words: list[str]) -> None:
        root, key = self.bones[ROOT], words[0].lower()
        if key == "order":
            root.channels = self._channels(words[1:])
        elif key == "axis" and len(words) > 1:
            root.axis_order = self._order(words[1])
        elif key == "position":
            self.place = self._numbers(words[1:], 3)
        elif key == "orientation":
            root.axis = self._numbers(words[1:], 3)

    def _bonedata(self, words: list[str]) -> None:
        key = words[0].lower()
        if key == "begin":
            self.bone = Bone("")
        elif self.bone is None:
            raise self._wrong(f"has {words[0]!r:.40} outside 'begin' and 'end'.")
        elif key == "end":
            self._finish(self.bone)
        elif key == "name" and len(words) > 1:
            self.bone.name = words[1]
        elif key == "direction":
            self.bone.direction = self._numbers(words[1:], 3)
        elif key == "length":
            self.bone.length = self._numbers(words[1:], 1)[0]
        elif key == "axis":
            self.bone.axis = self._numbers(words[1:], 3)
            self.bone.axis_order = self._order(words[4] if len(words) > 4 else "XYZ")
        elif key == "dof":
            self.bone.channels = self._channels(words[1:])

    def _finish(self, bone: Bone) -> None:
        if not bone.name or bone.name in self.bones:
            raise self._wrong(f"ends a bone that has {'the name of another' if bone.name else 'no name'}.")
        check_size(self.path, 0, len(self.bones) + 1, self.number)
        self.bones[bone.name] = bone
        self.bone = None

    def _hierarchy(self, words: list[str]) -> None:
        if words[0].lower() in ("begin", "end") and len(words) == 1:
            return
        for name in words:
            if name not in self.bones:
                raise self._wrong(f"names {name!r:.80}, which is no bone of the file.")
        for child in words[1:]:
            if child in self.parents or child == ROOT:
                raise self._wrong(f"hangs {child!r:.80} from {words[0]!r:.80}, but it hangs elsewhere or is the root.")
            self.parents[child] = words[0]
            self.bones[child].parent = words[0]

    def _ordered(self) -> dict[str, Bone]:
        """Bones below the root, parents first, in the file's order."""
        children: dict[str, list[str]] = {}
        for name in self.bones:
            if name in self.parents:
                children.setdefault(self.parents[name], []).append(name)
        order, stack = [], [ROOT]
        while stack:
            name = stack.pop()
            order.append(name)
            stack.extend(reversed(children.get(name, [])))
        loose = next((name for name in self.bones if name not in set(order)), None)
        if loose is not None or len(order) > MAX_JOINTS:
            raise FormatError(self.path, f"bone {loose!r:.80} does not hang from the root.")
        return {name: self.bones[name] for name in order}
