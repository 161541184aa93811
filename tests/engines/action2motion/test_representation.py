"""Motions as the networks see them and back; a motion's place and heading leave no trace."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from engines.action2motion.representation import (
    Features,
    decode,
    encode,
    local_positions,
    root_yaw,
    travel,
    world_step,
)
from engines.geometry import rotations
from engines.motion import Motion
from engines.skeletons import SMPL22
from tests.engines.action2motion.tiny import movement

ARRAYS = ("height", "lie", "matrices", "positions", "velocity", "contacts")


def back(features: Features, fps: float = 20.0) -> Motion:
    return Motion(SMPL22, *decode(features.height, features.matrices, features.velocity), fps)


def at_front(motion: Motion) -> Motion:
    """Its root's yaw zero and its root above the origin at the first frame."""
    turned = motion.moved(yaw=-float(root_yaw(motion.global_rotations[:, 0])[0]))
    return turned.moved((-turned.positions[0, 0, 0], 0.0, -turned.positions[0, 0, 2]))


@settings(max_examples=15, deadline=None)
@given(st.integers(1, 60), st.integers(0, 999), st.floats(-6, 6))
def test_encode_then_decode_is_the_motion(frames: int, seed: int, turning: float) -> None:
    motion = movement(frames, seed, turning=turning)
    made, expected = back(encode(motion)), at_front(motion)
    np.testing.assert_allclose(made.positions, expected.positions, atol=3e-5)
    np.testing.assert_allclose(made.global_rotations, expected.global_rotations, atol=3e-5)


@settings(max_examples=10, deadline=None)
@given(st.floats(-10, 10), st.floats(-5, 5), st.floats(-5, 5))
def test_place_and_heading_leave_no_trace(yaw: float, x: float, z: float) -> None:
    motion = movement(12, seed=4)
    here, there = encode(motion), encode(motion.moved(yaw=yaw).moved((x, 0.0, z)))
    for name in ARRAYS:
        np.testing.assert_allclose(getattr(there, name), getattr(here, name), atol=1e-5, err_msg=name)


def test_shapes_and_the_first_step() -> None:
    features = encode(movement(9))
    shapes = {"height": (9, 1), "lie": (9, 22, 3), "matrices": (9, 22, 3, 3), "positions": (9, 22, 3)}
    shapes |= {"velocity": (9, 3), "contacts": (9, 4)}
    for name, shape in shapes.items():
        assert getattr(features, name).shape == shape
        assert getattr(features, name).dtype == np.float32
    np.testing.assert_array_equal(features.velocity[0], 0)
    np.testing.assert_allclose(features.positions[:, 0, [0, 2]], 0, atol=1e-6)
    np.testing.assert_allclose(features.positions[:, 0, 1], features.height[:, 0], atol=1e-6)


def test_a_step_forward_is_forward_whatever_the_heading() -> None:
    for yaw in (0.0, 1.0, np.pi):
        turns = np.tile(rotations.IDENTITY, (5, 22, 1))
        turns[:, 0] = rotations.yaw_quaternion(np.full(5, yaw))
        path = np.stack([0.1 * np.arange(5) * np.sin(yaw), np.ones(5), 0.1 * np.arange(5) * np.cos(yaw)], axis=-1)
        velocity = encode(Motion(SMPL22, turns, path, 20.0)).velocity
        np.testing.assert_allclose(velocity[1:], np.tile([0.0, 0.1, 0.0], (4, 1)), atol=1e-6)


def test_travel_is_the_sum_of_steps_along_the_heading_before() -> None:
    """Equation 3.9's sum for the root: what stood there, plus the step, frame after frame."""
    velocity = np.random.default_rng(1).normal(size=(20, 3)) * [0.1, 0.1, 0.4]
    yaw, place, heading = [], np.zeros(2), 0.0
    places = []
    for x, z, turn in velocity:
        step = [np.cos(heading) * x + np.sin(heading) * z, -np.sin(heading) * x + np.cos(heading) * z]
        place = np.add(place, step)
        heading += turn
        yaw.append(heading)
        places.append(place)
    made_yaw, ground = travel(velocity)
    np.testing.assert_allclose(made_yaw, yaw, atol=1e-12)
    np.testing.assert_allclose(ground, places, atol=1e-12)
    batched = travel(np.stack([velocity, 2 * velocity], axis=1))
    np.testing.assert_allclose(batched[1][:, 0], ground, atol=1e-12)


def test_joints_are_those_before_plus_the_step() -> None:
    """Equation 3.9: J_t = J_(t-1) + V + local pose, for every joint, seen from the heading before."""
    motion = movement(25, seed=7)
    features = encode(motion)
    step = world_step(torch.from_numpy(features.positions)[:, None], torch.from_numpy(features.velocity)[:, None])
    yaw = root_yaw(motion.global_rotations[:, 0])
    world = rotations.rotate(rotations.yaw_quaternion(-yaw[:-1])[:, None], np.diff(motion.positions, axis=0))
    np.testing.assert_allclose(step[:, 0].numpy(), world, atol=1e-5)


def test_local_positions_are_the_features() -> None:
    features = encode(movement(11, seed=2))
    positions, matrices = local_positions(torch.from_numpy(features.height), torch.from_numpy(features.lie))
    np.testing.assert_allclose(positions.numpy(), features.positions, atol=1e-5)
    np.testing.assert_allclose(matrices.numpy(), features.matrices, atol=1e-5)


@pytest.mark.parametrize("pitch", [0.0, 1.2, 1.5, 1.9, 2.5, -1.5])
def test_a_bent_body_keeps_its_heading(pitch: float) -> None:
    """Bent forward past the horizontal, the root's z axis points at the ground and then back."""
    bend = np.linspace(0, pitch, 40)
    turn = rotations.multiply(
        rotations.yaw_quaternion(np.full(40, 0.7)),
        rotations.rotvec_to_quaternion(np.stack([bend, np.zeros(40), np.zeros(40)], axis=-1)),
    )
    yaw = root_yaw(rotations.quaternion_to_matrix(turn))
    bent_double = np.abs(bend) < np.pi / 2 + 0.3
    np.testing.assert_allclose(yaw[bent_double], 0.7, atol=1e-6)
