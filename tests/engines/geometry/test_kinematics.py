"""Forward kinematics: NumPy, torch and a naive loop give the same; gradients flow."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from engines.geometry import kinematics, rotations
from engines.skeletons import SMPL22

CALM = settings(deadline=None, max_examples=20)


def naive(turns: np.ndarray, root: np.ndarray, offsets: np.ndarray, parents: tuple[int, ...]):
    """One pose (J, 3, 3) at a time, joint by joint."""
    places, world = np.zeros((len(parents), 3)), np.zeros((len(parents), 3, 3))
    for joint, parent in enumerate(parents):
        if parent < 0:
            world[joint], places[joint] = turns[joint], root + offsets[joint]
        else:
            world[joint] = world[parent] @ turns[joint]
            places[joint] = places[parent] + world[parent] @ offsets[joint]
    return places, world


@st.composite
def bodies(draw):
    """A random tree, and random poses of some batch shape."""
    rng = np.random.default_rng(draw(st.integers(0, 2**31)))
    joints = draw(st.integers(1, 9))
    parents = (-1, *(int(rng.integers(0, j)) for j in range(1, joints)))
    shape = draw(st.sampled_from([(), (1,), (4,), (2, 3)]))
    turns = rotations.quaternion_to_matrix(rng.normal(size=(*shape, joints, 4)))
    return turns, rng.normal(size=(*shape, 3)), rng.normal(size=(joints, 3)), parents


@CALM
@given(bodies())
def test_numpy_torch_and_the_naive_loop_agree(body) -> None:
    turns, root, offsets, parents = body
    places, world = kinematics.forward_kinematics(turns, root, offsets, parents)
    assert places.shape == (*turns.shape[:-2], 3)
    for at in np.ndindex(turns.shape[:-3]):
        expected = naive(turns[at], root[at], offsets, parents)
        np.testing.assert_allclose(places[at], expected[0], atol=1e-12)
        np.testing.assert_allclose(world[at], expected[1], atol=1e-12)
    tensors = [torch.from_numpy(np.asarray(value)) for value in (turns, root, offsets)]
    torch_places, torch_world = kinematics.forward_kinematics(*tensors, parents)
    assert isinstance(torch_places, torch.Tensor)
    np.testing.assert_allclose(torch_places.numpy(), places, atol=1e-12)
    np.testing.assert_allclose(torch_world.numpy(), world, atol=1e-12)


@CALM
@given(st.integers(0, 2**31))
def test_offsets_may_differ_from_pose_to_pose(seed: int) -> None:
    rng = np.random.default_rng(seed)
    turns = rotations.quaternion_to_matrix(rng.normal(size=(3, 22, 4)))
    offsets, root = rng.normal(size=(3, 22, 3)), rng.normal(size=(3, 3))
    places, _ = kinematics.forward_kinematics(turns, root, offsets, SMPL22.parents)
    for i in range(3):
        expected, _ = naive(turns[i], root[i], offsets[i], SMPL22.parents)
        np.testing.assert_allclose(places[i], expected, atol=1e-12)


def test_gradients_flow_and_are_right() -> None:
    generator = torch.Generator().manual_seed(0)
    parents = (-1, 0, 1, 1)
    turns = torch.randn(2, 4, 3, 3, generator=generator, dtype=torch.float64, requires_grad=True)
    root = torch.randn(2, 3, generator=generator, dtype=torch.float64, requires_grad=True)
    offsets = torch.randn(4, 3, generator=generator, dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(
        lambda a, b, c: kinematics.forward_kinematics(a, b, c, parents), (turns, root, offsets)
    )


def test_depth_levels_hold_every_joint_once_below_its_parent() -> None:
    levels = kinematics.depth_levels(SMPL22.parents)
    assert sorted(j for level in levels for j in level) == list(range(22))
    for above, level in pairwise(levels):
        assert all(SMPL22.parents[j] in above for j in level)
