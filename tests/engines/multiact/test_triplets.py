"""Triplets: what is cut stays as it was captured, what is joined has no jump, labels and lengths are right."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from engines.geometry import rotations
from engines.motion import Motion
from engines.multiact import triplets
from engines.multiact.representation import FPS, D, decode, encode
from engines.multiact.triplets import PREVIOUS, SHORTEST, Pool
from engines.skeletons import SMPL22
from tests.engines.action2motion.tiny import clip, movement
from tests.engines.multiact.tiny import clips


def walk(frames: int = 120, turn: tuple[int, int] = (50, 70), by: float = 1.6) -> Motion:
    """Straight on at 1.2 m/s, but for some frames in which it turns."""
    yaw = np.interp(np.arange(frames), turn, (0, by))
    step = 1.2 / FPS * np.stack([np.sin(yaw), np.zeros(frames), np.cos(yaw)], axis=-1)
    turns = np.tile(rotations.IDENTITY, (frames, 22, 1))
    turns[:, 0] = rotations.yaw_quaternion(yaw)
    return Motion(SMPL22, turns, np.cumsum(step, axis=0) + np.array([0, 0.95, 0]), FPS)


def test_features_come_back_in_the_frame_of_the_anchor() -> None:
    motion = movement(40)
    features = encode(motion, 11)
    assert features.shape == (40, D) and features.dtype == np.float32
    back = decode(features[12:])
    np.testing.assert_allclose(back.positions, motion.face_front(11).positions[12:], atol=1e-5)
    shifted = motion.moved((3.0, 0.0, -2.0), yaw=1.0)
    np.testing.assert_allclose(encode(shifted, 11), features, atol=1e-5)


@pytest.mark.parametrize("by", [1.6, -1.6])
def test_a_walk_that_turns_is_cut_where_it_does(by: float) -> None:
    first, last = triplets.turning(walk(by=by))
    assert abs(first - 50) <= 5 and abs(last - 70) <= 6
    assert triplets.turning(walk(by=0.0)) == (0, 0)


def test_cut_triplets_are_as_they_were_captured() -> None:
    original = replace(clip("turn left"), motion=walk())
    pool = Pool([original])
    rng = np.random.default_rng(0)
    seen = set()
    for _ in range(40):
        made = pool.draw(rng)
        seen.add((made.captured, *made.actions))
        if made.captured:  # frame for frame a stretch of the clip, or of its mirror image
            speed = np.linalg.norm(np.diff(made.motion.translation, axis=0), axis=-1)
            np.testing.assert_allclose(speed, 1.2 / FPS, rtol=1e-6)
        assert len(made.motion) - PREVIOUS - made.transition >= SHORTEST
    assert {(True, "walk", "turn left"), (True, "turn left", "walk"), (True, "walk", "turn right")} <= seen


def test_joined_triplets_go_on_without_a_jump_in_place_pose_or_speed() -> None:
    pool = Pool([clip(action, 70, seed) for seed, action in enumerate(("throw", "sit down", "bow"))])
    rng = np.random.default_rng(0)
    for _ in range(12):
        made = pool.draw(rng)
        assert not made.captured and made.motion.frames <= PREVIOUS + triplets.TRANSITION[1] + triplets.LONGEST
        steps = np.linalg.norm(np.diff(made.motion.positions, axis=0), axis=-1).max(axis=1)
        inside = steps[PREVIOUS + made.transition :]
        assert steps[PREVIOUS - 1] < 1.5 * max(steps[: PREVIOUS - 1].max(), inside.max())


def test_the_same_seed_gives_the_same_triplets_and_lengths_fit() -> None:
    one, again, other = (triplets.make(clips(), 16, seed) for seed in (3, 3, 4))
    assert np.array_equal(one.frames, again.frames) and not np.array_equal(one.lengths, other.lengths)
    assert np.array_equal(np.diff(one.starts), PREVIOUS + one.lengths.sum(1)[:-1])
    assert len(one.frames) == one.starts[-1] + PREVIOUS + one.lengths[-1].sum()
    assert one.actions.max() < len(one.names) and set(one.names) <= {c.action for c in clips()}
    assert (one.lengths[:, 0] >= triplets.TRANSITION[0]).all() and (one.lengths[:, 1] >= SHORTEST).all()
