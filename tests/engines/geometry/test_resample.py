"""Sampling at another rate."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from engines.geometry import resample, rotations

CALM = settings(deadline=None, max_examples=30)


@CALM
@given(st.integers(1, 40), st.sampled_from([10.0, 20, 24, 30, 60, 120]), st.sampled_from([10.0, 20, 25, 29.97, 30, 60]))
def test_length_ends_and_a_steady_turn(frames: int, fps: float, new_fps: float) -> None:
    times = np.arange(frames) / fps
    turns = rotations.yaw_quaternion(times * 0.8)[:, None]
    path = np.stack([times, 2 * times, -times], axis=-1)
    new_turns, new_path = resample.resample(turns, path, fps, new_fps)
    assert len(new_turns) == len(new_path) == int(np.floor((frames - 1) * new_fps / fps + 1e-6)) + 1
    new_times = np.arange(len(new_path)) / new_fps
    assert new_times[-1] <= times[-1] + 1e-6
    np.testing.assert_allclose(new_path, np.stack([new_times, 2 * new_times, -new_times], axis=-1), atol=1e-6)
    np.testing.assert_allclose(new_turns[:, 0], rotations.yaw_quaternion(new_times * 0.8), atol=1e-6)


def test_frames_that_fall_together_are_kept() -> None:
    rng = np.random.default_rng(0)
    turns, path = rotations.normalise(rng.normal(size=(9, 3, 4))), rng.normal(size=(9, 3))
    new_turns, new_path = resample.resample(turns, path, 30, 60)
    np.testing.assert_allclose(new_path[::2], path, atol=1e-12)
    np.testing.assert_allclose(np.abs((new_turns[::2] * turns).sum(-1)), 1, atol=1e-12)
    half, _ = resample.resample(turns, path, 30, 15)
    np.testing.assert_allclose(np.abs((half * turns[::2]).sum(-1)), 1, atol=1e-12)
