"""Charts that are seen from outside, do not overlap, and hold the picture in full detail."""

from __future__ import annotations

import numpy as np
import pytest

from engines.character.atlas import baked, unwrapped
from engines.character.depth import rasterised
from engines.character.mesh import Surface
from engines.character.texture import Front, painted
from engines.character.view import View
from engines.evaluation.characters import LOGO, Known
from tests.engines.character.test_mesh import ball


def flat_areas(surface: Surface) -> np.ndarray:
    """(F,) of faces in the texture, positive if seen from outside (v goes down)."""
    assert surface.uv is not None
    a, b, c = surface.uv[surface.faces].astype(float).transpose(1, 0, 2)
    u, v = b - a, c - a
    return (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) / 2


@pytest.mark.parametrize("body", [True, False])
def test_charts_lie_apart_and_are_not_stretched(known: Known, body: bool) -> None:
    surface = known.surface if body else ball(0.3, 4)
    flat = unwrapped(surface)
    assert np.array_equal(flat.vertices[flat.faces], surface.vertices[surface.faces])
    assert np.abs(flat.uv - 0.5).max() <= 0.5
    areas = flat_areas(flat)
    assert (np.sign(areas) == np.sign(np.median(areas))).mean() > 0.999  # none is turned over
    proper = surface.areas > 1e-8
    stretch = np.abs(areas[proper]) / surface.areas[proper]
    assert np.quantile(stretch, 0.02) > 0.2 * np.median(stretch)
    shown = rasterised(np.c_[flat.uv * (1, -1), 0 * flat.uv[:, :1]], flat.faces, View(1024, (0, 0)), (1024, 1024))
    assert 0.98 < np.abs(areas).sum() / shown.mask.mean() < 1.02  # no texel is used twice
    assert shown.mask.mean() > 0.35
    assert len(flat.vertices) < 1.6 * len(surface.vertices)


def test_a_print_is_as_sharp_in_the_texture_as_in_the_picture(known: Known, front: Front) -> None:
    done = baked(painted(known.surface.replaced(colours=None), front), front, 512)
    assert done.texture.shape == (512, 512, 3)
    corners = done.uv[done.faces].mean(1)
    column, row = (corners * 512).astype(int).T
    shown = done.texture[row, column].astype(int)
    rest = known.template.vertices[known.template.faces].mean(1)  # faces keep their order
    away = np.hypot(rest[:, 0], rest[:, 1] - 0.33)
    chest = (rest[:, 2] > 0.06) & (np.abs(rest[:, 0]) < 0.12)
    red = shown[:, 0] > 150
    assert red[chest & (away < 0.06)].all()
    assert not red[chest & (away > 0.08) & (away < 0.11)].any()
    assert np.abs(shown[chest & (away < 0.06)] - LOGO).max(1).mean() < 40


def test_colours_are_carried_on_into_the_gaps() -> None:
    plain = baked(ball(0.3, 2, (10, 200, 30)), size=64)
    assert (plain.texture == (10, 200, 30)).all()
    assert (baked(plain.replaced(colours=None, uv=None, texture=None), size=64).texture == 170).all()
