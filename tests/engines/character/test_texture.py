"""What is seen has the picture's colours; what is not has neither the face nor the print of the front."""

from __future__ import annotations

import numpy as np
import pytest

from engines.character.completion import completed
from engines.character.mesh import Surface
from engines.character.picture import Picture
from engines.character.texture import Front, painted
from engines.character.view import View
from engines.evaluation.characters import Known, back_error, mirrored, nearest_copy
from engines.skeletons import SMPL22
from tests.engines.character.test_mesh import ball

RED, GREEN = np.array([250.0, 0, 0]), np.array([0, 200.0, 0])


@pytest.fixture(scope="module")
def coloured(known: Known, front: Front) -> Surface:
    return painted(known.surface.replaced(colours=None), front)


def test_the_back_is_nearer_the_truth_than_both_simple_ways(known: Known, front: Front, coloured: Surface) -> None:
    ours = back_error(known, coloured)
    assert ours < 0.75 * back_error(known, mirrored(known.surface, front))
    assert ours < 0.75 * back_error(known, nearest_copy(known.surface, front))


def test_no_face_and_no_print_on_the_back(known: Known, front: Front, coloured: Surface) -> None:
    surface = known.surface
    behind = surface.normals[:, 2] < -0.5
    trunk = np.isin(surface.parts, [SMPL22.index(name) for name in ("spine1", "spine2", "spine3")])
    redness = [made.colours[behind & trunk].astype(int) @ (1, -1, 0) for made in (mirrored(surface, front), coloured)]
    assert redness[0].max() > 150  # the disc goes right through
    assert redness[1].max() < 80  # skin, at the neck
    head = surface.parts == SMPL22.index("head")
    deep = surface.vertices[:, 2] < surface.vertices[head, 2].min() + 0.1  # eyes and teeth face backward too
    high = deep & (surface.vertices[:, 1] > np.quantile(surface.vertices[head, 1], 0.4))
    hair = np.median(surface.colours[head & (surface.vertices[:, 1] > surface.vertices[:, 1].max() - 0.02)], axis=0)
    assert np.abs(coloured.colours[head & high & behind] - hair).max(1).mean() < 15


def test_what_is_seen_has_the_colours_of_the_picture(known: Known, front: Front, coloured: Surface) -> None:
    sure = front.sureness(known.surface.vertices, known.surface.normals) == 1
    picture = known.front[0].pixels
    column, row = known.view.project(known.surface.vertices[sure]).astype(int).T
    off = np.abs(picture[row, column].astype(int) - coloured.colours[sure])
    assert sure.mean() > 0.15
    assert np.median(off) < 3


def test_the_background_does_not_bleed_in(front: Front, coloured: Surface, known: Known) -> None:
    picture, mask = known.front
    glaring = np.where(mask[..., None], picture.pixels, np.array([255, 0, 255], np.uint8))
    other = painted(known.surface, Front.of(known.surface, Picture(glaring), mask, known.view))
    assert np.abs(other.colours.astype(int) - coloured.colours).max() < 5


def test_what_an_arm_hides_is_not_sure_and_has_not_its_colour() -> None:
    wall, stick = ball(1.0), ball(0.15)
    both = Surface(
        np.concatenate([wall.vertices, stick.vertices * (1, 4, 1) + (0, 0, 1.6)]),
        np.concatenate([wall.faces, stick.faces + len(wall.vertices)]),
    )
    view = View(100.0, (120.0, 120.0))
    rows, columns = np.indices((240, 240)) + 0.5
    x, y = (columns - 120) / 100, (120 - rows) / 100
    mask = np.hypot(x, y) < 1
    pixels = np.where((np.hypot(x, y / 4) < 0.14)[..., None], RED, GREEN).astype(np.uint8)
    front = Front.of(both, Picture(pixels), mask, view)
    sure = front.sureness(both.vertices, both.normals)
    hidden = (np.arange(len(sure)) < len(wall.vertices)) & (np.hypot(both.vertices[:, 0], both.vertices[:, 1]) < 0.12)
    assert sure[hidden].max() == 0
    assert sure[-len(stick.vertices) :].max() == 1
    colours = painted(both, front).colours[: len(wall.vertices)].astype(int)
    assert np.abs(colours - GREEN).max() < 10


def test_completion_is_the_least_of_its_objective() -> None:
    # eq. 3.12 from its definition, vertex by vertex; no other colours may do better
    surface = ball(1.0, 2)
    rng = np.random.default_rng(3)
    count = len(surface.vertices)
    known = surface.vertices[:, 1] > 0.3
    guess = np.where(surface.vertices[:, :1] < 0, RED, GREEN) + rng.normal(0, 15, (count, 3))
    guess[surface.vertices[:, 1] > 0] = np.nan
    begun = rng.uniform(0, 255, (count, 3))
    weight = 1.5
    found = completed(surface, begun, known, guess, weight)
    assert np.array_equal(found[known], begun[known])

    def objective(colours: np.ndarray) -> float:
        total = 0.0
        for vertex in np.flatnonzero(~known):
            near = np.argsort(np.linalg.norm(surface.vertices - surface.vertices[vertex], axis=1))
            near = [n for n in near[1:] if surface.normals[n] @ surface.normals[vertex] > 0][:10]
            total += weight * np.mean([np.linalg.norm(colours[vertex] - colours[n]) for n in near])
            if np.isfinite(guess[vertex]).all():
                total += np.linalg.norm(colours[vertex] - guess[vertex])
        return total

    least = objective(found)
    assert least < 0.9 * objective(begun)
    for _ in range(20):
        other = found + np.where(known[:, None], 0, rng.normal(0, 8, (count, 3)))
        assert least < objective(other)
        assert least < objective(0.8 * found + 0.2 * other) * 1.001


def test_nothing_unknown_and_nothing_seen_are_no_trouble(known: Known) -> None:
    surface = ball(1.0, 1)
    colours = np.full((len(surface.vertices), 3), 7.0)
    everything = np.ones(len(colours), bool)
    assert np.array_equal(completed(surface, colours, everything, colours, 1.0), colours)
    picture, mask = known.front
    blind = Front.of(known.surface, picture, np.zeros_like(mask), known.view)
    assert painted(known.surface, blind).colours is not None
