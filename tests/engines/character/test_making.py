"""From a picture, a mesh and a rigged file to characters, from one end to the other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from engines.character import making, models
from engines.character.character import Character
from engines.character.depth import rasterised
from engines.character.mesh import Surface
from engines.character.outline import overlap
from engines.character.rigged import Rigged
from engines.character.template import posed_vertices
from engines.errors import Cancelled, FormatError
from engines.evaluation.characters import Known, back_error, framed, standing
from engines.geometry.rotations import matrix_to_quaternion
from engines.motion import Motion
from engines.skeletons import SMPL22
from viewers import bodies


@pytest.fixture(scope="module")
def person() -> Known:
    """Someone who is not the usual body, in a picture as a telephone takes them."""
    body = bodies.get("anny").shaped(gender=0.2, weight=0.6)
    pose = standing(body, arms=1.15, bend=0.2)
    view, size = framed(posed_vertices(body, pose, np.zeros(3)), 720)
    return Known(body, body.painted((0.2, 0.4, 0.3)), pose, np.zeros(3), view, size)


@pytest.fixture(scope="module")
def told() -> list[tuple[float, str]]:
    return []


@pytest.fixture(scope="module")
def made(person: Known, told: list[tuple[float, str]]) -> Character:
    if not models.installed():
        pytest.skip("the networks that look at pictures are not installed: make character")
    picture = replace(person.front[0], name="aunt.jpg")
    return making.build(picture, bodies.get("anny"), progress=lambda share, words: told.append((share, words)))


def test_a_picture_becomes_a_character(made: Character, person: Known, told: list[tuple[float, str]]) -> None:
    assert made.name == "aunt"
    assert made.provenance["picture"] == "aunt.jpg"
    assert made.provenance["fit"]["overlap"] > 0.85
    assert [share for share, _ in told] == sorted(share for share, _ in told)
    assert told[-1][0] == 1
    assert made.skeleton.joints == SMPL22.joints
    assert made.surface.texture is not None
    height = np.ptp(made.surface.vertices[:, 1])
    assert 1.5 < height < 2.0
    rest = made.surface.vertices
    assert np.ptp(rest[:, 0]) == pytest.approx(height, rel=0.15)  # arms out, as wide as tall


def test_it_looks_like_the_picture_in_the_picture_s_pose(made: Character, person: Known) -> None:
    # the pose is the known one, on bones that were found; it is laid over the picture by height
    motion = Motion(made.skeleton, matrix_to_quaternion(person.pose)[None], np.zeros((1, 3)), 20.0)
    surface = made.surface.replaced(vertices=made.posed(motion))
    low, high = surface.vertices.min(0), surface.vertices.max(0)
    true_low, true_high = person.surface.vertices.min(0), person.surface.vertices.max(0)
    scale = (true_high[1] - true_low[1]) / (high[1] - low[1])
    middle, true_middle = (low + high) / 2, (true_low + true_high) / 2
    surface = surface.replaced(vertices=(surface.vertices - middle) * scale + true_middle)
    shown = rasterised(surface.vertices, surface.faces, person.view, person.size)
    assert overlap(shown.mask, person.front[1]) > 0.8
    assert back_error(person, surface) < 30


def test_stopping_and_nobody_there(person: Known) -> None:
    with pytest.raises(Cancelled):
        making.build(person.front[0], bodies.get("anny"), cancel=lambda: True)
    if models.installed():
        nobody = replace(person.front[0], pixels=np.full((300, 300, 3), 200, np.uint8))
        with pytest.raises(FormatError, match="nobody was found"):
            making.build(nobody, bodies.get("anny"))


def test_a_mesh_takes_the_place_of_the_reconstruction(known: Known) -> None:
    mesh = Surface(
        known.surface.vertices - [0, known.surface.vertices[:, 1].min(), 0], known.surface.faces, known.colours
    )
    made = making.from_mesh(mesh, bodies.get("anny"), "scan", provenance={"file": "scan.ply"})
    assert made.provenance["file"] == "scan.ply"
    assert made.provenance["faces"] == len(mesh.faces)
    rest = made.surface.vertices
    span = np.ptp(rest, axis=0)
    assert span[0] == pytest.approx(span[1], rel=0.15)
    assert abs(rest[:, 0].max() + rest[:, 0].min()) < 0.1


def test_a_rigged_file_keeps_its_skeleton(known: Known) -> None:
    body = known.template
    bare = Surface(body.vertices, body.faces)
    skeleton = SMPL22.replaced(name="theirs")
    source = Rigged(bare, body.skin_indices, body.skin_weights, skeleton, ("no texture",))
    made = making.from_rigged(source, "hero", provenance={"file": "hero.glb"})
    assert made.skeleton is skeleton
    assert made.provenance == {"remarks": ["no texture"], "file": "hero.glb"}
    still = Motion(skeleton, np.tile([1.0, 0, 0, 0], (1, 22, 1)), np.zeros((1, 3)), 20.0)
    assert np.allclose(made.posed(still), body.vertices, atol=1e-5)
