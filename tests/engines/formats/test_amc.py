"""Acclaim motions: against the textbook's formula, and against people as they are."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import engines
from engines import formats
from engines.errors import FormatError, OutOfRangeError
from engines.skeletons import SMPL22

SMALL_ASF = """# made for a test
:version 1.10
:name small
:units
  mass 1.0
  length 0.45
  angle deg
:root
   order TX TY TZ RX RY RZ
   axis XYZ
   position 0 1 0
   orientation 0 0 0
:bonedata
  begin
     id 1
     name hip
     direction 0.6 -0.8 0
     length 2.5
     axis 0 0 0 XYZ
  end
  begin
     id 2
     name thigh
     direction 0 -1 0
     length 6
     axis 10 20 30 XYZ
     dof rx ry rz
     limits (-160.0 20.0)
            (-70.0 70.0)
            (-60.0 70.0)
  end
  begin
     id 3
     name shin
     direction 0 -0.8 0.6
     length 7
     axis 0 0 20 ZXY
     dof rx
  end
:hierarchy
  begin
    root hip
    hip thigh
    thigh shin
  end
"""
SMALL_AMC = """#!OML:ASF somewhere.ASF
:FULLY-SPECIFIED
:DEGREES
1
root 1 2 3 0 0 0
thigh 0 0 0
shin 0
2
root 1 2 4 10 -20 30
thigh 40 50 -60
shin 70
"""


@pytest.fixture
def small(tmp_path) -> Path:
    (tmp_path / "07.asf").write_text(SMALL_ASF)
    path = tmp_path / "07_01.amc"
    path.write_text(SMALL_AMC)
    return path


def fixed(order: str, *degrees: float) -> np.ndarray:
    """Turns about fixed axes one after another, as scipy has them by small letters."""
    return Rotation.from_euler(order.lower(), degrees, degrees=True).as_matrix()


def test_places_are_those_of_the_textbook(small):
    motion = formats.read(small)
    factor = motion.provenance.parameters["scale"]
    assert motion.skeleton.joints == ("root", "hip", "thigh", "shin") and motion.fps == 120.0
    hip, thigh = np.array([1.5, -2, 0]), np.array([0, -6, 0])
    expected = np.array([[1, 3, 3], [1, 3, 3], [2.5, 1, 3], [2.5, -5, 3]])
    np.testing.assert_allclose(motion.positions[0] / factor, expected, atol=1e-9)
    whole = fixed("XYZ", 10, -20, 30)
    frame = fixed("XYZ", 10, 20, 30)
    leg = whole @ frame @ fixed("XYZ", 40, 50, -60) @ frame.T
    top = np.array([1, 3, 4])
    expected = np.array([top, top, top + whole @ hip, top + whole @ hip + leg @ thigh])
    np.testing.assert_allclose(motion.positions[1] / factor, expected, atol=1e-9)
    frame = fixed("ZXY", 0, 0, 20)
    shin = leg @ frame @ fixed("X", 70) @ frame.T
    np.testing.assert_allclose(motion.global_rotations[1, 3], shin, atol=1e-9)
    np.testing.assert_allclose(motion.skeleton.end_offsets["shin"] / factor, [0, -5.6, 4.2], atol=1e-9)


def test_radians_are_said_by_the_file(small):
    degrees = formats.read(small)
    lines = []
    for line in SMALL_AMC.replace(":DEGREES", ":RADIANS").splitlines():
        words = line.split()
        if words[0] in ("thigh", "shin"):
            words[1:] = [repr(float(np.radians(float(word)))) for word in words[1:]]
        if words[0] == "root":
            words[4:] = [repr(float(np.radians(float(word)))) for word in words[4:]]
        lines.append(" ".join(words))
    small.write_text("\n".join(lines))
    np.testing.assert_allclose(formats.read(small).positions, degrees.positions, atol=1e-9)


def test_the_skeleton_is_found_or_given(small, tmp_path):
    whole = formats.read(small, fps=60)
    assert whole.fps == 60
    (tmp_path / "07.asf").rename(tmp_path / "other.asf")
    assert formats.read(small).provenance.parameters["skeleton"] == "other.asf"  # the only one
    (tmp_path / "third.asf").write_text(SMALL_ASF)
    with pytest.raises(FormatError, match=r"needs its skeleton: an \.asf beside it"):
        formats.read(small)
    assert len(formats.read(small, skeleton=tmp_path / "third.asf")) == 2
    with pytest.raises(FormatError, match="is a skeleton without motion"):
        formats.read(tmp_path / "third.asf")
    with pytest.raises(OutOfRangeError, match="fps"):
        formats.read(small, fps=0)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("shin 70", "shin 70 1", r"\.amc:11: bone 'shin' has '70 1'; accepted: 1 numbers"),
        ("shin 70", "shin warm", r"\.amc:11: bone 'shin' has 'warm'"),
        ("shin 70", "shin nan", "accepted: 1 numbers"),
        ("shin 70", "shoe 70", r"\.amc:11: bone 'shoe' is no bone of its skeleton"),
        ("shin 70", "thigh 1 2 3", "twice in one frame"),
        ("shin 0\n", "", r"\.amc:7: the frame before this line lacks bone 'shin'"),
        ("2\n", "two\n", "'two' is no frame number"),
        ("1\nroot", "root", "values before the first frame's number"),
        (SMALL_AMC, ":FULLY-SPECIFIED\n", "holds no frames"),
    ],
)
def test_damage_of_the_motion_is_told_with_its_line(small, old, new, message):
    small.write_text(SMALL_AMC.replace(old, new, 1))
    with pytest.raises(FormatError, match=message):
        formats.read(small)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("direction 0 -1 0", "direction 0 -1", r"07\.asf:24: holds '0 -1'; accepted: 3 numbers"),
        ("dof rx ry rz", "dof rx ry rx", "each once"),
        ("20 ZXY", "20 ZXX", "accepted: X, Y and Z in some order"),
        ("name shin", "name thigh", "has the name of another"),
        ("thigh shin", "thigh shoe", "'shoe', which is no bone of the file"),
        ("    thigh shin\n", "", "'shin' does not hang from the root"),
        ("    hip thigh\n    thigh shin\n", "    shin thigh\n    thigh shin\n", "does not hang from the root"),
        ("    thigh shin\n", "    thigh shin\n    hip shin\n", "it hangs elsewhere"),
        (":hierarchy", ":higherarchy", "has no section ':hierarchy'"),
        (":version 1.10\n:name small\n:units\n", "", r"07\.asf:2: is no \.asf"),
        ("  begin\n     id 2", "  id 2", "outside 'begin' and 'end'"),
    ],
)
def test_damage_of_the_skeleton_is_told_with_its_line(small, old, new, message):
    small.with_name("07.asf").write_text(SMALL_ASF.replace(old, new, 1))
    with pytest.raises(FormatError, match=message):
        formats.read(small)


@pytest.fixture(scope="session")
def captured(shared_dir: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A real pair."""
    import tarfile

    folder = tmp_path_factory.mktemp("amc")
    with tarfile.open(shared_dir / "data" / "cmu-mocap-subset.tar.xz") as tar:
        for member in tar:
            if member.name.endswith(("amc/38.asf", "amc/38_01.amc")):
                tar.extract(member, folder, filter="data")
    return next(folder.rglob("38_01.amc"))


@pytest.mark.data
def test_a_real_person_walks_on_the_floor(captured):
    motion = engines.read(captured)
    assert len(motion) == 352 and len(motion.skeleton) == 31 and motion.provenance.parameters["unit"] == "cmu"
    house = motion.retarget(SMPL22)
    head, ankles = house.positions[:, SMPL22.index("head")], house.positions[:, [7, 8]]
    assert (head[:, 1] - ankles[..., 1].min(axis=1) > 1.2).all()  # upright throughout
    assert np.ptp(ankles[..., 1].min(axis=1)) < 0.08  # one foot is always down: no jump, no slope
    # walking forwards: the path of the root goes the way the body faces
    way = np.diff(house.translation[::30, [0, 2]], axis=0)
    facing = np.stack([np.sin(house.heading), np.cos(house.heading)], axis=-1)[::30][: len(way)]
    assert (np.einsum("tc,tc->t", way, facing) > 0.5 * np.linalg.norm(way, axis=1)).mean() > 0.8
