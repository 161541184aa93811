"""Motions set behind each other do not jump."""

from __future__ import annotations

import numpy as np
import pytest

from engines.errors import OutOfRangeError
from engines.geometry.seams import join
from engines.motion import Motion
from tests.engines.action2motion.tiny import movement


def calm(frames: int = 60, seed: int = 0) -> Motion:
    """Swings of two seconds and more."""
    return movement(frames, seed, fps=80.0).replaced(fps=20.0)


def jolt(motion: Motion, at: int) -> float:
    """The strongest acceleration of a joint about a frame, metres a frame squared."""
    return float(np.linalg.norm(np.diff(motion.positions, n=2, axis=0), axis=-1)[at - 3 : at + 3].max())


def test_a_motion_that_is_cut_and_joined_is_what_it_was():
    whole = calm()
    again = join(whole[:30], whole[30:])
    assert np.abs(again.positions - whole.positions).max() < 0.02 * np.ptp(whole.positions)


def test_pose_place_and_speed_go_over_smoothly_and_the_ends_stay():
    first, second = calm(seed=0), calm(seed=5).moved((0.3, 0.1, -0.2))
    made = join(first, second)
    assert jolt(made, 60) < 0.25 * jolt(first.concat(second), 60)
    assert np.abs(made.positions[:60] - first.positions).max() < 1e-9
    assert np.abs(made.positions[70:] - second.positions[10:]).max() < 1e-6
    assert np.isfinite(made.positions).all()


@pytest.mark.parametrize(("one", "other"), [(1, 1), (1, 5), (5, 1), (2, 2)])
def test_the_shortest_motions(one, other):
    made = join(calm(one), calm(other, seed=3))
    assert len(made) == one + other
    assert np.isfinite(made.positions).all()


def test_no_time_no_change_and_no_negative_time():
    first, second = calm(10), calm(10, seed=3)
    assert np.array_equal(join(first, second, 0.0).positions, first.concat(second).positions)
    with pytest.raises(OutOfRangeError, match="seconds"):
        join(first, second, -1.0)
