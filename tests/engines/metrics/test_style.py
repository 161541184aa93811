"""Stylised motions: scores of known classifiers' answers, angles of known turns."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engines.errors import OutOfRangeError, SkeletonError
from engines.geometry import rotations
from engines.metrics import style
from engines.metrics.recognition import Recognised
from engines.motion import Motion
from engines.skeletons import SMPL22, Skeleton

RNG = np.random.default_rng(0)


def turn(angle: float, axis: np.ndarray) -> np.ndarray:
    return rotations.rotvec_to_matrix(angle * axis / np.linalg.norm(axis))


@given(angle=st.floats(0, np.pi), seed=st.integers(0, 10**6))
@settings(max_examples=100, deadline=None)
def test_the_distance_is_the_angle_between(angle: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    start = rotations.rotvec_to_matrix(rng.normal(size=3))
    end = start @ turn(angle, rng.normal(size=3))
    tolerance = 1e-12 if angle < 3 else 1e-6
    assert style.geodesic_distance(start, end) == pytest.approx(angle, abs=tolerance)
    assert style.geodesic_distance(end, start) == pytest.approx(angle, abs=tolerance)


def test_tiny_angles_keep_their_digits() -> None:
    for angle in (1e-4, 1e-7, 1e-10):
        assert style.geodesic_distance(np.eye(3), turn(angle, np.array([0.0, 1, 1]))) == pytest.approx(angle, rel=1e-5)
    assert style.geodesic_distance(np.eye(3), np.eye(3)) == 0


def moving(frames: int = 25) -> Motion:
    swings = 0.5 * np.sin(np.arange(frames)[:, None, None] / 5 + RNG.normal(size=(22, 3)))
    return Motion(SMPL22, rotations.rotvec_to_quaternion(swings), np.zeros((frames, 3)), 20.0)


def test_where_a_body_faces_is_not_its_pose() -> None:
    motion = moving()
    assert style.pose_distance(motion, motion) == 0
    assert style.pose_distance(motion, motion.moved((3, 0, 1), yaw=2.0)) == pytest.approx(0, abs=1e-9)


def test_one_bent_joint_counts_by_its_share() -> None:
    motion = moving()
    turns = np.array(motion.rotations)
    elbow = SMPL22.index("left_elbow")
    bend = rotations.rotvec_to_quaternion(np.array([0, 0, 0.6]))
    turns[:, elbow] = rotations.multiply(turns[:, elbow], bend)
    assert style.pose_distance(motion, motion.replaced(rotations=turns)) == pytest.approx(0.6 / 22)


def test_scores_are_named_and_right() -> None:
    features, labels = RNG.normal(size=(20, 4)), np.arange(20) % 5
    answers = np.eye(5)[labels]
    answers[:5] = np.roll(answers[:5], 1, axis=1)
    seen = Recognised(features + 2, answers)
    assert style.style_scores(seen, labels, features) == pytest.approx({"style_accuracy": 0.75, "style_fid": 16})
    assert style.content_scores(seen, labels, features) == pytest.approx({"content_accuracy": 0.75, "content_fid": 16})


def test_wrong_input_is_told() -> None:
    motion = moving()
    with pytest.raises(
        OutOfRangeError, match="frames of the stylised motion is '10 at 20 fps'; accepted: 25 at 20 fps"
    ):
        style.pose_distance(motion, motion[:10])
    with pytest.raises(OutOfRangeError, match="at 10 fps"):
        style.pose_distance(motion, motion.replaced(fps=10.0))
    rod = Skeleton("rod", ("a", "b"), (-1, 0), np.array([[0, 0, 0], [0, 1.0, 0]]))
    other = Motion(rod, np.tile(rotations.IDENTITY, (25, 2, 1)), np.zeros((25, 3)), 20.0)
    with pytest.raises(SkeletonError, match="skeletons 'smpl22' and 'rod'"):
        style.pose_distance(motion, other)
    with pytest.raises(OutOfRangeError, match="shape of the rotations"):
        style.geodesic_distance(np.eye(3), np.eye(3)[None])
    with pytest.raises(OutOfRangeError, match="shape of the rotations"):
        style.geodesic_distance(np.zeros((5, 4)), np.zeros((5, 4)))
    with pytest.raises(OutOfRangeError, match="NaN or infinite"):
        style.geodesic_distance(np.eye(3) * np.nan, np.eye(3))
