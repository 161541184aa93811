"""Facing, standing, and the exact way back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engines.formats import bvh
from engines.geometry import canonical, rotations
from engines.motion import Motion
from engines.skeletons import SMPL22, Skeleton

CALM = settings(deadline=None, max_examples=20)
REST = np.tile(rotations.IDENTITY, (12, 22, 1))


@st.composite
def motions(draw) -> Motion:
    """Random poses, path and root offset."""
    rng = np.random.default_rng(draw(st.integers(0, 2**31)))
    offsets = np.array(SMPL22.offsets)
    offsets[0] = rng.normal(size=3) * draw(st.sampled_from([0, 1]))
    turns = rotations.normalise(rotations.IDENTITY + rng.normal(size=(8, 22, 4)) * 0.4)
    return Motion(SMPL22.replaced(offsets=offsets), turns, rng.normal(size=(8, 3)) * 3, 20.0)


@CALM
@given(motions(), st.integers(0, 7))
def test_face_front_faces_front_and_restore_is_exact(motion: Motion, frame: int) -> None:
    front, placement = canonical.face_front(motion, frame)
    assert np.sin(front.heading[frame] / 2) == pytest.approx(0, abs=1e-9), "but for whole turns"
    np.testing.assert_allclose(front.positions[frame, 0, [0, 2]], 0, atol=1e-9)
    np.testing.assert_allclose(front.positions[..., 1], motion.positions[..., 1], atol=1e-9)
    back = placement.restore(front)
    np.testing.assert_allclose(back.positions, motion.positions, atol=1e-9)
    np.testing.assert_allclose(back.global_rotations, motion.global_rotations, atol=1e-9)
    again, nothing = canonical.face_front(front, frame)
    np.testing.assert_allclose(again.positions, front.positions, atol=1e-9)
    assert np.sin(nothing.yaw / 2) == pytest.approx(0, abs=1e-9)


@CALM
@given(st.floats(-3.1, 3.1))
def test_heading_of_a_turned_body(yaw: float) -> None:
    motion = Motion(SMPL22, REST, np.zeros((12, 3)), 20.0)
    np.testing.assert_allclose(motion.heading, 0, atol=1e-12)
    turned = motion.moved((1, 0, 2), yaw=yaw)
    np.testing.assert_allclose(turned.heading, yaw, atol=1e-9)
    ahead = turned.global_rotations[0, 0] @ [0, 0, 1]
    np.testing.assert_allclose(ahead, [np.sin(yaw), 0, np.cos(yaw)], atol=1e-9)


def test_heading_counts_whole_turns_on() -> None:
    yaw = np.linspace(0, 7 * np.pi, 60)
    turns = np.tile(rotations.IDENTITY, (60, 22, 1))
    turns[:, 0] = rotations.yaw_quaternion(yaw)
    np.testing.assert_allclose(Motion(SMPL22, turns, np.zeros((60, 3)), 20.0).heading, yaw, atol=1e-9)


def test_a_body_without_sides_has_no_heading() -> None:
    rod = Skeleton("rod", ("a", "b"), (-1, 0), np.array([[0, 0, 0], [0, 1.0, 0]]))
    assert not Motion(rod, np.tile(rotations.IDENTITY, (3, 2, 1)), np.zeros((3, 3)), 20.0).heading.any()


def test_sides_without_known_names_will_do() -> None:
    offsets = np.array([[0, 0, 0], [1.0, 0, 0], [-1.0, 0, 0]])
    body = Skeleton("body", ("trunk", "wing_a", "wing_b"), (-1, 0, 0), offsets, mirror_pairs=(("wing_a", "wing_b"),))
    turns = np.tile(rotations.IDENTITY, (2, 3, 1))
    turns[:, 0] = rotations.yaw_quaternion(np.array(0.7))
    np.testing.assert_allclose(Motion(body, turns, np.zeros((2, 3)), 20.0).heading, 0.7, atol=1e-12)


@pytest.mark.data
def test_heading_of_a_cmu_rig_is_that_of_the_same_body_as_house_motion(real_clips: Path) -> None:
    """The paired joints nearest its root are bones without length."""
    motion = bvh.read(real_clips / "cmu/bvh/09_12.bvh")[1:1600:20]
    house = motion.retarget(SMPL22)
    assert np.ptp(house.heading) > 1.0
    np.testing.assert_allclose(motion.heading, house.heading, atol=0.25)


@CALM
@given(st.floats(-2, 2))
def test_on_ground_puts_the_sole_on_the_floor(height: float) -> None:
    motion = Motion(SMPL22, REST, np.tile([0.3, height, 0.1], (12, 1)), 20.0).on_ground()
    lowest = motion.positions[:, SMPL22.index("left_foot"), 1]
    np.testing.assert_allclose(lowest, canonical.toe_clearance(SMPL22), atol=1e-9)
    np.testing.assert_allclose(motion.positions[:, 0, [0, 2]], np.tile([0.3, 0.1], (12, 1)), atol=1e-12)


def test_one_noisy_frame_does_not_move_the_floor() -> None:
    path = np.zeros((100, 3))
    path[50, 1] = -0.5
    motion = Motion(SMPL22, np.tile(rotations.IDENTITY, (100, 22, 1)), path, 20.0).on_ground()
    assert motion.positions[0, SMPL22.index("left_foot"), 1] == pytest.approx(canonical.toe_clearance(SMPL22), abs=1e-6)


def test_toe_clearance_is_the_drop_of_the_toes_end() -> None:
    assert canonical.toe_clearance(SMPL22) == pytest.approx(0.0277)
    assert canonical.toe_clearance(SMPL22.replaced(end_offsets={})) == 0.0


def test_leg_length_is_the_bones_from_root_to_ankle() -> None:
    hip = np.linalg.norm([0.1125, 0.0426, 0.0121])
    assert canonical.leg_length(SMPL22) == pytest.approx(hip + 0.4032 + 0.4277)
    assert canonical.leg_length(SMPL22.scaled({"*": 2.0})) == pytest.approx(2 * (hip + 0.4032 + 0.4277))
    assert canonical.leg_length(SMPL22.scaled({"left_knee": 2.0})) == pytest.approx(hip + 1.5 * 0.4032 + 0.4277)
    rest = SMPL22.rest_positions
    assert canonical.leg_length(SMPL22.replaced(feet=())) == pytest.approx(rest[0, 1] - rest[:, 1].min())
