"""Joint positions back to rotations, exactly and without flips.

Positions say where a bone points, not how it is turned about itself. The twist of an upper limb is read from
the plane its elbow or knee bends in; where the limb is too straight to tell, from the frames around it and from the
parent. That choice is one small least-squares problem per limb over all frames, so it cannot jump.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from scipy.linalg import solveh_banded

from engines.errors import SkeletonError
from engines.geometry import rotations
from engines.skeletons.skeleton import Skeleton

_SHORT = 1e-6
"""Bones shorter than this, in metres, have no direction."""
_TWIST_STIFFNESS = 2.0
"""Weight of twist changing between frames, against a limb bent at a right angle."""
_TWIST_REST = 0.03
"""Weight of no twist relative to the parent: decides for limbs that stay straight."""

_HARDLY_BENT = 0.1
"""Squared sine of a bend (18 degrees) up to which the side a limb bends to may be noise."""


def inverse(
    positions: Float[np.ndarray, "T J 3"], skeleton: Skeleton
) -> tuple[Float[np.ndarray, "T J 4"], Float[np.ndarray, "T 3"]]:
    """Parent-relative rotations whose forward kinematics gives the positions.

    Exact (rounding) where the bone lengths agree with the skeleton's; elsewhere bones keep the skeleton's length
    and point the way the positions do. Leaves, whose turning no position shows, follow their parent.

    Args:
        positions: (T, J, 3) metres, in the skeleton's joint order.
        skeleton: `hinges` name the joints from which twist is read.

    Returns:
        rotations (T, J, 4) wxyz, continuous in sign, and root translation (T, 3).

    Raises:
        SkeletonError: wrong shape, or numbers that are not finite.
    """
    positions = np.asarray(positions, dtype=np.float64)
    if positions.ndim != 3 or positions.shape[1:] != (len(skeleton), 3):
        raise SkeletonError(f"positions have shape {positions.shape}; accepted: (frames, {len(skeleton)}, 3).")
    if not np.isfinite(positions).all():
        raise SkeletonError("positions hold values that are not finite numbers.")
    world = np.empty((len(skeleton), len(positions), 4))  # (J, T, 4): joint by joint, each over all frames
    for joint in range(len(skeleton)):
        above = world[skeleton.parents[joint]] if joint else np.tile(rotations.IDENTITY, (len(positions), 1))
        world[joint] = _world_rotation(joint, above, positions, skeleton)
    local = np.array(world)
    parents = np.array(skeleton.parents[1:], dtype=int)
    local[1:] = rotations.multiply(rotations.invert(world[parents]), world[1:])
    turns = rotations.continuous(rotations.normalise(local.swapaxes(0, 1)))  # (J, T, 4) -> (T, J, 4)
    return turns, positions[:, 0] - skeleton.offsets[0]


def _bones_from(joint: int, skeleton: Skeleton) -> list[tuple[int, np.ndarray]]:
    """The bones that turn with a joint: (far joint, rest vector). A child of no length passes its own bones on."""
    bones = []
    for child in skeleton.children[joint]:
        if skeleton.bone_lengths[child] > _SHORT:
            bones.append((child, skeleton.offsets[child]))
        else:
            bones.extend(_bones_from(child, skeleton))
    return bones


def _world_rotation(joint: int, above: np.ndarray, positions: np.ndarray, skeleton: Skeleton) -> np.ndarray:
    """World rotation (T, 4) of a joint from where its bones point, given its parent's (T, 4)."""
    bones = _bones_from(joint, skeleton)
    if not bones:
        return above
    rest = np.array([vector for _, vector in bones])
    seen = positions[:, [far for far, _ in bones]] - positions[:, joint : joint + 1]
    spread = np.linalg.svd(rotations.normalise(rest), compute_uv=False)
    if len(bones) > 1 and spread[1] > 0.05:
        return _fit(rest, seen)
    if not skeleton.hinges:
        return _swing_about_mean(rest[0], seen[:, 0], above)
    swing = rotations.multiply(rotations.between(rotations.rotate(above, rest[0]), seen[:, 0]), above)
    hinge = skeleton.hinges.get(skeleton.joints[bones[0][0]])
    following = _bones_from(bones[0][0], skeleton)
    if hinge is None or not following:
        return swing
    beyond = positions[:, following[0][0]] - positions[:, bones[0][0]]
    return _twist_to_hinge(swing, seen[:, 0], beyond, np.asarray(hinge, dtype=np.float64))


def _swing_about_mean(rest: np.ndarray, seen: np.ndarray, above: np.ndarray) -> np.ndarray:
    """World rotation (T, 4) that points a bone along `seen` (T, 3) with no twist about the motion's mean direction.

    For rigs whose rest pose is no standing person (all bones along one axis): the rest direction may lie opposite to
    where the limb moves, and there the shortest turn flips. The mean direction lies amid the movement.
    """
    local = rotations.normalise(rotations.rotate(rotations.invert(above), seen))
    mean = local.mean(axis=0)
    if np.linalg.norm(mean) < _SHORT:
        mean = rest
    return rotations.multiply(above, rotations.multiply(rotations.between(mean, local), rotations.between(rest, mean)))


def _fit(rest: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """Rotation (T, 4) that best turns rest vectors (N, 3) onto seen ones (T, N, 3) (Kabsch, by SVD)."""
    u, _, vt = np.linalg.svd(np.einsum("tni,nj->tij", seen, rest))
    sign = np.ones((len(seen), 3))
    sign[:, 2] = np.sign(np.linalg.det(u) * np.linalg.det(vt))
    return rotations.matrix_to_quaternion((u * sign[:, None]) @ vt)


def _twist_to_hinge(swing: np.ndarray, bone: np.ndarray, beyond: np.ndarray, hinge: np.ndarray) -> np.ndarray:
    """Turn a limb about itself so that its hinge stands across the plane in which the limb bends.

    Args:
        swing: (T, 4) world rotation of the limb, twist free.
        bone: (T, 3) direction of the limb.
        beyond: (T, 3) direction of the bone past the hinge.
        hinge: (3,) flexion axis in the rest pose.
    """
    bone, beyond = rotations.normalise(bone), rotations.normalise(beyond)
    axis = np.cross(bone, beyond)
    bent = (axis**2).sum(-1)
    resting = rotations.rotate(swing, hinge)
    resting = rotations.normalise(resting - (resting * bone).sum(-1, keepdims=True) * bone)
    across = np.cross(bone, resting)
    # the sine of the bend is already in `axis`; a complex number holds cosine and sine of the twist
    target = np.sqrt(bent) * ((axis * resting).sum(-1) + 1j * (axis * across).sum(-1))
    # a limb that is all but straight may bend backwards by a few degrees, and must not turn over for that: where the
    # frames that bend well say the opposite, believe them
    well = np.clip((bent - _HARDLY_BENT / 3) / _HARDLY_BENT, 0.0, 1.0)
    coarse = _smooth(target * well, bent * well)
    target = np.where((bent < _HARDLY_BENT) & ((target * coarse.conj()).real < 0), -target, target)
    twist = np.angle(_smooth(target, bent))
    return rotations.multiply(rotations.rotvec_to_quaternion(bone * twist[:, None]), swing)


def _smooth(target: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Minimise sum weight |c - target/weight|^2 + stiffness |c[t+1] - c[t]|^2 + rest |c - 1|^2 over complex c (T,).

    Only the angle of the result counts."""
    count = len(target)
    if count == 1:
        return target + _TWIST_REST
    diagonal = weight + _TWIST_REST + _TWIST_STIFFNESS * np.r_[1.0, np.full(count - 2, 2.0), 1.0]
    bands = np.zeros((2, count))
    bands[0, 1:] = -_TWIST_STIFFNESS
    bands[1] = diagonal
    right = target + _TWIST_REST
    return solveh_banded(bands, np.stack([right.real, right.imag], axis=-1)) @ np.array([1.0, 1j])
