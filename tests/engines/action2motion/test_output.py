"""From the model's frames to Motions at the house rate."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from scipy.interpolate import CubicSpline

from engines.action2motion.model import Poses
from engines.action2motion.output import Upsampler, to_motions
from engines.action2motion.representation import encode
from engines.skeletons import SMPL22
from tests.engines.action2motion.test_representation import at_front
from tests.engines.action2motion.tiny import movement


def poses(motions, plain: bool = False) -> Poses:
    """What a perfect model would decode."""
    parts = [encode(motion) for motion in motions]
    height, lie, matrices, positions, velocity = (
        torch.from_numpy(np.stack([getattr(part, name) for part in parts], axis=1))
        for name in ("height", "lie", "matrices", "positions", "velocity")
    )
    if plain:
        return Poses(positions.flatten(-2), positions, None, velocity)
    return Poses(torch.cat([height, lie.flatten(-2)], dim=-1), positions, matrices, velocity)


@pytest.mark.parametrize("steps", [1, 2, 5, 128, 129, 300])
@pytest.mark.parametrize("shape", [(), (2, 3)])
def test_upsampling_is_a_natural_spline(steps: int, shape: tuple[int, ...]) -> None:
    values = np.random.default_rng(0).normal(size=(steps, *shape))
    frames = 2 * steps - 1
    made = Upsampler(steps, 10.0, 20.0, frames)(values)
    assert made.shape == (frames, *shape)
    np.testing.assert_allclose(made[::2], values, atol=1e-6)
    if steps > 1:
        expected = CubicSpline(np.arange(steps), values, bc_type="natural")(np.arange(frames) / 2)
        np.testing.assert_allclose(made, expected, atol=1e-5)


def test_times_past_the_last_step_hold_it() -> None:
    values = np.arange(4.0)
    np.testing.assert_allclose(Upsampler(4, 10.0, 20.0, 10)(values)[6:], 3.0, atol=1e-6)


def test_at_the_same_rate_the_motion_comes_back() -> None:
    motions = [movement(21, seed) for seed in range(3)]
    made = to_motions(poses(motions), Upsampler(21, 20.0, 20.0, 21))
    for motion, found in zip(motions, made, strict=True):
        expected = at_front(motion)
        np.testing.assert_allclose(found.positions, expected.positions, atol=5e-5)
        np.testing.assert_allclose(found.global_rotations, expected.global_rotations, atol=5e-5)


def test_between_the_models_frames_the_motion_is_smooth() -> None:
    motion = movement(41, seed=1, turning=1.0)
    made = to_motions(poses([motion[::2]]), Upsampler(21, 10.0, 20.0, 41))[0]
    expected = at_front(motion)
    # the model's frames are met, those between are about right and no rougher
    np.testing.assert_allclose(made.positions[::2], expected.positions[::2], atol=5e-5)
    assert np.abs(made.positions - expected.positions).max() < 0.03


def test_the_plain_decoders_joints_become_rotations() -> None:
    motion = movement(15, seed=2)
    made = to_motions(poses([motion], plain=True), Upsampler(15, 20.0, 20.0, 15))[0]
    assert made.skeleton == SMPL22
    np.testing.assert_allclose(made.positions, at_front(motion).positions, atol=5e-4)


def test_the_first_velocity_is_not_looked_at() -> None:
    motions = poses([movement(6)])
    moved = Poses(motions.vectors, motions.positions, motions.matrices, motions.velocity.clone())
    moved.velocity[0] = 5.0
    a, b = (to_motions(p, Upsampler(6, 10.0, 20.0, 11))[0] for p in (motions, moved))
    np.testing.assert_array_equal(a.positions, b.positions)
    np.testing.assert_allclose(a.positions[0, 0, [0, 2]], 0, atol=1e-9)
