"""Fewer faces on the same vertices, quickly: for meshes that come from people and are not simplified beforehand.

Edges are collapsed onto one of their ends, in rounds of as many as do not touch each other, the least visible first
(quadric error metrics after Garland and Heckbert 1997). `baking.simplify` takes them one by one, which looks better and
takes a hundred times as long.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float, Integer
from scipy import sparse

ROUNDS = 24
"""At most; a round takes away a tenth of the faces or so."""
SHARE = 0.4
"""Of the possible collapses of a round, the least visible."""
TURN = 0.3
"""Cosine of the angle by which a collapse may turn a face."""


def coarser(
    vertices: Float[np.ndarray, "V 3"], faces: Integer[np.ndarray, "F 3"], kept: Bool[np.ndarray, " V"], target: int
) -> Integer[np.ndarray, "G 3"]:
    """Fewer faces over the same vertices.

    Args:
        vertices: (V, 3) metres.
        faces: (F, 3) vertex indices.
        kept: (V,) vertices that stay: those of seams and rims.
        target: so many faces are enough; it may end with more where seams are dense.

    Returns:
        (G, 3) vertex indices, none beyond those there were.
    """
    points = np.asarray(vertices, np.float64)
    faces = np.asarray(faces, np.int64)
    quadrics = _quadrics(points, faces)
    for _ in range(ROUNDS):
        collapsed = _collapses(points, faces, kept, quadrics)
        collapsed = collapsed[: max((len(faces) - target) // 2, 0)]  # each takes two faces away
        if not len(collapsed):
            break
        onto = np.arange(len(points))
        onto[collapsed[:, 0]] = collapsed[:, 1]
        np.add.at(quadrics, collapsed[:, 1], quadrics[collapsed[:, 0]])
        faces = onto[faces]
        faces = faces[(faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])]
    return faces


def rims(faces: Integer[np.ndarray, "F 3"], groups: Integer[np.ndarray, " V"]) -> Bool[np.ndarray, " V"]:
    """(V,) which vertices lie on a seam, where several share a place, or on the edge of a hole."""
    several = np.bincount(groups)[groups] > 1
    edges = np.sort(groups[faces][:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    found, count = np.unique(edges, axis=0, return_counts=True)
    open_ = np.zeros(groups.max() + 1, bool)
    open_[found[count != 2].ravel()] = True
    return several | open_[groups]


def _normals(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    corners = points[faces]
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


def _quadrics(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """(V, 4, 4) squared distances from the planes around each vertex, weighted by area."""
    normal = _normals(points, faces)
    area = np.linalg.norm(normal, axis=1, keepdims=True)
    normal /= np.maximum(area, 1e-18)
    plane = np.concatenate([normal, -np.einsum("fa,fa->f", normal, points[faces[:, 0]])[:, None]], axis=1)
    each = area[..., None] * plane[:, :, None] * plane[:, None, :]
    made = np.zeros((len(points), 4, 4))
    for corner in range(3):
        np.add.at(made, faces[:, corner], each)
    return made


def _collapses(points: np.ndarray, faces: np.ndarray, kept: np.ndarray, quadrics: np.ndarray) -> np.ndarray:
    """(N, 2) vertices and what they may fall onto, the least visible first; no two of the first are neighbours."""
    ends = faces[:, [[0, 1], [1, 2], [2, 0], [1, 0], [2, 1], [0, 2]]].reshape(-1, 2)
    links = sparse.csr_array((np.ones(len(ends), np.int32), ends.T), shape=(len(points),) * 2)
    links.data[:] = 1
    start, end = links.nonzero()
    start, end = start[~kept[start]], end[~kept[start]]
    if not len(start):
        return np.zeros((0, 2), np.int64)
    place = np.concatenate([points[end], np.ones((len(end), 1))], axis=1)
    cost = np.einsum("na,nab,nb->n", place, quadrics[start], place)
    cost += 1e-9 * ((points[start] - points[end]) ** 2).sum(1)
    order = np.lexsort((cost, start))
    first = order[np.unique(start[order], return_index=True)[1]]  # the best of each vertex
    best = np.full(len(points), np.inf)
    best[start[first]] = cost[first]
    around = np.full(len(points), np.inf)
    np.minimum.at(around, ends[:, 0], best[ends[:, 1]])
    chosen = first[cost[first] < around[start[first]]]
    chosen = chosen[np.argsort(cost[chosen])]
    pairs = np.stack([start[chosen], end[chosen]], axis=-1)[: max(int(SHARE * len(first)), 1)]
    shared = links[pairs[:, 0]].multiply(links[pairs[:, 1]]).sum(axis=1)
    return _unturned(points, faces, pairs[np.asarray(shared).ravel() == 2])


def _unturned(points: np.ndarray, faces: np.ndarray, pairs: np.ndarray) -> np.ndarray:
    """Those collapses (N, 2) that turn no face over."""
    onto = np.arange(len(points))
    onto[pairs[:, 0]] = pairs[:, 1]
    moved = onto[faces]
    alive = (moved[:, 0] != moved[:, 1]) & (moved[:, 1] != moved[:, 2]) & (moved[:, 2] != moved[:, 0])
    touched = alive & (moved != faces).any(axis=1)
    old, new = _normals(points, faces[touched]), _normals(points, moved[touched])
    sizes = np.linalg.norm(old, axis=1) * np.linalg.norm(new, axis=1)
    turned = np.einsum("fa,fa->f", old, new) <= TURN * sizes
    spoiled = np.zeros(len(points), bool)
    spoiled[faces[touched][turned].ravel()] = True
    return pairs[~spoiled[pairs[:, 0]]]
