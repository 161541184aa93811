"""The clothed surface, of bodies whose clothes are known."""

from __future__ import annotations

import numpy as np
import pytest

from engines.character.depth import rasterised
from engines.character.fitting import Fit
from engines.character.mesh import Surface
from engines.character.sighting import Sighting
from engines.character.surface import clothed, halved
from engines.character.template import posed_vertices, strongest_joints
from engines.evaluation.characters import Known, chamfer, framed, overlap, standing
from tests.engines.character.seen import dressed, sighting_of

DRESS = 0.05


@pytest.fixture(scope="module")
def known(known: Known) -> Known:
    """Arms far enough from the trunk for clothes between them."""
    pose = standing(known.template, arms=0.7)
    return Known(
        known.template, known.colours, pose, known.root, *framed(posed_vertices(known.template, pose, known.root), 420)
    )


@pytest.fixture(scope="module")
def truth(known: Known) -> Fit:
    """The fit that is right."""
    return Fit(known.template, {}, known.pose, known.root, known.view, {})


@pytest.fixture(scope="module")
def loose(known: Known, truth: Fit) -> tuple[Sighting, Surface]:
    sighting = sighting_of(known, dress=DRESS)
    return sighting, clothed(truth, sighting)


def test_the_surface_has_the_outline_of_the_mask(known: Known, loose: tuple[Sighting, Surface]) -> None:
    sighting, surface = loose
    assert overlap(known.front[1], sighting.mask >= 0.5) < 0.88  # the body alone has not
    shown = rasterised(surface.vertices, surface.faces, known.view, known.size)
    assert overlap(shown.mask, sighting.mask >= 0.5) > 0.97
    across = np.cross(*(surface.vertices[surface.faces[:, i]] - surface.vertices[surface.faces[:, 0]] for i in (1, 2)))
    assert (across[shown.faces[shown.mask], 2] > 0).mean() > 0.998  # nothing is turned inside out


def test_loose_clothes_stand_off_in_front_and_behind(known: Known, loose: tuple[Sighting, Surface]) -> None:
    _, surface = loose
    body, wanted = known.surface.vertices, dressed(known, DRESS)
    middle = known.root + np.array([0, 0.25, 0])
    bare, ours = (np.abs(vertices - middle)[:, :2].max(1) < 0.03 for vertices in (body, surface.vertices))
    for end in (np.max, np.min):
        assert end(surface.vertices[ours, 2]) == pytest.approx(end(wanted[bare, 2]), abs=0.015)
        assert abs(end(body[bare, 2]) - end(wanted[bare, 2])) > 0.04
    assert chamfer(surface.vertices, wanted) < 0.009


def test_hands_and_shoes_keep_their_form(known: Known, truth: Fit, loose: tuple[Sighting, Surface]) -> None:
    _, surface = loose
    assert surface.parts is not None
    for joint in ("left_wrist", "right_wrist", "left_foot", "right_foot"):
        part = known.template.skeleton.index(joint)
        ours = np.ptp(surface.vertices[surface.parts == part], axis=0)
        assert ours == pytest.approx(np.ptp(truth.vertices[strongest_joints(truth.template) == part], axis=0), abs=0.02)


def test_a_mask_that_fits_changes_little(known: Known, truth: Fit) -> None:
    surface = clothed(truth, sighting_of(known))
    assert chamfer(surface.vertices, truth.vertices) < 0.009
    assert 15_000 < len(surface.vertices) < 45_000


def test_halving_keeps_the_shape_and_ends() -> None:
    random = np.random.default_rng(0)
    corners = random.normal(size=(4, 3))
    before = Surface(corners, np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]), parts=np.arange(4))
    after = halved(before, 0.4)
    edges = after.vertices[after.faces[:, [0, 1, 2]]] - after.vertices[after.faces[:, [1, 2, 0]]]
    assert np.linalg.norm(edges, axis=2).max() <= 0.4
    assert after.open_edges == 0  # no corner of one face on the edge of another
    assert after.areas.sum() == pytest.approx(before.areas.sum())
    assert after.parts is not None and set(after.parts) == {0, 1, 2, 3}
    flat = [np.cross(*(s.vertices[s.faces[:, i]] - s.vertices[s.faces[:, 0]] for i in (1, 2))) for s in (before, after)]
    assert flat[1].sum(0) == pytest.approx(flat[0].sum(0), abs=1e-9)  # all faces still turn the same way
