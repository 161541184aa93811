"""A depth buffer in NumPy: which triangle a pixel shows, and how near it is. Orthographic, as `View` sees."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Integer

from engines.character.view import View
from engines.errors import OutOfRangeError

MOST_PIXELS = 40_000_000
"""Of a buffer: a picture of the largest size accepted."""
BATCH = 200_000
"""Candidates (a pixel in a triangle's box) looked at together: they fit the cache."""


@dataclass(frozen=True, eq=False)
class Buffer:
    """What each pixel shows of a mesh. Pixel (row, column) has its middle at x = column + 0.5, y = row + 0.5."""

    faces: Integer[np.ndarray, "H W"]
    """(H, W) the face in front, -1 where there is none."""
    depths: Float[np.ndarray, "H W"]
    """(H, W) world z of the surface there, -inf where there is none."""
    weights: Float[np.ndarray, "H W 3"]
    """(H, W, 3) barycentric weights of the face's corners."""

    @property
    def mask(self) -> np.ndarray:
        """(H, W) bool, where the mesh is."""
        return self.faces >= 0


def rasterised(
    vertices: Float[np.ndarray, "V 3"], faces: Integer[np.ndarray, "F 3"], view: View, size: tuple[int, int]
) -> Buffer:
    """A mesh as a view shows it; what is outside the picture is left out.

    Args:
        vertices: (V, 3) metres.
        faces: (F, 3) corners; both sides are seen.
        view: the camera.
        size: width and height, pixels.

    Returns:
        The buffer; the nearest face wins.

    Raises:
        OutOfRangeError: no pixel, or more than `MOST_PIXELS`.
    """
    width, height = size
    if not 0 < width * height <= MOST_PIXELS:
        raise OutOfRangeError("pixels of a depth buffer", width * height, f"1 to {MOST_PIXELS:,}")
    flat = view.project(vertices) - 0.5  # pixel middles are whole numbers
    low = np.ceil(flat[faces].min(1)).clip(0, None).astype(np.int32)
    high = np.floor(flat[faces].max(1)).clip(None, (width - 1, height - 1)).astype(np.int32)
    across, down = (high - low + 1).clip(0, None).T
    counts = across * down
    planes = _planes(flat[faces], np.asarray(vertices, np.float64)[faces, 2])
    which, depths = np.full(height * width, -1, np.int32), np.full(height * width, -np.inf)
    for chosen in _batches(counts):
        face = np.repeat(chosen, counts[chosen])
        step = np.arange(len(face)) - np.repeat(np.cumsum(counts[chosen]) - counts[chosen], counts[chosen])
        y, x = np.divmod(step, across[face])
        x, y = x + low[face, 0], y + low[face, 1]
        second, third = (plane[face, 0] * x + plane[face, 1] * y + plane[face, 2] for plane in planes[:2])
        inside = (second >= -1e-9) & (third >= -1e-9) & (second + third <= 1 + 1e-9)
        face, place = face[inside], y[inside] * width + x[inside]
        depth = (planes[2, face] * np.stack([x[inside], y[inside], np.ones(len(face))], axis=1)).sum(1)
        order = np.argsort(depth)  # of several writes to one pixel the last, nearest, stays
        order = order[depth[order] > depths[place[order]]]
        which[place[order]], depths[place[order]] = face[order], depth[order]
    weights = np.zeros((height * width, 3))
    seen = np.flatnonzero(which >= 0)
    spots = np.stack([seen % width, seen // width, np.ones(len(seen))], axis=1)
    weights[seen, 1:] = np.einsum("knc,nc->nk", planes[:2, which[seen]], spots)
    weights[seen, 0] = 1 - weights[seen, 1] - weights[seen, 2]
    return Buffer(which.reshape(height, width), depths.reshape(height, width), weights.reshape(height, width, 3))


def _batches(counts: np.ndarray):
    """Indices of faces with candidates, in runs of about `BATCH` candidates."""
    some = np.flatnonzero(counts)
    return np.split(some, np.flatnonzero(np.diff(np.cumsum(counts[some], dtype=np.int64) // BATCH)) + 1)


def _planes(flat: np.ndarray, depth: np.ndarray) -> np.ndarray:
    """What is linear over each triangle, as factors of (x, y, 1).

    Args:
        flat: (F, 3, 2) corners, pixels.
        depth: (F, 3) of the corners.

    Returns:
        (3, F, 3): the weight of the second corner, that of the third, the depth; of a triangle on edge, never inside.
    """
    first = flat[:, 0]
    u, v = flat[:, 1] - first, flat[:, 2] - first
    area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    edge = np.abs(area) < 1e-12
    safe = np.where(edge, 1.0, area)[:, None]
    second = np.stack([v[:, 1], -v[:, 0]], axis=1) / safe
    third = np.stack([-u[:, 1], u[:, 0]], axis=1) / safe
    planes = np.stack([np.column_stack([g, -(g * first).sum(1)]) for g in (second, third)])
    planes[:, edge] = (0.0, 0.0, -1.0)
    rise = (depth[:, 1:] - depth[:, :1]).T[..., None] * planes
    tilt = rise.sum(0)
    tilt[:, 2] += depth[:, 0]
    return np.concatenate([planes, tilt[None]])
