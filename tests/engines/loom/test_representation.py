"""Features of a motion and back, and the path that velocities and places agree on."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from engines.loom.passes import Passes
from engines.loom.representation import (
    FREE,
    HELD,
    LAYOUT,
    decode,
    follow,
    frames_of,
    from_start,
    joints_from_start,
    kinematics,
)
from engines.motion import Motion
from engines.skeletons import SMPL22
from tests.engines.action2motion.tiny import movement
from tests.engines.loom.tiny import model


def features(motion: Motion) -> np.ndarray:
    """(T, D), not normalised."""
    made = model()
    rows = Passes(made).features(motion)[0, : len(motion)]
    return (rows * made.std + made.mean).numpy()


@pytest.mark.parametrize("seed", range(3))
def test_there_and_back(seed: int) -> None:
    motion = movement(37, seed)
    turns, path = decode(features(motion))
    back = Motion(SMPL22, turns, path, 20.0)
    first = frames_of(motion)
    x, z = first.ground[0]
    seen = motion.moved((-float(x), 0.0, -float(z))).moved(yaw=-float(first.yaw[0]))
    assert np.abs(back.positions - seen.positions).max() < 2e-4


def test_kinematics_agree_with_the_motion() -> None:
    motion = movement(9)
    found = frames_of(motion)
    places = kinematics(torch.from_numpy(found.turns), torch.from_numpy(found.height))
    np.testing.assert_allclose(places.numpy(), found.joints, atol=2e-5)
    rows = torch.from_numpy(features(motion))[None]
    world = joints_from_start(places[None], LAYOUT.read(rows, "ground"), LAYOUT.read(rows, "facing"))
    ground, facing = from_start(torch.from_numpy(found.ground)[None], torch.from_numpy(found.yaw)[None])
    torch.testing.assert_close(LAYOUT.read(rows, "ground"), ground, atol=1e-4, rtol=0)
    torch.testing.assert_close(LAYOUT.read(rows, "facing"), facing, atol=1e-4, rtol=0)
    np.testing.assert_allclose(
        np.linalg.norm(world[0, :, 5] - world[0, :, 0], axis=-1),
        np.linalg.norm(motion.positions[:, 5] - motion.positions[:, 0], axis=-1), atol=1e-4,
    )  # fmt: skip


@settings(max_examples=25, deadline=None)
@given(st.integers(1, 12), st.integers(0, 2**31))
def test_follow_is_the_least_squares_path(frames: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    steps, places, weight = rng.normal(size=(frames - 1, 2)), rng.normal(size=(frames, 2)), rng.uniform(0.01, 9, frames)
    rows = np.zeros((frames - 1, frames))
    rows[np.arange(frames - 1), np.arange(frames - 1)], rows[np.arange(frames - 1), np.arange(1, frames)] = -1, 1
    root = np.sqrt(weight)[:, None]
    stacked, right = np.vstack([rows, root * np.eye(frames)]), np.vstack([steps, root * places])
    expected = np.linalg.lstsq(stacked, right, rcond=None)[0]
    np.testing.assert_allclose(follow(steps, places, weight), expected, atol=1e-8)


def test_pinned_places_are_kept_whatever_the_velocities_say() -> None:
    rows = features(movement(30))
    rows[:, LAYOUT["velocity"]] = 0.0
    held = np.full((30, 2), FREE)
    held[[0, 17]] = HELD
    _, path = decode(rows, held)
    np.testing.assert_allclose(path[[0, 17]][:, [0, 2]], rows[[0, 17]][:, LAYOUT["ground"]], atol=1e-3)


def test_whole_turns_are_counted() -> None:
    motion = movement(60, turning=6.0)
    turns, path = decode(features(motion))
    yaw = frames_of(Motion(SMPL22, turns, path, 20.0)).yaw
    assert yaw[-1] - yaw[0] == pytest.approx(frames_of(motion).yaw[-1] - frames_of(motion).yaw[0], abs=1e-3)
