"""The depth buffer against pixel-by-pixel rays."""

from __future__ import annotations

import numpy as np
import pytest

from engines.character.depth import rasterised
from engines.character.view import View
from engines.errors import OutOfRangeError

VIEW = View(10.0, (12.0, 9.0))


def ray(vertices: np.ndarray, faces: np.ndarray, x: float, y: float) -> tuple[int, float]:
    """The face in front at a pixel place, and how near, triangle by triangle."""
    best = -1, -np.inf
    for number, face in enumerate(faces):
        corners = VIEW.project(vertices[face])
        system = np.vstack([corners.T, np.ones(3)])
        if abs(np.linalg.det(system)) < 1e-12:
            continue
        share = np.linalg.solve(system, [x, y, 1.0])
        depth = share @ vertices[face][:, 2]
        if (share >= 0).all() and depth > best[1]:
            best = number, depth
    return best


def test_rasterised_agrees_with_rays() -> None:
    random = np.random.default_rng(3)
    vertices = random.uniform(-1.4, 1.4, size=(24, 3))  # some of it outside the picture
    faces = random.permutation(24).reshape(8, 3)
    buffer = rasterised(vertices, faces, VIEW, (24, 18))
    for row in range(18):
        for column in range(24):
            face, depth = ray(vertices, faces, column + 0.5, row + 0.5)
            assert buffer.faces[row, column] == face
            if face >= 0:
                assert buffer.depths[row, column] == pytest.approx(depth)
                place = buffer.weights[row, column] @ vertices[faces[face]]
                assert VIEW.project(place) == pytest.approx((column + 0.5, row + 0.5))
    assert buffer.mask.any() and not buffer.mask.all()


def test_a_triangle_on_edge_or_outside_shows_nothing() -> None:
    vertices = np.array([[0.0, 0, 0], [0, 0.5, 0], [0, 1, 0.3], [9, 9, 0], [9, 10, 0], [10, 9, 0]])
    assert not rasterised(vertices, np.array([[0, 1, 2], [3, 4, 5]]), VIEW, (24, 18)).mask.any()


def test_no_pixels_are_refused() -> None:
    with pytest.raises(OutOfRangeError, match="40,000,000"):
        rasterised(np.zeros((3, 3)), np.array([[0, 1, 2]]), VIEW, (0, 18))
