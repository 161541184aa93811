"""Writing BVH: what is read back, here and by bvhio, is what was written."""

from __future__ import annotations

import itertools

import bvhio
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engines.errors import FormatError, OutOfRangeError
from engines.formats import bvh
from engines.motion import Motion
from engines.skeletons import SMPL22
from engines.skeletons.skeleton import Skeleton
from tests.engines.formats.conftest import random_motion

TENTH_OF_A_MILLIMETRE = 1e-4


@st.composite
def motions(draw) -> Motion:
    """Random trees in any parents-first order, with random end sites, poses and rates."""
    count = draw(st.integers(1, 9))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    parents = (-1, *(int(rng.integers(0, j)) for j in range(1, count)))
    names = tuple(f"bone{j}" for j in rng.permutation(count))
    leaves = [name for j, name in enumerate(names) if j not in parents]
    skeleton = Skeleton(
        "random", names, parents, rng.normal(size=(count, 3)), {name: rng.normal(size=3) for name in leaves}
    )
    frames = draw(st.integers(1, 5))
    fps = draw(st.sampled_from([20, 24, 25, 29.97, 30, 59.94, 60, 120]) | st.floats(1, 1000))
    return random_motion(frames, int(rng.integers(2**31)), skeleton, fps)


def in_order_of(motion: Motion, like: Motion) -> np.ndarray:
    return motion.positions[:, [motion.skeleton.index(name) for name in like.skeleton.joints]]


@settings(max_examples=60, deadline=None)
@given(
    motion=motions(),
    order=st.sampled_from(["".join(p) for p in itertools.permutations("XYZ")]),
    scale=st.sampled_from([1.0, 100.0, 39.37]),
)
def test_round_trip_over_random_skeletons_and_orders(motion, order, scale, tmp_path_factory):
    path = bvh.write(motion, tmp_path_factory.mktemp("bvh") / "out.bvh", scale=scale, order=order)
    again = bvh.read(path, scale=1 / scale, up="y")
    np.testing.assert_allclose(in_order_of(again, motion), motion.positions, atol=TENTH_OF_A_MILLIMETRE)
    assert again.fps == pytest.approx(motion.fps, rel=1e-12)
    assert set(again.skeleton.end_offsets) == set(motion.skeleton.end_offsets)
    for name, end in motion.skeleton.end_offsets.items():
        np.testing.assert_allclose(again.skeleton.end_offsets[name], end, atol=1e-5)


def test_smpl22_comes_back_as_smpl22(tmp_path):
    motion = random_motion(40)
    again = bvh.read(bvh.write(motion, tmp_path / "out.bvh"))
    assert again.skeleton is SMPL22
    assert again.fps == motion.fps and len(again) == len(motion)
    np.testing.assert_allclose(again.positions, motion.positions, atol=1e-6)
    np.testing.assert_allclose(np.abs((again.rotations * motion.rotations).sum(-1)), 1.0, atol=1e-12)


def test_a_body_of_other_proportions_is_not_taken_for_smpl22(tmp_path):
    motion = random_motion(3).scale_bones({"left_knee": 1.1})
    again = bvh.read(bvh.write(motion, tmp_path / "out.bvh"))
    assert again.skeleton is not SMPL22
    np.testing.assert_allclose(in_order_of(again, motion), motion.positions, atol=1e-6)


@pytest.mark.parametrize("order", ["ZXY", "XYZ", "YZX"])
def test_bvhio_reads_what_is_written(tmp_path, order):
    motion = random_motion(6)
    other = bvhio.readAsHierarchy(str(bvh.write(motion, tmp_path / "out.bvh", order=order)))
    for frame in range(len(motion)):
        other.loadPose(frame)
        theirs = {joint.Name: np.array(joint.PositionWorld) / 100 for joint, _, _ in other.layout()}
        mine = dict(zip(SMPL22.joints, motion.positions[frame], strict=True))
        for name, place in mine.items():
            np.testing.assert_allclose(theirs[name], place, atol=TENTH_OF_A_MILLIMETRE)


def test_the_rest_pose_is_a_t_pose_in_centimetres(tmp_path):
    text = bvh.write(random_motion(1), tmp_path / "out.bvh").read_text()
    block = text.split("JOINT left_elbow")[1].split("CHANNELS")[0]
    assert "OFFSET 26.940000 0.000000 0.000000" in block
    assert "ROOT pelvis" in text and text.count("End Site") == 5
    assert "CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation" in text
    assert "-0.000000" not in text


def test_angles_do_not_jump(tmp_path):
    """A steady turn of two and a half rounds is written without jumps of 360 degrees."""
    turns = np.zeros((100, 22, 4))
    turns[..., 0] = 1.0
    half = np.linspace(0, 2.5 * np.pi, 100)
    turns[:, 0] = np.stack([np.cos(half), 0 * half, np.sin(half), 0 * half], axis=-1)
    path = bvh.write(Motion(SMPL22, turns, np.zeros((100, 3)), 30), tmp_path / "turn.bvh")
    rows = np.loadtxt(path.read_text().split("Frame Time:")[1].split("\n")[1:-1])
    assert np.abs(np.diff(rows[:, 3:], axis=0)).max() < 20


def test_names_are_made_fit_for_other_programs(tmp_path):
    skeleton = Skeleton("odd", ("a b", "a_b", "{x}"), (-1, 0, 0), np.ones((3, 3)))
    again = bvh.read(bvh.write(random_motion(2, skeleton=skeleton), tmp_path / "odd.bvh"), scale=0.01)
    assert again.skeleton.joints == ("a_b", "a_b_2", "_x_")


@pytest.mark.parametrize("options", [{"order": "XYX"}, {"order": "XY"}, {"scale": 0.0}, {"scale": float("nan")}])
def test_bad_options_leave_nothing(tmp_path, options):
    with pytest.raises(OutOfRangeError):
        bvh.write(random_motion(2), tmp_path / "out.bvh", **options)
    assert not list(tmp_path.iterdir())


def test_a_rate_no_frame_time_can_say(tmp_path):
    with pytest.raises(FormatError, match="frame rate"):
        bvh.write(random_motion(2, fps=1e7), tmp_path / "out.bvh")
    assert not list(tmp_path.iterdir())
