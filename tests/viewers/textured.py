"""A body with a texture, and textures that show every flip: numbered checkers, and a gradient to compare with."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from viewers import bodies
from viewers.bodies.body import Body

CELLS = 8
SIDE = 512


def checkers(side: int = SIDE) -> np.ndarray:
    """(side, side, 3) cells in many colours, "A1" in the upper left one: letters go down, numbers to the right."""
    image = Image.new("RGB", (side, side))
    draw, cell = ImageDraw.Draw(image), side // CELLS
    font = ImageFont.load_default(size=cell // 2)
    for row in range(CELLS):
        for column in range(CELLS):
            draw.rectangle([column * cell, row * cell, (column + 1) * cell, (row + 1) * cell], colour(row, column))
            at = ((column + 0.5) * cell, (row + 0.5) * cell)
            draw.text(at, f"{chr(65 + row)}{column + 1}", (255, 255, 255), font, anchor="mm")
    return np.array(image)


def colour(row: int, column: int) -> tuple[int, int, int]:
    """Of a cell: redder to the right, greener downwards, darker and lighter by turns."""
    dark = 1.0 if (row + column) % 2 else 0.55
    return int(dark * (60 + 25 * column)), int(dark * (60 + 25 * row)), int(dark * 150)


def gradient(side: int = 64) -> np.ndarray:
    """(side, side, 3) redder to the right, greener downwards: so smooth that colours of vertices look the same."""
    rise = np.round((np.arange(side) + 0.5) / side * 255)
    return np.stack([*np.meshgrid(rise, rise), np.full((side, side), 90.0)], axis=-1).astype(np.uint8)


def textured(texture: np.ndarray) -> Body:
    """The default body in a texture, whose left half is its front and whose right half its back, both upright."""
    body = _unwrapped()
    assert body.uv is not None
    height, width = texture.shape[:2]
    x, y = np.minimum((body.uv * (width, height)).astype(int), (width - 1, height - 1)).T
    return replace(body, texture=texture.copy(), colours=texture[y, x])


@lru_cache(maxsize=1)
def _unwrapped() -> Body:
    body = bodies.get("anny")
    corners = body.vertices[body.faces]
    behind = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2] < 0
    # a vertex of both sides is two; the second of each lies behind all first ones
    kept, faces = np.unique(body.faces + len(body.vertices) * behind[:, None], return_inverse=True)
    source, back = kept % len(body.vertices), kept >= len(body.vertices)
    low, high = body.vertices.min(0), body.vertices.max(0)
    across, down = ((body.vertices[source] - low) / (high - low))[:, :2].T
    uv = np.stack([np.where(back, 1 - across / 2, across / 2), 1 - down], axis=-1)
    named = ("vertices", "normals", "skin_indices", "skin_weights", "colours")
    return replace(
        body, name="textured", faces=faces.reshape(-1, 3), coarse=(), sliders=(), reshape=None, uv=uv,
        texture=checkers(), tint=np.zeros(len(source)), **{name: getattr(body, name)[source] for name in named},
    )  # fmt: skip
