"""AMASS: layouts, axes and damage."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from engines import formats
from engines.errors import FormatError, OutOfRangeError
from engines.formats import amass, arrays, bvh
from engines.motion import Motion
from engines.skeletons import SMPL22
from tests.engines.formats.conftest import random_motion

STANDING = np.radians([90.0, 0.0, 0.0])
"""Root rotation that stands SMPL's Y-up rest pose in AMASS's Z-up world."""


def amass_arrays(frames: int = 5, width: int = 156, **changes) -> dict[str, np.ndarray]:
    """A person standing in AMASS's world, walking along +X, the left elbow bent by one radian."""
    poses = np.zeros((frames, width))
    poses[:, :3] = STANDING
    poses[:, 3 * SMPL22.index("left_elbow") + 1] = -1.0
    trans = np.zeros((frames, 3))
    trans[:, 0], trans[:, 2] = np.arange(frames) * 0.1, 0.9
    content = {
        "trans": trans,
        "poses": poses,
        "betas": np.arange(16.0),
        "gender": np.array("female"),
        "mocap_framerate": np.array(120.0),
    } | changes
    return {name: value for name, value in content.items() if value is not None}


def written(tmp_path, **options):
    return arrays.save(tmp_path / "clip.npz", amass_arrays(**options))


@pytest.mark.parametrize("width", amass.JOINTS)
def test_layouts(tmp_path, width):
    motion = formats.read(written(tmp_path, width=width))
    assert motion.skeleton is SMPL22 and motion.fps == 120 and len(motion) == 5
    assert motion.provenance.parameters["gender"] == "female"
    assert motion.provenance.parameters["betas"] == list(range(16))
    elbow = Rotation.from_quat(motion.rotations[0, SMPL22.index("left_elbow")], scalar_first=True).as_rotvec()
    np.testing.assert_allclose(elbow, [0, -1, 0], atol=1e-12)


def test_z_up_becomes_y_up(tmp_path):
    motion = amass.read(written(tmp_path))
    place = dict(zip(SMPL22.joints, motion.positions[4], strict=True))
    np.testing.assert_allclose(place["pelvis"], [0.4, 0.9, 0.0], atol=1e-12)
    np.testing.assert_allclose(place["head"] - place["pelvis"], (SMPL22.rest_positions[15]), atol=1e-12)
    assert place["left_knee"][0] > place["right_knee"][0]
    np.testing.assert_allclose(place["left_wrist"][2] - place["left_elbow"][2], 0.242 * np.sin(1), atol=1e-9)


def test_split_poses_and_other_spellings(tmp_path):
    poses = amass_arrays()["poses"]
    path = written(
        tmp_path,
        poses=None,
        root_orient=poses[:, :3],
        pose_body=poses[:, 3:66],
        mocap_framerate=None,
        mocap_frame_rate=np.array([60]),
        gender=np.array(b"male"),
    )
    motion = formats.read(path)
    assert motion.fps == 60 and motion.provenance.parameters["gender"] == "male"
    np.testing.assert_array_equal(motion.rotations, amass.read(written(tmp_path)).rotations)


def test_float32_and_fortran_order(tmp_path):
    poses = np.asfortranarray(amass_arrays()["poses"].astype(np.float32))
    motion = amass.read(written(tmp_path, poses=poses))
    np.testing.assert_allclose(motion.rotations, amass.read(written(tmp_path)).rotations, atol=1e-6)


def test_round_trip(tmp_path):
    motion = random_motion(9, fps=59.94)
    again = formats.read(formats.write(motion, tmp_path / "m.amass.npz"))
    assert again.skeleton is SMPL22 and again.fps == motion.fps
    np.testing.assert_allclose(again.positions, motion.positions, atol=1e-9)
    np.testing.assert_allclose(np.abs((again.rotations * motion.rotations).sum(-1)), 1, atol=1e-9)


def test_written_as_amass_lays_it_out(tmp_path):
    original = written(tmp_path)
    path = amass.write(amass.read(original), tmp_path / "again.npz")
    with np.load(original) as mine, np.load(path) as theirs:
        for name in ("trans", "poses", "betas"):
            np.testing.assert_allclose(theirs[name], mine[name], atol=1e-12)
        assert str(theirs["gender"]) == "female" and theirs["mocap_framerate"] == 120
        assert theirs["poses"].shape == (5, 156)


def test_pelvis_place_shifts_the_root_and_back(tmp_path):
    pelvis = (-0.002, -0.22, 0.03)
    motion = amass.read(written(tmp_path), pelvis=pelvis)
    np.testing.assert_allclose(motion.positions[0, 0], [-0.002, 0.93, 0.22], atol=1e-12)
    with np.load(amass.write(motion, tmp_path / "again.npz", pelvis=pelvis)) as held:
        np.testing.assert_allclose(held["trans"], amass_arrays()["trans"], atol=1e-12)


def test_resampled_or_kept(tmp_path):
    path = written(tmp_path, frames=13)
    assert (amass.read(path).fps, len(amass.read(path))) == (120, 13)
    motion = amass.read(path, fps=20)
    assert (motion.fps, len(motion)) == (20, 3)
    np.testing.assert_allclose(motion.positions[:, 0, 0], [0, 0.6, 1.2], atol=1e-12)


@pytest.mark.data
def test_other_skeletons_are_retargeted(tmp_path, real_files):
    motion = bvh.read(real_files["cmu"])[:20]
    again = amass.read(amass.write(motion, tmp_path / "m.npz"))
    assert again.skeleton is SMPL22 and len(again) == 20
    theirs = motion.skeleton.index("Head")
    rise = motion.positions[:, theirs, 1] - motion.positions[:, 0, 1]
    assert np.corrcoef(rise, again.positions[:, 15, 1] - again.positions[:, 0, 1])[0, 1] > 0 or rise.std() < 0.01
    assert (again.positions[:, 15, 1] > again.positions[:, 0, 1]).all()


BAD = {
    "no rate": ({"mocap_framerate": None}, "no frame rate; accepted: one of mocap_framerate"),
    "rate zero": ({"mocap_framerate": np.array(0.0)}, "a frame rate of 0"),
    "rate nan": ({"mocap_framerate": np.array(np.nan)}, "a frame rate of nan"),
    "two rates": ({"mocap_framerate": np.array([30.0, 60.0])}, "accepted: one number"),
    "rate of words": ({"mocap_framerate": np.array("fast")}, "accepted: one number"),
    "width": ({"poses": np.zeros((5, 100))}, r"poses has shape \(5, 100\); accepted"),
    "no frames": ({"poses": np.zeros((0, 156)), "trans": np.zeros((0, 3))}, "at least one frame"),
    "flat": ({"poses": np.zeros(156)}, "poses has shape"),
    "lengths differ": ({"trans": np.zeros((4, 3))}, r"trans has shape \(4, 3\); accepted: \(5, 3\)"),
    "nan": ({"trans": np.full((5, 3), np.nan)}, "frame 0 holds values that are not finite"),
    "huge": ({"trans": np.full((5, 3), 1e300)}, "frame 0 holds values that are not finite, or beyond reason"),
    "integers": ({"poses": np.zeros((5, 156), int)}, "accepted: floating point"),
    "split wrongly": (
        {"poses": None, "root_orient": np.zeros((5, 3)), "pose_body": np.zeros((4, 63))}, "as many frames"),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_damage_is_named(tmp_path, case):
    changes, message = BAD[case]
    with pytest.raises(FormatError, match=message):
        formats.read(written(tmp_path, **changes))


def test_a_rate_may_be_given(tmp_path):
    assert amass.read(written(tmp_path, mocap_framerate=None), frame_rate=60).fps == 60


@pytest.mark.parametrize("pelvis", [(1, 2), np.nan, (np.inf, 0, 0)])
def test_a_pelvis_that_is_no_point(tmp_path, pelvis):
    with pytest.raises(OutOfRangeError, match="pelvis"):
        amass.read(written(tmp_path), pelvis=pelvis)
    with pytest.raises(OutOfRangeError, match="pelvis"):
        amass.write(random_motion(), tmp_path / "out.npz", pelvis=pelvis)
    assert not (tmp_path / "out.npz").exists()


def test_trans_missing(tmp_path):
    with pytest.raises(FormatError, match="'trans' is missing"):
        amass.read(written(tmp_path, trans=None))


def test_pickled_extras_do_no_harm(tmp_path):
    """Some AMASS files carry pickled objects beside the poses: they are not looked at."""
    path = tmp_path / "clip.npz"
    np.savez(path, **amass_arrays(), markers=np.array([print], dtype=object))
    assert isinstance(formats.read(path), Motion)
