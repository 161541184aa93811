"""Where a body faces, where it stands, and the exact way to the canonical frame and back."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from jaxtyping import Float

from engines.motion import Motion
from engines.skeletons import Skeleton, roles

FLOOR_PERCENTILE = 2.0
"""The floor lies at this percentile of the lowest foot point over time, so that one noisy frame does not move it."""


@dataclass(frozen=True)
class Placement:
    """How a motion stood in its world: undoing it brings the motion back exactly."""

    yaw: float
    """Radians about +Y that turn the canonical motion back."""
    origin: tuple[float, float, float]
    """Shift, metres, after turning."""

    def restore(self, motion: Motion) -> Motion:
        """From the canonical frame back to where the motion came from."""
        return motion.moved(yaw=self.yaw).moved(self.origin)


def across(positions: Float[np.ndarray, "T J 3"], skeleton: Skeleton) -> Float[np.ndarray, "T 3"]:
    """(T, 3) direction from the body's right to its left, summed over hips, collars and shoulders.

    Of a body in whose names none of these is found, over the left/right pairs that hang from an unpaired joint.
    """
    total = np.zeros((len(positions), 3))
    for left, right in _torso_pairs(skeleton.joints) or _topmost_pairs(skeleton):
        total += positions[:, left] - positions[:, right]
    return total


@lru_cache(maxsize=64)
def _torso_pairs(joints: tuple[str, ...]) -> tuple[tuple[int, int], ...]:
    """Indices of the left and the right of hips, collars and shoulders, as far as their names tell them."""
    known = roles.recognise(joints)
    named = [(known.get(f"left_{part}"), known.get(f"right_{part}")) for part in ("hip", "collar", "shoulder")]
    return tuple((joints.index(left), joints.index(right)) for left, right in named if left and right)


def _topmost_pairs(skeleton: Skeleton) -> tuple[tuple[int, int], ...]:
    """The left/right pairs that hang from a joint in the middle of the body."""
    pairs = [(skeleton.index(a), skeleton.index(b)) for a, b in skeleton.mirror_pairs]
    paired = {joint for pair in pairs for joint in pair}
    return tuple((left, right) for left, right in pairs if skeleton.parents[left] not in paired)


def heading(positions: Float[np.ndarray, "T J 3"], skeleton: Skeleton) -> Float[np.ndarray, " T"]:
    """(T,) yaw in radians: 0 faces +Z, positive turns towards +X. Continuous in time (unwrapped).

    Facing is across x up, over hips and shoulders; for a skeleton without left and right it is zero.
    """
    left = across(np.asarray(positions, dtype=np.float64), skeleton)
    return np.unwrap(np.arctan2(-left[:, 2], left[:, 0]))


def face_front(motion: Motion, frame: int = 0) -> tuple[Motion, Placement]:
    """The motion turned and shifted so that at `frame` it faces +Z above the origin, and the way back."""
    yaw = float(motion.heading[frame])
    root = motion.positions[frame, 0]
    turned = motion.moved((-root[0], 0.0, -root[2])).moved(yaw=-yaw)
    return turned, Placement(yaw, (float(root[0]), 0.0, float(root[2])))


def leg_length(skeleton: Skeleton) -> float:
    """Length of the bones from root to ankle, metres, mean of both legs; without feet, the height of the root."""
    if not skeleton.feet:
        return float(max(skeleton.rest_positions[0, 1] - skeleton.rest_positions[:, 1].min(), 1e-6))
    lengths = []
    for ankle, _ in skeleton.feet:
        joint, total = skeleton.index(ankle), 0.0
        while skeleton.parents[joint] >= 0:
            total += skeleton.bone_lengths[joint]
            joint = skeleton.parents[joint]
        lengths.append(total)
    return float(np.mean(lengths))


def floor_height(positions: Float[np.ndarray, "T J 3"], skeleton: Skeleton) -> float:
    """Height of the floor under a motion: a low percentile of the lowest foot joint, less that joint's clearance."""
    feet = [skeleton.index(name) for foot in skeleton.feet for name in foot] or list(range(len(skeleton)))
    lowest = positions[:, feet, 1].min(axis=1)
    return float(np.percentile(lowest, FLOOR_PERCENTILE)) - toe_clearance(skeleton)


def toe_clearance(skeleton: Skeleton) -> float:
    """How high the lowest foot joint is above the sole when the foot stands flat, metres: 0 for bodies without a sole.

    A skeleton's joints lie inside the body. The end offset of the toe points at its tip on the ground, so its
    drop is that clearance.
    """
    drops = [-float(skeleton.end_offsets[toe][1]) for _, toe in skeleton.feet if toe in skeleton.end_offsets]
    return max([*drops, 0.0]) if drops else 0.0
