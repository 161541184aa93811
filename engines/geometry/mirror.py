"""Left for right."""

from __future__ import annotations

import re

import numpy as np
from jaxtyping import Float

from engines.errors import SkeletonError
from engines.skeletons.skeleton import Skeleton

ASYMMETRY_LIMIT = 0.05
"""How far a joint of the rest pose may lie from its partner's mirror image, as a share of the body's extent."""


def mirror(
    turns: Float[np.ndarray, "T J 4"], path: Float[np.ndarray, "T 3"], skeleton: Skeleton
) -> tuple[Float[np.ndarray, "T J 4"], Float[np.ndarray, "T 3"]]:
    """Rotations (T, J, 4) and root path (T, 3) reflected in the plane x = 0, paired joints changing places.

    A reflection S = diag(-1, 1, 1) turns a rotation R into S R S: the quaternion keeps w and x and flips y and z. That
    is the mirrored pose where the rest pose is its own mirror image, and another pose where not.

    Raises:
        SkeletonError: the rest pose is not mirror symmetric; the message names the joint that is farthest off.
    """
    check_symmetric(skeleton)
    turns = np.asarray(turns)[:, skeleton.mirror_index] * np.array([1.0, 1.0, -1.0, -1.0])
    return turns, np.asarray(path) * np.array([-1.0, 1.0, 1.0])


def asymmetry(skeleton: Skeleton) -> Float[np.ndarray, " J"]:
    """(J,) metres between each joint of the rest pose and the mirror image of the joint that takes its place."""
    rest = skeleton.rest_positions
    return np.linalg.norm(rest[skeleton.mirror_index] * np.array([-1.0, 1.0, 1.0]) - rest, axis=-1)


def check_symmetric(skeleton: Skeleton) -> None:
    """Refuse a skeleton whose motions cannot be mirrored joint by joint.

    Raises:
        SkeletonError: as `mirror`.
    """
    off = asymmetry(skeleton)
    extent = float(np.linalg.norm(np.ptp(skeleton.rest_positions, axis=0)))
    worst = int(off.argmax())
    if off[worst] > ASYMMETRY_LIMIT * max(extent, 1e-9):
        raise SkeletonError(
            f"skeleton {skeleton.name!r} cannot be mirrored: its rest pose is not symmetric about x = 0 "
            f"({skeleton.joints[worst]!r} is {off[worst]:.2f} m off); retarget the motion to smpl22 first."
        )


_SIDES = {
    "left": "right", "right": "left", "clockwise": "counterclockwise",
    "counterclockwise": "clockwise", "counter-clockwise": "clockwise", "anticlockwise": "clockwise",
}  # fmt: skip
_PATTERN = re.compile(r"(?<![a-z])(" + "|".join(sorted(_SIDES, key=len, reverse=True)) + r")(?![a-z])", re.IGNORECASE)


def mirror_words(text: str) -> str:
    """A label or sentence with left and right (and the senses of turning) exchanged, capitals kept."""

    def swapped(match: re.Match[str]) -> str:
        word = _SIDES[match[0].lower()]
        return word.capitalize() if match[0][0].isupper() else word

    return _PATTERN.sub(swapped, text)
