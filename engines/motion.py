"""Motion: the one value that flows through the whole program.

NumPy only. Every engine, reader, viewer and exporter speaks it; none speaks to another directly.
"""

from __future__ import annotations

import copy
import logging
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from importlib.metadata import EntryPoint, distributions
from pathlib import Path
from typing import Any, Literal

import numpy as np
from jaxtyping import Bool, Float

from engines.errors import MotionloomError, OutOfRangeError, SkeletonError
from engines.geometry import contacts as foot_contacts
from engines.geometry import kinematics, resample, rotations
from engines.skeletons.skeleton import Skeleton

log = logging.getLogger(__name__)

PICTURES = "motionloom.pictures"
"""Entry points that make a picture (PNG) of a Motion: engines know no viewer, but a notebook shows one."""
LabelKind = Literal["action", "transition", "text", "style"]


@dataclass(frozen=True)
class Segment:
    """A labelled stretch of frames."""

    start: int
    """First frame."""
    end: int
    """One past the last frame."""
    kind: LabelKind
    """What the label says: an action, a transition between two, a sentence or a style."""
    value: str
    """The label itself, e.g. "walk"."""

    def moved(self, by: int) -> Segment:
        """The same label `by` frames later."""
        return replace(self, start=self.start + by, end=self.end + by)


@dataclass(frozen=True)
class Provenance:
    """What made a motion: enough to make it again bit for bit."""

    source: str = ""
    """Engine name, or the file or data set the motion was read from."""
    weights: str = ""
    """SHA-256 of the engine's weights; empty when no engine was used."""
    prompt: str = ""
    """Action, sentence or other request."""
    seed: int | None = None
    """Seed of the draw."""
    index: int = 0
    """Which of the motions of that draw this is."""
    parameters: Mapping[str, Any] = field(default_factory=dict)
    """Everything else the engine was told (JSON values only)."""


@dataclass(frozen=True, eq=False)
class Motion:
    """A body's movement: parent-relative rotations and a root path, sampled at a fixed rate.

    Metres, radians, seconds; right-handed, Y up, facing +Z. Arrays are read-only float64.
    """

    skeleton: Skeleton
    rotations: Float[np.ndarray, "T J 4"]
    """(T, J, 4) unit quaternions wxyz, parent-relative."""
    translation: Float[np.ndarray, "T 3"]
    """(T, 3) root position, metres."""
    fps: float
    """Frames a second."""
    labels: tuple[Segment, ...] = ()
    provenance: Provenance = field(default_factory=Provenance)

    def __post_init__(self) -> None:
        turns = np.array(self.rotations, dtype=np.float64)
        path = np.array(self.translation, dtype=np.float64)
        joints = len(self.skeleton)
        if turns.ndim != 3 or turns.shape[1:] != (joints, 4):
            raise SkeletonError(f"rotations have shape {turns.shape}; accepted: (frames, {joints}, 4).")
        if path.shape != (len(turns), 3):
            raise SkeletonError(f"translation has shape {path.shape}; accepted: ({len(turns)}, 3).")
        if len(turns) == 0:
            raise OutOfRangeError("number of frames", 0, "1 or more")
        squared = np.einsum("tjc,tjc->tj", turns, turns)  # several times faster than a norm over four
        if not (np.isfinite(squared).all() and np.isfinite(path).all()):
            raise SkeletonError("rotations and translation hold values that are not finite numbers.")
        if not np.isfinite(self.fps) or self.fps <= 0:
            raise OutOfRangeError("fps", self.fps, "a positive number")
        if (squared < 1e-12).any():
            raise SkeletonError("rotations hold zero quaternions; accepted: unit quaternions wxyz.")
        if np.abs(squared - 1.0).max() > 2e-12:
            turns /= np.sqrt(squared)[..., None]
        for array in (turns, path):
            array.setflags(write=False)
        object.__setattr__(self, "rotations", turns)
        object.__setattr__(self, "translation", path)
        object.__setattr__(self, "fps", float(self.fps))
        object.__setattr__(self, "labels", tuple(self.labels))

    # ---- what it is -----------------------------------------------------------------------------------

    def __len__(self) -> int:
        return len(self.rotations)

    def __repr__(self) -> str:
        made = f", from {self.provenance.source}" if self.provenance.source else ""
        tags = ", ".join(dict.fromkeys(s.value for s in self.labels))
        return (
            f"<Motion {len(self)} frames at {self.fps:g} fps ({self.duration:.2f} s), {self.skeleton.name}"
            f"{', ' + tags if tags else ''}{made}>"
        )

    def _repr_png_(self) -> bytes | None:
        """A strip of its poses, for notebooks; None where nothing that can draw is installed, or it cannot here."""
        for drawing in _drawings():
            try:
                return drawing.load()(self)
            except MotionloomError as problem:
                log.info("no picture of the motion: %s", problem)
        return None

    @property
    def frames(self) -> int:
        """Number of frames."""
        return len(self.rotations)

    @property
    def duration(self) -> float:
        """Seconds the motion lasts, each frame shown for 1 / fps."""
        return len(self) / self.fps

    @cached_property
    def positions(self) -> Float[np.ndarray, "T J 3"]:
        """(T, J, 3) joint positions, metres."""
        return self._kinematics[0]

    @cached_property
    def global_rotations(self) -> Float[np.ndarray, "T J 3 3"]:
        """(T, J, 3, 3) rotation of each joint relative to the world."""
        return self._kinematics[1]

    @cached_property
    def _kinematics(self) -> tuple[Float[np.ndarray, "T J 3"], Float[np.ndarray, "T J 3 3"]]:
        local = rotations.quaternion_to_matrix(self.rotations)
        places, turns = kinematics.forward_kinematics(
            local, self.translation, self.skeleton.offsets, self.skeleton.parents
        )
        places.setflags(write=False)
        turns.setflags(write=False)
        return places, turns

    @cached_property
    def contacts(self) -> Bool[np.ndarray, "T feet 2"]:
        """(T, feet, 2) booleans: is the ankle, is the toe, of each of `skeleton.feet` on the ground and at rest."""
        return foot_contacts.detect(self.positions, self.fps, self.skeleton)

    @cached_property
    def heading(self) -> Float[np.ndarray, " T"]:
        """(T,) yaw of the body in radians: 0 faces +Z, positive turns towards +X."""
        from engines.geometry import canonical

        return canonical.heading(self.positions, self.skeleton)

    def label_at(self, frame: int, kind: LabelKind = "action") -> str | None:
        """The label of that kind at a frame, or None."""
        return next((s.value for s in self.labels if s.kind == kind and s.start <= frame < s.end), None)

    # ---- operations, each giving a new Motion ------------------------------------------------------------

    def replaced(self, **changes: Any) -> Motion:
        """A copy with some fields changed (checked again, where they are the movement itself)."""
        if not changes.keys() <= {"labels", "provenance"}:
            return replace(self, **changes)
        made = copy.copy(self)  # the arrays cannot be written to, so two motions may share them and what follows
        for name, value in changes.items():
            object.__setattr__(made, name, tuple(value) if name == "labels" else value)
        return made

    def labelled(self, value: str, kind: LabelKind = "action") -> Motion:
        """The whole motion under one more label."""
        return self.replaced(labels=(*self.labels, Segment(0, len(self), kind, value)))

    def __getitem__(self, frames: slice) -> Motion:
        """A stretch of frames, `motion[10:50]`; labels are cut to it. Steps other than 1 keep the duration."""
        if not isinstance(frames, slice):
            raise TypeError("a Motion is cut by a slice of frames, motion[start:stop]; for one pose use motion[i:i+1]")
        start, stop, step = frames.indices(len(self))
        if step < 1 or stop <= start:
            raise OutOfRangeError("slice", f"[{frames.start}:{frames.stop}:{frames.step}]", "1 or more frames, forward")
        kept = [
            Segment(-(-(max(s.start, start) - start) // step), -(-(min(s.end, stop) - start) // step), s.kind, s.value)
            for s in self.labels
            if s.start < stop and s.end > start
        ]
        return self.replaced(
            rotations=self.rotations[start:stop:step],
            translation=self.translation[start:stop:step],
            fps=self.fps / step,
            labels=tuple(s for s in kept if s.end > s.start),
        )

    def resample(self, fps: float) -> Motion:
        """The same movement at another rate: slerp for rotations, linear for the path.

        The first frame stays the first; the last sample lies at or before the last frame. A label goes with the
        samples that lie in it; one that none lies in is dropped.
        """
        if not np.isfinite(fps) or fps <= 0:
            raise OutOfRangeError("fps", fps, "a positive number")
        if fps == self.fps:
            return self
        turns, path = resample.resample(self.rotations, self.translation, self.fps, fps)
        ratio = fps / self.fps

        def first_at(frame: int) -> int:
            # the first new frame at or after an old one, so that segments that met still meet
            return min(math.ceil(frame * ratio - 1e-6), len(turns))

        moved = (replace(s, start=first_at(s.start), end=first_at(s.end)) for s in self.labels)
        labels = tuple(s for s in moved if s.end > s.start)
        return self.replaced(rotations=turns, translation=path, fps=fps, labels=labels)

    def concat(self, *others: Motion) -> Motion:
        """This motion and then the others, frames as they are (no blending), labels moved along.

        Raises:
            SkeletonError: another skeleton; retarget first.
        """
        parts: list[Motion] = [self]
        for other in others:
            if other.skeleton != self.skeleton:
                raise SkeletonError(
                    f"cannot join a motion of skeleton {other.skeleton.name!r} to one of {self.skeleton.name!r}; "
                    "retarget it first."
                )
            parts.append(other.resample(self.fps))
        starts = np.cumsum([0] + [len(part) for part in parts])
        return self.replaced(
            rotations=np.concatenate([part.rotations for part in parts]),
            translation=np.concatenate([part.translation for part in parts]),
            labels=tuple(s.moved(int(at)) for part, at in zip(parts, starts, strict=False) for s in part.labels),
        )

    def mirror(self) -> Motion:
        """Left and right changed about the plane x = 0; labels trade left and right.

        Raises:
            SkeletonError: the rest pose is not its own mirror image (a rig whose bones all point along x), so that the
                mirrored rotations would be another pose; retarget to `smpl22` first.
        """
        from engines.geometry import mirror

        turns, path = mirror.mirror(self.rotations, self.translation, self.skeleton)
        labels = tuple(replace(s, value=mirror.mirror_words(s.value)) for s in self.labels)
        return self.replaced(rotations=turns, translation=path, labels=labels)

    def moved(self, translation: Sequence[float] = (0.0, 0.0, 0.0), yaw: float = 0.0) -> Motion:
        """Turned by `yaw` about the vertical through the origin, then shifted by `translation`, metres."""
        turn = rotations.yaw_quaternion(np.asarray(yaw))
        turns = np.array(self.rotations)
        turns[:, 0] = rotations.multiply(turn, turns[:, 0])
        # offsets[0] turns with the body around the root's own origin, so it is carried along here
        root = self.skeleton.offsets[0]
        path = rotations.rotate(turn, self.translation + root) - root + np.asarray(translation, dtype=np.float64)
        return self.replaced(rotations=turns, translation=path)

    def face_front(self, frame: int = 0) -> Motion:
        """At `frame` the body faces +Z with its root above the origin (height kept)."""
        from engines.geometry import canonical

        return canonical.face_front(self, frame)[0]

    def on_ground(self) -> Motion:
        """Shifted vertically so that the lowest the feet go lies on the floor (a low percentile, against noise)."""
        from engines.geometry import canonical

        return self.moved((0.0, -canonical.floor_height(self.positions, self.skeleton), 0.0))

    def in_place(self) -> Motion:
        """The root stays above its first place; height and turning are kept."""
        path = np.array(self.translation)
        path[:, [0, 2]] = path[0, [0, 2]]
        return self.replaced(translation=path)

    def scale_bones(self, factors: Mapping[str, float]) -> Motion:
        """Longer or shorter bones (joint name -> factor, "*" for all others); the root path grows with the legs."""
        from engines.geometry import canonical

        skeleton = self.skeleton.scaled(factors)
        ratio = canonical.leg_length(skeleton) / canonical.leg_length(self.skeleton)
        return self.replaced(skeleton=skeleton, translation=self.translation * ratio)

    def retarget(self, target: Skeleton, **options: Any) -> Motion:
        """The same movement on another skeleton, joints matched by name; see `geometry.retarget.retarget`."""
        from engines.geometry import retarget

        return retarget.retarget(self, target, **options)

    def write(self, path: str | Path, **options: Any) -> Path:
        """Write to a file, the format chosen by its extension; see `engines.formats`. Returns the path."""
        from engines import formats

        return formats.write(self, path, **options)

    @classmethod
    def from_positions(
        cls, positions: Float[np.ndarray, "T J 3"], skeleton: Skeleton, fps: float, labels: Sequence[Segment] = ()
    ) -> Motion:
        """Joint positions (T, J, 3), metres -> Motion, through `geometry.inverse` (exact where bone lengths agree)."""
        from engines.geometry import inverse

        turns, path = inverse.inverse(positions, skeleton)
        return cls(skeleton, turns, path, fps, tuple(labels))


@cache
def _drawings() -> tuple[EntryPoint, ...]:
    """What is installed that draws a Motion.

    Every distribution is asked, not the first of each name: a checkout may hold stale metadata of itself.
    """
    return tuple(entry for found in distributions() for entry in found.entry_points if entry.group == PICTURES)
