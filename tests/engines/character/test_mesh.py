"""Surfaces: what is refused, in words, and what cleaning and simplifying leave."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from engines.character.mesh import MAX_FACES, Surface, cleaned, simplified
from engines.errors import MeshError, OutOfRangeError

TRIANGLE = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])


def ball(radius: float = 1.0, subdivisions: int = 3, colour: tuple[int, int, int] = (200, 100, 50)) -> Surface:
    mesh = trimesh.creation.icosphere(subdivisions=subdivisions, radius=radius)
    places = np.asarray(mesh.vertices)
    return Surface(places, np.asarray(mesh.faces), np.tile(np.array(colour, np.uint8), (len(places), 1)))


@pytest.mark.parametrize(
    ("vertices", "faces", "told"),
    [
        (TRIANGLE, np.zeros((0, 3), int), "no faces"),
        (TRIANGLE, np.array([[0, 1, 3]]), "1 of 1 faces"),
        (TRIANGLE, np.array([[0, 1, -1]]), "point at vertices it has not"),
        (TRIANGLE * [np.nan, 1, 1], np.array([[0, 1, 2]]), "3 of 3 vertices"),
        (TRIANGLE[:, :2], np.array([[0, 1, 2]]), r"vertices of the mesh are float64 of shape \(3, 2\)"),
        (TRIANGLE, np.array([[0.0, 1, 2]]), "faces of the mesh are float64"),
        (TRIANGLE, np.broadcast_to(np.array([[0, 1, 2]]), (MAX_FACES + 1, 3)), "2,000,001 faces"),
    ],
)
def test_meshes_that_are_none_are_refused_in_words(vertices: np.ndarray, faces: np.ndarray, told: str) -> None:
    with pytest.raises(MeshError, match=told):
        Surface(vertices, faces)


def test_colours_and_textures_must_fit() -> None:
    face = np.array([[0, 1, 2]])
    with pytest.raises(MeshError, match="3 vertices and 2 colours"):
        Surface(TRIANGLE, face, np.zeros((2, 3), np.uint8))
    with pytest.raises(MeshError, match="needs uv"):
        Surface(TRIANGLE, face, texture=np.zeros((4, 4, 3), np.uint8))
    with pytest.raises(MeshError, match="texture has shape"):
        Surface(TRIANGLE, face, uv=np.zeros((3, 2)), texture=np.zeros((4, 4), np.uint8))


def test_normals_of_a_ball_point_outward_over_a_seam_too() -> None:
    ball_ = ball()
    assert np.allclose(ball_.normals, ball_.vertices, atol=0.02)
    torn = Surface(ball_.vertices[ball_.faces].reshape(-1, 3), np.arange(3 * len(ball_.faces)).reshape(-1, 3))
    assert np.allclose(torn.normals, torn.vertices, atol=0.02)
    assert ball_.open_edges == torn.open_edges == 0
    assert ball_.replaced(faces=ball_.faces[1:]).open_edges == 3


def test_colours_come_out_of_a_texture() -> None:
    texture = np.zeros((2, 4, 3), np.uint8)
    texture[0, 3], texture[1, 0] = 255, 80
    made = Surface(TRIANGLE, np.array([[0, 1, 2]]), uv=np.array([[0.9, 0.1], [0.1, 0.9], [1.0, 1.0]]), texture=texture)
    assert made.coloured().colours.tolist() == [[255] * 3, [80] * 3, [0] * 3]


def test_cleaning_welds_and_drops_crumbs_and_faces_without_area() -> None:
    big, crumb = ball(), ball(0.01)
    torn = big.vertices[big.faces].reshape(-1, 3)
    count = len(torn)
    faces = np.concatenate([np.arange(count).reshape(-1, 3), crumb.faces + count, [[0, 0, 1]]])
    mess = Surface(np.concatenate([torn, crumb.vertices + 5, [[9, 9, 9]]]), faces)
    tidy = cleaned(mess)
    assert (len(tidy.vertices), len(tidy.faces), tidy.open_edges) == (len(big.vertices), len(big.faces), 0)
    assert np.allclose(tidy.areas.sum(), big.areas.sum())
    with pytest.raises(MeshError, match="no face of the mesh has an area"):
        cleaned(Surface(TRIANGLE * [1, 0, 0], np.array([[0, 1, 2]])))


def test_simplifying_keeps_the_shape_and_the_colours() -> None:
    pytest.importorskip("fast_simplification")
    fine = ball(subdivisions=4)
    north = fine.vertices[:, 1] > 0
    fine = fine.replaced(colours=np.where(north[:, None], fine.colours, 0).astype(np.uint8), parts=north.astype(int))
    few = simplified(fine, 400)
    assert 300 < len(few.faces) <= 440
    assert np.abs(np.linalg.norm(few.vertices, axis=1) - 1).max() < 0.05
    clear = np.abs(few.vertices[:, 1]) > 0.1
    assert ((few.colours[:, 0] > 0) == (few.vertices[:, 1] > 0))[clear].all()
    assert ((few.parts > 0) == (few.vertices[:, 1] > 0))[clear].all()
    assert simplified(few, 400) is few
    with pytest.raises(OutOfRangeError, match="faces is 3"):
        simplified(fine, 3)
