"""Work on triangle surfaces: smoothing, cutting along lines, giving cloth its thickness."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse

from engines.geometry.skins import vertex_normals
from viewers.bodies.baking.weights import SkinMesh, neighbours

_SNAP = 0.22
"""A cut this near an edge's end (as a share of the edge) moves the end onto the cut instead of making a sliver."""


def averaging(faces: np.ndarray, count: int) -> sparse.csr_matrix:
    """(V, V) matrix that replaces each value by the mean over its neighbours."""
    near = neighbours(faces, count)
    degree = np.asarray(near.sum(1)).ravel()
    return sparse.diags(1.0 / np.maximum(degree, 1)) @ near


def smooth(values: np.ndarray, faces: np.ndarray, amount: np.ndarray, passes: int) -> np.ndarray:
    """Values (V, D) drawn towards their neighbours' mean by `amount` (V,) 0..1, several times."""
    mean = averaging(faces, len(values))
    for _ in range(passes):
        values = values + amount[:, None] * (mean @ values - values)
    return values


def fair(values: np.ndarray, faces: np.ndarray, amount: np.ndarray, passes: int) -> np.ndarray:
    """Like `smooth`, but every pass is followed by one that swells again (Taubin 1995), so that nothing shrinks."""
    mean = averaging(faces, len(values))
    for _ in range(passes):
        for step in (0.6, -0.62):
            values = values + step * amount[:, None] * (mean @ values - values)
    return values


@dataclass(frozen=True)
class Cut:
    """A mesh divided along the zero line of a field."""

    mesh: SkinMesh
    regions: np.ndarray
    """(F,) region of each face."""


def cut(mesh: SkinMesh, regions: np.ndarray, field: np.ndarray, region: int, over: tuple[int, ...]) -> Cut:
    """Divide faces of the regions `over` where `field` (V,) is zero; the positive side becomes `region`."""
    wanted = np.isin(regions, over)
    mesh, field = _snapped(mesh, field, mesh.faces[wanted])
    faces = mesh.faces
    sign = np.sign(field).astype(int)
    mixed = wanted & (sign[faces].max(1) > 0) & (sign[faces].min(1) < 0)
    inside = wanted & ~mixed & (sign[faces].sum(1) > 0)
    regions = np.where(inside, region, regions)
    edges, place = _crossed(faces[mixed], sign)
    share = (field[edges[:, 0]] / (field[edges[:, 0]] - field[edges[:, 1]]))[:, None]
    between = {tuple(edge): len(mesh.vertices) + number for edge, number in zip(edges.tolist(), place, strict=True)}

    def along(values: np.ndarray) -> np.ndarray:
        return np.concatenate([values, (1 - share) * values[edges[:, 0]] + share * values[edges[:, 1]]])

    pieces, kinds = [faces[~mixed]], [regions[~mixed]]
    for face, old in zip(faces[mixed].tolist(), regions[mixed].tolist(), strict=True):
        for piece, positive in _divide(face, sign, between):
            pieces.append(np.array([piece]))
            kinds.append(np.array([region if positive else old]))
    divided = SkinMesh(along(mesh.vertices), np.concatenate(pieces), along(mesh.weights))
    return Cut(divided, np.concatenate(kinds))


def _snapped(mesh: SkinMesh, field: np.ndarray, faces: np.ndarray) -> tuple[SkinMesh, np.ndarray]:
    """Move vertices that lie nearly on the zero line onto it, along the edge that crosses it nearest to them."""
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    edges = np.concatenate([edges, edges[:, ::-1]])
    edges = edges[field[edges[:, 0]] * field[edges[:, 1]] < 0]
    share = field[edges[:, 0]] / (field[edges[:, 0]] - field[edges[:, 1]])
    order = np.argsort(-share, kind="stable")  # the smallest share is written last and stays
    order = order[share[order] < _SNAP]
    vertices, weights, field = np.array(mesh.vertices), np.array(mesh.weights), np.array(field)
    start, end, part = edges[order, 0], edges[order, 1], share[order, None]
    vertices[start] = mesh.vertices[start] + part * (mesh.vertices[end] - mesh.vertices[start])
    weights[start] = mesh.weights[start] + part * (mesh.weights[end] - mesh.weights[start])
    field[start] = 0.0
    return replace(mesh, vertices=vertices, weights=weights), field


def _crossed(faces: np.ndarray, sign: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Edges (low, high index) whose ends lie on different sides, and a number for each."""
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]).reshape(-1, 2)
    edges = np.unique(np.sort(edges, axis=1), axis=0)
    edges = edges[sign[edges[:, 0]] * sign[edges[:, 1]] < 0]
    return edges, np.arange(len(edges))


def _divide(face: list[int], sign: np.ndarray, between: dict[tuple[int, int], int]) -> list[tuple[list[int], bool]]:
    """The pieces of a face that the line crosses, each with its side."""
    rings: dict[bool, list[int]] = {True: [], False: []}
    for here, there in zip(face, face[1:] + face[:1], strict=True):
        for side in (True, False):
            if sign[here] == 0 or (sign[here] > 0) == side:
                rings[side].append(here)
        if sign[here] * sign[there] < 0:
            middle = between[min(here, there), max(here, there)]
            rings[True].append(middle)
            rings[False].append(middle)
    return [([ring[0], ring[i], ring[i + 1]], side) for side, ring in rings.items() for i in range(1, len(ring) - 1)]


@dataclass(frozen=True)
class Garments:
    """A mesh whose regions have become shells of their own, with rims between them."""

    vertices: np.ndarray
    """(V, 3) metres."""
    normals: np.ndarray
    """(V, 3) unit."""
    faces: np.ndarray
    """(F, 3) indices."""
    weights: np.ndarray
    """(V, J)."""
    region: np.ndarray
    """(V,) region of each vertex."""
    coarse: tuple[np.ndarray, ...] = ()
    """Fewer faces (F', 3) over the same vertices, the finer first."""


Level = tuple[np.ndarray, np.ndarray]
"""Faces (F, 3) of the bare mesh and the region (F,) of each."""


@dataclass(frozen=True)
class Lining:
    """One region that goes on for a little way under another."""

    under: int
    """The region that goes on ..."""
    over: int
    """... under this one ..."""
    within: np.ndarray
    """(V,) ... where this holds."""


def thicken(mesh: SkinMesh, level: Level, thickness: np.ndarray, coarse: Sequence[Level], lining: Lining) -> Garments:
    """Give each region vertices of its own, lifted off the skin by its thickness, and close the steps between them.

    Args:
        mesh: closed mesh.
        level: its faces and their regions.
        thickness: (R, V) metres each region is lifted at each vertex.
        coarse: coarser faces over the same vertices, and their regions.
        lining: what goes on under the edge of something else, so that no gap shows there when it moves.
    """
    levels = [level, *coarse]
    lined = [_lined(level, lining) for level in levels]
    bare = vertex_normals(mesh.vertices, mesh.faces).astype(np.float64)
    pairs = np.concatenate([np.stack([np.repeat(kind, 3), faces.ravel()], axis=-1) for faces, kind in lined])
    pairs = np.unique(pairs, axis=0)
    region, source = pairs[:, 0], pairs[:, 1]
    known = {pair: n for n, pair in enumerate(map(tuple, pairs.tolist()))}
    shelled = [_renumbered(level, known) for level in lined]
    vertices = mesh.vertices[source] + bare[source] * thickness[region, source][:, None]
    normals = vertex_normals(vertices, shelled[0])
    own = (thickness[region, source] > 0) & (np.abs(normals).sum(1) > 0)
    normals = np.where(own[:, None], normals, bare[source])
    shell = Garments(vertices, normals, shelled[0], mesh.weights[source], region)
    rims = [_rims(*level, new[: len(level[0])], vertices) for level, new in zip(levels, shelled, strict=True)]
    return _with_rims(shell, shelled, rims)


def _lined(level: Level, lining: Lining) -> Level:
    faces, regions = level
    more = (regions == lining.over) & lining.within[faces].any(1)
    return np.concatenate([faces, faces[more]]), np.concatenate([regions, np.full(more.sum(), lining.under)])


def _renumbered(level: Level, known: dict[tuple[int, int], int]) -> np.ndarray:
    """Faces of the bare mesh as faces of the shells."""
    return np.array(
        [
            [known[region, vertex] for vertex in face]
            for face, region in zip(level[0].tolist(), level[1].tolist(), strict=True)
        ]
    )


def _with_rims(shell: Garments, shelled: list[np.ndarray], rims: list[Level]) -> Garments:
    """Add to each level its rims: quads (Q, 4) of repeated vertices with the colour of their outer region (Q,)."""
    corners = [np.stack([quads.ravel(), np.repeat(owners, 4)], axis=-1) for quads, owners in rims]
    added, number = np.unique(np.concatenate(corners), axis=0, return_inverse=True)
    count = len(shell.vertices)
    number = np.split(number.ravel() + count, np.cumsum([len(c) for c in corners])[:-1])
    closed = []
    for faces, quad in zip(shelled, (n.reshape(-1, 4) for n in number), strict=True):
        closed.append(np.concatenate([faces, quad[:, [0, 1, 2]], quad[:, [0, 2, 3]]]))
    source = added[:, 0]
    places = np.concatenate([shell.vertices, shell.vertices[source]])
    normals = vertex_normals(places, closed[0][len(shelled[0]) :])[count:]
    return Garments(
        places,
        np.concatenate([shell.normals, normals]),
        closed[0],
        np.concatenate([shell.weights, shell.weights[source]]),
        np.concatenate([shell.region, added[:, 1]]),
        tuple(closed[1:]),
    )


def _rims(old: np.ndarray, regions: np.ndarray, new: np.ndarray, vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Quads (Q, 4) between the two lips of each edge where regions meet, and the region on the outer lip (Q,)."""
    sides: dict[tuple[int, int], tuple[int, int, int]] = {}
    for before, after, region in zip(old.tolist(), new.tolist(), regions.tolist(), strict=True):
        for corner in range(3):
            onward = (corner + 1) % 3
            sides[before[corner], before[onward]] = (region, after[corner], after[onward])
    quads, owners = [], []
    for (a, b), (region, low, high) in sides.items():
        other = sides.get((b, a))
        if other and other[0] < region and np.abs(vertices[low] - vertices[other[2]]).max() > 1e-5:
            quads.append((high, low, other[2], other[1]))
            owners.append(region)
    return np.array(quads, int).reshape(-1, 4), np.array(owners, int)
