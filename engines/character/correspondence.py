"""Which point of the fitted body a point of the surface belongs to, and how far off it lies (thesis eq. 3.17)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.spatial import KDTree

from engines.character.fitting import Fit
from engines.character.mesh import Surface
from engines.character.parts import LIMBS
from engines.character.template import strongest_joints

CANDIDATES = 8
"""Vertices of the body looked at for one of the surface."""
AGREEING = 0.2
"""Least cosine between the normals of a pair."""
FARTHEST = 0.12
"""Metres between the two of a pair; what stands off more goes along with its surroundings."""


@dataclass(frozen=True, eq=False)
class Correspondence:
    """For each of the N vertices of a surface, vertices of the fitted body."""

    vertices: Int[np.ndarray, "N K"]
    """(N, K) the nearest of its limb, the nearest first."""
    distances: Float[np.ndarray, "N K"]
    """(N, K) metres; infinite where the two are no pair (they face other ways, or lie too far apart)."""
    displacements: Float[np.ndarray, "N 3"]
    """(N, 3) from the nearest to the surface, metres: d of eq. 3.17."""

    @property
    def paired(self) -> Bool[np.ndarray, " N"]:
        """(N,) whether there is a pair: the nearest come first."""
        return np.isfinite(self.distances[:, 0])


def matched(surface: Surface, fit: Fit) -> Correspondence:
    """Pairs of nearest vertices, filtered by body part and by where both face.

    The thesis has a network (DensePose) tell the picture's body parts, whose weights cannot be handed on; here
    `surface.parts` tells them, or else the fitted body, the nearest point that faces the same way.

    Args:
        surface: in the pose of the fit.
        fit: the body.
    """
    body = Surface(fit.vertices, fit.template.faces)
    used = np.unique(body.faces)
    body_parts = strongest_joints(fit.template)
    own = _parts(surface, body, body_parts, used) if surface.parts is None else surface.parts
    count = len(surface.vertices)
    found, far = np.zeros((count, CANDIDATES), np.int64), np.full((count, CANDIDATES), np.inf)
    for limb in np.unique(LIMBS):
        mine, theirs = np.flatnonzero(LIMBS[own] == limb), used[LIMBS[body_parts[used]] == limb]
        if len(mine) and len(theirs) >= CANDIDATES:
            distance, index = KDTree(body.vertices[theirs]).query(surface.vertices[mine], k=CANDIDATES)
            found[mine], far[mine] = theirs[np.asarray(index)], distance
    alike = np.einsum("nkc,nc->nk", body.normals[found], surface.normals) > AGREEING
    far = np.where(alike & (far < FARTHEST), far, np.inf)
    order = np.argsort(far, axis=1, kind="stable")
    found, far = np.take_along_axis(found, order, 1), np.take_along_axis(far, order, 1)
    return Correspondence(found, far, surface.vertices - body.vertices[found[:, 0]])


def _parts(surface: Surface, body: Surface, parts: np.ndarray, used: np.ndarray) -> Int[np.ndarray, " N"]:
    """(N,) the joint of the nearest vertex that faces the same way, of several near ones; else of the nearest."""
    found = used[np.asarray(KDTree(body.vertices[used]).query(surface.vertices, k=4 * CANDIDATES)[1])]
    alike = np.einsum("nkc,nc->nk", body.normals[found], surface.normals) > AGREEING
    return parts[found[np.arange(len(found)), alike.argmax(1)]]
