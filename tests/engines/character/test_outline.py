"""Outlines of masks and of meshes."""

from __future__ import annotations

import numpy as np
import pytest

from engines.character.outline import contour, overlap, reduced, rim
from engines.character.view import View
from engines.evaluation.characters import Known


def disc(radius: float, centre: tuple[float, float], size: int = 80) -> np.ndarray:
    """(size, size) a disc with soft edges, one half exactly at the radius."""
    y, x = np.mgrid[:size, :size] + 0.5
    return np.clip(radius - np.hypot(x - centre[0], y - centre[1]) + 0.5, 0, 1)


def test_the_contour_of_a_disc_is_its_circle() -> None:
    edge = contour(disc(20.0, (41.3, 38.6)))
    away = edge.points - (41.3, 38.6)
    assert np.linalg.norm(away, axis=1) == pytest.approx(20.0, abs=0.12)
    cosines = (away / np.linalg.norm(away, axis=1, keepdims=True) * edge.normals).sum(1)
    assert cosines.min() > 0.98


def test_the_picture_edge_is_no_contour() -> None:
    edge = contour(disc(30.0, (5.0, 40.0)))
    assert np.linalg.norm(edge.points - (5.0, 40.0), axis=1) == pytest.approx(30.0, abs=0.15)  # none along x = 0


def test_a_reduced_mask_shows_the_same_places() -> None:
    view, mask = View(300.0, (41.3, 38.6)), disc(20.0, (41.3, 38.6))
    small, seen = reduced(mask, view, 14)
    assert small.shape == (27, 27)
    middle = seen.unproject(contour(small).points).mean(0)
    assert middle[:2] == pytest.approx((0.0, 0.0), abs=0.002)


def test_the_rim_of_a_body_lies_on_its_triangles(known: Known) -> None:
    edge = rim(known.surface.vertices, known.surface.faces, known.view, known.size)
    points = (edge.weights[..., None] * known.surface.vertices[edge.corners]).sum(1)
    away = np.linalg.norm(known.view.project(points) - edge.contour.points, axis=1)
    assert away.max() <= 0.5 + 1e-6  # the triangle of the pixel within, half a pixel from the edge
    assert overlap(edge.mask, known.front[1].astype(float)) == 1.0
