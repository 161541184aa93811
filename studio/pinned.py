"""What a person pins before a motion is made, as settings files hold it and as the app lists it.

    {"kept": [{"source": "take 2", "start": 30, "at": 30, "rotations": [...], "translation": [...]}],
     "path": [[0, 0], [1.5, 2]], "pins": [{"joint": "left_wrist", "frame": 40, "position": [0.3, 1.2, 0.4]}],
     "loop": false}

Poses are on smpl22 at the rate of the engine; metres and frames. Numbers only, so that a settings file makes the same
motion again wherever it is taken.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from engines import SMPL22, Motion
from engines.errors import MotionloomError, OutOfRangeError, UnknownLabelError

if TYPE_CHECKING:
    from engines.loom.constraints import Constraints

SHORTEST_PATH = 0.3
"""Metres; a shorter line is no way to go."""
FARTHEST = 100.0
"""Metres from the middle of the stage within which things are pinned."""
MOST_POINTS = 200
JOINTS = SMPL22.joints[1:]
"""Joints that can be pinned."""
_DECIMALS = 6

Turns = tuple[tuple[tuple[float, ...], ...], ...]
Places = tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class Kept:
    """Frames that are to appear as they are; a single one is a key pose."""

    rotations: Turns
    """(T, 22, 4) unit quaternions wxyz on smpl22."""
    translation: Places
    """(T, 3) root, metres."""
    at: int = 0
    """Frame of the new motion where the first of them goes."""
    start: int = 0
    """Frame of the first of them in the motion they come from, at the same rate."""
    source: str = ""
    """That motion, in words: "take 2", "walk.bvh"."""
    parts: tuple[str, ...] = ()
    """Parts of the body that are kept; all of it if none is named."""
    placed: bool = True
    """Whether they also stand where they stood."""

    def __post_init__(self) -> None:
        turns = _numbers("rotations of kept frames", self.rotations, (None, len(SMPL22), 4))
        path = _numbers("translation of kept frames", self.translation, (len(turns), 3))
        _whole("frame of a kept pose", self.at, 0)
        _whole("first kept frame", self.start, 0)
        if (np.linalg.norm(turns, axis=-1) < 0.5).any():
            raise OutOfRangeError("rotations of kept frames", "zero quaternions", "unit quaternions wxyz")
        object.__setattr__(self, "rotations", _tuples(turns))
        object.__setattr__(self, "translation", _tuples(path))
        object.__setattr__(self, "parts", tuple(self.parts))

    @classmethod
    def of(cls, motion: Motion, start: int, stop: int, at: int, source: str = "", fps: float = 20.0) -> Kept:  # noqa: PLR0913, PLR0917
        """Frames [start, stop) of a motion, counted at `fps` on any skeleton."""
        house = motion.retarget(SMPL22).resample(fps)
        if not 0 <= start < stop <= len(house):
            shown = f"{start}" if stop == start + 1 else f"{start} to {stop - 1}"
            raise OutOfRangeError(f"frame of {source or 'the motion'}", shown, f"0 to {len(house) - 1}")
        cut = house[start:stop]
        return cls(
            _tuples(cut.rotations.round(_DECIMALS)), _tuples(cut.translation.round(_DECIMALS)), at, start, source
        )

    def __len__(self) -> int:
        return len(self.rotations)

    def motion(self, fps: float) -> Motion:
        """The frames as a motion."""
        return Motion(SMPL22, np.array(self.rotations), np.array(self.translation), fps)

    def words(self, fps: float) -> str:
        """Plain words: "pose of take 2 at 1.5 s", "frames 0–20 of take 1"."""
        name = self.source or "a motion"
        only = f" ({', '.join(self.parts)} only)" if self.parts else ""
        if len(self) == 1:
            own = "" if self.start == self.at else f" (its {self.start / fps:.1f} s)"
            return f"pose of {name}{own} at {self.at / fps:.1f} s{only}"
        moved = "" if self.start == self.at else f", from {self.at / fps:.1f} s on"
        return f"frames {self.start}–{self.start + len(self) - 1} of {name}{moved}{only}"


@dataclass(frozen=True)
class JointPin:
    """A joint that is to be at a place at a time."""

    joint: str
    """Of smpl22, other than the root."""
    frame: int
    position: tuple[float, float, float]
    """Metres."""
    until: int = 0
    """One past the last frame it stays there; that one frame only if 0."""

    def __post_init__(self) -> None:
        if self.joint not in JOINTS:
            raise UnknownLabelError("joint to pin", self.joint, JOINTS)
        _whole(f"frame of the pin of {self.joint}", self.frame, 0)
        _whole(f"end of the pin of {self.joint}", self.until, 0)
        place = _numbers(f"place of {self.joint}", self.position, (3,))
        object.__setattr__(self, "position", tuple(float(x) for x in place))

    def words(self, fps: float) -> str:
        """Plain words: "left wrist at 2.0 s"."""
        until = f"–{(self.until - 1) / fps:.1f}" if self.until > self.frame + 1 else ""
        return f"{self.joint.replace('_', ' ')} at {self.frame / fps:.1f}{until} s"


@dataclass(frozen=True)
class Pinned:
    """All that is pinned."""

    kept: tuple[Kept, ...] = ()
    path: Places = ()
    """Points (N, 2) of a line on the floor, x and z, metres; empty: none."""
    pins: tuple[JointPin, ...] = ()
    loop: bool = False
    """The motion is to end as it began."""

    def __post_init__(self) -> None:
        if self.path:
            object.__setattr__(self, "path", _path(self.path))

    def __bool__(self) -> bool:
        return bool(self.kept or self.path or self.pins or self.loop)

    @property
    def length(self) -> float:
        """Metres of the path."""
        return float(sum(math.dist(a, b) for a, b in pairwise(self.path)))

    def listed(self, fps: float) -> list[tuple[str, str]]:
        """(key, words) of everything but the loop; the key is what `without` takes."""
        found = [(f"kept {i}", kept.words(fps)) for i, kept in enumerate(self.kept)]
        found += [("path", f"path of {self.length:.1f} m")] if self.path else []
        return found + [(f"pin {i}", pin.words(fps)) for i, pin in enumerate(self.pins)]

    def without(self, key: str) -> Pinned:
        """All but what is listed under a key."""
        kind, _, number = key.partition(" ")
        if kind == "path":
            return replace(self, path=())
        name = {"kept": "kept", "pin": "pins"}.get(kind)
        if name is None or not number.isdigit():
            return self
        return replace(self, **{name: tuple(x for i, x in enumerate(getattr(self, name)) if i != int(number))})

    def with_kept(self, kept: Kept) -> Pinned:
        """With a pose or a stretch; one of the same kind at the same time gives way."""
        same = [k for k in self.kept if k.at == kept.at and (len(k) > 1) == (len(kept) > 1)]
        return replace(self, kept=(*(k for k in self.kept if k not in same), kept))

    def with_pin(self, pin: JointPin) -> Pinned:
        """With a joint pinned; another place of it at that frame gives way."""
        others = (p for p in self.pins if (p.joint, p.frame) != (pin.joint, pin.frame))
        return replace(self, pins=(*others, pin))

    def problem(self, frames: int, fps: float) -> str:
        """Why this cannot be asked of a motion of so many frames, in words; empty when it can."""
        for kept in self.kept:
            if kept.at >= frames:
                return f"The {kept.words(fps)} lies behind the end of the motion at {frames / fps:.1f} s."
            if len(kept) >= frames - kept.at and kept.at == 0 and not kept.parts:
                return f"All {frames} frames are kept; make the motion longer, or keep fewer."
        for pin in self.pins:
            if max(pin.frame + 1, pin.until) > frames:
                return f"The pin of {pin.words(fps)} lies behind the end of the motion at {frames / fps:.1f} s."
        return ""

    def to_json(self) -> dict[str, Any]:
        """JSON values; what is not pinned is left out."""
        tree: dict[str, Any] = {}
        if self.kept:
            tree["kept"] = [_tree(kept) for kept in self.kept]
        if self.path:
            tree["path"] = _lists(self.path)
        if self.pins:
            tree["pins"] = [_tree(pin) for pin in self.pins]
        return tree | {"loop": True} if self.loop else tree

    @classmethod
    def from_json(cls, tree: object) -> Pinned:
        """What `to_json` gave.

        Raises:
            OutOfRangeError: a value of the wrong kind or shape.
            UnknownLabelError: a key or a joint that is not known.
        """
        tree = _object("constraints", tree, cls)
        loop = tree.get("loop", False)
        if not isinstance(loop, bool):
            raise OutOfRangeError("constraints.loop", loop, "true or false")
        kept = tuple(_made(Kept, "kept", entry) for entry in _list("constraints.kept", tree.get("kept", [])))
        pins = tuple(_made(JointPin, "pins", entry) for entry in _list("constraints.pins", tree.get("pins", [])))
        return cls(kept, tuple(_list("constraints.path", tree.get("path", []))), pins, loop)

    def to_engine(self, fps: float) -> Constraints:
        """The form that engines take."""
        from engines.loom.constraints import Constraints, Keep, Path, Pin

        kept = tuple(Keep(k.motion(fps), k.at, k.parts, k.placed) for k in self.kept)
        pins = tuple(Pin(p.joint, p.frame, p.position, p.until) for p in self.pins)
        return Constraints(kept, Path(np.array(self.path)) if self.path else None, pins, self.loop)


# ---- checks and JSON --------------------------------------------------------------------------------------


def _path(points: Sequence[Sequence[float]]) -> Places:
    found = _numbers("points of the path", points, (None, 2))
    length = float(np.linalg.norm(np.diff(found, axis=0), axis=1).sum())
    if len(found) < 2 or length < SHORTEST_PATH:
        raise OutOfRangeError("length of the path", f"{length:.2f} m", f"{SHORTEST_PATH:g} m or more")
    if len(found) > MOST_POINTS:
        raise OutOfRangeError("number of points of the path", len(found), f"up to {MOST_POINTS}")
    return tuple((float(x), float(z)) for x, z in found)


def _numbers(name: str, value: object, shape: tuple[int | None, ...]) -> np.ndarray:
    wanted = " × ".join("any number of" if size is None else str(size) for size in shape)
    try:
        found = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise OutOfRangeError(name, "not a table of numbers", f"{wanted} numbers") from None
    if found.ndim != len(shape) or any(size not in (None, own) for own, size in zip(found.shape, shape, strict=True)):
        raise OutOfRangeError(name, " × ".join(map(str, found.shape)) + " numbers", f"{wanted} numbers")
    if found.size == 0 or not np.isfinite(found).all() or np.abs(found).max() > FARTHEST:
        raise OutOfRangeError(name, "empty or beyond", f"finite numbers, at most {FARTHEST:g} m from the middle")
    return found


def _whole(name: str, value: object, low: int) -> None:
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < low:
        raise OutOfRangeError(name, value, f"a whole number from {low} on")


def _tuples(array: Any) -> Any:
    return tuple(map(_tuples, array.tolist() if isinstance(array, np.ndarray) else array)) if np.ndim(array) else array


def _lists(value: Any) -> Any:
    return [_lists(item) for item in value] if isinstance(value, tuple) else value


def _tree(entry: Any) -> dict[str, Any]:
    """The fields of an entry that are not at their defaults."""
    return {f.name: _lists(getattr(entry, f.name)) for f in fields(entry) if getattr(entry, f.name) != f.default}


def _list(name: str, value: object) -> list:
    if not isinstance(value, list):
        raise OutOfRangeError(name, value, "a list")
    return value


def _object(name: str, tree: object, kind: type) -> Mapping[str, Any]:
    if not isinstance(tree, Mapping):
        raise OutOfRangeError(name, tree, "an object")
    known = [f.name for f in fields(kind)]
    for key in tree:
        if key not in known:
            raise UnknownLabelError(f"key of {name}", key, known)
    return tree


def _made(kind: Callable[..., Any], name: str, tree: object) -> Any:
    given = dict(_object(f"constraints.{name}", tree, kind))  # type: ignore[arg-type]
    for key, wanted in (("source", str), ("placed", bool), ("parts", list), ("joint", str)):
        if key in given and not isinstance(given[key], wanted):
            raise OutOfRangeError(f"constraints.{name}.{key}", given[key], f"a value of kind {wanted.__name__}")
    try:
        return kind(**given)
    except TypeError as problem:
        raise MotionloomError(f"constraints.{name}: {problem}") from None


NOTHING = Pinned()
"""Nothing pinned."""
