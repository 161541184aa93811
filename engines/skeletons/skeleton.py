"""Skeleton: the joints of a body, how they hang together, and the names by which code finds them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Float, Int

from engines.errors import OutOfRangeError, SkeletonError


@dataclass(frozen=True, eq=False)
class Skeleton:
    """Joint names, their tree and their rest pose. Units metres, Y up, facing +Z, left is +X.

    In the rest pose every rotation is the identity, so `offsets` are also the bone directions of that pose.
    """

    name: str
    """Name of the definition, or of the file it came from."""
    joints: tuple[str, ...]
    """Joint names, parents before children, the root first."""
    parents: tuple[int, ...]
    """Index of each joint's parent; -1 for the root."""
    offsets: Float[np.ndarray, "J 3"]
    """(J, 3) rest offset of each joint from its parent; for the root, from the origin of `translation` (mostly 0)."""
    end_offsets: Mapping[str, Float[np.ndarray, " 3"]] = field(default_factory=dict)
    """Where a leaf bone ends (toe tips, crown, fingertips), relative to that leaf; used by BVH end sites."""
    feet: tuple[tuple[str, str], ...] = ()
    """(ankle, toe) joint names of the left and then the right foot."""
    hinges: Mapping[str, Float[np.ndarray, " 3"]] = field(default_factory=dict)
    """Axis (3,), in rest-pose world coordinates, about which each knee and elbow flexes by a positive angle."""
    mirror_pairs: tuple[tuple[str, str], ...] = ()
    """(left, right) joint names that change places in a mirror."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "offsets", np.array(self.offsets, dtype=np.float64))
        object.__setattr__(self, "joints", tuple(self.joints))
        object.__setattr__(self, "parents", tuple(int(p) for p in self.parents))
        self.offsets.setflags(write=False)
        count = len(self.joints)
        if count == 0 or len(self.parents) != count or self.offsets.shape != (count, 3):
            raise SkeletonError(
                f"skeleton {self.name!r} has {count} joints, {len(self.parents)} parents and offsets of shape "
                f"{self.offsets.shape}; accepted: at least one joint, and as many parents and offsets as joints."
            )
        if len(set(self.joints)) != count:
            twice = sorted({j for j in self.joints if self.joints.count(j) > 1})
            raise SkeletonError(f"skeleton {self.name!r} names joints twice: {', '.join(twice)}.")
        if self.parents[0] != -1 or any(not 0 <= p < j for j, p in enumerate(self.parents) if j):
            raise SkeletonError(f"skeleton {self.name!r} needs its root first and parents before children.")
        if not np.isfinite(self.offsets).all():
            raise SkeletonError(f"skeleton {self.name!r} has offsets that are not finite numbers.")

    def __len__(self) -> int:
        return len(self.joints)

    def __eq__(self, other: object) -> bool:
        """Same joints, tree and rest pose (the name does not count)."""
        if not isinstance(other, Skeleton):
            return NotImplemented
        return (
            self.joints == other.joints
            and self.parents == other.parents
            and np.array_equal(self.offsets, other.offsets)
        )

    def __hash__(self) -> int:
        return hash((self.joints, self.parents, self.offsets.tobytes()))

    def __contains__(self, joint: str) -> bool:
        return joint in self._index

    def index(self, joint: str) -> int:
        """Index of a joint by name.

        Raises:
            SkeletonError: there is no such joint; the message lists those there are.
        """
        try:
            return self._index[joint]
        except KeyError:
            raise SkeletonError(
                f"skeleton {self.name!r} has no joint {joint!r}; it has {', '.join(self.joints)}."
            ) from None

    @cached_property
    def _index(self) -> dict[str, int]:
        return {joint: i for i, joint in enumerate(self.joints)}

    @cached_property
    def children(self) -> tuple[tuple[int, ...], ...]:
        """Indices of each joint's children."""
        return tuple(tuple(c for c, p in enumerate(self.parents) if p == j) for j in range(len(self)))

    @cached_property
    def bone_lengths(self) -> Float[np.ndarray, " J"]:
        """(J,) length of each joint's offset, metres."""
        return np.linalg.norm(self.offsets, axis=-1)

    @cached_property
    def rest_positions(self) -> Float[np.ndarray, "J 3"]:
        """(J, 3) joint positions of the rest pose with `translation` at the origin."""
        positions = np.array(self.offsets)
        for joint, parent in enumerate(self.parents):
            if parent >= 0:
                positions[joint] += positions[parent]
        return positions

    @cached_property
    def chains(self) -> tuple[tuple[int, ...], ...]:
        """Kinematic chains: runs of joints from the root or a branch down to a leaf, the main one first."""
        chains: list[tuple[int, ...]] = []
        starts: list[tuple[int, ...]] = [(0,)]
        while starts:
            chain = list(starts.pop(0))
            while self.children[chain[-1]]:
                first, *others = self.children[chain[-1]]
                starts.extend((chain[-1], other) for other in others)
                chain.append(first)
            chains.append(tuple(chain))
        return tuple(chains)

    @cached_property
    def mirror_index(self) -> Int[np.ndarray, " J"]:
        """(J,) index of the joint that takes each joint's place in a mirror."""
        index = np.arange(len(self))
        for left, right in self.mirror_pairs:
            a, b = self.index(left), self.index(right)
            index[a], index[b] = b, a
        return index

    def scaled(self, factors: Mapping[str, float]) -> Skeleton:
        """The same skeleton with the bones that lead to the named joints made longer or shorter.

        Args:
            factors: joint name -> factor > 0; "*" scales every joint not named.

        Raises:
            OutOfRangeError: a factor that is not a positive number.
            SkeletonError: no such joint.
        """
        for joint, factor in factors.items():
            if not (np.isfinite(factor) and factor > 0):
                raise OutOfRangeError(f"bone factor of {joint!r}", factor, "a positive number")
        offsets = np.array(self.offsets)
        everywhere = factors.get("*", 1.0)
        offsets *= everywhere
        for joint, factor in factors.items():
            if joint != "*":
                offsets[self.index(joint)] = self.offsets[self.index(joint)] * factor
        return self.replaced(offsets=offsets)

    def replaced(self, **changes: Any) -> Skeleton:
        """A copy with some fields changed."""
        return replace(self, **changes)
