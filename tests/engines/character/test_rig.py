"""From a surface in a picture's pose to a character in any pose: pairs, weights, rest shape, ways of posing, file."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from engines.character.arap import AsRigidAsPossible
from engines.character.character import Character, load
from engines.character.correspondence import matched
from engines.character.fitting import Fit
from engines.character.mesh import Surface
from engines.character.rig import rigged
from engines.character.template import posed_vertices
from engines.errors import FormatError, OutOfRangeError, SkeletonError
from engines.evaluation.characters import Known
from engines.formats import arrays
from engines.geometry.rotations import matrix_to_quaternion, rotvec_to_matrix
from engines.motion import Motion
from engines.skeletons import SMPL22
from tests.engines.character.test_mesh import ball


@pytest.fixture(scope="module")
def fit(known: Known) -> Fit:
    return Fit(known.template, {}, known.pose, known.root, known.view, {})


@pytest.fixture(scope="module")
def character(known: Known, fit: Fit) -> Character:
    return rigged(known.surface, fit, "known", {"picture": "drawn"})


@pytest.fixture(scope="module")
def raised(fit: Fit) -> tuple[Motion, np.ndarray]:
    """A pose far from the picture's, and the vertices of the body in it."""
    turns = np.zeros((22, 3))
    for joint, axis, angle in (
        ("left_shoulder", 2, 0.9),
        ("left_elbow", 1, -2.0),
        ("left_hip", 0, -1.4),
        ("left_knee", 0, 1.8),
    ):
        turns[SMPL22.index(joint), axis] = angle
    pose, place = rotvec_to_matrix(turns), np.array([0.1, 0.95, 0.2])
    motion = Motion(fit.template.skeleton, matrix_to_quaternion(pose)[None], place[None], 20.0)
    return motion, posed_vertices(fit.template, pose, place)


def off(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """(N,) millimetres between places."""
    return 1000 * np.linalg.norm(one - other, axis=1)


def full(indices: np.ndarray, weights: np.ndarray) -> np.ndarray:
    table = np.zeros((len(indices), len(SMPL22)))
    np.add.at(table, (np.arange(len(indices))[:, None], indices), weights)
    return table


def test_arms_beside_the_trunk_are_not_taken_for_it(known: Known, fit: Fit) -> None:
    # everything a centimetre larger than the body, and no word of which part is which
    swollen = known.surface.replaced(vertices=known.surface.vertices + 0.01 * known.surface.normals, parts=None)
    pairs = matched(swollen, fit)
    plain = [joint for joint, name in enumerate(SMPL22.joints) if not name.endswith(("head", "wrist", "ankle", "foot"))]
    used = np.isin(np.arange(len(swollen.vertices)), swollen.faces) & np.isin(known.surface.parts, plain)
    assert pairs.paired[used].mean() > 0.97
    right = known.surface.parts[pairs.vertices[:, 0]] == known.surface.parts
    assert right[used & pairs.paired].mean() > 0.93
    arm = np.array([joint.endswith(("shoulder", "elbow", "wrist")) for joint in SMPL22.joints])
    below = np.array([joint.endswith("elbow") for joint in SMPL22.joints])[known.surface.parts]
    assert arm[known.surface.parts[pairs.vertices[:, 0]]][used & pairs.paired & below].mean() > 0.995
    length = np.linalg.norm(pairs.displacements, axis=1)[used & pairs.paired]
    assert np.median(length) == pytest.approx(0.01, abs=0.002)


def test_what_stands_far_off_has_no_pair_and_goes_along(known: Known, fit: Fit) -> None:
    surface = known.surface
    skirt = surface.normals[:, [0, 2]] * np.isin(surface.parts, [1, 2])[:, None] * 0.2
    wide = surface.replaced(vertices=surface.vertices + np.insert(skirt, 1, 0, axis=1))
    made = rigged(wide, fit, "skirt")
    assert not matched(wide, fit).paired[np.isin(surface.parts, [1, 2])].all()
    table = full(made.skin_indices, made.skin_weights)
    legs = np.isin(surface.parts, [1, 2])
    hips = [SMPL22.index(joint) for joint in ("pelvis", "left_hip", "right_hip", "left_knee", "right_knee")]
    assert table[legs][:, hips].sum(1).min() > 0.9


def test_the_rest_pose_comes_back(known: Known, character: Character) -> None:
    gap = off(character.surface.vertices, known.template.vertices)
    assert np.median(gap) < 0.5
    assert np.quantile(gap, 0.95) < 5
    table = full(character.skin_indices, character.skin_weights)
    true = full(known.template.skin_indices, known.template.skin_weights)
    assert np.abs(table - true).sum(1).mean() < 0.1


def test_it_takes_poses_like_the_body_it_is(character: Character, raised: tuple[Motion, np.ndarray]) -> None:
    motion, true = raised
    skinned, rigid = character.posed(motion), character.posed(motion, way="rigid")
    assert off(skinned, true).mean() < 2
    assert off(rigid, true).mean() < 5
    first, solver = character._rigid
    assert solver.energy(rigid[first]) < 0.5 * solver.energy(skinned[first])
    assert np.array_equal(rigid, rigid[first][character.surface.groups])  # seams stay closed


def test_the_picture_s_own_pose_is_the_picture_s_surface(known: Known, fit: Fit, character: Character) -> None:
    motion = Motion(character.skeleton, matrix_to_quaternion(fit.pose)[None], fit.root[None], 20.0)
    assert np.quantile(off(character.posed(motion), known.surface.vertices), 0.95) < 3


def test_rigid_motions_cost_nothing_and_are_found() -> None:
    body = ball(0.5, 2)
    turn = rotvec_to_matrix(np.array([0.4, -1.0, 0.3]))
    wanted = body.vertices @ turn.T + (1, 2, 3)
    hold = np.zeros(len(wanted))
    hold[[0, 5, 50, 90]] = 100.0  # four control points say where all of it goes
    solver = AsRigidAsPossible(body.vertices, body.faces, hold)
    assert solver.energy(wanted) < 1e-20
    start = np.where(hold[:, None] > 0, wanted, body.vertices + np.array([1, 2, 3]))
    assert off(solver.deformed(wanted * (hold[:, None] > 0), start, rounds=60), wanted).max() < 10


def test_rounds_lessen_what_is_minimised() -> None:
    body = ball(0.5, 2)
    targets = body.vertices * (1, 1.6, 0.7) + 0.2 * np.sin(9 * body.vertices[:, ::-1])
    hold = np.full(len(targets), 0.3)
    solver = AsRigidAsPossible(body.vertices, body.faces, hold)

    def whole(places: np.ndarray) -> float:
        return solver.energy(places) + float((hold[:, None] * (places - targets) ** 2).sum())

    found = [whole(solver.deformed(targets, rounds=rounds)) for rounds in (1, 2, 4, 30)]
    assert found == sorted(found, reverse=True) and found[0] < whole(targets)
    best = solver.deformed(targets, rounds=30)
    rng = np.random.default_rng(0)
    assert all(whole(best) < whole(best + rng.normal(0, 0.003, best.shape)) for _ in range(10))


def test_nothing_held_is_refused() -> None:
    body = ball(0.5, 1)
    with pytest.raises(OutOfRangeError, match="not all of them 0"):
        AsRigidAsPossible(body.vertices, body.faces, np.zeros(len(body.vertices)))


def test_a_character_s_file_gives_it_back(character: Character, tmp_path: Path) -> None:
    count = len(character.surface.vertices)
    texture = np.random.default_rng(0).integers(0, 255, (8, 16, 3), np.uint8)
    surface = character.surface.replaced(uv=np.full((count, 2), 0.25), texture=texture)
    made = replace(character, surface=surface, shape={"weight": 0.7}, provenance={"picture": "me.jpg", "overlap": 0.9})
    file = made.save(tmp_path / "me.npz")
    back = load(file)
    assert (back.name, back.shape, back.provenance, back.skeleton) == (
        made.name,
        made.shape,
        made.provenance,
        made.skeleton,
    )
    assert back.skeleton.feet == made.skeleton.feet
    for name in ("vertices", "faces", "colours", "uv", "texture", "parts"):
        assert np.allclose(getattr(back.surface, name), getattr(made.surface, name), atol=1e-6)
    for name in ("skin_indices", "skin_weights", "hold"):
        assert np.array_equal(getattr(back, name), getattr(made, name))
    assert back.save(tmp_path / "again.npz").read_bytes() == file.read_bytes()
    assert list(tmp_path.glob(".*")) == []


def test_files_that_are_no_characters_are_refused_in_words(character: Character, tmp_path: Path) -> None:
    file = character.save(tmp_path / "a.npz")
    held = arrays.load(file, {*arrays.names(file)})
    cut = tmp_path / "cut.npz"
    cut.write_bytes(file.read_bytes()[:5000])
    with pytest.raises(FormatError, match="cut short"):
        load(cut)
    with pytest.raises(FormatError, match="no such file"):
        load(tmp_path / "none.npz")
    later = json.dumps({"version": 99, "name": "a", "shape": {}, "provenance": {}}).encode()
    for changes, told in (
        ({"character": np.frombuffer(later, np.uint8)}, "version 99"),
        ({"character": np.frombuffer(b"{", np.uint8)}, "is damaged"),
        ({"faces": held["faces"] + 10**6}, "point at vertices it has not"),
        ({"skin_indices": held["skin_indices"] + 40}, "joints its skeleton has not"),
        ({"skin_weights": held["skin_weights"] * 2}, "sum to one"),
        ({"hold": held["hold"][:5]}, "hold has shape"),
        ({"skeleton": held["skeleton"][:60]}, "skeleton"),
    ):
        arrays.save(cut, held | changes)
        with pytest.raises(FormatError, match=told):
            load(cut)
    del held["vertices"]
    arrays.save(cut, held)
    with pytest.raises(FormatError, match="has no 'vertices'; accepted: a character"):
        load(cut)
    with pytest.raises(FormatError, match="cannot be written as JSON"):
        replace(character, provenance={"who": object()}).save(cut)


def test_a_motion_of_another_skeleton_is_refused(character: Character) -> None:
    other = SMPL22.scaled({"*": 1.1})
    still = Motion(other, np.tile([1.0, 0, 0, 0], (1, 22, 1)), np.zeros((1, 3)), 20.0)
    with pytest.raises(SkeletonError, match="is skinned to"):
        character.posed(still)


def test_a_mesh_in_pieces_of_which_one_is_far_away_gets_weights(fit: Fit, known: Known) -> None:
    far = ball(0.1, 1)
    both = Surface(
        np.concatenate([known.surface.vertices, far.vertices + np.array([0, 1, 3])]),
        np.concatenate([known.surface.faces, far.faces + len(known.surface.vertices)]),
    )
    made = rigged(both, fit, "with a balloon")
    assert np.allclose(made.skin_weights.sum(1), 1)
    assert np.isfinite(made.surface.vertices).all()
