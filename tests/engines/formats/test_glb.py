"""Binary glTF: what is written obeys the standard and reads back; what others write reads as they mean it."""

from __future__ import annotations

import io
import json
import struct
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from engines import formats
from engines.errors import FormatError, OutOfRangeError, SkeletonError
from engines.formats import glb
from engines.formats.gltf import Builder, Gltf
from engines.geometry import rotations
from engines.motion import Motion
from engines.skeletons import SMPL22
from engines.skeletons.skeleton import Skeleton
from tests.engines.formats.conftest import random_motion

TURN = [np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)]  # glTF's order: a quarter about x


def tetrahedron(skeleton=SMPL22) -> SimpleNamespace:
    """The least skin there is; weights are float32 thirds, one influence is not used."""
    return SimpleNamespace(
        name="wedge",
        skeleton=skeleton,
        vertices=np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 1]], np.float32),
        normals=np.array([[0, 0, 0], [1, 0, 0], [0, 5, 0], [0, 0, 1]], np.float32),
        faces=np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], np.uint32),
        skin_indices=np.tile(np.array([3, 1, 2, 7], np.uint16), (4, 1)),
        skin_weights=np.tile(np.array([1 / 3, 1 / 3, 1 / 3, 0], np.float32), (4, 1)),
        colours=np.array([[255, 0, 188], [0, 0, 0], [255, 255, 255], [10, 20, 30]], np.uint8),
        uv=None,
        texture=None,
    )


def document(path) -> dict:
    return Gltf(path, path.read_bytes()).document


def check_standard(path) -> dict:
    """The rules of the glTF 2.0 specification that a file of ours could break."""
    data = path.read_bytes()
    magic, version, total, length, kind = struct.unpack_from("<4sIIII", data)
    assert (magic, version, total, kind) == (b"glTF", 2, len(data), 0x4E4F534A)
    assert length % 4 == 0 and total % 4 == 0
    tree = json.loads(data[20 : 20 + length])
    held = len(data) - 28 - length
    assert tree["asset"]["version"] == "2.0" and tree["buffers"] == [{"byteLength": held}]
    gltf = Gltf(path, data)
    sizes = {5121: 1, 5123: 2, 5125: 4, 5126: 4}
    for accessor in tree["accessors"]:
        view = tree["bufferViews"][accessor["bufferView"]]
        width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}[accessor["type"]]
        size = sizes[accessor["componentType"]]
        assert view["byteOffset"] % 4 == 0 and view["byteLength"] == accessor["count"] * width * size
        assert view["byteOffset"] + view["byteLength"] <= held
    children = [child for node in tree["nodes"] for child in node.get("children", ())]
    assert len(children) == len(set(children)) and not set(children) & set(tree["scenes"][0]["nodes"])
    skin = tree["skins"][0]
    matrices = gltf.array(skin["inverseBindMatrices"]).reshape(-1, 4, 4).transpose(0, 2, 1)
    assert len(matrices) == len(skin["joints"])
    np.testing.assert_array_equal(matrices[:, 3], np.tile([0, 0, 0, 1], (len(matrices), 1)))
    for animation in tree["animations"]:
        targets = [(c["target"]["node"], c["target"]["path"]) for c in animation["channels"]]
        assert len(targets) == len(set(targets))
        for sampler in animation["samplers"]:
            times = tree["accessors"][sampler["input"]]
            values = gltf.array(sampler["input"])
            assert times["min"] == [values.min()] and times["max"] == [values.max()] and values[0] == 0
            assert (np.diff(values) > 0).all()
            assert tree["accessors"][sampler["output"]]["count"] == times["count"]
    return tree


def test_bones_alone_obey_the_standard(tmp_path, motion):
    tree = check_standard(formats.write(motion, tmp_path / "walk.glb"))
    assert [node["name"] for node in tree["nodes"]] == list(SMPL22.joints)
    assert "meshes" not in tree and tree["skins"][0]["joints"] == list(range(22))
    rest = np.zeros((22, 3))
    for j, node in enumerate(tree["nodes"]):
        rest[j] = np.array(node["translation"]) + (rest[SMPL22.parents[j]] if j else 0)
    assert rest[:, 1].min() == pytest.approx(0.0, abs=1e-9)


def test_a_skin_obeys_the_standard(tmp_path, motion):
    path = formats.write(motion, tmp_path / "walk.glb", skin=tetrahedron())
    tree, gltf = check_standard(path), Gltf(path, path.read_bytes())
    node = tree["nodes"][-1]
    assert node == {"name": "wedge", "mesh": 0, "skin": 0} and tree["scenes"][0]["nodes"] == [0, 22]
    primitive = tree["meshes"][0]["primitives"][0]
    held = {name: gltf.array(number) for name, number in primitive["attributes"].items()}
    place = tree["accessors"][primitive["attributes"]["POSITION"]]
    assert place["min"] == [0, 0, 0] and place["max"] == [1, 2, 1]
    np.testing.assert_allclose(np.linalg.norm(held["NORMAL"], axis=1), 1, atol=1e-6)
    np.testing.assert_allclose(held["WEIGHTS_0"].sum(axis=1), 1, atol=2e-7)
    assert (held["JOINTS_0"][held["WEIGHTS_0"] == 0] == 0).all() and (held["JOINTS_0"][:, 0] == 3).all()
    np.testing.assert_allclose(held["COLOR_0"][0], [1, 0, 0.5029, 1], atol=1e-4)  # sRGB 188 is half the light
    assert gltf.array(primitive["indices"]).max() == 3
    bind = gltf.array(tree["skins"][0]["inverseBindMatrices"]).reshape(-1, 4, 4)[:, 3, :3]
    np.testing.assert_allclose(bind, -SMPL22.rest_positions, atol=1e-6)


def test_a_texture_takes_the_place_of_colours(tmp_path, motion):
    skin = tetrahedron()
    skin.texture = np.full((20, 30, 3), (200, 40, 90), np.uint8)
    skin.uv = np.array([[0, 0], [1, 0], [0, 1], [0.25, 0.5]], np.float32)
    path = formats.write(motion, tmp_path / "walk.glb", skin=skin)
    tree, gltf = check_standard(path), Gltf(path, path.read_bytes())
    attributes = tree["meshes"][0]["primitives"][0]["attributes"]
    assert "COLOR_0" not in attributes, "readers multiply it with the texture"
    np.testing.assert_array_equal(gltf.array(attributes["TEXCOORD_0"]), skin.uv)
    texture = tree["textures"][tree["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"]]
    view = tree["bufferViews"][tree["images"][texture["source"]]["bufferView"]]
    start = path.read_bytes().index(b"\xff\xd8\xff")
    picture = Image.open(io.BytesIO(path.read_bytes()[start : start + view["byteLength"]]))
    assert picture.size == (30, 20) and picture.format == "JPEG"
    assert np.abs(np.asarray(picture).astype(int) - skin.texture).max() <= 3


def test_every_default_body_is_a_skin(tmp_path):
    from viewers.bodies import body_for

    for name in ("anny", "stick"):
        body, motion = body_for(random_motion(2), name)
        tree = check_standard(formats.write(motion, tmp_path / f"{name}.glb", skin=body))
        assert tree["accessors"][tree["meshes"][0]["primitives"][0]["indices"]]["count"] == 3 * len(body.faces)


def test_skinning_by_the_file_moves_vertices_as_the_body_does(tmp_path):
    from viewers.bodies import body_for

    body, motion = body_for(random_motion(3))
    path = formats.write(motion, tmp_path / "walk.glb", skin=body)
    gltf, again = Gltf(path, path.read_bytes()), formats.read(path)
    held = gltf.document["meshes"][0]["primitives"][0]["attributes"]
    joints, weights = gltf.array(held["JOINTS_0"]).astype(int), gltf.array(held["WEIGHTS_0"])
    bind = gltf.array(gltf.document["skins"][0]["inverseBindMatrices"]).reshape(-1, 4, 4).transpose(0, 2, 1)
    world = np.tile(np.eye(4), (22, 1, 1))
    world[:, :3, :3], world[:, :3, 3] = again.global_rotations[2], again.positions[2]
    blended = np.einsum("vk,vkij->vij", weights, (world @ bind)[joints])
    points = np.c_[gltf.array(held["POSITION"]), np.ones(len(joints))]
    np.testing.assert_allclose(np.einsum("vij,vj->vi", blended, points)[:, :3], body.posed(motion, 2), atol=1e-5)


def test_a_skin_of_another_skeleton_is_refused(tmp_path, motion):
    with pytest.raises(SkeletonError, match="a skin of the motion's own skeleton"):
        formats.write(motion, tmp_path / "walk.glb", skin=tetrahedron(SMPL22.scaled({"*": 2.0})))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("fps", [20.0, 30.0, 29.97, 120.0])
def test_round_trip(tmp_path, fps):
    motion = random_motion(11, fps=fps)
    again = formats.read(formats.write(motion, tmp_path / "walk.glb"))
    assert again.skeleton is SMPL22 and again.fps == fps
    np.testing.assert_allclose(again.positions, motion.positions, atol=1e-6)
    assert np.abs(np.einsum("tjc,tjc->tj", again.rotations, motion.rotations)).min() > 1 - 1e-9


def test_one_frame_and_another_skeleton(tmp_path):
    tree = Skeleton("hand", ("palm", "thumb", "ring"), (-1, 0, 0), [[0.5, 1, 2], [0.1, 0, 0], [0, 0.2, 0]])
    motion = random_motion(1, skeleton=tree, fps=25.0)
    again = formats.read(formats.write(motion, tmp_path / "one.glb"))
    assert (again.skeleton.joints, again.skeleton.parents, again.fps, len(again)) == (tree.joints, tree.parents, 25, 1)
    np.testing.assert_allclose(again.positions, motion.positions, atol=1e-6)


# ---- files of others --------------------------------------------------------------------------------------


def foreign(path, nodes, channels, times=(0.0, 0.5, 1.0), skin=None, **more):
    """A .glb of nodes and channels (node, path, values, interpolation)."""
    made = Builder()
    made.document |= {"nodes": nodes, "scenes": [{"nodes": [0]}], **more}
    clock = made.accessor(np.array(times, np.float32), "SCALAR", bounds=True)
    samplers, targets = [], []
    for node, what, values, mode in channels:
        output = made.accessor(np.array(values, np.float32), "VEC4" if what == "rotation" else "VEC3")
        samplers.append({"input": clock, "output": output, "interpolation": mode})
        targets.append({"sampler": len(samplers) - 1, "target": {"node": node, "path": what}})
    made.document["animations"] = [{"name": "dance", "samplers": samplers, "channels": targets}]
    if skin is not None:
        made.document["skins"] = [{"joints": skin}]
    return made.save(path)


LIMB = [
    {"name": "Armature", "children": [1], "scale": [0.01, 0.01, 0.01]},
    {"name": "Hips", "children": [2], "translation": [0, 90, 0], "rotation": TURN},
    {"name": "Arm", "children": [3], "translation": [0, 0, 10]},
    {"name": "Hand", "translation": [0, 20, 0]},
]


def test_scales_above_and_turned_rests(tmp_path):
    still, quarter = [0, 0, 0, 1], TURN
    path = foreign(tmp_path / "limb.glb", LIMB, [(2, "rotation", [still, quarter, still], "LINEAR")], skin=[1, 2, 3])
    motion = formats.read(path)
    assert motion.skeleton.joints == ("Hips", "Arm", "Hand") and motion.fps == 2.0 and len(motion) == 3
    # a quarter about x carries z to -y and y to z
    np.testing.assert_allclose(motion.positions[0], [[0, 0.9, 0], [0, 0.8, 0], [0, 0.8, 0.2]], atol=1e-7)
    np.testing.assert_allclose(motion.positions[1], [[0, 0.9, 0], [0, 0.8, 0], [0, 0.6, 0]], atol=1e-7)
    np.testing.assert_allclose(motion.rotations[0], np.tile([1, 0, 0, 0], (3, 1)), atol=1e-7)
    np.testing.assert_allclose(np.add(motion.skeleton.rest_positions, [0, 0.9, 0]), motion.positions[0], atol=1e-7)
    assert motion.provenance.parameters["animation"] == "dance"


def test_steps_and_splines_and_uneven_keys(tmp_path):
    turns = [[0, 0, 0, 1], TURN, [0, 0, 0, 1]]
    times = (0.0, 0.1, 1.0)
    motion = formats.read(foreign(tmp_path / "a.glb", LIMB, [(2, "rotation", turns, "STEP")], times))
    assert motion.fps == 30 and len(motion) == 31
    arm = motion.skeleton.index("Arm")
    angle = 2 * np.degrees(np.arccos(np.clip(np.abs(motion.rotations[:, arm, 0]), 0, 1)))
    np.testing.assert_allclose(angle[[0, 2, 4, 29, 30]], [0, 0, 90, 90, 0], atol=1e-4)
    zero = [0, 0, 0, 0]
    spline = [zero, turns[0], zero, zero, turns[1], zero, zero, turns[2], zero]
    motion = formats.read(foreign(tmp_path / "b.glb", LIMB, [(2, "rotation", spline, "CUBICSPLINE")], times))
    angle = 2 * np.degrees(np.arccos(np.clip(np.abs(motion.rotations[:, motion.skeleton.index("Arm"), 0]), 0, 1)))
    np.testing.assert_allclose(angle[[0, 3, 30]], [0, 90, 0], atol=1e-3)
    assert 80 < angle[6] < 90  # flat tangents: slow to leave


def test_a_root_that_hands_the_way_to_its_child(tmp_path):
    walk = [[0, 0, 10], [0, 10, 10], [0, 20, 10]]
    motion = formats.read(foreign(tmp_path / "a.glb", LIMB, [(2, "translation", walk, "LINEAR")], skin=[1, 2, 3]))
    assert motion.skeleton.joints == ("Arm", "Hand")
    np.testing.assert_allclose(motion.positions[:, 0], [[0, 0.8, 0], [0, 0.8, 0.1], [0, 0.8, 0.2]], atol=1e-7)


def test_a_matrix_is_a_place_and_a_turn(tmp_path):
    matrix = np.eye(4)
    matrix[:3, :3] = rotations.quaternion_to_matrix(np.array([np.sqrt(0.5), np.sqrt(0.5), 0, 0])) * 0.5
    matrix[:3, 3] = [0, 90, 0]
    nodes = [LIMB[0], {"name": "Hips", "children": [2], "matrix": matrix.T.ravel().tolist()}, *LIMB[2:]]
    motion = formats.read(foreign(tmp_path / "a.glb", nodes, [(1, "translation", [[0, 90, 0]] * 3, "LINEAR")]))
    assert motion.skeleton.joints == ("Hips",)  # without a skin what is animated are the joints
    nodes_of_skin = foreign(tmp_path / "b.glb", nodes, [(2, "rotation", [[0, 0, 0, 1]] * 3, "LINEAR")], skin=[1, 2, 3])
    np.testing.assert_allclose(formats.read(nodes_of_skin).positions[0, 2], [0, 0.85, 0.1], atol=1e-7)


def test_a_bone_that_grows_is_refused_unless_told(tmp_path):
    nodes = [*LIMB, {"name": "LeftFoot", "translation": [0, -40, 0]}]
    nodes[1] = nodes[1] | {"children": [2, 4]}
    swing = [(4, "translation", [[0, -40, 0], [0, -80, 0], [0, -120, 0]], "LINEAR")]
    path = foreign(tmp_path / "a.glb", nodes, swing, skin=[1, 2, 3, 4])
    with pytest.raises(FormatError, match=r"'LeftFoot' moves 0\.40 m along its bone"):
        formats.read(path)
    motion = formats.read(path, stretch="mean")
    assert motion.provenance.parameters["averaged_positions"] == {"LeftFoot": pytest.approx(0.4)}
    with pytest.raises(OutOfRangeError, match="stretch"):
        formats.read(path, stretch="no")


CHANNEL = [(2, "rotation", [[0, 0, 0, 1]] * 3, "LINEAR")]


@pytest.mark.parametrize(
    ("nodes", "channels", "more", "message"),
    [
        (LIMB, [], {}, "has a skeleton of 0 joints"),
        (LIMB, CHANNEL, {"skin": [1, 9]}, "refers to number 9 of 4 nodes"),
        (LIMB, CHANNEL, {"times": (0.0, 0.5, 0.5)}, "times that do not rise"),
        (LIMB, CHANNEL, {"times": (0.0, 0.5, 9e9)}, "at most .* frames"),
        (LIMB, CHANNEL, {"times": (0.0, 0.5)}, "does not fit its 2 keys"),
        ([{"children": [1]}, {"children": [0]}, {}], CHANNEL, {}, "hangs from itself"),
        ([{"children": [2]}, {"children": [2]}, {}], CHANNEL, {}, "hangs from two others"),
        ([{}, {}, {"scale": [1, 1, -1]}], CHANNEL, {}, "stretched unevenly"),
        ([{}, {}, {"rotation": [0, 0, 0, 0]}], CHANNEL, {}, "no unit quaternion"),
        ([{}, {}, {"translation": ["a", 0, 0]}], CHANNEL, {}, "is damaged"),
    ],
)
def test_damage_is_told(tmp_path, nodes, channels, more, message):
    with pytest.raises(FormatError, match=message):
        formats.read(foreign(tmp_path / "a.glb", nodes, channels, **more))


def test_what_is_not_in_the_file_is_told(tmp_path, motion):
    path = formats.write(motion.labelled("walk"), tmp_path / "a.glb")
    with pytest.raises(FormatError, match="has no animation 'run'; it has 0 'walk'"):
        formats.read(path, animation="run")
    assert len(formats.read(path, animation="walk")) == 7
    made = Builder()
    made.document["nodes"] = [{}]
    with pytest.raises(FormatError, match="holds no animation"):
        formats.read(made.save(tmp_path / "still.glb"))
    data = path.read_bytes()
    path.write_bytes(data[:4] + struct.pack("<I", 1) + data[8:])
    with pytest.raises(FormatError, match="glTF of version 1; accepted: 2"):
        formats.read(path)
    path.write_bytes(data[:900])
    with pytest.raises(FormatError, match="breaks off after 900 of"):
        formats.read(path)


def test_compressed_arrays_are_refused(tmp_path, motion):
    path = formats.write(motion, tmp_path / "a.glb")
    tree = document(path)
    made = Builder()
    made.document = tree | {"bufferViews": [view | {"extensions": {}} for view in tree["bufferViews"]]}
    made._binary = bytearray(Gltf(path, path.read_bytes())._binary)
    with pytest.raises(FormatError, match="outside the file or compressed"):
        glb.read(made.save(path))


def test_numbers_that_are_not_finite_are_refused(tmp_path, motion):
    path = formats.write(motion, tmp_path / "a.glb")
    gltf = Gltf(path, path.read_bytes())
    view = gltf.document["bufferViews"][gltf.document["animations"][0]["samplers"][3]["output"]]
    data = bytearray(path.read_bytes())
    start = len(data) - len(gltf._binary) + view["byteOffset"]
    data[start : start + 4] = struct.pack("<f", np.nan)
    path.write_bytes(data)
    with pytest.raises(FormatError, match="not finite"):
        formats.read(path)


def test_a_motion_keeps_its_frames_however_it_is_cut(tmp_path):
    motion: Motion = random_motion(40, fps=24.0)
    again = formats.read(formats.write(motion[3:33], tmp_path / "a.glb"))
    np.testing.assert_allclose(again.positions, motion.positions[3:33], atol=1e-6)
