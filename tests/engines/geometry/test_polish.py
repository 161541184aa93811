from __future__ import annotations

import numpy as np
import pytest

from engines.errors import OutOfRangeError
from engines.geometry import rotations
from engines.geometry.polish import close_loop, smooth
from engines.metrics import physical
from engines.motion import Motion, Segment
from engines.skeletons import SMPL22, Skeleton
from tests.engines.action2motion.tiny import movement


def calmly(frames: int = 60) -> Motion:
    """Swings of two seconds and more."""
    return movement(frames, fps=80.0).replaced(fps=20.0)


def trembling(frames: int = 60, by: float = 0.03) -> Motion:
    draw = np.random.default_rng(0)
    calm = calmly(frames)
    shake = rotations.rotvec_to_quaternion(draw.normal(0, by, (frames, len(SMPL22), 3)))
    return calm.replaced(
        rotations=rotations.multiply(calm.rotations, shake),
        translation=calm.translation + draw.normal(0, by / 5, (frames, 3)),
    )


def apart(a: Motion, b: Motion) -> float:
    """Mean angle between the joints' rotations, radians."""
    return float(rotations.angle(rotations.multiply(rotations.invert(a.rotations), b.rotations)).mean())


def test_trembling_goes_and_the_movement_stays():
    calm, shaken = calmly(), trembling()
    after = smooth(shaken)
    assert physical.summary(after)["jitter"] < 0.1 * physical.summary(shaken)["jitter"]
    assert apart(after, calm) < 0.5 * apart(shaken, calm)
    assert np.abs(after.translation - calm.translation).mean() < np.abs(shaken.translation - calm.translation).mean()


def test_a_calm_motion_hardly_changes():
    calm = calmly()
    assert apart(smooth(calm, 0.05), calm) < 0.01


def test_the_ends_stay():
    shaken = trembling()
    after = smooth(shaken, 0.3)
    for at in (0, -1):
        np.testing.assert_allclose(after.translation[at], shaken.translation[at], atol=1e-12)
        same = np.abs((after.rotations[at] * shaken.rotations[at]).sum(-1))
        np.testing.assert_allclose(same, 1.0, atol=1e-9)


def test_a_path_walked_evenly_is_walked_evenly_to_its_ends():
    walk = movement(30)
    line = np.zeros((30, 3))
    line[:, 2] = np.arange(30) * 0.05
    after = smooth(walk.replaced(translation=line), 0.5)
    np.testing.assert_allclose(after.translation, line, atol=1e-12)


@pytest.mark.parametrize("frames", [1, 2, 3, 5])
@pytest.mark.parametrize("change", [smooth, close_loop])
def test_short_motions_pass(change, frames):
    assert len(change(movement(frames))) == frames


@pytest.mark.parametrize("change", [smooth, close_loop])
@pytest.mark.parametrize("seconds", [0, -1, float("nan")])
def test_a_time_that_is_none(change, seconds):
    with pytest.raises(OutOfRangeError):
        change(movement(5), seconds)


def turning(frames: int = 50) -> Motion:
    """Swinging joints on a curved way, ending elsewhere in every respect."""
    motion = movement(frames)
    yaw = rotations.yaw_quaternion(np.linspace(0.2, 2.0, frames))
    turns = motion.rotations.copy()
    turns[:, 0] = yaw
    path = np.stack([np.linspace(0, 2, frames) ** 2, np.linspace(0.9, 0.7, frames), np.linspace(0, 1, frames)], axis=-1)
    return motion.replaced(rotations=turns, translation=path, labels=(Segment(0, frames, "action", "walk"),))


def seam(motion: Motion) -> tuple[float, float]:
    """Angle a joint turns at most, and the root rises, from the last frame to the first, facing aside."""
    first = motion.face_front()
    last = motion.face_front(len(motion) - 1)
    turn = rotations.angle(rotations.multiply(rotations.invert(last.rotations[-1]), first.rotations[0]))
    return float(np.max(turn)), abs(motion.translation[-1, 1] - motion.translation[0, 1])


def test_a_loop_ends_in_its_first_pose_and_goes_on_facing_and_walking():
    before = turning()
    after = close_loop(before)
    step = rotations.angle(rotations.multiply(rotations.invert(after.rotations[:-1]), after.rotations[1:])).max()
    turn, rise = seam(after)
    assert turn < step
    assert turn < 0.1 * seam(before)[0]
    assert rise < 0.1 * seam(before)[1]
    assert after.labels == before.labels
    np.testing.assert_array_equal(after.translation[:, [0, 2]], before.translation[:, [0, 2]])
    assert abs(after.heading[-1] - before.heading[-1]) < 0.05
    np.testing.assert_array_equal(after.rotations[:-10], before.rotations[:-10])
    assert not np.array_equal(after.rotations[-10:], before.rotations[-10:])


def test_what_already_loops_stays():
    still = movement(1)
    motion = still.replaced(
        rotations=np.repeat(still.rotations, 20, axis=0), translation=np.repeat(still.translation, 20, axis=0)
    )
    np.testing.assert_allclose(close_loop(motion).positions, motion.positions, atol=1e-9)


def test_a_skeleton_that_faces_nowhere_loops_too():
    rod = Skeleton("rod", ("base", "tip"), (-1, 0), np.array([[0.0, 0, 0], [0, 1.0, 0]]))
    turns = rotations.rotvec_to_quaternion(np.linspace(0, 1, 20)[:, None, None] * np.ones((1, 2, 3)) * [0.5, 0, 0.2])
    after = close_loop(Motion(rod, turns, np.zeros((20, 3)), 20.0))
    left = rotations.angle(rotations.multiply(rotations.invert(after.rotations[-1]), after.rotations[0]))
    assert left.max() < 0.1
