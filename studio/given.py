"""A whole motion among the settings that say what is made of it.

    {"source": "take 2", "fps": 30.0, "frames": 90, "labels": [[0, 90, "action", "walk"]], "values": "eJxs..."}

`values` holds rotations and root path on smpl22 in steps of a millionth, packed, so that a settings file makes the same
motion again wherever it is taken.
"""

from __future__ import annotations

import base64
import binascii
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any, get_args

import numpy as np

from engines import SMPL22, Motion, Provenance, Segment
from engines.errors import OutOfRangeError, SkeletonError, UnknownLabelError
from engines.motion import LabelKind

LONGEST = 18_000
"""Frames."""
FARTHEST = 1000.0
"""Metres from the middle of the stage."""
_STEP = 1e-6
_COLUMNS = 4 * len(SMPL22) + 3


@dataclass(frozen=True)
class Given:
    """A motion on smpl22, as numbers."""

    values: str
    """Packed; see `_pack`."""
    frames: int
    fps: float
    source: str = ""
    """Where it comes from, in words: "take 2", "walk.bvh"."""
    labels: tuple[Segment, ...] = ()

    def __post_init__(self) -> None:
        whole = type(self.frames) is int and 1 <= self.frames <= LONGEST
        if not whole:
            raise OutOfRangeError("frames of the motion given", self.frames, f"1 to {LONGEST:,}")
        if not 1 <= self.fps <= 240:
            raise OutOfRangeError("fps of the motion given", self.fps, "1 to 240")
        object.__setattr__(self, "labels", tuple(self.labels))

    @classmethod
    def of(cls, motion: Motion, source: str = "", fps: float = 30.0) -> Given:
        """Any motion, brought to smpl22 and to a rate.

        Raises:
            SkeletonError: its skeleton has not the joints of a body.
            OutOfRangeError: it is too long, or goes farther than `FARTHEST`.
        """
        house = motion.retarget(SMPL22).resample(fps)
        reach = float(np.abs(house.translation).max())
        if reach > FARTHEST:
            raise OutOfRangeError(
                f"place of {source or 'the motion'}", f"{reach:,.0f} m away", f"up to {FARTHEST:,.0f} m from the middle"
            )
        rows = np.concatenate([house.rotations.reshape(len(house), -1), house.translation], axis=1)
        return cls(_pack(rows), len(house), fps, source, house.labels)

    @cached_property
    def motion(self) -> Motion:
        """The motion itself.

        Raises:
            OutOfRangeError: `values` do not hold so many frames of a body.
        """
        rows = _unpack(self.values, self.frames)
        turns, path = rows[:, :-3].reshape(self.frames, len(SMPL22), 4), rows[:, -3:]
        try:
            return Motion(SMPL22, turns, path, self.fps, self.labels, Provenance(self.source))
        except SkeletonError as problem:
            raise OutOfRangeError("values of the motion given", str(problem), "what the studio packed") from None

    def to_json(self) -> dict[str, Any]:
        """JSON values."""
        labels = [[label.start, label.end, label.kind, label.value] for label in self.labels]
        return {f.name: getattr(self, f.name) for f in fields(self)} | {"labels": labels}

    @classmethod
    def from_json(cls, tree: object) -> Given | None:
        """What `to_json` gave; None of nothing.

        Raises:
            OutOfRangeError: a value of the wrong kind, or values that are damaged.
            UnknownLabelError: a key that is not known.
        """
        if tree is None:
            return None
        if not isinstance(tree, Mapping):
            raise OutOfRangeError("the motion given", tree, "an object")
        known = [f.name for f in fields(cls)]
        for key in tree:
            if key not in known:
                raise UnknownLabelError("key of the motion given", key, known)
        for key, kinds in (("values", str), ("frames", int), ("fps", int | float), ("source", str), ("labels", list)):
            value = tree.get(key, "" if key == "source" else [] if key == "labels" else None)
            if isinstance(value, bool) or not isinstance(value, kinds):
                raise OutOfRangeError(f"{key} of the motion given", value, "what the studio wrote")
        made = cls(**{**tree, "labels": tuple(map(_label, tree.get("labels", ())))})
        made.motion  # noqa: B018 - said now, not when it is asked for
        return made


def _label(entry: object) -> Segment:
    kinds = get_args(LabelKind)
    match entry:
        case [int(start), int(end), str(kind), str(value)] if 0 <= start < end and kind in kinds:
            return Segment(start, end, kind, value)  # type: ignore[arg-type]
    raise OutOfRangeError("a label of the motion given", entry, '[first frame, one past the last, "action", name]')


def _pack(rows: np.ndarray) -> str:
    """(T, C) numbers as text: steps from frame to frame, bytes of like weight together, since these press well."""
    steps = np.diff(np.round(rows / _STEP).astype(np.int64), axis=0, prepend=0).astype("<i4")
    planes = np.ascontiguousarray(steps.T).view(np.uint8).reshape(-1, 4).T
    return base64.b64encode(zlib.compress(planes.tobytes(), 6)).decode("ascii")


def _unpack(text: str, frames: int) -> np.ndarray:
    """(T, C) of what `_pack` gave."""
    size = 4 * frames * _COLUMNS
    try:
        data = zlib.decompressobj().decompress(base64.b64decode(text, validate=True), size + 1)
    except (binascii.Error, ValueError, zlib.error):
        data = b""
    if len(data) != size:
        raise OutOfRangeError("values of the motion given", "damaged", f"{frames} frames as the studio packed them")
    planes = np.frombuffer(data, np.uint8).reshape(4, -1)
    steps = np.ascontiguousarray(planes.T).view("<i4").reshape(_COLUMNS, frames).T
    return np.cumsum(steps, axis=0, dtype=np.int64) * _STEP
