"""Character: a textured surface on a skeleton, which performs any motion; and its file."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import numpy as np
from jaxtyping import Float, Float32, UInt16

from engines.character.arap import AsRigidAsPossible
from engines.character.mesh import Surface
from engines.errors import FormatError, MotionloomError, SkeletonError
from engines.formats import arrays, npz
from engines.geometry.skins import INFLUENCES, blended, skinning_matrices
from engines.motion import Motion
from engines.skeletons.skeleton import Skeleton

VERSION = 1
"""Version written; files of a later one are refused."""
HEADER = "character"
"""Name of the entry that makes an .npz a character."""
CONTROL = 0.1
"""Weight of a control point against its neighbourhood's rigidity, in eq. 3.18."""
Way = Literal["skin", "rigid"]
"""Linear blend skinning, which every viewer does in real time, or as rigid as possible after it."""

_REQUIRED = ("vertices", "faces", "skin_indices", "skin_weights", "hold", "skeleton")
_OPTIONAL = ("colours", "uv", "texture", "parts")


@dataclass(frozen=True, eq=False)
class Character:
    """A surface in its skeleton's rest pose with skin weights. Arrays are read-only.

    Raises:
        SkeletonError: arrays do not fit together.
    """

    name: str
    """For lists and messages."""
    surface: Surface
    """In the rest pose of the skeleton; vertices are split at a texture's seams."""
    skin_indices: UInt16[np.ndarray, "N 4"]
    """(N, 4) joints each vertex hangs on."""
    skin_weights: Float32[np.ndarray, "N 4"]
    """(N, 4) weights, summing to one, largest first."""
    hold: Float32[np.ndarray, " N"]
    """(N,) how surely skinning carries a vertex, 0 to 1: its weight as a control point."""
    skeleton: Skeleton
    """The character's own: smpl22 with its bone lengths, or that of a rigged file."""
    shape: Mapping[str, float] = field(default_factory=dict)
    """Sliders of the body that was fitted."""
    provenance: Mapping[str, Any] = field(default_factory=dict)
    """What it was made of and how; plain values."""

    def __post_init__(self) -> None:
        count = len(self.surface.vertices)
        wanted = {
            "skin_indices": (np.uint16, (count, INFLUENCES)), "skin_weights": (np.float32, (count, INFLUENCES)),
            "hold": (np.float32, (count,)),
        }  # fmt: skip
        for name, (kind, shape) in wanted.items():
            array = np.array(getattr(self, name), dtype=kind)
            if array.shape != shape or not np.isfinite(array).all():
                raise SkeletonError(
                    f"character {self.name!r}: {name} has shape {array.shape}; accepted: {shape}, finite."
                )
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        if self.skin_indices.max() >= len(self.skeleton):
            raise SkeletonError(f"character {self.name!r}: weights point at joints its skeleton has not.")
        if np.abs(self.skin_weights.sum(1) - 1).max() > 1e-3 or self.hold.min() < 0 or self.hold.max() <= 0:
            raise SkeletonError(
                f"character {self.name!r}: weights must sum to one, and hold must be above 0 somewhere."
            )

    def posed(self, motion: Motion, frame: int = 0, way: Way = "skin") -> Float[np.ndarray, "N 3"]:
        """(N, 3) vertices of one frame, metres.

        Args:
            motion: on this skeleton (`viewers.bodies` brings others to it).
            frame: which.
            way: "skin", or "rigid" (thesis eq. 3.18), which keeps elbows and armpits from collapsing and takes some
                tenths of a second.

        Raises:
            SkeletonError: the motion lives on another skeleton.
        """
        if motion.skeleton != self.skeleton:
            raise SkeletonError(
                f"character {self.name!r} is skinned to {self.skeleton.name!r}, not {motion.skeleton.name!r}."
            )
        matrices = skinning_matrices(self.skeleton, motion.positions[frame], motion.global_rotations[frame])
        own = blended(matrices, self.skin_indices, self.skin_weights)
        skinned = np.einsum("nab,nb->na", own[:, :, :3], self.surface.vertices) + own[:, :, 3]
        if way == "skin":
            return skinned
        first, solver = self._rigid
        return solver.deformed(skinned[first])[self.surface.groups]

    @cached_property
    def _rigid(self) -> tuple[np.ndarray, AsRigidAsPossible]:
        """The first vertex at each place, and what moves those."""
        surface = self.surface
        first = np.unique(surface.groups, return_index=True)[1]
        faces = surface.groups[surface.faces]
        return first, AsRigidAsPossible(surface.vertices[first], faces, CONTROL * self.hold[first])

    def save(self, path: str | Path) -> Path:
        """Write the character as an .npz, beside and renamed; the same character always gives the same bytes.

        Raises:
            FormatError: the file cannot be written, or the provenance holds what JSON cannot say.
        """
        path = Path(path)
        about = {"version": VERSION, "name": self.name, "shape": self.shape, "provenance": self.provenance}
        try:
            header = json.dumps(about, ensure_ascii=False, allow_nan=False).encode("utf-8")
        except (TypeError, ValueError, RecursionError) as error:
            raise FormatError(path, f"the character's provenance cannot be written as JSON: {error}.") from error
        rest = Motion(self.skeleton, np.tile([1.0, 0, 0, 0], (1, len(self.skeleton), 1)), np.zeros((1, 3)), 1.0)
        held: dict[str, np.ndarray] = {
            HEADER: np.frombuffer(header, np.uint8),
            "skeleton": np.frombuffer(npz.to_bytes(rest), np.uint8),  # a motion of one frame, the rest pose
            "vertices": self.surface.vertices.astype(np.float32),
            "faces": self.surface.faces.astype(np.uint32),
            "skin_indices": self.skin_indices,
            "skin_weights": self.skin_weights,
            "hold": self.hold,
        }
        values = {name: getattr(self.surface, name) for name in _OPTIONAL}
        return arrays.save(path, held | {name: value for name, value in values.items() if value is not None})


def load(path: str | Path) -> Character:
    """The character in a file that `Character.save` wrote.

    Raises:
        FormatError: no such file, no character, of a later version, or damaged.
    """
    path = Path(path)
    held = arrays.load(path, (HEADER, *_REQUIRED, *_OPTIONAL))
    missing = [name for name in (HEADER, *_REQUIRED) if name not in held]
    if missing:
        raise FormatError(path, f"has no {missing[0]!r}; accepted: a character that motionloom wrote (.npz).")
    try:
        about = json.loads(held[HEADER].astype(np.uint8).tobytes().decode("utf-8"))
        if int(about["version"]) > VERSION:
            raise FormatError(path, f"is of version {about['version']}; this program reads up to {VERSION}: update it.")
        rest = npz.from_bytes(held["skeleton"].astype(np.uint8).tobytes(), f"{path.name}: skeleton")
        surface = Surface(held["vertices"], held["faces"], **{n: held[n] for n in _OPTIONAL if n in held})
        return Character(
            name=str(about["name"]),
            surface=surface,
            skin_indices=held["skin_indices"],
            skin_weights=held["skin_weights"],
            hold=held["hold"],
            skeleton=rest.skeleton,
            shape={str(name): float(value) for name, value in about["shape"].items()},
            provenance=dict(about["provenance"]),
        )
    except FormatError:
        raise
    except (MotionloomError, KeyError, TypeError, ValueError, AttributeError) as error:
        raise FormatError(path, f"is damaged: {error!s}") from error
