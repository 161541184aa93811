"""The steps of the bake, on small meshes and made-up skeletons: the bake itself needs a package users need not have."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from engines.geometry import rotations
from engines.geometry.skins import strongest
from engines.skeletons import SMPL22
from tests.viewers import poses
from viewers.bodies.baking import dress, simplify, surface, unpose, weights
from viewers.bodies.baking.weights import SkinMesh
from viewers.bodies.packed import UNIT, save, unpack


def ball(points: int = 400) -> SkinMesh:
    """A closed unit sphere, one half on each of two joints."""
    number = np.arange(points) + 0.5
    polar, round_ = np.arccos(1 - 2 * number / points), np.pi * (1 + 5**0.5) * number
    places = np.stack([np.cos(round_) * np.sin(polar), np.sin(round_) * np.sin(polar), np.cos(polar)], axis=-1)
    hull = ConvexHull(places)
    corners = places[hull.simplices]
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inward = np.einsum("fa,fa->f", flat, corners.mean(1)) < 0
    faces = hull.simplices.copy()
    faces[inward] = faces[inward][:, ::-1]
    share = np.zeros((points, 22))
    share[:, 0] = (places[:, 1] + 1) / 2
    share[:, 3] = 1 - share[:, 0]
    return SkinMesh(places, faces, share)


def area(vertices: np.ndarray, faces: np.ndarray) -> float:
    corners = vertices[faces]
    return float(
        np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum() / 2
    )


def is_closed(faces: np.ndarray) -> bool:
    """Every edge has one face on either side, wound the other way."""
    edges = {tuple(e) for f in faces.tolist() for e in ((f[0], f[1]), (f[1], f[2]), (f[2], f[0]))}
    return len(edges) == 3 * len(faces) and all((b, a) in edges for a, b in edges)


@settings(max_examples=25, deadline=None)
@given(st.floats(-0.8, 0.8), st.integers(0, 2))
def test_a_cut_divides_and_keeps_the_surface(level: float, axis: int) -> None:
    mesh = ball()
    regions = np.zeros(len(mesh.faces), int)
    done = surface.cut(mesh, regions, mesh.vertices[:, axis] - level, 1, (0,))
    assert is_closed(done.mesh.faces)
    assert area(done.mesh.vertices, done.mesh.faces) == pytest.approx(area(mesh.vertices, mesh.faces), rel=0.02)
    height = done.mesh.vertices[done.mesh.faces][..., axis]
    assert (height[done.regions == 1] > level - 1e-9).all() and (height[done.regions == 0] < level + 1e-9).all()
    assert np.allclose(done.mesh.weights.sum(1), 1.0)


def test_a_cut_leaves_other_regions_alone() -> None:
    mesh = ball()
    regions = np.where(mesh.vertices[mesh.faces].mean(1)[:, 0] > 0, 5, 0)
    done = surface.cut(mesh, regions, mesh.vertices[:, 1], 1, (0,))
    assert (done.regions == 5).sum() >= (regions == 5).sum()
    assert (done.mesh.vertices[done.mesh.faces[done.regions == 1]].mean(1)[:, 0] < 0.1).all()


def test_thickened_regions_stand_off_and_their_edges_are_closed() -> None:
    mesh = ball()
    done = surface.cut(mesh, np.zeros(len(mesh.faces), int), mesh.vertices[:, 1] - 0.1, 1, (0,))
    thickness = np.zeros((2, len(done.mesh.vertices)))
    thickness[1] = 0.1
    none = surface.Lining(0, 1, np.zeros(len(done.mesh.vertices), bool))
    cloth = surface.thicken(done.mesh, (done.mesh.faces, done.regions), thickness, [], none)
    radius = np.linalg.norm(cloth.vertices, axis=1)
    upper = cloth.vertices[:, 1] > 0.3
    assert np.allclose(radius[upper], 1.1, atol=0.01) and radius[cloth.vertices[:, 1] < -0.1].max() < 1.001
    place = np.unique(np.round(cloth.vertices, 6), axis=0, return_inverse=True)[1].ravel()
    assert is_closed(place[cloth.faces])
    lined = surface.Lining(0, 1, done.mesh.vertices[:, 1] < 0.4)
    under = surface.thicken(done.mesh, (done.mesh.faces, done.regions), thickness, [], lined)
    assert len(under.faces) > len(cloth.faces)
    assert ((under.region == 0) & (under.vertices[:, 1] > 0.15)).any(), "the lower region goes on under the upper"


def test_simplified_meshes_stay_closed_and_keep_their_seams() -> None:
    mesh = ball(900)
    done = surface.cut(mesh, np.zeros(len(mesh.faces), int), mesh.vertices[:, 1], 1, (0,))
    levels = simplify.simplify(done.mesh, done.regions, np.ones(len(done.mesh.vertices)), (900, 400))
    for (faces, regions), wanted in zip(levels, (900, 400), strict=True):
        assert wanted - 2 <= len(faces) <= wanted
        assert is_closed(faces)
        seam = done.mesh.vertices[faces]
        assert seam[regions == 1][..., 1].min() > -1e-6 and seam[regions == 0][..., 1].max() < 1e-6
        assert area(done.mesh.vertices, faces) == pytest.approx(4 * np.pi, rel=0.06)


def test_fairing_keeps_the_size_and_smoothing_shrinks() -> None:
    mesh = ball()
    rng = np.random.default_rng(0)
    rough = mesh.vertices * (1 + 0.05 * rng.normal(size=(len(mesh.vertices), 1)))
    everywhere = np.ones(len(rough))
    fair = np.linalg.norm(surface.fair(rough, mesh.faces, everywhere, 15), axis=1)
    assert fair.std() < 0.03 and fair.mean() == pytest.approx(1.0, abs=0.02)
    assert np.linalg.norm(surface.smooth(rough, mesh.faces, everywhere, 15), axis=1).mean() < 0.9


def test_bones_find_their_joints() -> None:
    names = {
        "Hips": "pelvis",
        "LeftHandIndex2": "left_wrist",
        "RightToeBase": "right_foot",
        "LeftShoulder": "left_collar",
    }
    for bone, joint in names.items():
        assert SMPL22.joints[weights.joint_of(bone)] == joint


def made_up_rig() -> tuple[dict[str, np.ndarray], np.ndarray, np.ndarray]:
    """A rig that stands as a posed smpl22 does, and three points a bone, posed and at rest."""
    motion = poses.pose(
        **poses.both("shoulder", 0, 0, -45), **poses.both("elbow", 0, -40, 0), **poses.both("hip", -4, 0, 6),
        **poses.both("knee", 9, 0, 0), **poses.both("ankle", -5, 0, -6),
    )  # fmt: skip
    places, turns = motion.positions[0], motion.global_rotations[0]
    bones = {
        "Hips": "pelvis", "Spine": "spine1", "Spine1": "spine2", "Spine2": "spine3", "Neck": "neck", "Head": "head",
    }  # fmt: skip
    parts = {
        "Shoulder": "collar", "Arm": "shoulder", "ForeArm": "elbow", "Hand": "wrist", "UpLeg": "hip", "Leg": "knee",
        "Foot": "ankle", "ToeBase": "foot",
    }  # fmt: skip
    for side in ("Left", "Right"):
        bones |= {side + bone: f"{side.lower()}_{joint}" for bone, joint in parts.items()}
    names = list(bones)
    heads = [places[SMPL22.index(joint)] for joint in bones.values()]
    for side, sign in (("Left", 1.0), ("Right", -1.0)):
        wrist = SMPL22.index(f"{side.lower()}_wrist")
        for finger, ahead in (("Middle1", 0.0), ("Index1", 0.03), ("Pinky1", -0.04)):
            names.append(f"{side}Hand{finger}")
            heads.append(places[wrist] + turns[wrist] @ np.array([sign * 0.09, 0.0, ahead]))
    raw = {"bones": np.array(names), "heads": np.array(heads)}
    children = [SMPL22.children[j][0] if SMPL22.children[j] else j for j in range(22)]
    children[0] = SMPL22.index("spine1")
    rest = SMPL22.rest_positions
    along = [np.linspace(rest[j], rest[c], 4)[:3] for j, c in enumerate(children)]
    posed = [np.linspace(places[j], places[c], 4)[:3] for j, c in enumerate(children)]
    return raw, np.concatenate(posed), np.concatenate(along)


def test_unposing_brings_every_bone_to_rest() -> None:
    raw, posed, rest = made_up_rig()
    shares = np.repeat(np.eye(22), 3, axis=0)
    mesh = SkinMesh(posed, np.zeros((0, 3), int), shares)
    symmetric = unpose.to_rest_pose(mesh, raw)
    assert np.abs(symmetric.vertices - rest).max() < 2e-3


def test_unposing_finds_the_twist_of_forearms() -> None:
    raw, _, _ = made_up_rig()
    turns = {SMPL22.joints[b.joint]: b for b in unpose.bone_turns(raw)}
    assert abs(np.degrees(turns["left_elbow"].twist)) < 3.0, "the made-up hand is not turned"
    index, little = (list(raw["bones"]).index(f"LeftHand{f}1") for f in ("Index", "Pinky"))
    middle, wrist = (raw["heads"][list(raw["bones"]).index(f"LeftHand{f}")] for f in ("Middle1", ""))
    axis = rotations.normalise(middle - wrist)
    turned = rotations.rotvec_to_quaternion(np.radians(30) * axis)
    for finger in (index, little):
        raw["heads"][finger] = wrist + rotations.rotate(turned, raw["heads"][finger] - wrist)
    twisted = {SMPL22.joints[b.joint]: b for b in unpose.bone_turns(raw)}
    assert np.degrees(twisted["left_elbow"].twist) == pytest.approx(30.0, abs=3.0)


@given(st.integers(0, 10_000))
def test_the_strongest_four_sum_to_one_and_change_smoothly(seed: int) -> None:
    rng = np.random.default_rng(seed)
    full = rng.dirichlet(np.full(22, 0.3), size=5)
    index, kept = strongest(full)
    assert np.allclose(kept.sum(1), 1.0) and (np.diff(kept, axis=1) <= 1e-12).all()
    nudged = full + 1e-7 * rng.normal(size=full.shape)
    again = np.zeros_like(full)
    first = np.zeros_like(full)
    np.put_along_axis(first, index, kept, axis=1)
    np.put_along_axis(again, *strongest(nudged), axis=1)
    assert np.abs(first - again).max() < 1e-3, "a fourth and a fifth of equal weight may change places unnoticed"


def test_a_saved_body_comes_back(tmp_path: Path) -> None:
    mesh = ball()
    regions = np.zeros(len(mesh.faces), int)
    none = surface.Lining(0, 1, np.zeros(len(mesh.vertices), bool))
    coarse = simplify.simplify(mesh, regions, np.ones(len(mesh.vertices)), (300,))
    shell = surface.thicken(mesh, (mesh.faces, regions), np.zeros((1, len(mesh.vertices))), coarse, none)
    count = len(shell.vertices)
    colours = np.tile(np.array([10, 20, 30], np.uint8), (count, 1))
    save(dress.Dressed(shell, colours, np.full(count, 0.5)), tmp_path / "ball.npz")
    body = unpack(tmp_path / "ball.npz", "ball", "none")
    assert [p.name for p in tmp_path.iterdir()] == ["ball.npz"]
    assert sorted(map(len, (body.faces, *body.coarse))) == sorted([len(shell.faces), len(shell.coarse[0])])
    assert np.abs(np.sort(body.vertices, 0) - np.sort(shell.vertices, 0)).max() <= UNIT
    assert np.abs(np.linalg.norm(body.vertices, axis=1) - 1).max() < 1e-3
    assert np.einsum("va,va->v", body.normals, body.vertices).min() > 0.98
    assert (body.colours == (10, 20, 30)).all() and np.allclose(body.tint, 0.5, atol=0.01)
    full = np.zeros((count, 22))
    np.put_along_axis(full, body.skin_indices.astype(int), body.skin_weights, axis=1)
    assert np.allclose(full[:, 0], (body.vertices[:, 1] + 1) / 2, atol=0.01)
