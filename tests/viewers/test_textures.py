"""Textured bodies: every way of drawing them agrees with colours at the vertices, and shows letters the right way."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from engines.errors import SkeletonError
from tests.viewers import poses
from tests.viewers.pictures import same_picture
from tests.viewers.textured import checkers, gradient, textured
from viewers.bodies.body import Body
from viewers.camera import Camera
from viewers.moderngl_renderer import Renderer
from viewers.scene import Actor, Scene

SIZE = (160, 160)


def draw(make, body: Body, camera: str, **options) -> np.ndarray:
    with make(*SIZE) as renderer:
        return renderer.frame(Scene((Actor(poses.stand(), body, **options),), Camera(camera))).astype(int)  # type: ignore[arg-type]


def pyvista_pictures(width: int, height: int):
    pytest.importorskip("pyvista")
    from viewers.pv.pictures import Pictures

    return Pictures(width, height)


@pytest.mark.parametrize("make", [Renderer, pyvista_pictures])
def test_a_texture_looks_as_the_same_colours_at_the_vertices(make) -> None:
    body = textured(gradient())
    flipped = replace(body, uv=body.uv * [1, -1] + [0, 1])
    for camera in ("front", "back"):
        wanted = draw(make, replace(body, uv=None, texture=None), camera)
        picture = draw(make, body, camera)
        figure = np.abs(wanted - draw(make, flipped, camera)).max(-1) > 12
        assert 0.02 < figure.mean() < 0.5, "upside down it looks otherwise"
        assert np.abs(picture - wanted)[figure].mean() < 4.0
        assert np.abs(picture - wanted)[~figure].mean() < 0.5


def test_numbered_checkers_look_like_their_reference(tmp_path) -> None:
    both = [draw(Renderer, textured(checkers()), camera) for camera in ("front", "back")]
    same_picture(np.concatenate(both, axis=1).astype(np.uint8), "checkers", tmp_path)


def test_an_actors_colour_covers_a_texture_where_the_body_is_tinted() -> None:
    body = textured(gradient())
    shirt = replace(body, tint=body.vertices[:, 1] > 0.1)
    red = draw(Renderer, shirt, "front", colour="#ff0000")
    assert (draw(Renderer, body, "front", colour="#ff0000") == draw(Renderer, body, "front")).all()
    changed = np.abs(red - draw(Renderer, shirt, "front")).max(-1) > 20
    rows = np.flatnonzero(changed.any(1))
    assert len(rows) and rows.max() < 100, "the upper half alone"
    ground = Renderer(*SIZE)
    with ground:
        before = len(ground.graphics.meshes)
        for colour in ("#00ff00", "#0000ff"):
            ground.frame(Scene((Actor(poses.stand(), body, colour=colour),), Camera("front")))
        assert len(ground.graphics.meshes) == before, "what takes no colour is uploaded once"


@pytest.mark.parametrize(
    "change",
    [
        {"uv": None}, {"texture": None}, {"texture": np.zeros((8, 8, 4), np.uint8)}, {"texture": np.zeros((8, 8, 3))},
        {"texture": np.zeros((4, 4096, 3), np.uint8)}, {"uv": np.zeros((7, 2), np.float32)},
    ],
)  # fmt: skip
def test_textures_that_cannot_be_are_refused(change) -> None:
    body = textured(gradient())
    with pytest.raises(SkeletonError, match="accepted"):
        replace(body, **change)
    for wrong in (-0.1, 1.1, np.nan):
        uv = np.array(body.uv)
        uv[5] = wrong
        with pytest.raises(SkeletonError, match="0 to 1"):
            replace(body, uv=uv)
