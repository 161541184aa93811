"""The same movement on another skeleton."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engines.errors import SkeletonError
from engines.formats import bvh
from engines.geometry import canonical, retarget, rotations
from engines.motion import Motion
from engines.skeletons import SMPL22, roles

pytestmark = pytest.mark.filterwarnings("error::RuntimeWarning")
REST = np.tile(rotations.IDENTITY, (3, 22, 1))
LIMBS = [(f"{s}_{a}", f"{s}_{b}") for s in ("left", "right") for a, b in
         (("hip", "knee"), ("knee", "ankle"), ("shoulder", "elbow"), ("elbow", "wrist"))]  # fmt: skip


def directions(motion: Motion) -> dict[str, np.ndarray]:
    """Direction (T, 3) of each limb bone, by the role at its far end."""
    known = roles.recognise(motion.skeleton.joints)
    at = {role: motion.positions[:, motion.skeleton.index(joint)] for role, joint in known.items()}
    return {far: rotations.normalise(at[far] - at[near]) for near, far in LIMBS}


def degrees_apart(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.degrees(np.arccos(np.clip((a * b).sum(-1), -1, 1)))


def renamed(skeleton, **changes: str):
    names = tuple(changes.get(joint, joint) for joint in skeleton.joints)
    return skeleton.replaced(joints=names, feet=(), hinges={}, mirror_pairs=())


@pytest.fixture(scope="session")
def walk(real_clips: Path) -> Motion:
    """A CMU walk whose first frame is a T-pose."""
    return bvh.read(real_clips / "cmu/bvh/26_01.bvh")


def test_the_same_skeleton_is_no_change() -> None:
    motion = Motion(SMPL22, REST, np.zeros((3, 3)), 30.0)
    assert motion.retarget(SMPL22) is motion


def test_a_t_pose_of_another_body_is_the_identity() -> None:
    tall = renamed(SMPL22.scaled({"*": 1.2, "left_knee": 1.3, "right_knee": 1.3}))
    moved = Motion(tall, REST, np.zeros((3, 3)), 30.0).retarget(SMPL22)
    torso = rotations.angle(moved.rotations)
    assert torso.max() < 1e-6
    assert moved.skeleton == SMPL22


@settings(deadline=None, max_examples=8)
@given(st.integers(0, 2**31), st.floats(0.6, 1.5))
def test_a_body_of_another_size_makes_the_same_movement(seed: int, size: float) -> None:
    rng = np.random.default_rng(seed)
    turns = rotations.normalise(rotations.IDENTITY + rng.normal(size=(6, 22, 4)) * 0.3)
    other = SMPL22.scaled({"*": size}).replaced(name="other")
    path = rng.normal(size=(6, 3))
    moved = Motion(other, turns, path, 30.0).retarget(SMPL22)
    assert rotations.angle(rotations.multiply(rotations.invert(turns), moved.rotations)).max() < 1e-6
    np.testing.assert_allclose(moved.translation, path / size, atol=1e-6)


@pytest.mark.data
def test_a_cmu_walk_keeps_its_bone_directions_its_facing_and_its_feet_on_the_floor(walk: Motion) -> None:
    moved = walk.retarget(SMPL22, reference="first")[1:]
    source = walk[1:]
    assert len(moved) == len(source)
    assert moved.fps == source.fps
    mine, theirs = directions(moved), directions(source)
    first_mine, first_theirs = directions(walk.retarget(SMPL22, reference="first")[:1]), directions(walk[:1])
    for role in mine:
        # the T-pose of the file is not the T-pose of smpl22 to the degree: what is carried over is the turn since
        allowed = degrees_apart(first_mine[role], first_theirs[role]).max() + 6.0
        assert allowed < 20, role
        assert degrees_apart(mine[role], theirs[role]).max() < allowed, role
    np.testing.assert_allclose(moved.heading, source.heading, atol=0.2)
    left, right = (moved.positions[:, moved.skeleton.index(f"{side}_wrist")] for side in ("left", "right"))
    known = roles.recognise(source.skeleton.joints)
    across_source = source.positions[:, source.skeleton.index(known["left_wrist"])]
    across_source = across_source - source.positions[:, source.skeleton.index(known["right_wrist"])]
    assert (((left - right) * across_source).sum(-1) > 0).all(), "left is left"
    feet = moved.on_ground().positions[:, [SMPL22.index("left_foot"), SMPL22.index("right_foot")], 1].min(axis=1)
    assert np.abs(feet - canonical.toe_clearance(SMPL22)).max() < 0.05


@pytest.mark.data
def test_the_path_is_scaled_by_the_legs(walk: Motion) -> None:
    moved = walk.retarget(SMPL22, reference="first")[1:]
    went = np.linalg.norm(np.ptp(walk[1:].positions[:, 0, [0, 2]], axis=0))
    now = np.linalg.norm(np.ptp(moved.positions[:, 0, [0, 2]], axis=0))
    ratio = canonical.leg_length(SMPL22) / canonical.leg_length(walk.skeleton)
    assert now / went == pytest.approx(ratio, rel=0.05)


@pytest.mark.data
def test_to_the_house_skeleton_and_back(walk: Motion) -> None:
    """A rig with more joints: what smpl22 has no joints for (fingers) is lost, the limbs are not."""
    source = walk[1:120]
    there = source.retarget(SMPL22, reference=walk[:1])
    back = there.retarget(source.skeleton, target_reference=walk[:1])
    assert back.skeleton == source.skeleton
    for role, seen in directions(back).items():
        assert degrees_apart(seen, directions(source)[role]).max() < 8, role
    np.testing.assert_allclose(back.heading, source.heading, atol=0.1)


def test_a_target_with_splayed_legs_stands_as_the_source_stands() -> None:
    offsets = np.array(SMPL22.offsets)
    spread = np.radians(20)
    for side, sign in (("left", 1), ("right", -1)):
        for joint in ("knee", "ankle"):
            length = SMPL22.bone_lengths[SMPL22.index(f"{side}_{joint}")]
            offsets[SMPL22.index(f"{side}_{joint}")] = length * np.array([sign * np.sin(spread), -np.cos(spread), 0])
    splayed = SMPL22.replaced(offsets=offsets, name="splayed")
    straight = Motion(SMPL22, REST, np.zeros((3, 3)), 30.0)
    moved = straight.retarget(splayed)
    for role, seen in directions(moved).items():
        assert degrees_apart(seen, directions(straight)[role]).max() < 0.01, role
    back = moved.retarget(SMPL22)
    assert rotations.angle(back.rotations).max() < 1e-4


@pytest.mark.data
def test_onto_bandai_namcos_rig_and_back(bandai_folder: Path, walk: Motion) -> None:
    """Its bones all point along x at rest: it must be told a pose in which it stands."""
    from engines.datasets import bandai_namco

    rig = bandai_namco._standing_frame(bandai_folder)
    house = walk[1:60].retarget(SMPL22, reference=walk[:1])
    with pytest.raises(SkeletonError, match="target_reference"):
        house.retarget(rig.skeleton)
    there = house.retarget(rig.skeleton, target_reference=rig)
    for role, seen in directions(there).items():
        assert degrees_apart(seen, directions(house)[role]).max() < 10, role
    back = there.retarget(SMPL22, reference=rig)
    for role, seen in directions(back).items():
        assert degrees_apart(seen, directions(house)[role]).max() < 2, role
    np.testing.assert_allclose(back.heading, house.heading, atol=0.05)
    with pytest.raises(SkeletonError, match="target skeleton"):
        house.retarget(rig.skeleton, target_reference=house)


@pytest.mark.data
def test_a_bandai_namco_clip_by_a_standing_frame(bandai_folder: Path) -> None:
    from engines.datasets import bandai_namco

    source = bvh.read(next(bandai_folder.rglob("dataset-2_raise-up-left-hand_normal_002.bvh")))
    standing = bandai_namco._standing_frame(bandai_folder)
    moved = source.retarget(SMPL22, reference=standing)
    for role, seen in directions(moved).items():
        assert np.median(degrees_apart(seen, directions(source)[role])) < 12, role
    wrist = moved.positions[:, [SMPL22.index("left_wrist"), SMPL22.index("right_wrist")], 1]
    assert np.ptp(wrist[:, 0]) > 5 * np.ptp(wrist[:, 1])


def test_a_rest_pose_that_does_not_stand_is_refused() -> None:
    lying = SMPL22.replaced(offsets=SMPL22.offsets[:, [1, 0, 2]], name="lying")
    with pytest.raises(SkeletonError, match=r"does not stand upright.*reference='first'"):
        Motion(lying, REST, np.zeros((3, 3)), 30.0).retarget(SMPL22)


def test_missing_joints_are_named() -> None:
    strange = renamed(SMPL22, left_knee="zork", right_wrist="blip")
    with pytest.raises(SkeletonError, match=r"left_knee.*right_wrist"):
        Motion(strange, REST, np.zeros((3, 3)), 30.0).retarget(SMPL22)
    names = {role: {"left_knee": "zork", "right_wrist": "blip"}.get(role, role) for role in SMPL22.joints}
    moved = Motion(strange, REST, np.zeros((3, 3)), 30.0).retarget(SMPL22, names=names)
    assert rotations.angle(moved.rotations).max() < 1e-6


def test_a_reference_of_another_skeleton_is_refused() -> None:
    strange = renamed(SMPL22, head="top_of_the_neck")
    motion = Motion(strange, REST, np.zeros((3, 3)), 30.0)
    with pytest.raises(SkeletonError, match="same skeleton"):
        motion.retarget(SMPL22, reference=Motion(SMPL22, REST, np.zeros((3, 3)), 30.0))


@settings(deadline=None, max_examples=6)
@given(st.integers(0, 2**31))
def test_points_of_the_house_skeleton_give_its_limbs_back(seed: int) -> None:
    rng = np.random.default_rng(seed)
    turns = np.tile(rotations.IDENTITY, (5, 22, 1))
    for part in ("hip", "knee", "shoulder", "elbow"):
        for side in ("left", "right"):
            turns[:, SMPL22.index(f"{side}_{part}")] = rotations.rotvec_to_quaternion(rng.normal(size=3) * 0.5)
    source = Motion(SMPL22, turns, rng.normal(size=(5, 3)), 20.0)
    needed = [*retarget._NEEDED, "head", "left_foot", "right_foot"]
    points = {role: source.positions[:, SMPL22.index(role)] for role in needed}
    moved = retarget.from_points(points, 20.0)
    for role, seen in directions(moved).items():
        assert degrees_apart(seen, directions(source)[role]).max() < 1e-3, role
    np.testing.assert_allclose(moved.heading, source.heading, atol=0.05)


def test_points_that_are_missing_are_named() -> None:
    points = {role: np.zeros((2, 3)) for role in retarget._NEEDED if role != "right_elbow"}
    with pytest.raises(SkeletonError, match="right_elbow"):
        retarget.from_points(points, 20.0)
