"""Feet that stand are held where they stand: a clean-up for any Motion, applied or left out without loss.

Each standing ankle and toe is held at one place for as long as it touches the ground; in between what was moved fades
out. The leg follows by turning as a whole and bending at the knee (closed form); the foot keeps its own direction in
the world, and nothing above the hips changes.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float
from scipy.ndimage import gaussian_filter1d

from engines.errors import SkeletonError
from engines.geometry import canonical, kinematics, rotations
from engines.motion import Motion

_GAP = 2
"""Frames without contact, at most, that interrupt no standing."""
_SHORTEST = 3
"""Frames of contact that count as standing."""
_EASE = 2.0
"""Frames over which a body's travel gives in to its feet (deviation of a Gaussian)."""
_STRETCH = 0.998
"""Of a leg, at most: a straight one has no knee to bend."""


def plant_feet(motion: Motion, contacts: Bool[np.ndarray, "T feet 2"] | None = None, fade: float = 0.3) -> Motion:
    """The motion with standing feet that do not slide, and no foot under the floor.

    Args:
        motion: of a skeleton with feet whose ankles hang on a knee and a hip.
        contacts: (T, feet, 2) which ankles and toes stand; `motion.contacts` if not given.
        fade: seconds over which a correction comes and goes.

    Raises:
        SkeletonError: no feet, or no legs above them.
    """
    skeleton = motion.skeleton
    if not skeleton.feet:
        raise SkeletonError(f"skeleton {skeleton.name!r} names no feet to hold.")
    touching = motion.contacts if contacts is None else np.asarray(contacts, dtype=bool)
    local = rotations.quaternion_to_matrix(motion.rotations)
    for foot, (ankle, toe) in enumerate(skeleton.feet):
        points = motion.positions[:, [skeleton.index(ankle), skeleton.index(toe)]]
        shift = _correction(points, touching[:, foot], _standing(motion, foot), round(fade * motion.fps))
        _bend(local, motion, skeleton.index(ankle), shift)
    return motion.replaced(rotations=rotations.continuous(rotations.matrix_to_quaternion(local)))


def travel_on_feet(motion: Motion, given: Motion) -> Motion:
    """The motion on a path its feet call for: one that stands in the motion it was made of moves as it does there.

    Poses stay; where no foot stands the path keeps its own velocity. A motion that is the given one stays as it is.

    Args:
        motion: made of `given` frame by frame, at its rate.
        given: says which ankles and toes stand, and how still.

    Raises:
        SkeletonError: no feet, or another skeleton.
    """
    skeleton = motion.skeleton
    if not skeleton.feet:
        raise SkeletonError(f"skeleton {skeleton.name!r} names no feet to stand on.")
    if given.skeleton != skeleton:
        raise SkeletonError(f"a motion of skeleton {skeleton.name!r} was not made of one of {given.skeleton.name!r}.")
    points = [skeleton.index(name) for pair in skeleton.feet for name in pair]
    stands = given.contacts.reshape(len(given), -1)
    gap = given.positions[:, points] - motion.positions[:, points]
    stay = stands[1:] & stands[:-1]
    steps = (np.diff(gap, axis=0) * stay[..., None]).sum(axis=1) / np.maximum(stay.sum(axis=1), 1)[:, None]
    steps = gaussian_filter1d(steps, _EASE, axis=0, mode="nearest") if len(steps) else steps
    shift = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
    shift[:, 1] = _lifted(gap[..., 1], stands)
    return motion.replaced(translation=motion.translation + shift)


def _lifted(gap: Float[np.ndarray, "T points"], stands: Bool[np.ndarray, "T points"]) -> Float[np.ndarray, " T"]:
    """How far to lift a body so that standing feet are at their height, metres; in between from the one to the next."""
    at = np.flatnonzero(stands.any(axis=1))
    if not len(at):
        return np.zeros(len(gap))
    heights = (gap[at] * stands[at]).sum(axis=1) / stands[at].sum(axis=1)
    return gaussian_filter1d(np.interp(np.arange(len(gap)), at, heights), _EASE, mode="nearest")


def _standing(motion: Motion, foot: int) -> Float[np.ndarray, 2]:
    """Heights above the floor at which ankle and toe stand."""
    skeleton = motion.skeleton
    rest = skeleton.rest_positions[:, 1]
    every = [skeleton.index(name) for pair in skeleton.feet for name in pair]
    own = [skeleton.index(name) for name in skeleton.feet[foot]]
    return rest[own] - rest[every].min() + canonical.toe_clearance(skeleton)


def _correction(
    points: Float[np.ndarray, "T 2 3"], touching: Bool[np.ndarray, "T 2"], standing: Float[np.ndarray, 2], fade: int
) -> Float[np.ndarray, "T 3"]:
    """How far a foot is to be moved at each frame, metres."""
    wanted, count = np.zeros((len(points), 3)), np.zeros(len(points))
    for point in range(2):
        for start, end in _stretches(touching[:, point]):
            place = points[start:end, point].mean(axis=0)
            place[1] = max(place[1], standing[point])
            wanted[start:end] += place - points[start:end, point]
            count[start:end] += 1
    held = count > 0
    wanted[held] /= count[held, None]
    shift = _faded(wanted, held, fade)
    shift = gaussian_filter1d(shift, 1.0, axis=0, mode="nearest") if len(shift) > 3 else shift
    under = (standing - points[..., 1] - shift[:, 1:2]).max(axis=1)
    shift[:, 1] += np.maximum(under, 0.0)
    return shift


def _stretches(touching: Bool[np.ndarray, " T"]) -> list[tuple[int, int]]:
    """(first frame, one past the last) of each standing, short gaps closed and short touches left out."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], touching.astype(int), [0]]))).reshape(-1, 2).tolist()
    joined: list[list[int]] = []
    for start, end in edges:
        if joined and start - joined[-1][1] <= _GAP:
            joined[-1][1] = end
        else:
            joined.append([start, end])
    return [(start, end) for start, end in joined if end - start >= _SHORTEST]


def _faded(wanted: Float[np.ndarray, "T 3"], held: Bool[np.ndarray, " T"], fade: int) -> Float[np.ndarray, "T 3"]:
    """Corrections of standing frames, and between them what is left of the last and already there of the next."""
    at = np.flatnonzero(held)
    if not len(at):
        return np.zeros_like(wanted)
    frames = np.arange(len(wanted))
    before = np.maximum(np.searchsorted(at, frames, side="right") - 1, 0)
    after = np.minimum(np.searchsorted(at, frames), len(at) - 1)
    first, last = at[before], at[after]

    def share(distance: np.ndarray) -> np.ndarray:
        x = np.clip(1 - distance / max(1, fade), 0.0, 1.0)
        return x * x * (3 - 2 * x)

    one, other = share(np.abs(frames - first)), share(np.abs(last - frames))
    total = np.maximum(one + other, 1.0)[:, None]
    mixed = (one[:, None] * wanted[first] + other[:, None] * wanted[last]) / total
    return np.where(held[:, None], wanted, mixed)


def _bend(local: Float[np.ndarray, "T J 3 3"], motion: Motion, ankle: int, shift: Float[np.ndarray, "T 3"]) -> None:
    """Move an ankle by turning the leg and bending its knee; `local` rotations are changed in place."""
    parents = motion.skeleton.parents
    knee = parents[ankle]
    hip = parents[knee] if knee >= 0 else -1
    if hip < 0 or parents[hip] < 0:
        raise SkeletonError(f"{motion.skeleton.joints[ankle]} has no knee and hip above it.")
    world = kinematics.global_rotations(local, parents)
    at = motion.positions
    leg, thigh, shank = at[:, ankle] - at[:, hip], at[:, knee] - at[:, hip], at[:, ankle] - at[:, knee]
    wanted = leg + shift
    upper, lower = (np.linalg.norm(part, axis=-1) for part in (thigh, shank))
    length = np.linalg.norm(wanted, axis=-1)
    reach = np.clip(length, np.abs(upper - lower) + 1e-3, _STRETCH * (upper + lower))
    whole = rotations.quaternion_to_matrix(rotations.between(leg, wanted))
    axis = rotations.normalise(np.cross(thigh, shank))
    side = motion.global_rotations[:, parents[hip]][:, :, 0]
    straight = np.linalg.norm(np.cross(thigh, shank), axis=-1) < 1e-4 * upper * lower
    axis = np.where(straight[:, None], side, axis)
    axis = np.einsum("tij,tj->ti", whole, axis)
    old = np.linalg.norm(leg, axis=-1)
    hip_turn = _angle(upper, old, lower) - _angle(upper, reach, lower)
    knee_turn = hip_turn + _angle(upper, lower, old) - _angle(upper, lower, reach)
    moved_hip = _turn(axis, hip_turn) @ whole @ world[:, hip]
    moved_knee = _turn(axis, knee_turn) @ whole @ world[:, knee]
    local[:, hip] = world[:, parents[hip]].swapaxes(-1, -2) @ moved_hip
    local[:, knee] = moved_hip.swapaxes(-1, -2) @ moved_knee
    local[:, ankle] = moved_knee.swapaxes(-1, -2) @ world[:, ankle]


def _angle(a: np.ndarray, b: np.ndarray, opposite: np.ndarray) -> np.ndarray:
    """Angle between sides a and b of a triangle, radians."""
    return np.arccos(np.clip((a * a + b * b - opposite * opposite) / (2 * a * b), -1.0, 1.0))


def _turn(axis: Float[np.ndarray, "T 3"], angle: Float[np.ndarray, " T"]) -> Float[np.ndarray, "T 3 3"]:
    return rotations.rotvec_to_matrix(axis * angle[:, None])
