"""From Anny's A-pose to smpl22's T-pose: the rotation of every bone, and the skin carried back by it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from engines.geometry import rotations
from engines.skeletons import SMPL22
from engines.skeletons.skeleton import Skeleton
from viewers.bodies.baking.weights import SkinMesh, joint_of

TOE_DROP = 0.0277
"""smpl22's toe joints lie this high above the sole, metres."""


@dataclass(frozen=True)
class BoneTurn:
    """How a bone lies in the A-pose: its rotation at the joint, and how much more it is twisted at its far end."""

    joint: int
    turn: np.ndarray
    """(4,) quaternion: smpl22's rest pose -> A-pose, at the near end."""
    axis: np.ndarray
    """(3,) the bone's direction in the rest pose."""
    twist: float
    """Radians about `axis` gained from the near to the far end."""


def to_rest_pose(mesh: SkinMesh, raw: dict[str, np.ndarray], skeleton: Skeleton = SMPL22) -> SkinMesh:
    """The mesh in smpl22's rest pose, pelvis at the origin; or in that of `skeleton`, smpl22 with other bone lengths.

    Every vertex is carried by the rigid motions of its bones, blended as dual quaternions (they keep volume), each
    bone's twist growing along it.
    """
    heads = joint_heads(raw)
    real = np.zeros((*mesh.weights.shape, 4))
    dual = np.zeros_like(real)
    for bone in bone_turns(raw):
        along, rest = rotations.rotate(bone.turn, bone.axis), skeleton.rest_positions[bone.joint]
        share = np.clip(
            (mesh.vertices - heads[bone.joint]) @ along / max(_length(skeleton, bone.joint), 1e-6), 0.0, 1.0
        )
        extra = rotations.rotvec_to_quaternion(bone.axis * (bone.twist * share)[:, None])
        back = rotations.invert(rotations.multiply(bone.turn, extra))
        shift = rest - rotations.rotate(back, heads[bone.joint])
        real[:, bone.joint] = back
        dual[:, bone.joint] = 0.5 * rotations.multiply(np.pad(shift, ((0, 0), (1, 0))), back)
    moved = _blend(real, dual, mesh.weights, mesh.vertices)
    twins = mesh.twins
    return replace(mesh, vertices=(moved + moved[twins] * [-1, 1, 1]) / 2)


def _blend(real: np.ndarray, dual: np.ndarray, weights: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Points (V, 3) under dual quaternions (V, J, 4) blended by weights (V, J)."""
    main = weights.argmax(1)[:, None, None]
    sign = np.where((real * np.take_along_axis(real, main, 1)).sum(-1) < 0, -1.0, 1.0)
    share = (weights * sign)[..., None]
    real, dual = (share * real).sum(1), (share * dual).sum(1)
    norm = np.linalg.norm(real, axis=-1, keepdims=True)
    real, dual = real / norm, dual / norm
    shift = 2.0 * rotations.multiply(dual, rotations.invert(real))[:, 1:]
    return rotations.rotate(real, points) + shift


def joint_heads(raw: dict[str, np.ndarray]) -> np.ndarray:
    """(J, 3) where smpl22's joints lie in the A-pose, made symmetric."""
    heads = np.zeros((len(SMPL22), 3))
    for bone, head in zip(raw["bones"], raw["heads"], strict=True):
        if "Hand" not in bone or bone.endswith("Hand"):
            heads[joint_of(str(bone))] = head
    return (heads + heads[SMPL22.mirror_index] * [-1, 1, 1]) / 2


def bone_turns(raw: dict[str, np.ndarray]) -> list[BoneTurn]:
    """The turn of each of smpl22's bones in the A-pose."""
    heads = joint_heads(raw)
    turns = {joint: np.array(rotations.IDENTITY) for joint in range(len(SMPL22))}
    for side in ("left_", "right_"):
        for upper, lower, end in (("hip", "knee", "ankle"), ("shoulder", "elbow", "wrist")):
            a, b, c = (SMPL22.index(side + name) for name in (upper, lower, end))
            hinge = np.cross(heads[b] - heads[a], heads[c] - heads[b])
            rest_hinge = SMPL22.hinges[side + lower]
            turns[a] = _frame(SMPL22.offsets[b], rest_hinge, heads[b] - heads[a], hinge)
            turns[b] = _frame(SMPL22.offsets[c], rest_hinge, heads[c] - heads[b], hinge)
        turns[SMPL22.index(side + "wrist")] = _hand(raw, heads, side)
        ankle, toe = SMPL22.index(side + "ankle"), SMPL22.index(side + "foot")
        ahead = (heads[toe] - heads[ankle]) * [1, 0, 1]  # the sole stays level: only the heading counts
        turns[ankle] = turns[toe] = rotations.between(np.array([0.0, 0.0, 1.0]), ahead)
    return [_with_twist(joint, turns) for joint in range(len(SMPL22))]


def _hand(raw: dict[str, np.ndarray], heads: np.ndarray, side: str) -> np.ndarray:
    """Turn of a hand: its middle finger runs along the arm in the rest pose, index before little finger."""
    place = dict(zip(raw["bones"], raw["heads"], strict=True))
    name = side.removesuffix("_").capitalize() + "Hand"
    along = place[name + "Middle1"] - place[name]
    across = place[name + "Index1"] - place[name + "Pinky1"]
    wrist = SMPL22.index(side + "wrist")
    return _frame(SMPL22.offsets[wrist], np.array([0.0, 0.0, 1.0]), along, across)


def _with_twist(joint: int, turns: dict[int, np.ndarray]) -> BoneTurn:
    """Spread the twist a limb's bone holds over its length: none at the trunk, all of it where the next bone begins."""
    name, turn = SMPL22.joints[joint], turns[joint]
    part = name.split("_")[-1]
    if part not in ("hip", "shoulder", "knee", "elbow"):
        return BoneTurn(joint, turn, np.zeros(3), 0.0)
    child = SMPL22.children[joint][0]
    axis = rotations.normalise(SMPL22.offsets[child])
    if part in ("hip", "shoulder"):
        swing = rotations.between(axis, rotations.rotate(turn, axis))
        return BoneTurn(joint, swing, axis, _twist_about(axis, rotations.multiply(rotations.invert(swing), turn)))
    onward = rotations.multiply(rotations.invert(turn), turns[child])
    return BoneTurn(joint, turn, axis, _twist_about(axis, onward))


def _twist_about(axis: np.ndarray, turn: np.ndarray) -> float:
    """Radians by which a rotation turns about an axis, the rest of it aside, in (-pi, pi]."""
    angle = 2.0 * np.arctan2(turn[1:] @ axis, turn[0])
    return float((angle + np.pi) % (2 * np.pi) - np.pi)


def _frame(rest_along: np.ndarray, rest_across: np.ndarray, along: np.ndarray, across: np.ndarray) -> np.ndarray:
    """(4,) rotation that takes one direction exactly, and a second as nearly as it can."""
    here, there = _axes(rest_along, rest_across), _axes(along, across)
    return rotations.matrix_to_quaternion(there @ here.T)


def _axes(along: np.ndarray, across: np.ndarray) -> np.ndarray:
    first = rotations.normalise(along)
    second = rotations.normalise(across - (across @ first) * first)
    return np.stack([first, second, np.cross(first, second)], axis=-1)


def _length(skeleton: Skeleton, joint: int) -> float:
    children = skeleton.children[joint]
    return float(skeleton.bone_lengths[children[0]]) if children else 0.0
