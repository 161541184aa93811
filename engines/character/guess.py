"""What a person looks like from behind, guessed from the front: c^p of eq. 3.12, where the thesis asks PIFu.

Clothes are much the same behind as in front, but not what is printed on the chest, and never the face. So the colour
is told for each cross-section of a segment by what is seen there, most by what is seen near the outline: that goes on
behind. Where the mirrored front is about that colour, it is kept, folds and all. Heads have their crown's colour.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from scipy.ndimage import gaussian_filter1d

from engines.character.mesh import Surface
from engines.character.parts import LONG, SEGMENTS
from engines.skeletons.smpl22 import SMPL22

STEP = 0.012
"""Metres between cross-sections."""
LIKE = 40.0
"""Steps of 255 by which the mirrored front may differ from the cross-section's colour before it counts as print."""
HAIRLINE = (0.18, 0.3)
"""Of the head's height from its lowest to its highest point: behind, below the first there is neck, above the second
hair."""
CROWN = 0.8
"""Of the head's height: what is above shows the hair's colour."""
EARS = 0.45
"""Of the head's depth from its back to the tip of the nose: what is farther is face."""
COLLAR = 0.04
"""Metres by which a neckline is higher behind than in front."""


@dataclass(frozen=True, eq=False)
class Samples:
    """What P pixels show of a surface."""

    places: Float[np.ndarray, "P 3"]
    """(P, 3) metres."""
    colours: Float[np.ndarray, "P 3"]
    """(P, 3) sRGB, 0 to 255."""
    vertex: Int[np.ndarray, " P"]
    """(P,) the surface's nearest vertex."""


def guessed(
    surface: Surface, samples: Samples, mirrored: Float[np.ndarray, "N 3"], face: Float[np.ndarray, " 3"]
) -> Float[np.ndarray, "N 3"]:
    """(N, 3) sRGB, 0 to 255, of the surface's vertices as if they could not be seen; NaN for the face.

    Args:
        surface: as it stands before the camera; without parts, every height has its colour.
        samples: what is seen of it.
        mirrored: (N, 3) colours of the picture before the vertices.
        face: where the head faces.
    """
    segments = np.zeros(len(surface.vertices), np.int64) if surface.parts is None else SEGMENTS[surface.parts]
    head = SMPL22.index("head") if surface.parts is not None else -1
    result = np.array(mirrored)
    everywhere = _weighted_median(samples.colours, np.ones(len(samples.colours)))
    for segment in np.unique(segments):
        mine, seen = np.flatnonzero(segments == segment), np.flatnonzero(segments[samples.vertex] == segment)
        if not len(seen):
            result[mine] = everywhere
            continue
        along, across = _axes(SMPL22.joints[segment], surface.vertices[mine])
        level, level_seen = surface.vertices[mine] @ along, samples.places[seen] @ along
        if SMPL22.joints[segment] == "pelvis" and surface.parts is not None:
            level = _below_collar(level, surface.parts[mine] == SMPL22.index("neck"))
        section = _sections(level, level_seen, samples.places[seen] @ across, samples.colours[seen])
        if segment == head:
            result[mine] = _head(level, level_seen, samples.colours[seen], section)
            depth = surface.vertices[mine] @ face
            result[mine[depth > depth.min() + EARS * np.ptp(depth)]] = np.nan
        else:
            print_ = np.abs(result[mine] - section).max(axis=1, keepdims=True)
            alike = np.exp(-((print_ / LIKE) ** 2))
            result[mine] = alike * result[mine] + (1 - alike) * section
    return result


def _axes(joint: str, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(3,) along a segment, and (3,) across it in the picture; of a hand nothing is along: all of it is skin."""
    up, right = np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0])
    if joint.endswith("wrist"):
        return np.zeros(3), right
    if not joint.endswith(LONG):
        return up, right
    along = np.linalg.svd(points - points.mean(0), full_matrices=False)[2][0]
    across = np.array([-along[1], along[0], 0.0])
    return along, across / max(np.linalg.norm(across), 1e-9)


def _below_collar(level: np.ndarray, neck: np.ndarray) -> np.ndarray:
    """Levels of the trunk, those near the neck's lower end brought below the collar; the neck's own stay."""
    if not neck.any():
        return level
    return np.where(neck, level, np.minimum(level, level[neck].min() - COLLAR))


def _head(level: np.ndarray, level_seen: np.ndarray, colours: np.ndarray, section: np.ndarray) -> np.ndarray:
    """Hair like the crown's down to the hairline, then what the outline shows."""
    low, span = level.min(), max(float(np.ptp(level)), 1e-6)
    crown = (level_seen - low) / span > CROWN
    if not crown.any():
        crown = level_seen >= np.quantile(level_seen, 0.9)
    hair = _weighted_median(colours[crown], np.ones(crown.sum()))
    share = np.clip(((level - low) / span - HAIRLINE[0]) / (HAIRLINE[1] - HAIRLINE[0]), 0, 1)[:, None]
    return share * hair + (1 - share) * section


def _sections(level: np.ndarray, level_seen: np.ndarray, across: np.ndarray, colours: np.ndarray) -> np.ndarray:
    """(N, 3) the median colour of what is seen at each level, most of what is near the outline.

    Where nothing is seen, it lies between the nearest levels'.
    """
    number = np.floor((level_seen - level_seen.min()) / STEP).astype(np.int64)
    there = np.unique(number)
    medians = []
    for n in there:
        near = np.abs(number - n) <= 1
        row, place = colours[near], across[near]
        low, high = place.min(), place.max()
        outward = np.abs(2 * place - low - high) / max(high - low, 1e-6)  # 0 in the middle, 1 at the outline
        medians.append(_weighted_median(row, outward**2 + 0.02))
    middle = level_seen.min() + (there + 0.5) * STEP
    smooth = gaussian_filter1d(np.array(medians), 1.0, axis=0, mode="nearest")
    return np.stack([np.interp(level, middle, smooth[:, c]) for c in range(3)], axis=1)


def _weighted_median(values: Float[np.ndarray, "P 3"], weights: Float[np.ndarray, " P"]) -> Float[np.ndarray, " 3"]:
    order = np.argsort(values, axis=0)
    running = np.cumsum(weights[order], axis=0)
    place = (running < running[-1] / 2).sum(axis=0)
    return np.take_along_axis(values, np.take_along_axis(order, place[None], axis=0), axis=0)[0]
