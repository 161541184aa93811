"""What every body must be, and what the default one promises."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import KDTree

from engines.errors import SkeletonError, UnknownLabelError
from engines.geometry import rotations
from engines.geometry.skins import skinning_matrices
from engines.motion import Motion
from engines.skeletons import SMPL22, Skeleton
from tests.viewers import poses
from viewers import bodies
from viewers.bodies.body import eight_bit_weights


@st.composite
def skeletons(draw) -> Skeleton:
    """Trees of 1 to 12 joints with any bones, some of length zero."""
    count = draw(st.integers(1, 12))
    parents = [-1] + [draw(st.integers(0, j - 1)) for j in range(1, count)]
    coordinate = st.floats(-0.6, 0.6).map(lambda x: round(x, 3))
    offsets = [[draw(coordinate) for _ in range(3)] for _ in range(count)]
    return Skeleton("drawn", tuple(f"joint{j}" for j in range(count)), tuple(parents), np.array(offsets))


def edges_of(body: bodies.Body, faces: np.ndarray) -> np.ndarray:
    """How many faces share each edge, vertices of one place taken as one."""
    place = np.unique(np.round(body.vertices, 4), axis=0, return_inverse=True)[1].ravel()[faces]
    place = place[(np.ptp(np.sort(place, 1), axis=1) > 0)]
    edges = np.sort(np.concatenate([place[:, [0, 1]], place[:, [1, 2]], place[:, [2, 0]]]), axis=1)
    edges = edges[edges[:, 0] != edges[:, 1]]
    return np.unique(edges, axis=0, return_counts=True)[1]


@pytest.mark.parametrize("name", bodies.available())
def test_every_body_is_well_formed(name: str) -> None:
    body = bodies.get(name)
    assert body.own_bones or body.skeleton == SMPL22
    assert body.skeleton.joints == SMPL22.joints
    assert np.allclose(body.skin_weights.sum(1), 1.0, atol=1e-5)
    assert (body.skin_weights >= 0).all()
    assert body.skin_weights.shape[1] == 4
    assert np.allclose(np.linalg.norm(body.normals, axis=1), 1.0, atol=1e-3)
    assert body.licence
    corners = body.vertices[body.faces]
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    outward = np.einsum("fa,fa->f", flat, body.normals[body.faces].sum(1)) >= 0
    assert outward.mean() > 0.985, "faces and normals must point the same way"
    assert np.einsum("fa,fa->", flat, corners.mean(1)) > 0, "the volume must be positive: faces seen from outside"


def test_the_default_body_is_the_first_and_small() -> None:
    assert bodies.available()[0] == bodies.DEFAULT == "anny"
    from viewers.bodies import anny

    assert anny.FILE.stat().st_size < 400_000
    assert "CC0" in bodies.get().licence


def test_soles_stand_on_the_floor_and_the_size_is_human() -> None:
    body = bodies.get("anny")
    ankle = SMPL22.rest_positions[SMPL22.index("left_ankle"), 1]
    assert body.vertices[:, 1].min() == pytest.approx(ankle - poses.ANKLE, abs=5e-4)
    assert 1.70 < body.height < 1.78
    feet = body.vertices[(body.vertices[:, 1] < ankle - poses.ANKLE + 0.003)]
    assert np.ptp(feet[feet[:, 0] > 0], axis=0)[2] > 0.2, "the sole is flat from heel to toe"


def test_joints_lie_inside_the_skin() -> None:
    body = bodies.get("anny")
    for joint, place in zip(SMPL22.joints, SMPL22.rest_positions, strict=True):
        around = body.vertices[np.linalg.norm(body.vertices - place, axis=1) < 0.22]
        assert len(around), joint
        low, high = around.min(0), around.max(0)
        assert (low < place).all() and (place < high).all(), f"{joint} lies outside the skin around it"


def test_the_default_body_is_symmetric() -> None:
    body = bodies.get("anny")
    distance, twin = KDTree(body.vertices).query(body.vertices * [-1, 1, 1])
    assert np.quantile(distance, 0.9) < 1e-3
    assert distance.max() < 0.012
    full = np.zeros((len(body.vertices), 22))
    np.put_along_axis(full, body.skin_indices.astype(int), body.skin_weights, axis=1)
    apart = np.abs(full - full[twin][:, SMPL22.mirror_index]).max(1)
    assert np.quantile(apart, 0.95) < 0.05


def test_the_default_body_is_closed_but_for_the_lining_of_the_shirt() -> None:
    body = bodies.get("anny")
    for faces in (body.faces, *body.coarse):
        shared = edges_of(body, faces)
        assert (shared == 2).mean() > 0.97
        assert (shared == 1).mean() < 0.02


def test_coarse_levels_shrink_and_keep_the_shape() -> None:
    body = bodies.get("anny")
    sizes = [len(faces) for faces in (body.faces, *body.coarse)]
    assert sizes[1] < 0.4 * sizes[0] and sizes[2] < 0.5 * sizes[1]
    for faces, limit in zip(body.coarse, (0.012, 0.03), strict=True):
        corners = body.vertices[faces]
        middles = np.concatenate([corners.mean(1), corners.reshape(-1, 3)])
        assert KDTree(body.vertices).query(middles)[0].max() < 0.08
        longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=-1).max()
        assert longest < 0.26, "a long edge means a face between parts that do not belong together"
        apart = KDTree(middles).query(body.vertices)[0]
        assert np.quantile(apart, 0.9) < limit + 0.02


def test_rest_pose_is_a_fixed_point_of_skinning() -> None:
    body = bodies.get("anny")
    rest = Motion(SMPL22, np.tile(rotations.IDENTITY, (1, 22, 1)), np.zeros((1, 3)), 20.0)
    assert np.abs(body.posed(rest) - body.vertices).max() < 1e-5


@pytest.mark.parametrize("make", [poses.squat, poses.arms_up, poses.seated])
def test_skin_neither_tears_nor_collapses(make) -> None:
    """In large poses few edges may grow or shrink much, and the body must keep most of its volume."""
    body = bodies.get("anny")
    posed = body.posed(make())

    def lengths(vertices: np.ndarray) -> np.ndarray:
        corners = vertices[body.faces]
        return np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=-1)

    def volume(vertices: np.ndarray) -> float:
        corners = vertices[body.faces] - vertices.mean(0)
        return float(np.einsum("fa,fa->", np.cross(corners[:, 0], corners[:, 1]), corners[:, 2])) / 6

    rest = lengths(body.vertices)
    ratio = (lengths(posed) / np.maximum(rest, 1e-3))[rest > 2e-3]
    assert np.quantile(ratio, 0.99) < 1.7
    assert ratio.max() < 6.0
    assert volume(posed) > 0.90 * volume(body.vertices)


def test_a_stretched_skeleton_stretches_the_body() -> None:
    longer = SMPL22.scaled({"left_knee": 1.3, "right_knee": 1.3, "left_elbow": 0.8, "right_elbow": 0.8})
    body = bodies.get("anny").fitted(longer)
    assert body.skeleton == longer
    ankle = longer.rest_positions[longer.index("left_ankle"), 1]
    assert body.vertices[:, 1].min() == pytest.approx(ankle - poses.ANKLE, abs=1e-3)
    hand = longer.rest_positions[longer.index("left_wrist"), 0] - SMPL22.rest_positions[SMPL22.index("left_wrist"), 0]
    assert body.vertices[:, 0].max() == pytest.approx(bodies.get("anny").vertices[:, 0].max() + hand, abs=1e-3)
    with pytest.raises(SkeletonError, match="fits skeletons"):
        bodies.get("anny").fitted(Skeleton("one", ("root",), (-1,), np.zeros((1, 3))))


def test_paint_covers_the_shirt_and_spares_the_skin() -> None:
    body = bodies.get("anny")
    painted = body.painted((1.0, 0.0, 0.0))
    assert (painted[body.tint == 1.0] == (255, 0, 0)).all()
    assert (painted[body.tint == 0.0] == body.colours[body.tint == 0.0]).all()
    assert 0.2 < (body.tint > 0).mean() < 0.8
    assert body.painted(None) is body.colours


def test_left_and_right_can_be_told_apart() -> None:
    body = bodies.get("anny")
    colours = {tuple(c) for c in body.colours[body.vertices[:, 0] > 0.05].tolist()}
    others = {tuple(c) for c in body.colours[body.vertices[:, 0] < -0.05].tolist()}
    assert colours - others and others - colours


@settings(max_examples=40, deadline=None)
@given(skeletons())
def test_a_stick_figure_fits_any_skeleton(skeleton: Skeleton) -> None:
    body = bodies.get("stick", skeleton)
    assert body.skeleton == skeleton
    assert (body.skin_weights[:, 0] == 1.0).all() and (body.skin_weights[:, 1:] == 0.0).all()
    assert set(body.skin_indices[:, 0]) == set(range(len(skeleton))), "every joint has a ball"
    rng = np.random.default_rng(0)
    turns = rotations.normalise(rng.normal(size=(1, len(skeleton), 4)))
    motion = Motion(skeleton, turns, rng.normal(size=(1, 3)), 20.0)
    posed = body.posed(motion)
    for joint, place in enumerate(motion.positions[0]):
        mine = posed[body.skin_indices[:, 0] == joint]
        assert np.linalg.norm(mine - place, axis=1).min() < 0.06


def test_stick_parts_are_closed_and_turned_outwards() -> None:
    body = bodies.get("stick")
    assert (edges_of(body, body.faces) == 2).all()
    corners = body.vertices[body.faces]
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (np.einsum("fa,fa->f", flat, body.normals[body.faces].mean(1)) > 0).all()


def test_skinning_matrices_carry_joints_to_their_places() -> None:
    motion = poses.stride(5)
    matrices = skinning_matrices(SMPL22, motion.positions, motion.global_rotations)
    rest = np.concatenate([SMPL22.rest_positions, np.ones((22, 1))], axis=1)
    assert np.allclose(np.einsum("tjab,jb->tja", matrices, rest), motion.positions, atol=1e-5)


@given(st.lists(st.lists(st.floats(0.0, 1.0), min_size=4, max_size=4), min_size=1, max_size=8))
def test_eight_bit_weights_sum_to_255(rows: list[list[float]]) -> None:
    weights = np.array(rows) + np.eye(4)[0]
    packed = eight_bit_weights(weights / weights.sum(1, keepdims=True))
    assert (packed.sum(1, dtype=int) == 255).all()
    assert np.abs(packed / 255 - weights / weights.sum(1, keepdims=True)).max() < 3 / 255


def test_body_for_takes_the_motion_as_it_is_or_finds_another_body() -> None:
    walk = poses.stride(3)
    body, motion = bodies.body_for(walk)
    assert body.name == "anny" and motion is walk
    tall = walk.scale_bones({"*": 1.1})
    body, motion = bodies.body_for(tall)
    assert motion is tall and body.skeleton == tall.skeleton
    snake = Skeleton("snake", ("a", "b", "c"), (-1, 0, 1), np.array([[0, 0, 0], [0, 0, 0.3], [0, 0, 0.3]]))
    crawl = Motion(snake, np.tile(rotations.IDENTITY, (2, 3, 1)), np.zeros((2, 3)), 20.0)
    body, motion = bodies.body_for(crawl)
    assert body.name == "stick" and motion is crawl


def test_unknown_bodies_and_broken_ones_are_refused() -> None:
    with pytest.raises(UnknownLabelError, match="anny"):
        bodies.get("ani")
    body = bodies.get("stick")
    with pytest.raises(SkeletonError, match="skin_weights"):
        replace(body, skin_weights=body.skin_weights[:-1])
    with pytest.raises(SkeletonError, match="do not exist"):
        replace(body, skin_indices=body.skin_indices + 100)
    with pytest.raises(SkeletonError, match="skinned to"):
        body.posed(poses.t_pose().scale_bones({"*": 2.0}))
