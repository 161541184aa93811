"""What speaks for a fit: a person in a picture, or a mesh. Each gives the terms of thesis eq. 3.13 that it knows.

Every term is a mean of penalties of errors over their usual size (below), so it is about 1 where the fit is as good as
can be asked for, whatever the picture's size.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
import torch
from jaxtyping import Float, Integer
from scipy.spatial import KDTree
from torch import Tensor

from engines.character import landmarks
from engines.character.marks import trust
from engines.character.mesh import Surface
from engines.character.outline import contour, reduced, rim
from engines.character.sighting import Sighting
from engines.character.view import View

LANDMARK_ERROR = 0.025
"""Metres a landmark usually lies off, sideways and up."""
DEPTH_ERROR = 0.2
"""Metres it does in depth."""
TILT, TILT_ERROR = 0.15, 0.1
"""Radians that all places together lean forward (as BlazePose has people lean who stand straight), and by how much
more or less they usually do, since cameras look down or up."""
SURFACE_ERROR = 0.006
"""Metres the outline of a mask, or the surface of a mesh, does."""
CLOTHES = 0.025
"""Metres that clothes usually stand off; so much further than the body may an outline lie at no more cost."""
ROBUST = 5.0
"""Errors beyond so many usual ones hardly count more than these (Geman and McClure)."""
OUTLINE_HEIGHT = 320
"""Pixels a person's outline is looked at with."""
OUTLINE_POINTS = 500
"""Points compared, each way."""
MESH_POINTS = 1500
"""Vertices of a mesh compared."""
ALONG = 0.1
"""What a distance along a mesh's surface counts beside one across it: no vertex lies just beside its nearest."""
TURNED = 0.15
"""Metres that two outlines of opposite directions count as apart."""
REACH = 0.2
"""Metres; what is farther apart is not matched."""


class Evidence(Protocol):
    """What a search listens to."""

    leaves: list[Tensor]
    """What of the evidence itself is searched too."""
    metric: bool
    """Its metres are the body's; else how many it has in one of those is searched too."""

    def match(self, vertices: Float[np.ndarray, "N 3"]) -> Integer[np.ndarray, " M"]:
        """Find out anew which points of the body belong to which of the evidence; the body is as seen now.

        Returns:
            (M,) the vertices that `surface` then wants.
        """
        ...

    def surface(self, vertices: Float[Tensor, "M 3"]) -> Float[Tensor, ""]:
        """L_surface of the matched points, for the vertices wanted, in the evidence's metres."""
        ...

    def joints(self, marks: Float[Tensor, "33 3"], wide: float) -> Float[Tensor, ""]:
        """L_joints of landmarks in the evidence's metres; errors up to `wide` times the usual ones pull."""
        ...


def geman_mcclure(squared: Tensor, robust: float | Tensor) -> Tensor:
    """The penalty of squared errors, in usual ones: the square at first, never more than `robust` squared."""
    return squared / (1 + squared / robust**2)


class Seen:
    """Evidence of a picture. Its metres: sideways and up from the mask's middle, at the landmarks' scale.

    Args:
        sighting: the person.
        faces: (F, 3) of the vertices that `match` gets.
        bones: metres, the summed length of `landmarks.BONES` on the template: `places` are brought to it.
    """

    def __init__(self, sighting: Sighting, faces: Integer[np.ndarray, "F 3"], bones: float) -> None:
        self.faces = faces
        rows, columns = np.nonzero(sighting.mask >= 0.5)
        centre = float(np.ptp(columns) / 2 + columns.min()), float(np.ptp(rows) / 2 + rows.min())
        size = bones / bone_length(sighting.places)
        self.view = View(sighting.scale / size, centre)
        """Of the evidence's metres."""
        self.mask, self._small = reduced(sighting.mask.astype(np.float64), self.view, OUTLINE_HEIGHT)
        edge = contour(self.mask).thinned(OUTLINE_POINTS)
        self._edge = self._small.unproject(edge.points)[:, :2], edge.normals * (1, -1)
        self._points = torch.from_numpy(self.view.unproject(sighting.points)[:, :2])
        self._depths = torch.from_numpy(sighting.places[:, 2] * size)
        self._weights = torch.from_numpy(trust() * sighting.seen)
        self._tilt = torch.tensor(TILT, dtype=torch.float64, requires_grad=True)
        self.leaves, self.metric = [self._tilt], False
        self._pairs: tuple[Tensor, ...] | None = None

    def match(self, vertices: Float[np.ndarray, "N 3"]) -> Integer[np.ndarray, " M"]:
        """The outline of the body against the mask's, both ways, each to the nearest point that faces alike."""
        tall, wide = self.mask.shape
        body = rim(vertices, self.faces, self._small, (wide, tall))
        step = max(1, len(body.corners) // OUTLINE_POINTS)
        corners, weights = body.corners[::step], body.weights[::step]
        places = self._small.unproject(body.contour.points[::step])[:, :2]
        normals = body.contour.normals[::step] * (1, -1)
        mine, its = _nearest_both_ways(_facing(places, normals), _facing(*self._edge), REACH)
        wanted, corners = np.unique(corners[mine], return_inverse=True)
        arrays = corners.reshape(-1, 3), weights[mine], self._edge[0][its], self._edge[1][its]
        self._pairs = tuple(torch.from_numpy(np.ascontiguousarray(array)) for array in arrays)
        return wanted

    def surface(self, vertices: Float[Tensor, "N 3"]) -> Float[Tensor, ""]:
        """Distances across the mask's outline; within it, where clothes may be, they count less."""
        if self._pairs is None:
            return vertices.new_zeros(())
        corners, weights, places, normals = self._pairs
        points = (weights[..., None] * vertices[corners][..., :2]).sum(1)
        outward = ((points - places) * normals).sum(1)
        errors = torch.where(outward > 0, outward / SURFACE_ERROR, outward / CLOTHES)
        return geman_mcclure(errors.square(), torch.where(outward > 0, ROBUST, ROBUST / 2)).mean()

    def joints(self, marks: Float[Tensor, "33 3"], wide: float) -> Float[Tensor, ""]:
        """Landmarks against the picture, and their depths before or behind the hips' middle."""
        flat = ((marks[:, :2] - self._points) / LANDMARK_ERROR).square().sum(1)
        hips = [landmarks.index("left_hip"), landmarks.index("right_hip")]
        about = marks - marks[hips].mean(0)
        leaning = self._tilt.sin() * about[:, 1] + self._tilt.cos() * about[:, 2]
        deep = ((leaning - self._depths) / DEPTH_ERROR).square()
        penalties = geman_mcclure(flat, wide) + geman_mcclure(deep, wide)
        return (self._weights * penalties).sum() / self._weights.sum() + ((self._tilt - TILT) / TILT_ERROR).square()


class Scanned:
    """Evidence of a mesh that stands on the floor, in metres, facing +Z.

    Args:
        surface: the mesh.
        marks: (33, 3) landmarks on it, metres; not known if left out.
    """

    def __init__(self, surface: Surface, marks: Float[np.ndarray, "33 3"] | None) -> None:
        order = np.arange(len(surface.vertices))[:: max(1, len(surface.vertices) // MESH_POINTS)]
        self._places, self._normals = surface.vertices[order], surface.normals[order]
        self.leaves, self.metric = [], True
        self._marks = None if marks is None else torch.from_numpy(np.asarray(marks, np.float64))
        self._weights = torch.from_numpy(trust())
        self._pairs: tuple[Tensor, ...] | None = None

    def match(self, vertices: Float[np.ndarray, "N 3"]) -> Integer[np.ndarray, " M"]:
        """Each point of the mesh and its nearest vertex (eq. 3.15), and each vertex and its nearest point."""
        mine, its = _nearest_both_ways(vertices, self._places, np.inf)
        wanted, mine = np.unique(mine, return_inverse=True)
        arrays = mine.astype(np.int64), self._places[its], self._normals[its]
        self._pairs = tuple(torch.from_numpy(array) for array in arrays)
        return wanted

    def surface(self, vertices: Float[Tensor, "N 3"]) -> Float[Tensor, ""]:
        """Distances of the pairs."""
        if self._pairs is None:
            return vertices.new_zeros(())
        mine, places, normals = self._pairs
        away = (vertices[mine] - places) / SURFACE_ERROR
        squared = (away * normals).sum(1).square() + (ALONG * away).square().sum(1)
        return geman_mcclure(squared, 2 * ROBUST).mean()

    def joints(self, marks: Float[Tensor, "33 3"], wide: float) -> Float[Tensor, ""]:
        """Landmarks, where they are known."""
        if self._marks is None:
            return marks.new_zeros(())
        errors = ((marks - self._marks) / LANDMARK_ERROR).square().sum(1)
        return (self._weights * geman_mcclure(errors, wide)).sum() / self._weights.sum()


def bone_length(places: Float[np.ndarray, "33 3"]) -> float:
    """Metres, the summed length of `landmarks.BONES` between landmarks (33, 3)."""
    ends = np.array([[landmarks.index(name) for name in bone] for bone in landmarks.BONES])
    return float(np.linalg.norm(places[ends[:, 0]] - places[ends[:, 1]], axis=1).sum())


def _nearest_both_ways(ours: np.ndarray, theirs: np.ndarray, reach: float) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of rows: each of `ours` (K, D) and the nearest of `theirs` (L, D), then the other way round."""
    far, there = (np.asarray(found) for found in KDTree(theirs).query(ours, distance_upper_bound=reach))
    back, here = (np.asarray(found) for found in KDTree(ours).query(theirs, distance_upper_bound=reach))
    near, met = np.flatnonzero(np.isfinite(far)), np.flatnonzero(np.isfinite(back))
    return np.concatenate([near, here[met]]), np.concatenate([there[near], met])


def _facing(places: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """(K, 4) points with their directions, so that distances tell opposite sides of a limb apart."""
    return np.concatenate([places, normals * (TURNED / 2)], axis=1)
