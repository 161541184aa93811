"""Colours for a whole surface from one picture of its front: what is seen is taken, the rest completed (eq. 3.12)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Num, UInt8
from PIL import Image
from scipy import ndimage

from engines.character.completion import completed
from engines.character.depth import Buffer, rasterised
from engines.character.guess import Samples, guessed
from engines.character.mesh import Surface
from engines.character.picture import Picture
from engines.character.view import View

TALLEST = 1600
"""Rows of the person that are looked at; a larger picture is brought down, since no texture holds more."""
RIM = 0.006
"""Metres inside the silhouette where the background may still show through."""
SURE_RIM = 0.02
"""Metres inside the silhouette from where a pixel is the person's alone."""
BEHIND = 0.03
"""Metres behind its neighbourhood at which a pixel may show what stands in front."""
THICK = 0.012
"""Metres by which a point may lie behind the foremost face and still be that face."""
FACING = (0.15, 0.4)
"""A normal's z from which a pixel begins to tell the colour, and from which it does so fully."""


@dataclass(frozen=True, eq=False)
class Front:
    """A surface's picture: what it tells of a point's colour, and how surely."""

    pixels: Float[np.ndarray, "H W 3"]
    """(H, W, 3) float32 sRGB of the person, carried on beyond the silhouette."""
    trust: Float[np.ndarray, "H W"]
    """(H, W) float32: 0 where the background or a nearer limb may show through, to 1."""
    shown: Buffer
    """Which faces the pixels show."""
    view: View

    @classmethod
    def of(
        cls, surface: Surface, picture: Picture, mask: Float[np.ndarray, "H W"] | Bool[np.ndarray, "H W"], view: View
    ) -> Front:
        """The part of a picture that shows a surface, in the pose the surface has.

        Args:
            surface: as it stands before the camera.
            picture: what the camera saw.
            mask: (H, W) 0 to 1, where the person is in the picture.
            view: the camera.
        """
        pixels, mask, view = _cropped(picture.pixels, np.asarray(mask) > 0.5, view)
        inside = np.asarray(ndimage.distance_transform_edt(mask)) / view.scale  # metres from the background
        shown = rasterised(surface.vertices, surface.faces, view, (mask.shape[1], mask.shape[0]))
        reach = 2 * round(0.5 * SURE_RIM * view.scale) + 1
        depths = np.where(shown.mask, shown.depths, surface.vertices[:, 2].min())
        clear = ndimage.maximum_filter(depths, reach) - depths <= BEHIND
        trust = np.clip((inside - RIM) / (SURE_RIM - RIM), 0, 1) * clear
        core = (inside > RIM) & clear & shown.mask
        return cls(carried_on(pixels, core), trust.astype(np.float32), shown, view)

    def colours(self, points: Float[np.ndarray, "N 3"]) -> Float[np.ndarray, "N 3"]:
        """(N, 3) sRGB 0 to 255 of the pixels before points, between pixels linearly."""
        return _sampled(self.pixels, self.view.project(points))

    def sureness(self, points: Float[np.ndarray, "N 3"], normals: Float[np.ndarray, "N 3"]) -> Float[np.ndarray, " N"]:
        """(N,) how surely the picture shows points of the surface: 0 (hidden, turned away, at the rim) to 1."""
        at = self.view.project(points)
        low, high = FACING
        facing = np.clip((normals[:, 2] - low) / (high - low), 0, 1)
        column, row = np.clip(at.astype(np.int64), 0, np.array(self.trust.shape[::-1]) - 1).T
        open_ = points[:, 2] > self.shown.depths[row, column] - THICK
        return _sampled(self.trust[..., None], at)[:, 0] * facing * open_


def painted(
    surface: Surface, front: Front, weight: float = 1.0, face: tuple[float, float, float] = (0.0, 0.0, 1.0)
) -> Surface:
    """Colours everywhere (thesis eq. 3.12): the picture's where it is sure, elsewhere near a guess and the neighbours.

    Where the surface turns away at the silhouette, or another limb hides it, only the neighbours count. The guess,
    which the thesis takes from PIFu, is `guess.guessed`.

    Args:
        surface: as it stands before the camera; with `parts`, hair is told from face.
        front: its picture.
        weight: lambda_nn, how much neighbours count against the guess.
        face: where the head faces; there is no hair, whatever the camera sees.

    Returns:
        The surface with colours.
    """
    sure = front.sureness(surface.vertices, surface.normals)
    known = sure > 0.5
    colours = front.colours(surface.vertices)
    away = surface.normals[:, 2] < 0
    if known.any():
        guess = guessed(surface, _samples(surface, front), colours, np.array(face))
        colours = completed(surface, colours, known, np.where(away[:, None], guess, np.nan), weight)
    return surface.replaced(colours=np.round(colours).clip(0, 255).astype(np.uint8))


def interpolated(shown: Buffer, faces: np.ndarray, values: Num[np.ndarray, "N D"]) -> Float[np.ndarray, "P D"]:
    """(P, D) values of vertices (N, D) at the pixels of `shown.mask`, row by row."""
    corners = np.asarray(values, np.float64)[faces[shown.faces[shown.mask]]]  # (P, 3, D)
    return np.einsum("pk,pkd->pd", shown.weights[shown.mask], corners)


def _samples(surface: Surface, front: Front) -> Samples:
    """What sure pixels show."""
    mask = front.shown.mask
    sure = front.trust[mask] > 0.5
    face = surface.faces[front.shown.faces[mask]]
    corner = face[np.arange(len(face)), front.shown.weights[mask].argmax(1)]  # the nearest
    places = interpolated(front.shown, surface.faces, surface.vertices)
    return Samples(places[sure], front.pixels[mask][sure], corner[sure])


def _cropped(pixels: UInt8[np.ndarray, "H W 3"], mask: np.ndarray, view: View) -> tuple[np.ndarray, np.ndarray, View]:
    """The person with some room around, at most `TALLEST` rows high; the view goes along."""
    rows, columns = np.flatnonzero(mask.any(1)), np.flatnonzero(mask.any(0))
    if not len(rows):
        return pixels.astype(np.float32), mask, view
    room = 8
    top, bottom = max(rows[0] - room, 0), min(rows[-1] + room + 1, len(mask))
    left, right = max(columns[0] - room, 0), min(columns[-1] + room + 1, mask.shape[1])
    pixels, mask = pixels[top:bottom, left:right], mask[top:bottom, left:right]
    centre = np.array(view.centre) - (left, top)
    factor = min(1.0, TALLEST / len(mask))
    if factor < 1:
        size = (round(mask.shape[1] * factor), TALLEST)
        pixels = np.asarray(Image.fromarray(pixels).resize(size, Image.Resampling.BOX))
        mask = np.asarray(Image.fromarray(mask).resize(size, Image.Resampling.NEAREST))
    return pixels.astype(np.float32), mask, View(view.scale * factor, (centre[0] * factor, centre[1] * factor))


def carried_on(pixels: np.ndarray, core: Bool[np.ndarray, "H W"]) -> np.ndarray:
    """Pixels (H, W, D) of which each outside the core takes the colour of the nearest inside."""
    if not core.any():
        return pixels
    row, column = np.asarray(ndimage.distance_transform_edt(~core, return_distances=False, return_indices=True))
    return pixels[row, column]


def _sampled(values: Float[np.ndarray, "H W D"], at: Float[np.ndarray, "N 2"]) -> Float[np.ndarray, "N D"]:
    """Values at places (N, 2) in pixels, linearly between their middles; beyond the rim the rim's."""
    height, width = values.shape[:2]
    place = np.clip(at - 0.5, 0, (width - 1, height - 1))
    low = np.minimum(place.astype(np.int64), (max(width - 2, 0), max(height - 2, 0)))
    share = place - low
    total = np.zeros((len(at), values.shape[2]))
    for across in (0, 1):
        for down in (0, 1):
            weight = np.abs(1 - across - share[:, 0]) * np.abs(1 - down - share[:, 1])
            row, column = np.minimum(low[:, 1] + down, height - 1), np.minimum(low[:, 0] + across, width - 1)
            total += weight[:, None] * values[row, column]
    return total
