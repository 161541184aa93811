"""What a person looks like from behind, guessed from the front: c^p of eq. 3.12, where the thesis asks PIFu.

Clothes are much the same behind as in front, but not what is printed on the chest, and never the face. So a limb's
colour is told for each of its cross-sections by what is seen there, most by what is seen near the outline: that goes
on behind. Where the mirrored front is about that colour, it is kept, folds and all. Heads have their crown's colour.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from engines.character.mesh import Surface
from engines.skeletons.smpl22 import SMPL22

STEP = 0.012
"""Metres between a limb's cross-sections."""
LIKE = 24.0
"""Steps of 255 by which the mirrored front may differ from the cross-section's colour before it counts as print."""
HAIRLINE = (0.18, 0.3)
"""Of the head's height from its lowest to its highest point: behind, below the first there is neck, above the second
hair."""
CROWN = 0.9
"""Of the head's height: what is above shows the hair's colour."""

_LIMBS = {"hip", "knee", "shoulder", "elbow"}
_WHOLE = {"wrist"}


@dataclass(frozen=True, eq=False)
class Samples:
    """What P pixels show of a surface."""

    places: Float[np.ndarray, "P 3"]
    """(P, 3) metres."""
    facing: Float[np.ndarray, " P"]
    """(P,) the normal's z."""
    colours: Float[np.ndarray, "P 3"]
    """(P, 3) sRGB, 0 to 255."""
    vertex: Int[np.ndarray, " P"]
    """(P,) the surface's nearest vertex."""


def guessed(surface: Surface, samples: Samples, mirrored: Float[np.ndarray, "N 3"]) -> Float[np.ndarray, "N 3"]:
    """(N, 3) sRGB, 0 to 255, of the surface's vertices as if they could not be seen.

    Args:
        surface: as it stands before the camera; without parts, every height has its colour.
        samples: what is seen of it.
        mirrored: (N, 3) colours of the picture before the vertices.
    """
    parts = np.zeros(len(surface.vertices), np.int64) if surface.parts is None else surface.parts
    head = SMPL22.index("head") if surface.parts is not None else -1
    result = np.array(mirrored)
    everywhere = _weighted_median(samples.colours, np.ones(len(samples.colours)))
    for part in np.unique(parts):
        mine, seen = np.flatnonzero(parts == part), np.flatnonzero(parts[samples.vertex] == part)
        if not len(seen):
            result[mine] = everywhere
            continue
        level, level_seen = _levels(SMPL22.joints[part], surface.vertices[mine], samples.places[seen])
        outline = (1.05 - samples.facing[seen]) ** 2
        section = _sections(level, level_seen, samples.colours[seen], outline)
        if part == head:
            result[mine] = _head(level, level_seen, samples.colours[seen], section)
        else:
            print_ = np.abs(result[mine] - section).max(axis=1, keepdims=True)
            alike = np.exp(-((print_ / LIKE) ** 2))
            result[mine] = alike * result[mine] + (1 - alike) * section
    return result


def _levels(joint: str, own: np.ndarray, seen: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How far along the part, metres, its vertices and what is seen of it are."""
    kind = joint.rsplit("_", 1)[-1]
    axis = np.array([0.0, 1.0, 0.0])
    if kind in _LIMBS:
        axis = np.linalg.svd(own - own.mean(0), full_matrices=False)[2][0]
    if kind in _WHOLE:
        axis = np.zeros(3)
    return own @ axis, seen @ axis


def _head(level: np.ndarray, level_seen: np.ndarray, colours: np.ndarray, section: np.ndarray) -> np.ndarray:
    """Hair like the crown's down to the hairline, then what the outline shows."""
    low, span = level.min(), max(float(np.ptp(level)), 1e-6)
    crown = (level_seen - low) / span > CROWN
    if not crown.any():
        crown = level_seen >= np.quantile(level_seen, 0.9)
    hair = _weighted_median(colours[crown], np.ones(crown.sum()))
    share = np.clip(((level - low) / span - HAIRLINE[0]) / (HAIRLINE[1] - HAIRLINE[0]), 0, 1)[:, None]
    return share * hair + (1 - share) * section


def _sections(level: np.ndarray, level_seen: np.ndarray, colours: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """(N, 3) the weighted median colour of what is seen at each level; where nothing is, between the nearest."""
    number = np.floor((level_seen - level_seen.min()) / STEP).astype(np.int64)
    there = np.unique(number)
    medians = np.array([_weighted_median(colours[number == n], weights[number == n]) for n in there])
    middle = level_seen.min() + (there + 0.5) * STEP
    return np.stack([np.interp(level, middle, medians[:, c]) for c in range(3)], axis=1)


def _weighted_median(values: Float[np.ndarray, "P 3"], weights: Float[np.ndarray, " P"]) -> Float[np.ndarray, " 3"]:
    order = np.argsort(values, axis=0)
    running = np.cumsum(weights[order], axis=0)
    place = (running < running[-1] / 2).sum(axis=0)
    return np.take_along_axis(values, np.take_along_axis(order, place[None], axis=0), axis=0)[0]
