"""Where a body faces, where it stands, and the exact way to the canonical frame and back."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from engines.skeletons.skeleton import Skeleton

if TYPE_CHECKING:
    from engines.motion import Motion

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


def across(positions: np.ndarray, skeleton: Skeleton) -> np.ndarray:
    """(T, 3) direction from the body's right to its left, summed over the paired joints nearest the root."""
    pairs = [(skeleton.index(a), skeleton.index(b)) for a, b in skeleton.mirror_pairs]
    total = np.zeros((len(positions), 3))
    for left, right in pairs:
        if skeleton.rest_positions[left, 1] > skeleton.rest_positions[0, 1] - 0.3 and _is_torso(skeleton, left):
            total += positions[:, left] - positions[:, right]
    return total


def _is_torso(skeleton: Skeleton, joint: int) -> bool:
    """Hips, collars and shoulders: the joints that have no paired joint, or only a collar, above them."""
    paired = {skeleton.index(name) for pair in skeleton.mirror_pairs for name in pair}
    above = skeleton.parents[joint]
    return above not in paired or (skeleton.parents[above] not in paired and "collar" in skeleton.joints[above])


def heading(positions: np.ndarray, skeleton: Skeleton) -> np.ndarray:
    """(T,) yaw in radians: 0 faces +Z, positive turns towards +X. Continuous in time (unwrapped).

    Facing is across x up, over hips and shoulders; for a skeleton without left/right pairs it is zero.
    """
    left = across(np.asarray(positions, dtype=np.float64), skeleton)
    return np.unwrap(np.arctan2(-left[:, 2], left[:, 0])) if skeleton.mirror_pairs else np.zeros(len(positions))


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


def floor_height(positions: np.ndarray, skeleton: Skeleton) -> float:
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
