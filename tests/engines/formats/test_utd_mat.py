"""UTD-MHAD skeletons: axes, sides and damage."""

from __future__ import annotations

import tracemalloc
import zlib

import numpy as np
import pytest
import scipy.io

from engines import formats
from engines.errors import FormatError
from engines.formats import mat5, utd_mat
from engines.skeletons import SMPL22


def saved(tmp_path, values, name: str = "d_skel"):
    path = tmp_path / "a1_s1_t1_skeleton.mat"
    scipy.io.savemat(path, {name: values}, do_compression=True)
    return path


def standing(frames: int = 4) -> np.ndarray:
    """(20, 3, T) as the Kinect sees someone who stands facing it: their left at -X, farther away is +Z."""
    rest = dict(zip(SMPL22.joints, SMPL22.rest_positions, strict=True))
    same = {"shoulder_center": "neck", "spine": "spine1", "hip_center": "pelvis"}
    same |= {"left_hand": "left_wrist", "right_hand": "right_wrist"}
    points = np.array([rest[same.get(name, name)] for name in utd_mat.JOINTS])
    points = points * [-1, 1, -1] + [0, 0, 3]
    return np.repeat(points[:, :, None], frames, axis=2)


def test_axes(tmp_path):
    points, fps = utd_mat.read_points(saved(tmp_path, standing()))
    assert fps == 30 and tuple(points) == utd_mat.JOINTS
    assert points["head"].shape == (4, 3)
    assert (points["left_shoulder"][:, 0] > points["right_shoulder"][:, 0]).all()
    assert (points["left_foot"][:, 2] > points["left_ankle"][:, 2]).all()
    assert (points["head"][:, 1] > points["spine"][:, 1]).all()
    np.testing.assert_allclose(points["hip_center"], np.tile([0, 0, -3], (4, 1)), atol=1e-12)


def test_read_makes_a_motion_that_stands_on_the_floor(tmp_path):
    motion = formats.read(saved(tmp_path, standing()))
    assert motion.skeleton is SMPL22 and motion.fps == 30 and len(motion) == 4
    place = dict(zip(SMPL22.joints, motion.positions[0], strict=True))
    assert place["head"][1] > 1.3 and place["left_ankle"][0] > place["right_ankle"][0]
    assert 0 <= motion.positions[..., 1].min() < 0.1
    assert abs(motion.heading[0]) < 0.1


@pytest.mark.data
def test_the_right_hand_is_the_right_one(real_files):
    """Action 1 is "right arm swipe to the left": the right hand moves, and towards +X."""
    points, _ = utd_mat.read_points(real_files["utd"])
    travel = {side: np.linalg.norm(np.diff(points[f"{side}_hand"], axis=0), axis=1).sum() for side in ("left", "right")}
    assert travel["right"] > 3 * travel["left"]
    across = (points["right_hand"] - points["hip_center"])[:, 0]
    assert across.max() > 0 > across[0]
    assert (points["left_hip"][:, 0] > points["right_hip"][:, 0]).all()
    motion = formats.read(real_files["utd"])
    assert np.ptp(motion.positions[:, SMPL22.index("right_wrist"), 0]) > 0.4


BAD = {
    "another name": (standing(), "skeleton", "holds skeleton 20 x 3 x 4 double; accepted: d_skel, 20 x 3 x frames"),
    "19 joints": (standing()[:19], "d_skel", "holds d_skel 19 x 3 x 4"),
    "one frame flat": (standing()[:, :, 0], "d_skel", "holds d_skel 20 x 3 double"),
    "no frames": (np.zeros((20, 3, 0)), "d_skel", "holds d_skel 20 x 3 x 0"),
    "text": ("hello", "d_skel", "holds d_skel 1 x 5 char; accepted"),
    "cells": (np.full((20, 3, 2), "x", object), "d_skel", "d_skel is cell, not real numbers"),
    "integers": (np.ones((20, 3, 2), np.int16), "d_skel", "not finite real"),
    "nan": (standing() * np.nan, "d_skel", "not finite"),
    "far": (standing() * 1e6, "d_skel", "frame 0 has joints beyond 100 m"),
    "lost": (standing() * [1, 1, 0, 1], "d_skel", "in frame 2, left_hip and right_hip fall together"),
    "complex": (standing() * 1j, "d_skel", "d_skel is complex, not real numbers"),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_damage_is_named(tmp_path, case):
    values, name, message = BAD[case]
    with pytest.raises(FormatError, match=message):
        formats.read(saved(tmp_path, values, name))


def test_cut_short_and_junk(tmp_path):
    path = saved(tmp_path, standing(50))
    whole = path.read_bytes()
    for length in (100, 128, 140, len(whole) // 2, len(whole) - 1):
        path.write_bytes(whole[:length])
        with pytest.raises(FormatError):
            formats.read(path)
    path.write_bytes(np.random.default_rng(0).bytes(3000))
    with pytest.raises(FormatError, match="no MATLAB file"):
        formats.read(path)


@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize("dtype", ["f8", "f4"])
def test_the_reader_agrees_with_scipy(tmp_path, packed, dtype):
    """Whole numbers, which MATLAB stores as bytes, among several variables, one of them short."""
    rng = np.random.default_rng(0)
    content = {"d_skel": rng.normal(size=(20, 3, 5)).astype(dtype), "a": np.float64(3), "text": "hello"}
    content |= {"whole": np.arange(6.0).reshape(2, 3), "long_name_of_a_variable": np.arange(5, dtype=np.int32)}
    path = tmp_path / "many.mat"
    scipy.io.savemat(path, content, do_compression=packed)
    found = {variable.name: variable for variable in mat5.variables(path.read_bytes())}
    expected = scipy.io.loadmat(path)
    assert list(found) == list(content)
    for name in ("d_skel", "a", "whole", "long_name_of_a_variable"):
        values = found[name].array()
        np.testing.assert_array_equal(values, expected[name])
        assert values.dtype == expected[name].dtype


@pytest.mark.data
def test_real_file_agrees_with_scipy(real_files):
    (found,) = mat5.variables(real_files["utd"].read_bytes())
    np.testing.assert_array_equal(found.array(), scipy.io.loadmat(real_files["utd"])["d_skel"])


def test_a_packed_bomb_is_not_unpacked(tmp_path):
    """Ten megabytes of zeros packed into ten thousand bytes, behind a small claim."""
    path = saved(tmp_path, np.zeros((20, 3, 20_000)))
    variable = mat5.variables(path.read_bytes())[0]
    body = zlib.decompress(variable._body).replace((20_000).to_bytes(4, "little"), (2).to_bytes(4, "little"), 1)
    packed = zlib.compress(body)
    tag = (15).to_bytes(4, "little") + len(packed).to_bytes(4, "little")
    path.write_bytes(path.read_bytes()[:128] + tag + packed)
    tracemalloc.start()
    with pytest.raises(FormatError, match="longer than its shape says"):
        formats.read(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 2**20


def test_newer_files_say_what_to_do(tmp_path):
    path = tmp_path / "new.mat"
    path.write_bytes(b"MATLAB 7.3 MAT-file, Platform: GLNXA64" + b" " * 200)
    with pytest.raises(FormatError, match="save it with -v7"):
        formats.read(path)


def test_a_claimed_size_is_checked_before_it_is_read(tmp_path):
    """The header of an uncompressed file claims 100 million frames."""
    path = tmp_path / "big.mat"
    scipy.io.savemat(path, {"d_skel": standing()})
    data = bytearray(path.read_bytes())
    at = data.find((20).to_bytes(4, "little") + (3).to_bytes(4, "little") + (4).to_bytes(4, "little"))
    data[at + 8 : at + 12] = (100_000_000).to_bytes(4, "little")
    path.write_bytes(data)
    with pytest.raises(FormatError, match="claims 100,000,000 frames"):
        formats.read(path)
