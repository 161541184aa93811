"""Positions back to rotations: exact, smooth, joints bending the right way, never a limb turned over."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engines.errors import SkeletonError
from engines.formats import bvh
from engines.geometry import inverse, kinematics, rotations
from engines.motion import Motion
from engines.skeletons import SMPL22, Skeleton

CALM = settings(deadline=None, max_examples=15)


def positions_of(turns: np.ndarray, path: np.ndarray, skeleton: Skeleton) -> np.ndarray:
    matrices = rotations.quaternion_to_matrix(turns)
    return kinematics.forward_kinematics(matrices, path, skeleton.offsets, skeleton.parents)[0]


def largest_step(turns: np.ndarray) -> float:
    """Largest change of any joint's rotation from one frame to the next, radians."""
    return float(rotations.angle(rotations.multiply(rotations.invert(turns[:-1]), turns[1:])).max())


def limb_pose(frames: int, **turned: np.ndarray) -> np.ndarray:
    """Quaternions (T, 22, 4) of `smpl22`, the named joints turned by rotation vectors (T, 3)."""
    turns = np.tile(rotations.IDENTITY, (frames, 22, 1))
    for joint, vectors in turned.items():
        turns[:, SMPL22.index(joint)] = rotations.rotvec_to_quaternion(vectors)
    return turns


@pytest.mark.data
@pytest.mark.parametrize(
    "name", ["cmu/bvh/09_12.bvh", "cmu/bvh/06_04.bvh", "raise-up-left-hand_normal_002", "dataset-1_walk_normal_001"]
)
def test_real_clips_come_back_exactly_and_as_smooth_as_they_were(real_clips: Path, name: str) -> None:
    path = real_clips / name if "/" in name else next(real_clips.rglob(f"*{name}.bvh"))
    motion = bvh.read(path)[1:300]  # a CMU file's first frame is a T-pose, a jump away from the second
    turns, root = inverse.inverse(motion.positions, motion.skeleton)
    assert np.abs(positions_of(turns, root, motion.skeleton) - motion.positions).max() < 1e-3
    assert largest_step(turns) <= 1.2 * largest_step(motion.rotations)
    assert ((turns[1:] * turns[:-1]).sum(-1) >= 0).all()


@CALM
@given(st.integers(0, 2**31), st.integers(1, 6))
def test_any_pose_of_the_house_skeleton_comes_back_exactly(seed: int, frames: int) -> None:
    rng = np.random.default_rng(seed)
    turns, root = rotations.normalise(rng.normal(size=(frames, 22, 4))), rng.normal(size=(frames, 3))
    turns[:, SMPL22.index("spine3")] = rotations.IDENTITY
    positions = positions_of(turns, root, SMPL22)
    back, path = inverse.inverse(positions, SMPL22)
    np.testing.assert_allclose(positions_of(back, path, SMPL22), positions, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(back, axis=-1), 1, atol=1e-12)


@CALM
@given(st.integers(0, 2**31))
def test_any_tree_comes_back_exactly(seed: int) -> None:
    rng = np.random.default_rng(seed)
    parents = (-1, *(j - 1 - int(rng.integers(0, 1 + (j > 3))) for j in range(1, 7)))
    skeleton = Skeleton("tree", tuple("abcdefg"), parents, rng.normal(size=(7, 3)))
    turns, root = rotations.normalise(rng.normal(size=(4, 7, 4))), rng.normal(size=(4, 3))
    positions = positions_of(turns, root, skeleton)
    back, path = inverse.inverse(positions, skeleton)
    np.testing.assert_allclose(positions_of(back, path, skeleton), positions, atol=1e-9)


def test_a_squat_flexes_knees_and_elbows_about_their_hinges() -> None:
    flex = 1.0 + np.sin(np.linspace(0, np.pi, 30))  # 57 to 115 degrees
    x, y = np.array([1.0, 0, 0]), np.array([0, 1.0, 0])
    bend = {f"{side}_hip": -flex[:, None] / 2 * x for side in ("left", "right")}
    bend |= {f"{side}_knee": flex[:, None] * SMPL22.hinges[f"{side}_knee"] for side in ("left", "right")}
    bend |= {"left_elbow": -flex[:, None] * y, "right_elbow": flex[:, None] * y}
    positions = positions_of(limb_pose(30, **bend), np.tile([0, 0.9, 0], (30, 1)), SMPL22)
    knee, ankle, hip = (SMPL22.index(f"left_{part}") for part in ("knee", "ankle", "hip"))
    assert (positions[:, knee, 2] > positions[:, hip, 2] + 0.1).all(), "the knees go forward"
    assert (positions[:, ankle, 2] < positions[:, knee, 2]).all()
    turns, _ = inverse.inverse(positions, SMPL22)
    for joint, hinge in SMPL22.hinges.items():
        vector = rotations.quaternion_to_rotvec(turns[:, SMPL22.index(joint)])
        np.testing.assert_allclose(vector @ hinge, flex, atol=1e-6, err_msg=joint)
        np.testing.assert_allclose(vector, flex[:, None] * hinge, atol=1e-6, err_msg=joint)


def test_twist_of_an_upper_arm_is_read_from_the_bent_elbow() -> None:
    twist = np.linspace(0, 1.2, 20)[:, None] * np.array([1.0, 0, 0])
    elbow = np.tile(1.3 * SMPL22.hinges["left_elbow"], (20, 1))
    positions = positions_of(limb_pose(20, left_shoulder=twist, left_elbow=elbow), np.zeros((20, 3)), SMPL22)
    turns, _ = inverse.inverse(positions, SMPL22)
    found = rotations.quaternion_to_rotvec(turns[:, SMPL22.index("left_shoulder")])
    assert np.abs(found - twist).max() < 0.12, "smoothing may trail a steady twist by a few degrees"


@CALM
@given(st.integers(0, 2**31), st.floats(0.0005, 0.006))
def test_straight_limbs_with_noise_never_turn_over(seed: int, noise: float) -> None:
    rng = np.random.default_rng(seed)
    swing = np.sin(np.linspace(0, 6, 60))[:, None] * 0.4
    legs = {f"{side}_hip": sign * swing * [1.0, 0, 0] for side, sign in (("left", 1), ("right", -1))}
    arms = {"left_shoulder": np.tile([0, 0, -1.3], (60, 1)), "right_shoulder": np.tile([0, 0, 1.3], (60, 1))}
    turns = limb_pose(60, **legs, **arms)
    clean = positions_of(turns, np.zeros((60, 3)), SMPL22)
    back, _ = inverse.inverse(clean + rng.normal(size=clean.shape) * noise, SMPL22)
    limbs = [SMPL22.index(f"{side}_{part}") for side in ("left", "right") for part in ("hip", "knee", "shoulder")]
    off = rotations.angle(rotations.multiply(rotations.invert(turns), back))[:, limbs]
    assert off.max() < np.pi / 4, "a limb turned about itself"


def test_knees_bent_slightly_backwards_by_noise_stay_forward() -> None:
    flex = np.where(np.arange(50) % 10 < 8, 0.9, -0.08)  # locks the knee for two frames of ten
    bend = {"left_hip": -flex[:, None] / 2 * [1.0, 0, 0], "left_knee": flex[:, None] * [1.0, 0, 0]}
    turns = limb_pose(50, **bend)
    back, _ = inverse.inverse(positions_of(turns, np.zeros((50, 3)), SMPL22), SMPL22)
    vector = rotations.quaternion_to_rotvec(back[:, SMPL22.index("left_knee")])
    np.testing.assert_allclose(vector[:, 0], flex, atol=0.02)


def test_a_rig_whose_rest_pose_points_the_other_way_does_not_flip() -> None:
    """Without hinges the rest direction means nothing: movement about its opposite must stay smooth."""
    rod = Skeleton("rig", ("a", "b", "c"), (-1, 0, 1), np.array([[0, 0, 0], [1.0, 0, 0], [1.0, 0, 0]]))
    t = np.linspace(0, 12, 200)
    b = np.stack([-np.ones(200), 0.1 * np.sin(t), 0.1 * np.cos(3 * t)], axis=-1)
    b = rotations.normalise(b)
    positions = np.stack([np.zeros((200, 3)), b, 2 * b], axis=1)
    turns, path = inverse.inverse(positions, rod)
    np.testing.assert_allclose(positions_of(turns, path, rod), positions, atol=1e-9)
    step = np.linalg.norm(np.diff(b, axis=0), axis=-1).max()
    assert largest_step(turns) < 1.2 * step


def test_bones_without_length_pass_their_children_on() -> None:
    names, parents = ("root", "none", "left", "right", "tip"), (-1, 0, 1, 1, 2)
    offsets = np.array([[0, 0, 0], [0, 0, 0], [0.2, 0.1, 0], [-0.2, 0.1, 0], [0.3, 0, 0]])
    skeleton = Skeleton("doubled", names, parents, offsets)
    rng = np.random.default_rng(3)
    turns = rotations.normalise(rng.normal(size=(5, 5, 4)))
    turns[:, 1] = rotations.IDENTITY
    positions = positions_of(turns, rng.normal(size=(5, 3)), skeleton)
    back, path = inverse.inverse(positions, skeleton)
    np.testing.assert_allclose(positions_of(back, path, skeleton), positions, atol=1e-9)


def test_bones_of_another_length_keep_the_skeletons_length_and_the_direction_seen() -> None:
    longer = SMPL22.scaled({"left_knee": 1.5, "left_ankle": 0.5})
    turns = limb_pose(4, left_hip=np.tile([0.3, 0.1, 0.2], (4, 1)))
    positions = positions_of(turns, np.zeros((4, 3)), longer)
    back = Motion.from_positions(positions, SMPL22, 20.0).positions
    hip, knee = SMPL22.index("left_hip"), SMPL22.index("left_knee")
    bone = back[:, knee] - back[:, hip]
    np.testing.assert_allclose(np.linalg.norm(bone, axis=-1), SMPL22.bone_lengths[knee], atol=1e-9)
    np.testing.assert_allclose(
        rotations.normalise(bone), rotations.normalise(positions[:, knee] - positions[:, hip]), atol=1e-9
    )


def test_all_joints_in_one_place_is_a_pose_all_the_same() -> None:
    turns, path = inverse.inverse(np.zeros((3, 22, 3)), SMPL22)
    assert np.isfinite(turns).all()
    np.testing.assert_allclose(np.linalg.norm(turns, axis=-1), 1)
    assert not path.any()


@pytest.mark.parametrize("shape", [(22, 3), (4, 21, 3), (4, 22, 2), (4, 66)])
def test_wrong_shapes_are_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(SkeletonError, match=r"accepted: \(frames, 22, 3\)"):
        inverse.inverse(np.zeros(shape), SMPL22)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_non_finite_positions_are_refused(value: float) -> None:
    positions = np.zeros((2, 22, 3))
    positions[1, 4, 1] = value
    with pytest.raises(SkeletonError, match="not finite"):
        inverse.inverse(positions, SMPL22)
