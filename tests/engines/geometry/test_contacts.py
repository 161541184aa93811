"""Foot contacts of feet whose state is known."""

from __future__ import annotations

import numpy as np
import pytest

from engines.geometry import contacts
from engines.motion import Motion
from engines.skeletons import SMPL22, Skeleton


def standing(frames: int = 40) -> np.ndarray:
    """Joint positions (T, 22, 3) of the T-pose, soles on y = 0."""
    rest = SMPL22.rest_positions
    rest = rest - [0, rest[:, 1].min() - 0.0277, 0]
    return np.tile(rest, (frames, 1, 1))


def foot(side: str) -> list[int]:
    return [SMPL22.index(f"{side}_ankle"), SMPL22.index(f"{side}_foot")]


def test_a_stand_is_all_contact() -> None:
    assert contacts.detect(standing(), 20.0, SMPL22).all()


def test_a_planted_and_a_swinging_foot() -> None:
    positions = standing()
    positions[10:20, foot("left"), 1] += 0.2  # lifted, not moving
    positions[25:35, foot("left"), 2] += np.linspace(0, 0.9, 10)[:, None]  # slid along the floor at 2 m/s
    positions[35:, foot("left"), 2] += 0.9
    seen = contacts.detect(positions, 20.0, SMPL22)
    assert seen.shape == (40, 2, 2)
    assert seen[:, 1].all(), "the right foot is planted"
    assert not seen[10:20, 0].any(), "lifted"
    assert not seen[26:34, 0].any(), "sliding"
    assert seen[:9, 0].all()
    assert seen[36:, 0].all()


def test_heel_up_with_the_toe_down() -> None:
    positions = standing()
    positions[5:15, SMPL22.index("right_ankle"), 1] += 0.12
    seen = contacts.detect(positions, 20.0, SMPL22)
    assert not seen[5:15, 1, 0].any()
    assert seen[:, 1, 1].all()


def test_a_clip_that_never_lands_has_no_contacts() -> None:
    assert not contacts.detect(standing() + np.array([0, 1.0, 0]), 20.0, SMPL22).any()


def test_speed_is_metres_a_second_and_one_frame_is_at_rest() -> None:
    points = np.zeros((6, 2, 3))
    points[:, 1, 0] = np.arange(6) * 0.1
    np.testing.assert_allclose(contacts.joint_speed(points, 30.0), np.tile([0.0, 3.0], (6, 1)))
    assert contacts.joint_speed(points[:1], 30.0).tolist() == [[0, 0]]


def test_a_body_without_feet() -> None:
    rod = Skeleton("rod", ("a", "b"), (-1, 0), np.array([[0, 0, 0], [0, 1, 0]]))
    assert Motion(rod, np.tile([1.0, 0, 0, 0], (3, 2, 1)), np.zeros((3, 3)), 20.0).contacts.shape == (3, 0, 2)


@pytest.mark.parametrize("fps", [20.0, 60.0])
def test_a_motion_caches_them(fps: float) -> None:
    motion = Motion.from_positions(standing(5), SMPL22, fps)
    assert motion.contacts.all()
    assert motion.contacts is motion.contacts
