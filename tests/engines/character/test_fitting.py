"""Bodies fitted to what is seen of known ones, and to meshes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import KDTree

from engines.character.fitting import Fit, fit, fit_to_surface
from engines.character.mesh import Surface, cleaned
from engines.character.sighting import Sighting
from engines.character.template import posed_vertices
from engines.errors import OutOfRangeError
from engines.evaluation.characters import Known, framed, standing
from tests.engines.character.seen import dressed, joints_of, sighting_of
from viewers import bodies


@pytest.fixture(scope="module")
def someone() -> Known:
    """A heavy woman turned a little to her left, arms hanging, off the middle of the picture."""
    body = bodies.get("anny").shaped(gender=1.0, weight=0.8, height=0.3)
    pose, root = standing(body, arms=1.0, turn=0.3), np.array([0.3, 0.8, 0.0])
    return Known(body, body.colours, pose, root, *framed(posed_vertices(body, pose, root), 420))


@pytest.fixture(scope="module")
def found(someone: Known) -> tuple[Sighting, Fit]:
    sighting = sighting_of(someone, error=0.015)
    return sighting, fit(sighting, bodies.get("anny"), height=someone.template.height)


def test_a_fit_has_the_outline_the_joints_and_the_height(someone: Known, found: tuple[Sighting, Fit]) -> None:
    sighting, fitted = found
    assert fitted.report["overlap"] > 0.92
    shown = fitted.view.project(fitted.joints) - someone.view.project(joints_of(someone)[0])
    assert np.linalg.norm(shown, axis=1).mean() / someone.view.scale < 0.015
    away = (fitted.joints - fitted.joints[0]) - (joints_of(someone)[0] - joints_of(someone)[0][0])
    assert np.linalg.norm(away, axis=1).mean() < 0.05
    assert np.ptp(fitted.template.vertices[:, 1]) == pytest.approx(someone.template.height, abs=0.02)
    assert sighting.mask.sum() == someone.front[1].sum()  # she wears nothing loose


def test_a_fit_stands_on_the_floor_over_the_origin(found: tuple[Sighting, Fit]) -> None:
    _, fitted = found
    assert fitted.vertices[:, 1].min() == pytest.approx(0.0, abs=1e-6)
    assert fitted.root[[0, 2]] == pytest.approx((0.0, 0.0))
    assert fitted.pose @ fitted.pose.swapaxes(1, 2) == pytest.approx(np.tile(np.eye(3), (22, 1, 1)), abs=1e-9)
    assert fitted.shape.keys() == {"gender", "age", "muscle", "weight", "height"}
    assert fitted.turns[0] == pytest.approx(fitted.pose[0])


def test_loose_clothes_do_not_make_the_body_fat(someone: Known, found: tuple[Sighting, Fit]) -> None:
    loose = fit(sighting_of(someone, dress=0.05, error=0.015), bodies.get("anny"), height=someone.template.height)
    volumes = [volume(Surface(other.vertices, other.template.faces)) for other in (found[1], loose)]
    clothes = volume(Surface(dressed(someone, 0.05), someone.surface.faces)) - volume(someone.surface)
    assert volumes[1] - volumes[0] < 0.4 * clothes


def test_a_mesh_in_an_a_pose_needs_no_landmarks(someone: Known) -> None:
    pose = standing(someone.template, arms=0.8)
    known = replace(someone, pose=pose)
    mesh = cleaned(Surface(known.surface.vertices, known.surface.faces))
    floor = np.array([0, mesh.vertices[:, 1].min(), 0])
    fitted = fit_to_surface(mesh.replaced(vertices=mesh.vertices - floor), bodies.get("anny"))
    away = np.linalg.norm(fitted.joints + floor - joints_of(known)[0], axis=1)
    assert away.mean() < 0.025 and away.max() < 0.06
    nearest = np.asarray(KDTree(fitted.vertices + floor).query(mesh.vertices)[0])
    assert nearest.mean() < 0.01


def test_what_cannot_be_fitted_is_refused(someone: Known, found: tuple[Sighting, Fit]) -> None:
    sighting, _ = found
    with pytest.raises(OutOfRangeError, match="height is 17"):
        fit(sighting, bodies.get("anny"), height=17.0)
    with pytest.raises(OutOfRangeError, match="covers the person"):
        fit(sighting.painted(np.zeros_like(sighting.mask)), bodies.get("anny"))


def volume(surface: Surface) -> float:
    """Cubic metres within a closed mesh."""
    a, b, c = (surface.vertices[surface.faces[:, corner]] for corner in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)
