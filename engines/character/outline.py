"""Outlines: where a mask ends, to fractions of a pixel, and what of a mesh lies there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Integer, Shaped
from scipy.ndimage import gaussian_filter

from engines.character.depth import rasterised
from engines.character.view import View

SMOOTHING = 2.0
"""Pixels (standard deviation) over which an outline's direction is taken."""
SIDES = ((0, 1), (1, 0), (0, -1), (-1, 0))
"""Rows and columns from a pixel to its neighbours."""


@dataclass(frozen=True, eq=False)
class Contour:
    """Points where a mask ends. Where the picture itself ends is none: what goes on there is not known."""

    points: Float[np.ndarray, "K 2"]
    """(K, 2) pixels, x to the right and y down."""
    normals: Float[np.ndarray, "K 2"]
    """(K, 2) unit, out of the mask."""
    pixels: Integer[np.ndarray, "K 2"]
    """(K, 2) row and column of the pixel within."""

    def thinned(self, count: int) -> Contour:
        """About `count` of the points, evenly."""
        step = max(1, len(self.points) // count)
        return Contour(self.points[::step], self.normals[::step], self.pixels[::step])


def contour(mask: Float[np.ndarray, "H W"]) -> Contour:
    """The line on which a mask (H, W), 0 to 1, is one half: a point for every two neighbours on either side of it."""
    inside = mask >= 0.5
    smooth = gaussian_filter(inside.astype(np.float32), SMOOTHING)
    slope = np.stack([np.gradient(smooth, axis=axis) for axis in (0, 1)], axis=-1)
    padded = np.pad(np.asarray(mask, np.float64), 1, constant_values=1.0)  # beyond the picture is not outside
    points, pixels = [], []
    for row, column in SIDES:
        beside = padded[1 + row : padded.shape[0] - 1 + row, 1 + column : padded.shape[1] - 1 + column]
        pixel = np.argwhere(inside & (beside < 0.5))
        here, there = mask[pixel[:, 0], pixel[:, 1]], beside[pixel[:, 0], pixel[:, 1]]
        share = (here - 0.5) / (here - there)
        points.append(pixel + 0.5 + share[:, None] * (row, column))
        pixels.append(pixel)
    pixel = np.concatenate(pixels)
    out = -slope[pixel[:, 0], pixel[:, 1]]
    normals = out / np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-9)
    return Contour(np.concatenate(points)[:, ::-1], normals[:, ::-1], pixel)


@dataclass(frozen=True, eq=False)
class Rim:
    """The outline of a mesh in a view, as points of its triangles."""

    contour: Contour
    """Where it lies."""
    corners: Integer[np.ndarray, "K 3"]
    """(K, 3) vertices of the triangle at each point."""
    weights: Float[np.ndarray, "K 3"]
    """(K, 3) and the point's barycentric weights."""
    mask: Float[np.ndarray, "H W"]
    """(H, W) float32, 1 where the mesh is."""


def rim(
    vertices: Float[np.ndarray, "V 3"], faces: Integer[np.ndarray, "F 3"], view: View, size: tuple[int, int]
) -> Rim:
    """The outline of a mesh (metres) in a view of `size` (width and height, pixels)."""
    buffer = rasterised(vertices, faces, view, size)
    mask = buffer.mask.astype(np.float32)
    edge = contour(mask)
    row, column = edge.pixels.T
    return Rim(edge, faces[buffer.faces[row, column]], buffer.weights[row, column], mask)


def reduced(mask: Float[np.ndarray, "H W"], view: View, height: int) -> tuple[Float[np.ndarray, "h w"], View]:
    """A mask made smaller, until what it shows is at most `height` pixels tall, and the view of that picture.

    Args:
        mask: (H, W), 0 to 1, with something in it.
        view: of the picture it comes from.
        height: pixels.
    """
    rows = np.flatnonzero((mask >= 0.5).any(axis=1))
    block = max(1, int(np.ceil((rows[-1] - rows[0] + 1) / height)))
    tall, wide = (-(-side // block) * block for side in mask.shape)
    padded = np.pad(mask, ((0, tall - mask.shape[0]), (0, wide - mask.shape[1])), mode="edge")
    small = padded.reshape(tall // block, block, wide // block, block).mean((1, 3))
    return small, View(view.scale / block, (view.centre[0] / block, view.centre[1] / block))


def overlap(one: Shaped[np.ndarray, "H W"], other: Shaped[np.ndarray, "H W"]) -> float:
    """Intersection over union of two masks, of truth or of shares from 0 to 1."""
    first, second = one >= 0.5, other >= 0.5
    return float((first & second).sum() / max((first | second).sum(), 1))
