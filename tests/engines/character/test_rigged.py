"""Rigged .glb files: ours come back as they were, and others' stand as they mean it."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image

from engines import formats
from engines.character.rigged import is_rigged, read_rigged
from engines.errors import FormatError, MeshError
from engines.formats.gltf import Builder
from engines.geometry import rotations
from engines.skeletons import SMPL22
from tests.viewers import poses
from tests.viewers.textured import gradient, textured
from viewers import bodies

MIXAMO_NAMES = """Hips LeftUpLeg RightUpLeg Spine LeftLeg RightLeg Spine1 LeftFoot RightFoot Spine2 LeftToeBase
RightToeBase Neck LeftShoulder RightShoulder Head LeftArm RightArm LeftForeArm RightForeArm LeftHand RightHand"""
MIXAMO = dict(zip(SMPL22.joints, MIXAMO_NAMES.split(), strict=True))
ELSEWHERE = np.array([3.0, 1.0, -2.0])
"""Where the others' bodies stand, metres."""


def matrix(turn, place, scale: float = 1.0) -> np.ndarray:
    made = np.eye(4)
    made[:3, :3] = rotations.quaternion_to_matrix(turn) * scale
    made[:3, 3] = place
    return made


def full_weights(skin) -> np.ndarray:
    """(V, J) of something with skin_indices and skin_weights."""
    full = np.zeros((len(skin.skin_indices), len(skin.skeleton)))
    np.add.at(full, (np.arange(len(full))[:, None], skin.skin_indices.astype(int)), skin.skin_weights)
    return full


def foreign(path, body, names: dict[str, str], seed: int = 3) -> None:
    """The body as other programs write it: joints with axes of their own below an armature in centimetres, Z up."""
    rng = np.random.default_rng(seed)
    made, count = Builder(), len(SMPL22)
    lying = rotations.rotvec_to_quaternion(np.array([-np.pi / 2, 0, 0]))
    armature = matrix(lying, ELSEWHERE, 0.01)
    world = [armature @ matrix(rotations.normalise(rng.normal(size=4)), (0, 0, 0)) for _ in range(count)]
    for joint, place in enumerate(SMPL22.rest_positions):
        world[joint][:3, 3] = place + ELSEWHERE
    nodes = []
    for joint, parent in enumerate(SMPL22.parents):
        local = np.linalg.inv(armature if parent < 0 else world[parent]) @ world[joint]
        turn = rotations.matrix_to_quaternion(local[:3, :3] / np.cbrt(np.linalg.det(local[:3, :3])))
        nodes.append(
            {
                "name": names[SMPL22.joints[joint]],
                "rotation": turn[[1, 2, 3, 0]].tolist(),
                "translation": local[:3, 3].tolist(),
            }
        )
        below = [2 + child for child in SMPL22.children[joint]]
        if below:
            nodes[-1]["children"] = below
    made.document["nodes"] = [
        {"name": "Armature", "matrix": armature.T.ravel().tolist(), "children": [1, 2 + count]},
        {"name": "root", "children": [2]}, *nodes, {"name": "Skin", "mesh": 0, "skin": 0},
    ]  # fmt: skip
    inside = np.c_[body.vertices + ELSEWHERE, np.ones(len(body.vertices))] @ np.linalg.inv(armature).T
    bind = np.stack([np.linalg.inv(one) @ armature for one in world])
    made.document["skins"] = [
        {
            "joints": [1, *range(2, 2 + count)],
            "inverseBindMatrices": made.accessor(
                np.concatenate([np.eye(4)[None], bind]).transpose(0, 2, 1).reshape(-1, 16).astype(np.float32), "MAT4"
            ),
        }
    ]
    zero = np.zeros((len(body.vertices), 4), np.uint8)
    attributes = {
        "POSITION": made.accessor(inside[:, :3].astype(np.float32), "VEC3", bounds=True),
        "JOINTS_0": made.accessor((body.skin_indices + 1).astype(np.uint16), "VEC4"),
        "WEIGHTS_0": made.accessor(body.skin_weights * np.float32(0.9), "VEC4"),
        "JOINTS_1": made.accessor(zero, "VEC4"),  # a fifth, far weaker
        "WEIGHTS_1": made.accessor(np.full((len(zero), 4), (1e-6, 0, 0, 0), np.float32), "VEC4"),
        "TEXCOORD_0": made.accessor(body.uv, "VEC2"),
    }
    file = io.BytesIO()
    Image.fromarray(body.texture).save(file, "PNG")
    made.document["images"] = [{"mimeType": "image/png", "bufferView": made.view(file.getvalue())}]
    made.document["textures"] = [{"source": 0}]
    look = {"baseColorTexture": {"index": 0}, "baseColorFactor": [1.0, 0.2140, 1.0, 1.0]}  # half as green in sRGB
    made.document["materials"] = [{"pbrMetallicRoughness": look}]
    indices = made.accessor(body.faces.reshape(-1), "SCALAR")
    hat = {"attributes": {"POSITION": attributes["POSITION"]}, "indices": indices}
    made.document["meshes"] = [
        {"primitives": [{"attributes": attributes, "indices": indices, "material": 0}]}, {"primitives": [hat]},
    ]  # fmt: skip
    made.document["nodes"].append({"name": "floor", "mesh": 1})
    made.document["scenes"] = [{"nodes": [0, 3 + count]}]
    made.save(path)


def test_what_we_write_comes_back(tmp_path) -> None:
    body = textured(gradient())
    path = formats.write(poses.stride(4), tmp_path / "body.glb", skin=body)
    found = read_rigged(path)
    assert found.skeleton.joints == SMPL22.joints and found.skeleton.parents == SMPL22.parents
    np.testing.assert_allclose(found.skeleton.offsets[1:], SMPL22.offsets[1:], atol=1e-6)
    np.testing.assert_allclose(found.surface.vertices, body.vertices, atol=1e-5)
    np.testing.assert_array_equal(found.surface.faces, body.faces)
    np.testing.assert_allclose(found.surface.uv, body.uv, atol=1e-6)
    assert np.abs(found.surface.texture.astype(int) - body.texture).max() < 8
    np.testing.assert_allclose(full_weights(found), full_weights(body), atol=1e-5)
    assert (np.diff(found.skin_weights, axis=1) <= 0).all(), "the largest first"
    assert found.remarks == () and is_rigged(path.read_bytes())


def test_axes_armatures_units_and_names_of_others(tmp_path) -> None:
    body = textured(gradient())
    foreign(tmp_path / "mixamo.glb", body, {role: f"mixamorig:{name}" for role, name in MIXAMO.items()})
    found = read_rigged(tmp_path / "mixamo.glb")
    assert found.skeleton.joints[:3] == ("mixamorig:Hips", "mixamorig:LeftUpLeg", "mixamorig:RightUpLeg")
    np.testing.assert_allclose(found.skeleton.rest_positions, SMPL22.rest_positions, atol=1e-5)
    np.testing.assert_allclose(found.surface.vertices, body.vertices, atol=1e-4)
    np.testing.assert_allclose(full_weights(found), full_weights(body), atol=1e-4)
    wanted = body.texture.astype(int) // (1, 2, 1)
    assert np.abs(found.surface.texture - wanted)[-8:].max() < 4, "the factor is of linear light"
    assert found.remarks == ("1 of its meshes hang on no joint of the body and are left out.",)


def test_what_cannot_be_played_is_refused_in_words(tmp_path) -> None:
    body = textured(gradient())
    foreign(tmp_path / "crab.glb", body, {role: f"limb{n}" for n, role in enumerate(SMPL22.joints)})
    with pytest.raises(FormatError, match=r"left_knee.*Mixamo"):
        read_rigged(tmp_path / "crab.glb")
    bare = formats.write(poses.stride(4), tmp_path / "bare.glb")
    with pytest.raises(MeshError, match="no faces"):
        read_rigged(bare)
    data = (tmp_path / "crab.glb").read_bytes()
    for wrong, words in ((b"no glb at all, nowhere", "is no .glb"), (data[:-900], "breaks off")):
        with pytest.raises(FormatError, match=words):
            read_rigged(wrong, "mine.glb")
        assert not is_rigged(wrong)
    no_skin = data.replace(b'"skins"', b'"skims"').replace(b'"skin":0', b'"skim":0')
    with pytest.raises(FormatError, match="no skin"):
        read_rigged(no_skin, "mine.glb")
    foreign(tmp_path / "mixamo.glb", body, MIXAMO)
    data = (tmp_path / "mixamo.glb").read_bytes()
    with pytest.raises(FormatError, match="damaged"):
        read_rigged(data.replace(b'"inverseBindMatrices":0', b'"inverseBindMatrices":1'), "mine.glb")


def test_it_plays_our_motions(tmp_path) -> None:
    body = textured(gradient())
    foreign(tmp_path / "mixamo.glb", body, MIXAMO)
    found = read_rigged(tmp_path / "mixamo.glb")
    moved = poses.squat().retarget(found.skeleton)
    wanted = poses.squat()
    for role, joint in MIXAMO.items():
        apart = moved.positions[0, moved.skeleton.index(joint)] - wanted.positions[0, SMPL22.index(role)]
        assert np.linalg.norm(apart) < 0.02, role
    assert bodies.get("anny").height == pytest.approx(np.ptp(found.surface.vertices[:, 1]), abs=1e-3)
