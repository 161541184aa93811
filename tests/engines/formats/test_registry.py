"""The right format for a file: by content, then by name."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.io

import engines
from engines import formats
from engines.errors import FormatError, UnknownLabelError
from engines.formats import amass, bvh, npz
from tests.engines.formats.conftest import random_motion


def test_formats_describe_themselves():
    kinds = {kind.name: kind for kind in formats.formats()}
    assert {"motionloom", "amass", "bvh", "utd_mat"} <= set(kinds)
    assert kinds["bvh"].reads and kinds["bvh"].writes
    assert kinds["utd_mat"].reads and not kinds["utd_mat"].writes
    for kind in kinds.values():
        assert kind.description and all(end.startswith(".") and end == end.lower() for end in kind.extensions)


@pytest.mark.parametrize("end", [".bvh", ".npz", ".amass.npz", ".BVH"])
def test_written_by_extension_and_read_back(tmp_path, motion, end):
    path = formats.write(motion, tmp_path / f"walk{end}")
    again = engines.read(path)
    np.testing.assert_allclose(again.positions, motion.positions, atol=1e-6)
    assert [p.name for p in tmp_path.iterdir()] == [f"walk{end}"]


def test_motion_write_goes_the_same_way(tmp_path, motion):
    assert motion.write(tmp_path / "walk.bvh", order="XYZ").read_text().count("Xrotation Yrotation Zrotation") == 22


@pytest.mark.parametrize("end", [".npz", ".bvh", ".mat", ".txt", ""])
@pytest.mark.parametrize("module", [bvh, npz, amass])
def test_content_goes_before_the_extension(tmp_path, motion, module, end):
    path = module.write(motion, tmp_path / f"walk{end}")
    np.testing.assert_allclose(formats.read(path).positions, motion.positions, atol=1e-6)


def test_an_npz_may_be_ours_or_amass(tmp_path, motion):
    labelled = motion.labelled("walk")
    assert formats.read(formats.write(labelled, tmp_path / "a.npz")).labels == labelled.labels
    read = formats.read(formats.write(labelled, tmp_path / "b.npz", format="amass"))
    assert read.labels == () and read.provenance.parameters["format"] == "amass"


def test_another_kind_of_file_names_what_is_accepted(tmp_path):
    path = tmp_path / "notes.txt"
    path.write_text("not a motion")
    with pytest.raises(FormatError, match=r"of no kind that is known here\. Accepted: .*\.bvh.*\.mat"):
        formats.read(path)


@pytest.mark.parametrize(("end", "message"), [(".bvh", "HIERARCHY"), (".npz", "no .npz"), (".mat", "no MATLAB file")])
def test_content_that_belies_the_extension(tmp_path, end, message):
    path = tmp_path / f"walk{end}"
    path.write_text("something else altogether")
    with pytest.raises(FormatError, match=message):
        formats.read(path)


def test_a_mat_of_something_else(tmp_path):
    path = tmp_path / "other.mat"
    scipy.io.savemat(path, {"speed": np.arange(3.0)})
    with pytest.raises(FormatError, match="holds speed 1 x 3 double"):
        formats.read(path)


def test_unknown_extension_names_and_options(tmp_path, motion):
    with pytest.raises(FormatError, match=r"extension '\.xyz'; accepted: \.npz"):
        formats.write(motion, tmp_path / "walk.xyz")
    with pytest.raises(FormatError, match=r"read but not written"):
        formats.write(motion, tmp_path / "walk.mat", format="utd_mat")
    with pytest.raises(UnknownLabelError, match="bvh"):
        formats.write(motion, tmp_path / "walk.x", format="bhv")
    with pytest.raises(FormatError, match="format 'bvh' has no option 'units'; accepted: scale, order"):
        formats.write(motion, tmp_path / "walk.bvh", units="cm")
    assert not list(tmp_path.iterdir())
    path = formats.write(motion, tmp_path / "walk.bvh")
    with pytest.raises(FormatError, match="has no option 'sclae'; accepted: scale, up, stretch"):
        formats.read(path, sclae=1)


def test_a_failed_write_keeps_the_old_file(tmp_path):
    path = formats.write(random_motion(2), tmp_path / "walk.bvh")
    before = path.read_bytes()
    with pytest.raises(FormatError):
        formats.write(random_motion(2, fps=1e7), path)
    assert path.read_bytes() == before
