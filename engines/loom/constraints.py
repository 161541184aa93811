"""What a person pins before a motion is made: stretches and poses to keep, a path on the floor, joints at places.

Everything is in the world's metres. `compile_known` brings it into the frame of the motion's start and into the form
that the network is told; what nobody can do is answered in words, either refused or brought as near as it goes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
import torch
from torch import Tensor

from engines.errors import MotionloomError, OutOfRangeError, UnknownLabelError
from engines.features.codec import Start
from engines.loom.known import PARTS, Masks
from engines.loom.representation import ALONG, FREE, HELD, JOINTS, KNOWN, LAYOUT, Frames, frames_of
from engines.motion import Motion
from engines.skeletons import SMPL22

FASTEST = 7.0
"""Metres a second that a drawn path may ask for; faster ones are cut short."""
HIGHEST, LOWEST = 3.0, -0.25
"""Metres above the floor that a pinned joint may be at."""
_EASY = 1.2
"""Metres a second at which a pose far away is walked to, where nothing says where the motion begins."""
_SAME = 0.03
"""Metres within which two poses for one frame are the same."""


@dataclass(frozen=True)
class Keep:
    """Frames of a motion that are to appear as they are."""

    motion: Motion
    """On any skeleton and at any rate; one frame is a key pose."""
    at: int = 0
    """The frame of the new motion where its first frame goes."""
    parts: tuple[str, ...] = ()
    """Parts of the body that are kept, of `PARTS`; the whole of it, if none is named."""
    placed: bool = True
    """Whether where the body stands and faces is kept as well, or only the pose."""


@dataclass(frozen=True, eq=False)
class Path:
    """A line on the floor that the root follows."""

    points: np.ndarray
    """(N, 2) x and z, metres; N >= 2."""
    frames: tuple[int, ...] = ()
    """When each point is passed; if none, the line is followed at an even speed over the whole motion."""
    recorded: bool = False
    """It is the path of a motion there is, which was as fast as it was; a wish is held to what people can run."""


@dataclass(frozen=True)
class Pin:
    """A joint that is to be at a place."""

    joint: str
    """Of smpl22, other than the root."""
    frame: int
    position: tuple[float, float, float]
    """Metres."""
    until: int = 0
    """One past the last frame it stays there; only that one frame if 0."""


@dataclass(frozen=True)
class Constraints:
    """All that is pinned."""

    kept: tuple[Keep, ...] = ()
    path: Path | None = None
    pins: tuple[Pin, ...] = ()
    loop: bool = False
    """The motion ends as it began, so that it can be played round and round."""

    def __bool__(self) -> bool:
        return bool(self.kept or self.path is not None or self.pins or self.loop)


NOTHING = Constraints()


@dataclass
class Known:
    """Constraints in the form that the network is told."""

    facts: Tensor
    """(T, K) as `KNOWN` has it."""
    held: np.ndarray
    """(T, 2) how much place and facing count against velocity (`representation.travelled`)."""
    start: Start
    """Where in the world the first frame is."""
    unmet: list[str] = field(default_factory=list)
    """What could not be asked of anybody, and what is done instead."""


def compile_known(  # noqa: PLR0913, PLR0917 - how the network is told is the model's
    constraints: Constraints, frames: int, mean: np.ndarray, std: np.ndarray, facing: float = 0.0, fps: float = 20.0
) -> Known:
    """What the network is told for a motion of `frames` frames.

    Args:
        constraints: what is pinned.
        frames: T.
        mean: (D,) of the features.
        std: (D,) of the features.
        facing: how the body of this action faces beside the way it goes, radians (backward: pi).
        fps: of the motion.

    Raises:
        OutOfRangeError: a frame or a place that cannot be.
        MotionloomError: two constraints contradict each other.
    """
    unmet: list[str] = []
    kept = [_fitted(keep, frames, fps, unmet) for keep in constraints.kept]
    path = None if constraints.path is None else _timed(constraints.path, frames, fps, unmet)
    start = _start(kept, path, facing, fps)
    raw = np.zeros((frames, LAYOUT.size), dtype=np.float32)
    joints = np.zeros((frames, JOINTS - 1, 3), dtype=np.float32)
    masks = Masks.nothing(1, frames)
    for keep, found in kept:
        _put(keep, found, raw, masks, start)
    if path is not None:
        _follow(path, raw, masks, start)
    for pin in constraints.pins:
        _pin(pin, joints, masks, start, unmet)
    _reachable(raw, masks, fps, unmet)
    facts = np.zeros((frames, KNOWN.size), dtype=np.float32)
    normal = (raw - mean) / std
    for name in ("turns", "height", "ground", "facing"):
        mask = getattr(masks, name)[0].astype(np.float32)
        KNOWN.read(facts, name)[...] = LAYOUT.read(normal, name) * mask[..., None]
        KNOWN.read(facts, f"{name}_known")[...] = mask if name == "turns" else mask[..., None]
    KNOWN.read(facts, "joints")[...] = joints
    KNOWN.read(facts, "joints_known")[...] = masks.joints[0]
    return Known(torch.from_numpy(facts), _held(masks, path is not None), start, unmet)


def _fitted(keep: Keep, frames: int, fps: float, unmet: list[str]) -> tuple[Keep, Frames]:
    """On the house skeleton, at the rate, checked against the motion's length and the floor."""
    house = keep.motion.retarget(SMPL22)
    house = house if len(house) == 1 else house.resample(fps)
    if not 0 <= keep.at < frames:
        raise OutOfRangeError("frame of a kept pose", keep.at, f"0 to {frames - 1}, within the motion")
    for part in keep.parts:
        if part not in PARTS:
            raise UnknownLabelError("part of the body", part, PARTS)
    house = house[: frames - keep.at]
    low = float(house.positions[..., 1].min())
    if keep.placed and not LOWEST <= low <= HIGHEST:
        where = "under" if low < 0 else "above"
        unmet.append(f"The pose for frame {keep.at} is {abs(low):.1f} m {where} the floor; it was set on the floor.")
        house = house.moved((0.0, -low, 0.0))
    return Keep(house, keep.at, keep.parts, keep.placed), frames_of(house)


def _timed(path: Path, frames: int, fps: float, unmet: list[str]) -> tuple[np.ndarray, np.ndarray]:
    """Frames (N,) and places (N, 2) of a path, no faster than anybody runs."""
    points = np.asarray(path.points, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 2 or len(points) < 2 or not np.isfinite(points).all():
        raise OutOfRangeError("points of the path", points.shape, "two or more points, each x and z in metres")
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(lengths)])
    if path.frames:
        at = np.asarray(path.frames)
        if len(at) != len(points) or (np.diff(at) <= 0).any() or at[0] < 0 or at[-1] >= frames:
            raise OutOfRangeError(
                "frames of the path", list(path.frames), f"{len(points)} rising numbers from 0 to {frames - 1}"
            )
        speed = (lengths / np.diff(at)).max() * fps
        if speed > FASTEST and not path.recorded:
            raise MotionloomError(
                f"the path asks for {speed:.1f} m/s between two of its points; nobody here runs faster than "
                f"{FASTEST:g}. Give it more frames, or draw it shorter."
            )
        return at, points
    speed = along[-1] * fps / max(1, frames - 1)
    at = np.arange(frames)
    if speed > FASTEST:
        reach = FASTEST * (frames - 1) / fps
        unmet.append(
            f"The path is {along[-1]:.1f} m long, {speed:.1f} m/s; at {FASTEST:g} m/s it is followed for {reach:.1f} m."
        )
        along_now = np.linspace(0.0, reach, frames)
    else:
        along_now = np.linspace(0.0, along[-1], frames)
    places = np.stack([np.interp(along_now, along, points[:, axis]) for axis in range(2)], axis=-1)
    return at, places


def _start(
    kept: Sequence[tuple[Keep, Frames]], path: tuple[np.ndarray, np.ndarray] | None, facing: float, fps: float
) -> Start:
    """Where in the world the motion's first frame stands and faces."""
    for keep, found in kept:
        if keep.at == 0 and keep.placed and _stands(keep):
            return Start(float(found.yaw[0]), found.ground[0])
    if path is not None and path[0][0] == 0:
        _, points = path
        ahead = points[np.linalg.norm(points - points[0], axis=1) > 0.2]
        way = (ahead[0] if len(ahead) else points[-1]) - points[0]
        yaw = math.atan2(way[0], way[1]) - facing if np.linalg.norm(way) > 1e-6 else 0.0
        return Start(yaw, points[0])
    for keep, found in sorted(kept, key=lambda pair: pair[0].at):
        if keep.placed and _stands(keep):
            return _before(found, keep.at / fps)
    return Start()


def _stands(keep: Keep) -> bool:
    """Whether where the body stands is part of what is kept."""
    return not keep.parts or "lower body" in keep.parts


def _before(found: Frames, seconds: float) -> Start:
    """Where to begin so that a pose is reached in time: at the origin, or as near to it as a walk away."""
    place = found.ground[0].astype(np.float64)
    way = float(np.linalg.norm(place))
    if way <= _EASY * seconds:
        return Start()
    return Start(math.atan2(place[0], place[1]), place * (1 - _EASY * seconds / way))


def _seen(points: np.ndarray, start: Start) -> np.ndarray:
    """World places (..., 2) as seen from the start."""
    x, z = np.moveaxis(points - np.asarray(start.ground), -1, 0)
    cos, sin = np.cos(start.yaw), np.sin(start.yaw)
    return np.stack([cos * x - sin * z, sin * x + cos * z], axis=-1)


def _put(keep: Keep, found: Frames, raw: np.ndarray, masks: Masks, start: Start) -> None:
    """A kept stretch into the features."""
    rows = slice(keep.at, keep.at + len(found.yaw))
    joints = sorted({j for part in keep.parts for j in PARTS[part]}) if keep.parts else list(range(JOINTS))
    rooted = 0 in joints
    turned = found.yaw - start.yaw
    told = {
        "turns": found.turns, "height": found.height, "ground": _seen(found.ground, start),
        "facing": np.stack([np.cos(turned), np.sin(turned)], axis=-1),
    }  # fmt: skip
    before = masks.turns[0, rows][:, joints]
    twice = before.all(axis=1)
    if twice.any():
        gap = np.abs(LAYOUT.read(raw[rows], "turns") - found.turns)[twice][:, joints].max()
        if gap > 2 * _SAME:
            frame = keep.at + int(np.flatnonzero(twice)[0])
            raise MotionloomError(f"frame {frame} is to show two different poses; take one of them away.")
    LAYOUT.read(raw[rows], "turns")[:, joints] = told["turns"][:, joints]
    for joint in joints:
        masks.turns[0, rows, joint] = True
    if rooted:
        LAYOUT.read(raw[rows], "height")[...] = told["height"]
        masks.height[0, rows] = True
        if keep.placed:
            for name in ("ground", "facing"):
                LAYOUT.read(raw[rows], name)[...] = told[name]
                getattr(masks, name)[0, rows] = True


def _follow(path: tuple[np.ndarray, np.ndarray], raw: np.ndarray, masks: Masks, start: Start) -> None:
    """A path into the features, where no kept pose says otherwise."""
    at, points = path
    free = ~masks.ground[0, at]
    LAYOUT.read(raw, "ground")[at[free]] = _seen(points[free], start)
    masks.ground[0, at] = True


def _held(masks: Masks, along: bool) -> np.ndarray:
    """(T, 2) from what is known: frames of a path may be left a little, kept ones not."""
    posed = masks.turns[0].any(axis=-1) & masks.height[0]
    ground = np.where(masks.ground[0], np.where(posed | (not along), HELD, ALONG), FREE)
    ground[np.flatnonzero(masks.ground[0])[-1:]] = HELD  # a path is walked to its end
    return np.stack([ground, np.where(masks.facing[0], HELD, FREE)], axis=-1)


def _pin(pin: Pin, joints: np.ndarray, masks: Masks, start: Start, unmet: list[str]) -> None:
    if pin.joint not in SMPL22.joints[1:]:
        raise UnknownLabelError("joint to pin", pin.joint, SMPL22.joints[1:])
    end, frames = pin.until or pin.frame + 1, len(joints)
    if not 0 <= pin.frame < end <= frames:
        raise OutOfRangeError(f"frames of the pin of {pin.joint}", (pin.frame, end), f"from 0 to {frames}")
    if not all(map(math.isfinite, pin.position)):
        raise OutOfRangeError(f"place of {pin.joint}", pin.position, "three finite numbers, metres")
    x, y, z = pin.position
    if not 0 <= y <= HIGHEST:
        nearer = min(max(y, 0.0), HIGHEST)
        unmet.append(f"{words(pin.joint)} cannot be {y:.2f} m high; it was asked for {nearer:.2f} m.")
        y = nearer
    seen = _seen(np.array([x, z]), start)
    index = SMPL22.index(pin.joint) - 1
    joints[pin.frame : end, index] = (seen[0], y, seen[1])
    masks.joints[0, pin.frame : end, index] = True


def words(joint: str) -> str:
    """A joint's name for people: "left_wrist" -> "The left wrist"."""
    return f"The {joint.replace('_', ' ')}"


def _reachable(raw: np.ndarray, masks: Masks, fps: float, unmet: list[str]) -> None:
    """Say where places that are known are too far apart in time."""
    at = np.flatnonzero(masks.ground[0])
    places = LAYOUT.read(raw, "ground")
    for a, b in pairwise(at):
        speed = float(np.linalg.norm(places[b] - places[a])) * fps / (b - a)
        if speed > 1.3 * FASTEST:
            unmet.append(f"From frame {a} to {b} the body would move at {speed:.0f} m/s; expect a jump there.")
            return
