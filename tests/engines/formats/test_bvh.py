"""Reading BVH: against a naive reader, bvhio, and by hand."""

from __future__ import annotations

import re
from pathlib import Path

import bvhio
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from engines.errors import FormatError, OutOfRangeError
from engines.formats import bvh
from engines.skeletons import roles
from tests.engines.formats.conftest import SMALL_BVH

AXES = "XYZ"


def naive_joints(lines: list[str]) -> list[dict]:
    """Name, parent, offset and channels of each joint, line by line."""
    joints: list[dict] = []
    stack: list[int] = []
    for line in lines:
        words = [*line.split(), ""]
        if words[0] in ("ROOT", "JOINT"):
            joints.append({"name": words[1], "parent": stack[-1] if stack else None, "channels": []})
            stack.append(len(joints) - 1)
        elif words[0] == "End":
            stack.append(-1)
        elif words[0] == "}":
            stack.pop()
        elif words[0] == "OFFSET" and stack[-1] >= 0:
            joints[stack[-1]]["offset"] = np.array([float(w) for w in words[1:4]])
        elif words[0] == "CHANNELS":
            joints[stack[-1]]["channels"] = words[2:-1]
    return joints


def naive_positions(text: str) -> dict[str, np.ndarray]:
    """World positions (T, 3) by joint, one joint and one frame at a time: position channels replace the offset."""
    head, motion = text.replace("\r", "").split("MOTION\n")
    joints = naive_joints(head.split("\n"))
    places: dict[str, list] = {joint["name"]: [] for joint in joints}
    for line in filter(str.strip, motion.split("\n")[2:]):
        values = iter(float(w) for w in line.split())
        world: list[tuple] = []
        for joint in joints:
            place, turn = np.array(joint["offset"]), np.eye(3)
            for channel in joint["channels"]:
                value = next(values)
                if channel.endswith("position"):
                    place[AXES.index(channel[0])] = value
                else:
                    turn = turn @ Rotation.from_euler(channel[0].lower(), value, degrees=True).as_matrix()
            if joint["parent"] is not None:
                above, around = world[joint["parent"]]
                place, turn = above + around @ place, around @ turn
            world.append((place, turn))
            places[joint["name"]].append(place)
    return {name: np.array(track) for name, track in places.items()}


def assert_agrees(path: Path, text: str, tolerance: float = 1e-9) -> None:
    motion = bvh.read(path, scale=1.0, up="y")
    expected = naive_positions(text)
    for j, name in enumerate(motion.skeleton.joints):
        np.testing.assert_allclose(motion.positions[:, j], expected[name], atol=tolerance)


@st.composite
def bvh_texts(draw) -> str:
    """Random trees, channel orders, line endings and blanks; positions on the root only."""
    count = draw(st.integers(1, 7))
    parents = [-1] + [draw(st.integers(0, j - 1)) for j in range(1, count)]
    number = st.floats(-200, 200).map(lambda x: f"{x:.5f}")
    blank = draw(st.sampled_from([" ", "\t", "  "]))
    channels = []

    def joint(j: int) -> list[str]:
        turns = draw(st.permutations(["Xrotation", "Yrotation", "Zrotation"]))
        turns = turns[: draw(st.integers(0 if j else 1, 3))]
        places = ["Xposition", "Yposition", "Zposition"] if j == 0 else []
        mine = draw(st.permutations([*places, *turns])) if j == 0 else turns
        channels.extend(mine)
        lines = [
            f"{'JOINT' if j else 'ROOT'} joint{j}",
            "{",
            f"OFFSET{blank}" + blank.join(draw(number) for _ in "xyz"),
        ]
        lines.append(blank.join(["CHANNELS", str(len(mine)), *mine]))
        children = [c for c in range(count) if parents[c] == j]
        for child in children:
            lines += joint(child)
        if not children:
            lines += ["End Site", "{", "OFFSET 0 1 0", "}"]
        return [*lines, "}"]

    hierarchy = joint(0)
    frames = draw(st.integers(1, 4))
    rows = [blank.join(draw(number) for _ in channels) for _ in range(frames)]
    lines = ["HIERARCHY", *hierarchy, "MOTION", f"Frames:{blank}{frames}", "Frame Time: 0.0333333", *rows]
    end = draw(st.sampled_from(["\n", "\r\n"]))
    return end.join(lines) + draw(st.sampled_from(["", end, end + end]))


@settings(max_examples=60, deadline=None)
@given(text=bvh_texts())
def test_any_tree_and_channel_order_agrees_with_a_naive_reader(text, tmp_path_factory):
    path = tmp_path_factory.mktemp("bvh") / "random.bvh"
    path.write_bytes(text.encode())
    assert_agrees(path, text, 1e-8)


def test_small_file(small_bvh):
    assert_agrees(small_bvh, SMALL_BVH)
    motion = bvh.read(small_bvh, scale=0.01)
    assert motion.skeleton.joints == ("Hips", "Spine", "Head", "LeftArm")
    assert motion.skeleton.parents == (-1, 0, 1, 0)
    assert motion.fps == 30.0 and len(motion) == 3 and motion.skeleton.name == "small"
    np.testing.assert_allclose(motion.skeleton.offsets[2], [0, 0.2, 0.01])
    np.testing.assert_allclose(motion.skeleton.end_offsets["Head"], [0, 0.05, 0])
    np.testing.assert_allclose(motion.positions[1, 0], [0.01, 0.91, 0.02])
    assert motion.provenance.source == "small.bvh"
    assert motion.provenance.parameters["scale"] == 0.01


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.replace("\n", "\r\n"),
        lambda text: text.replace("\n", "\r"),
        lambda text: text.rstrip("\n"),
        lambda text: text + "\n  \n\n",
        lambda text: text.replace("0 90 0 0", "\n \n0\t90   0 0", 1),
        lambda text: text.replace("\t", "    "),
        lambda text: text.replace("rotation", "ROTATION").replace("JOINT", "Joint").replace("End Site", "END SITE"),
        lambda text: text.replace("Frame Time:", "Frame  Time :"),
        lambda text: "\ufeff" + text,
        lambda text: text.replace("ROOT Hips\n{", "ROOT Hips {"),
        lambda text: text.replace("0 90 0 0", "0 9e1 0 -0.0"),
    ],
)
def test_spellings_that_say_the_same(tmp_path, small_bvh, change):
    path = tmp_path / "other.bvh"
    path.write_bytes(change(SMALL_BVH).encode())
    other, motion = bvh.read(path), bvh.read(small_bvh)
    assert other.skeleton == motion.skeleton
    np.testing.assert_array_equal(other.rotations, motion.rotations)
    np.testing.assert_array_equal(other.positions, motion.positions)


def test_names_with_spaces(tmp_path):
    path = tmp_path / "biped.bvh"
    path.write_text(SMALL_BVH.replace("LeftArm", "Bip01 L UpperArm"))
    assert bvh.read(path).skeleton.joints[3] == "Bip01 L UpperArm"


@pytest.mark.parametrize(
    ("text", "fps"),
    [
        ("0.0333333", 30.0), ("0.033333", 30.0), (".0083333", 120.0), ("0.00833333", 120.0), ("0.04", 25.0),
        ("0.016666667", 60.0), ("0.0417083", 23.976), ("0.0333667", 29.97), ("0.008", 125.0), ("8.3333e-3", 120.0),
        ("1", 1.0),
    ],
)  # fmt: skip
def test_frame_rate_is_freed_from_rounding(tmp_path, text, fps):
    path = tmp_path / "rate.bvh"
    path.write_text(SMALL_BVH.replace("0.0333333", text))
    assert bvh.read(path).fps == fps


def with_positions(spine: list[str]) -> str:
    """The small file with position channels on Spine, one triple a frame."""
    head, block = SMALL_BVH.split("Frame Time: 0.0333333\n")
    head = head.replace(
        "OFFSET 0 10 0\n\t\tCHANNELS 3 Z", "OFFSET 0 10 0\n\t\tCHANNELS 6 Xposition Yposition Zposition Z"
    )
    rows = [row.split() for row in block.strip().split("\n")]
    rows = [[*row[:6], *place.split(), *row[6:]] for row, place in zip(rows, spine, strict=True)]
    return head + "Frame Time: 0.0333333\n" + "\n".join(" ".join(row) for row in rows)


def test_still_positions_of_a_joint_replace_its_offset(tmp_path):
    path, text = tmp_path / "still.bvh", with_positions(["1 12 3"] * 3)
    path.write_text(text)
    assert_agrees(path, text)
    motion = bvh.read(path, scale=1.0)
    np.testing.assert_array_equal(motion.skeleton.offsets[1], [1, 12, 3])
    assert "averaged_positions" not in motion.provenance.parameters


def test_positions_that_vary_a_little_are_averaged_and_it_is_said(tmp_path, caplog):
    path = tmp_path / "stretch.bvh"
    path.write_text(with_positions(["0 11 0", "0 12 0", "0 13 0"]))
    motion = bvh.read(path, scale=0.01)
    np.testing.assert_allclose(motion.skeleton.offsets[1], [0, 0.12, 0])
    assert motion.provenance.parameters["averaged_positions"] == {"Spine": pytest.approx(0.01)}
    assert "stretch.bvh" in caplog.text


def test_positions_that_vary_much_are_refused_unless_asked_for(tmp_path):
    path = tmp_path / "stretch.bvh"
    path.write_text(with_positions(["0 11 0", "0 12 0", "0 61 0"]))
    with pytest.raises(FormatError, match=r"'Spine' moves 0\.33 m along its bone.*stretch='mean'"):
        bvh.read(path, scale=0.01)
    assert bvh.read(path, scale=0.01, stretch="mean").skeleton.offsets[1, 1] == pytest.approx(0.28)


def test_a_root_with_one_travelling_child_is_merged_into_it(tmp_path):
    body = "".join(
        "\n" + line for line in SMALL_BVH.split("HIERARCHY\n")[1].split("MOTION")[0].rstrip().split("\n")
    ).replace("ROOT Hips", "JOINT Hips")
    head = "HIERARCHY\nROOT World\n{\nOFFSET 0 0 0\nCHANNELS 4 Yrotation Xposition Yposition Zposition" + body + "\n}\n"
    rows = SMALL_BVH.split("0.0333333\n")[1].strip().split("\n")
    rows = [f"{30 * i} {i} 0 5 {row}" for i, row in enumerate(rows)]
    text = head + "MOTION\nFrames: 3\nFrame Time: 0.0333333\n" + "\n".join(rows)
    path = tmp_path / "carried.bvh"
    path.write_text(text)
    motion = bvh.read(path)
    assert motion.skeleton.joints == ("Hips", "Spine", "Head", "LeftArm")
    assert motion.provenance.parameters["merged_into_root"] == ["World"]
    assert_agrees(path, text)


def person(unit: float, up: str = "y") -> str:
    """A file of one person 1.7 m tall, `unit` metres to a unit, standing along `up`."""

    def point(x: float, y: float, z: float) -> str:
        x, y, z = (v / unit for v in ((x, y, z) if up == "y" else (x, -z, y)))
        return f"OFFSET {x:.6f} {y:.6f} {z:.6f}"

    def joint(name: str, place, *children: str, kind: str = "JOINT") -> str:
        channels = "CHANNELS 3 Zrotation Xrotation Yrotation"
        if kind == "ROOT":
            channels = channels.replace("3", "6 Xposition Yposition Zposition")
        tail = "".join(children) or "End Site\n{\nOFFSET 0 0 0\n}\n"
        return f"{kind} {name}\n{{\n{point(*place)}\n{channels}\n{tail}}}\n"

    def leg(side: str, sign: int) -> str:
        foot = joint(f"{side}Foot", (0, -0.42, 0), joint(f"{side}ToeBase", (0, -0.05, 0.14)))
        return joint(f"{side}UpLeg", (sign * 0.1, -0.05, 0), joint(f"{side}Leg", (0, -0.4, 0), foot))

    def arm(side: str, sign: int) -> str:
        fore = joint(f"{side}ForeArm", (sign * 0.27, 0, 0), joint(f"{side}Hand", (sign * 0.25, 0, 0)))
        return joint(f"{side}Shoulder", (sign * 0.05, 0.2, 0), joint(f"{side}Arm", (sign * 0.12, 0, 0), fore))

    head = joint("Neck", (0, 0.25, 0), joint("Head", (0, 0.1, 0)))
    spine = joint("Spine", (0, 0.1, 0), head, arm("Left", 1), arm("Right", -1))
    tree = joint("Hips", (0, 0, 0), leg("Left", 1), leg("Right", -1), spine, kind="ROOT")
    root = [0.0, 0.92, 0.0] if up == "y" else [0.0, 0.0, 0.92]
    row = " ".join(f"{v / unit:.6f}" for v in root) + " 0" * (tree.count("CHANNELS") * 3)
    return f"HIERARCHY\n{tree}MOTION\nFrames: 2\nFrame Time: 0.05\n{row}\n{row}\n"


@pytest.mark.parametrize("unit", bvh.UNITS)
def test_units_are_told_from_the_body(tmp_path, unit):
    path = tmp_path / "units.bvh"
    path.write_text(person(bvh.UNITS[unit]))
    motion = bvh.read(path)
    assert motion.provenance.parameters["unit"] == unit
    top = motion.positions[0, motion.skeleton.index("Head"), 1]
    assert top == pytest.approx(1.37, abs=1e-4)


def test_units_by_name(tmp_path, small_bvh):
    assert bvh.read(small_bvh, scale="in").provenance.parameters["scale"] == 0.0254
    np.testing.assert_allclose(bvh.read(small_bvh, scale="mm").positions[0, 0], [0, 0.09, 0])


@pytest.mark.parametrize(
    "options", [{"scale": 0}, {"scale": -1.0}, {"scale": "league"}, {"scale": np.inf}, {"up": "x"}, {"stretch": "no"}]
)
def test_bad_options(small_bvh, options):
    with pytest.raises(OutOfRangeError, match=next(iter(options))):
        bvh.read(small_bvh, **options)


def test_a_body_in_no_known_unit_is_fitted(tmp_path):
    path = tmp_path / "odd.bvh"
    path.write_text(person(1.7e-6))
    motion = bvh.read(path)
    assert motion.provenance.parameters["unit"] == "fitted"
    assert roles.body_height(motion.skeleton, roles.recognise(motion.skeleton.joints)) == pytest.approx(1.7)


@pytest.mark.parametrize("up", ["auto", "z"])
def test_z_up_becomes_y_up(tmp_path, up):
    turned, straight = tmp_path / "z.bvh", tmp_path / "y.bvh"
    turned.write_text(person(0.01, up="z"))
    straight.write_text(person(0.01))
    motion, expected = bvh.read(turned, up=up), bvh.read(straight)
    assert motion.provenance.parameters["up"] == "z" and expected.provenance.parameters["up"] == "y"
    np.testing.assert_allclose(motion.positions, expected.positions, atol=1e-6)
    np.testing.assert_allclose(motion.skeleton.offsets, expected.skeleton.offsets, atol=1e-6)


def test_z_up_with_an_upright_rest_pose_keeps_the_rest_pose(tmp_path):
    """As written by programs that turn the root: a Y-up rest pose, stood along Z by the root's rotation."""
    text = person(0.01)
    row = text.rstrip().split("\n")[-1]
    values = row.split()
    stood = " ".join(["0", "0", values[1], "0", "90", "0", *values[6:]])
    path = tmp_path / "stood.bvh"
    path.write_text(text.replace(row, stood))
    straight = tmp_path / "y.bvh"
    straight.write_text(text)
    motion, expected = bvh.read(path), bvh.read(straight)
    assert motion.provenance.parameters["up"] == "z"
    np.testing.assert_allclose(motion.positions, expected.positions, atol=1e-6)
    np.testing.assert_array_equal(motion.skeleton.offsets, expected.skeleton.offsets)


def test_roles_are_filled_in(tmp_path):
    path = tmp_path / "person.bvh"
    path.write_text(person(0.01))
    skeleton = bvh.read(path).skeleton
    assert skeleton.feet == (("LeftFoot", "LeftToeBase"), ("RightFoot", "RightToeBase"))
    assert ("LeftArm", "RightArm") in skeleton.mirror_pairs
    np.testing.assert_allclose(skeleton.hinges["LeftLeg"], [1, 0, 0], atol=1e-6)
    np.testing.assert_allclose(skeleton.hinges["RightForeArm"], [0, 1, 0], atol=1e-6)


def thinned(path: Path, to: Path, count: int = 60) -> Path:
    """The file with about `count` of its frames, which the slow reader takes in seconds."""
    head, rows = re.split(r"(?<=\n)(?=Frames:)", path.read_text())
    rows = rows.rstrip().split("\n")
    kept = rows[2 :: max((len(rows) - 2) // count, 1)]
    to.write_text(head + f"Frames: {len(kept)}\n{rows[1]}\n" + "\n".join(kept) + "\n")
    return to


@pytest.mark.data
@pytest.mark.parametrize("name", ["cmu", "cgspeed", "bandai"])
def test_real_files_agree_with_bvhio(real_files, name, tmp_path):
    """A second reader, in float32, shows the same positions in every joint of frames throughout the file."""
    path = thinned(real_files[name], tmp_path / "real.bvh")
    motion = bvh.read(path, scale=1.0)
    other = bvhio.readAsHierarchy(str(path))
    for frame in np.linspace(0, len(motion) - 1, 6).astype(int):
        other.loadPose(int(frame))
        theirs = {joint.Name: np.array(joint.PositionWorld) for joint, _, _ in other.layout()}
        for j, joint in enumerate(motion.skeleton.joints):
            np.testing.assert_allclose(motion.positions[frame, j], theirs[joint], atol=1e-3)


@pytest.mark.data
@pytest.mark.parametrize(("name", "unit", "fps"), [("cmu", "cmu", 120), ("cgspeed", "cm", 120), ("bandai", "cm", 30)])
def test_real_files_are_people(real_files, name, unit, fps):
    motion = bvh.read(real_files[name])
    assert (motion.provenance.parameters["unit"], motion.fps) == (unit, fps)
    assert "averaged_positions" not in motion.provenance.parameters
    known = roles.recognise(motion.skeleton.joints)
    assert len(known) >= 19
    head = motion.positions[:, motion.skeleton.index(known["head"]), 1]
    foot = motion.positions[:, motion.skeleton.index(known["left_ankle"]), 1]
    assert 1.2 < np.median(head - foot) < 1.8
    assert -0.2 < np.percentile(foot, 5) < 0.3
