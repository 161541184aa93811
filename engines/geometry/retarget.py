"""The same movement on another skeleton.

Two ways in. `retarget` carries rotations over: each joint of the target turns from the reference pose as the source's
joint does, so twists, heads and wrists come along. `from_points` has only joint positions (a depth camera, a network)
and makes a pose from them. Both end on `smpl22` or any other skeleton that has its joints.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import Literal

import numpy as np
from jaxtyping import Float

from engines.errors import SkeletonError
from engines.geometry import canonical, inverse, kinematics, rotations
from engines.motion import Motion
from engines.skeletons import SMPL22, Skeleton, roles

_NEEDED = (
    "pelvis", "neck", "left_hip", "right_hip", "left_knee", "right_knee", "left_ankle", "right_ankle",
    "left_shoulder", "right_shoulder", "left_elbow", "right_elbow", "left_wrist", "right_wrist",
)  # fmt: skip
_TORSO = ("pelvis", "spine1", "spine2", "spine3", "neck", "head")


def retarget(
    motion: Motion,
    target: Skeleton = SMPL22,
    *,
    reference: Literal["rest", "first"] | Motion = "rest",
    target_reference: Motion | None = None,
    names: Mapping[str, str] | None = None,
) -> Motion:
    """Carry a motion to another skeleton, joints matched by name.

    Args:
        motion: on any skeleton whose joints can be told by their names.
        target: `smpl22`, or any skeleton with the same joint names or roles.
        reference: an upright pose of the source with feet flat: its rest pose, its first frame (as CMU's T-poses),
            or one frame of another motion of that skeleton. Any position of the arms and legs will do.
        target_reference: one frame of the target in such a pose, where its own rest pose does not stand upright.
        names: role (a joint name of `smpl22`) -> joint of the source, where recognition by name is not enough.

    Returns:
        A motion of the same length and labels; the root path is scaled by the ratio of leg lengths.

    Raises:
        SkeletonError: joints are missing (they are named), or the reference pose is not upright.
    """
    if motion.skeleton == target:
        return motion
    mine = dict(names or roles.recognise(motion.skeleton.joints))
    theirs = roles.recognise(target.joints)
    frames = _target_frames(target, theirs, target_reference)
    pose = _reference(motion, reference)
    points = {role: pose.positions[:1, pose.skeleton.index(joint)] for role, joint in mine.items()}
    posed = from_points(points, fps=1.0, upright=True)
    carried: dict[str, np.ndarray] = {}
    for role in SMPL22.joints:
        if role in mine:
            joint = motion.skeleton.index(mine[role])
            start = pose.global_rotations[0, joint].T @ posed.global_rotations[0, SMPL22.index(role)]
            carried[role] = motion.global_rotations[:, joint] @ start
    world = _fill(carried, len(motion))
    ratio = canonical.leg_length(target) / _leg_length(points)
    root = motion.positions[:, motion.skeleton.index(mine["pelvis"])] * ratio
    by_joint = {theirs[role]: world[role] @ turn for role, turn in frames.items()}
    return _from_world(motion, target, by_joint, root)


def _target_frames(target: Skeleton, theirs: Mapping[str, str], reference: Motion | None) -> dict[str, np.ndarray]:
    """By role, the rotation (3, 3) from a joint of `smpl22` to that of the target when both stand in the same pose.

    A target whose legs are splayed at rest must turn them less far to stand as the source stands.
    """
    same = {role: np.eye(3) for role in theirs}
    if target == SMPL22 or (reference is None and any(role not in theirs for role in _NEEDED)):
        return same
    if reference is None:
        still = np.tile(rotations.IDENTITY, (1, len(target), 1))
        places, turned = kinematics.forward_kinematics(
            rotations.quaternion_to_matrix(still), np.zeros((1, 3)), target.offsets, target.parents
        )
    elif reference.skeleton.joints == target.joints:
        places, turned = reference.positions[:1], reference.global_rotations[:1]
    else:
        raise SkeletonError("target_reference has other joints than the target; give a frame of the target skeleton.")
    posed = from_points({role: places[:, target.index(joint)] for role, joint in theirs.items()}, 1.0, upright=True)
    return {
        role: posed.global_rotations[0, SMPL22.index(role)].T @ turned[0, target.index(joint)]
        for role, joint in theirs.items()
    }


def _reference(motion: Motion, reference: Literal["rest", "first"] | Motion) -> Motion:
    """The one-frame motion of the source that shows the reference pose."""
    if isinstance(reference, str):
        first = motion[:1]
        if reference == "first":
            return first
        turns = np.tile(rotations.IDENTITY, (1, len(motion.skeleton), 1))
        return first.replaced(rotations=turns, translation=np.zeros((1, 3)))
    if reference.skeleton.joints != motion.skeleton.joints:
        raise SkeletonError("the reference pose has other joints than the motion; give a frame of the same skeleton.")
    return reference[:1]


def _leg_length(points: Mapping[str, np.ndarray]) -> float:
    """Mean length of both legs, root to ankle along the bones: each bone's median over the frames."""
    chains = [("pelvis", f"{side}_hip", f"{side}_knee", f"{side}_ankle") for side in ("left", "right")]
    steps = [np.median(np.linalg.norm(points[b] - points[a], axis=-1)) for chain in chains for a, b in pairwise(chain)]
    return max(float(np.sum(steps)) / 2, 1e-6)


def _fill(carried: dict[str, np.ndarray], frames: int) -> dict[str, np.ndarray]:
    """World rotations of all roles: a joint the source lacks lies between its neighbours, or follows its parent."""
    world: dict[str, np.ndarray] = {}
    for joint, role in enumerate(SMPL22.joints):
        if role in carried:
            world[role] = carried[role]
            continue
        above = world[SMPL22.joints[SMPL22.parents[joint]]] if joint else np.tile(np.eye(3), (frames, 1, 1))
        below = next((r for r in _TORSO[_TORSO.index(role) + 1 :] if r in carried), None) if role in _TORSO else None
        if below is None:
            world[role] = above
            continue
        steps = _TORSO.index(below) - _TORSO.index(role) + 1
        world[role] = above @ rotations.rotvec_to_matrix(
            rotations.matrix_to_rotvec(above.swapaxes(-1, -2) @ carried[below]) / steps
        )
    return world


def _from_world(motion: Motion, target: Skeleton, by_joint: Mapping[str, np.ndarray], root: np.ndarray) -> Motion:
    """Parent-relative rotations on the target from world rotations by joint; the other joints do not turn."""
    turned: list[np.ndarray] = []
    local = np.empty((len(motion), len(target), 3, 3))
    for joint, name in enumerate(target.joints):
        above = turned[target.parents[joint]] if joint else np.tile(np.eye(3), (len(motion), 1, 1))
        turned.append(by_joint.get(name, above))
        local[:, joint] = above.swapaxes(-1, -2) @ turned[-1]
    turns = rotations.continuous(rotations.matrix_to_quaternion(local))
    from dataclasses import replace

    return replace(motion, skeleton=target, rotations=turns, translation=root - target.offsets[0])


def from_points(points: Mapping[str, Float[np.ndarray, "T 3"]], fps: float, *, upright: bool = False) -> Motion:
    """A pose of `smpl22` from the positions of the joints that are known.

    The torso's frames come from hips and shoulders, limbs point the way the points do, and twists are found by
    `inverse`. Bone lengths are the house skeleton's, so noise in the points cannot stretch the body.

    Args:
        points: role (joint name of `smpl22`) -> (T, 3), metres, Y up. Head, feet and spine are optional.
        fps: frames a second.
        upright: the pose is known to stand upright with feet flat, whatever the joints' exact places suggest
            (skeletons disagree on where in the body a hip or a neck lies).

    Raises:
        SkeletonError: joints are missing; the message names them.
    """
    missing = [role for role in _NEEDED if role not in points]
    if missing:
        raise SkeletonError(f"the pose lacks {', '.join(missing)}; needed are {', '.join(_NEEDED)}.")
    points = {role: np.asarray(value, dtype=np.float64) for role, value in points.items()}
    if upright:
        _check_upright(points)
    pelvis, chest = _torso_frames(points, upright)
    frames = {"pelvis": pelvis, "spine3": chest}
    middle = rotations.matrix_to_rotvec(pelvis.swapaxes(-1, -2) @ chest)
    frames["spine1"] = pelvis @ rotations.rotvec_to_matrix(middle / 3)
    frames["spine2"] = pelvis @ rotations.rotvec_to_matrix(middle * 2 / 3)
    places = _place(points, frames, upright)
    ratio = canonical.leg_length(SMPL22) / _leg_length(points)
    places += (points["pelvis"] * ratio)[:, None]
    turns, path = inverse.inverse(places, SMPL22)
    return Motion(SMPL22, turns, path, fps)


def _check_upright(points: Mapping[str, np.ndarray]) -> None:
    up = rotations.normalise(points["neck"] - points["pelvis"])[0, 1]
    down = rotations.normalise(points["left_ankle"] + points["right_ankle"] - 2 * points["pelvis"])[0, 1]
    if up < 0.8 or down > -0.8:
        raise SkeletonError(
            "the reference pose does not stand upright; give retarget a frame that does, e.g. reference='first' "
            "(or target_reference, if it is the target's rest pose that does not)."
        )


def _torso_frames(points: Mapping[str, np.ndarray], upright: bool) -> tuple[np.ndarray, np.ndarray]:
    """World rotations (T, 3, 3) of pelvis and chest: y along the spine, x from right to left."""
    base = (points["left_hip"] + points["right_hip"]) / 2
    waist = next((points[r] for r in ("spine2", "spine1", "spine3") if r in points), None)
    neck = points["neck"]
    up_low = neck - base if waist is None else waist - base
    up_high = neck - (base if waist is None else waist)
    if upright:
        up_low = up_high = np.broadcast_to([0.0, 1.0, 0.0], neck.shape)
    return (
        _frame(points["left_hip"] - points["right_hip"], up_low),
        _frame(points["left_shoulder"] - points["right_shoulder"], up_high),
    )


def _frame(left: np.ndarray, up: np.ndarray) -> np.ndarray:
    """Rotations (T, 3, 3) whose y is `up` and whose x leans to `left`."""
    y = rotations.normalise(up)
    z = rotations.normalise(np.cross(left, y))
    return np.stack([np.cross(y, z), y, z], axis=-1)


def _place(points: Mapping[str, np.ndarray], frames: dict[str, np.ndarray], upright: bool) -> np.ndarray:
    """Joint positions (T, 22, 3) relative to the pelvis, with the house skeleton's bone lengths."""
    count = len(points["pelvis"])
    places = np.zeros((count, len(SMPL22), 3))
    directions = _limb_directions(points) | _head_direction(points, frames, upright) | _foot_directions(points, upright)
    rigid = {"left_collar": "spine3", "right_collar": "spine3", "neck": "spine3", "left_shoulder": "spine3",
             "right_shoulder": "spine3", "left_hip": "pelvis", "right_hip": "pelvis", "spine1": "pelvis",
             "spine2": "spine1", "spine3": "spine2"}  # fmt: skip
    for joint, role in enumerate(SMPL22.joints[1:], start=1):
        offset = SMPL22.offsets[joint]
        if role in directions:
            bone = directions[role] * np.linalg.norm(offset)
        else:
            bone = frames[rigid.get(role, "spine3")] @ offset
        places[:, joint] = places[:, SMPL22.parents[joint]] + bone
    return places


def _limb_directions(points: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    limbs = [("hip", "knee"), ("knee", "ankle"), ("shoulder", "elbow"), ("elbow", "wrist")]
    return {
        f"{side}_{far}": rotations.normalise(points[f"{side}_{far}"] - points[f"{side}_{near}"])
        for side in ("left", "right")
        for near, far in limbs
    }


def _head_direction(
    points: Mapping[str, np.ndarray], frames: Mapping[str, np.ndarray], upright: bool
) -> dict[str, np.ndarray]:
    """Neck to head: as the chest's up turns onto the seen neck, so turns the rest direction."""
    rest = rotations.normalise(SMPL22.offsets[SMPL22.index("head")])
    chest = frames["spine3"]
    if upright or "head" not in points:
        return {"head": chest @ rest}
    up = chest @ np.array([0.0, 1.0, 0.0])
    return {"head": rotations.rotate(rotations.between(up, points["head"] - points["neck"]), chest @ rest)}


def _foot_directions(points: Mapping[str, np.ndarray], upright: bool) -> dict[str, np.ndarray]:
    """Ankle to toe: the seen direction, pitched so that the usual (median) pitch is the flat foot of the rest pose."""
    directions = {}
    rest = SMPL22.offsets[SMPL22.index("left_foot")]
    flat = float(np.arctan2(rest[1], rest[2]))
    for side in ("left", "right"):
        if f"{side}_foot" in points:
            seen = points[f"{side}_foot"] - points[f"{side}_ankle"]
        else:
            seen = np.cross(points["left_hip"] - points["right_hip"], [0.0, 1.0, 0.0])
        reach = np.maximum(np.linalg.norm(seen[:, [0, 2]], axis=-1), 1e-9)
        pitch = np.arctan2(seen[:, 1], reach)
        pitch = np.full_like(pitch, flat) if upright else pitch - np.median(pitch) + flat
        ahead = seen[:, [0, 2]] / reach[:, None]
        directions[f"{side}_foot"] = np.stack(
            [ahead[:, 0] * np.cos(pitch), np.sin(pitch), ahead[:, 1] * np.cos(pitch)], axis=-1
        )
    return directions
