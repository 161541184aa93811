"""A texture for a surface: cut into charts that are nearly flat, laid side by side, and filled from the picture.

Every limb is cut into what faces each of six ways in its own frame, so nothing is stretched by more than a half or so,
a face is one chart. A general unwrapper (xatlas) takes some twenty times as long for a body.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int, UInt8
from scipy import sparse
from scipy.sparse import csgraph

from engines.character.depth import rasterised
from engines.character.mesh import Surface
from engines.character.parts import LONG, SEGMENTS
from engines.character.texture import Front, carried_on, interpolated
from engines.character.view import View
from engines.skeletons.smpl22 import SMPL22

SIZE = 1024
"""Texels along a side of the texture."""
GAP = 2.0
"""Texels left free around every chart: colours are carried on into them."""
FINER = {"head": 1.5}
"""Parts of which a metre gets so many times the texels."""
FRONT_FIRST = 0.25
"""Added to the cosine of what faces the camera, so that it is cut less."""
FLAT = 0.2
"""Least cosine between a face and its chart."""
SMALLEST = 12
"""Charts of fewer faces go to their neighbours where they may."""

_ROUNDS = 4


def baked(surface: Surface, front: Front | None = None, size: int = SIZE) -> Surface:
    """The surface with a texture, its vertices split where charts meet.

    Args:
        surface: as it stood before the camera, with colours (grey without).
        front: its picture, of which the texture then has the full detail; else vertex colours are all there is.
        size: texels along a side.
    """
    if surface.colours is None:
        surface = surface.replaced(colours=np.full((len(surface.vertices), 3), 170, np.uint8))
    flat = unwrapped(surface, size)
    assert flat.uv is not None and flat.colours is not None
    return flat.replaced(texture=_filled(flat, front, size))


def unwrapped(surface: Surface, size: int = SIZE) -> Surface:
    """The surface with uv (and a texture of one texel), its vertices split where charts meet.

    Args:
        surface: with parts it is cut limb by limb; without, as a whole.
        size: texels along a side of the texture to come, which tells how wide the gaps are.
    """
    limb = _limbs(surface)
    numbers, place = np.unique(limb, return_inverse=True)
    turned = np.stack([_frame(surface, limb, number) for number in numbers.tolist()])
    chart, way = _charts(surface, limb, turned[place])
    corner = surface.faces + chart[:, None] * len(surface.vertices)  # one vertex for each chart it lies in
    names, faces = np.unique(corner, return_inverse=True)
    faces = faces.reshape(-1, 3)
    order = names % len(surface.vertices)
    owner = np.empty(len(names), np.int64)
    owner[faces.ravel()] = np.repeat(np.arange(len(faces)), 3)
    axes = _across(turned[place], way)[owner]  # (N', 2, 3)
    places = np.einsum("nab,nb->na", axes, surface.vertices[order])
    places *= _density(surface, order)[:, None]
    uv = _packed(places, chart[owner], size)
    kept = {name: getattr(surface, name) for name in ("colours", "parts")}
    chosen = {name: value[order] for name, value in kept.items() if value is not None}
    blank = np.zeros((1, 1, 3), np.uint8)
    return surface.replaced(vertices=surface.vertices[order], faces=faces, uv=uv, texture=blank, **chosen)


def _limbs(surface: Surface) -> Int[np.ndarray, " F"]:
    """(F,) which segment a face belongs to."""
    if surface.parts is None:
        return np.zeros(len(surface.faces), np.int64)
    corners = np.sort(SEGMENTS[surface.parts[surface.faces]], axis=1)
    return corners[:, 1]  # of three, the middle one: that of the majority if there is one


def _frame(surface: Surface, limb: np.ndarray, number: int) -> Float[np.ndarray, "3 3"]:
    """Rows: across, along and out of the front of a limb."""
    if surface.parts is None or not SMPL22.joints[number].endswith(LONG):
        return np.eye(3)
    points = surface.vertices[np.unique(surface.faces[limb == number])]
    along = np.linalg.svd(points - points.mean(0), full_matrices=False)[2][0]
    toward = np.array([0.0, 0, 1]) if abs(along[2]) < 0.8 else np.array([0.0, 1, 0])
    out = toward - (toward @ along) * along
    out /= np.linalg.norm(out)
    return np.stack([np.cross(along, out), along, out])


def _charts(surface: Surface, limb: np.ndarray, frames: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Number of each face's chart (F,), and which way it faces (F,): across, along, out, or the opposite of one."""
    corners = surface.vertices[surface.faces]
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    flat /= np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), 1e-12)
    turned = np.einsum("fab,fb->fa", frames, flat)
    cosine = np.concatenate([turned, -turned], axis=1)  # (F, 6)
    liking = cosine + FRONT_FIRST * (np.arange(6) == 2)
    beside = _neighbours(surface)
    beside = beside[limb[beside[:, 0]] == limb[beside[:, 1]]]
    way = liking.argmax(1)
    for _ in range(_ROUNDS):
        votes = liking + 0.5 * _votes(way, beside)
        way = np.where(cosine > FLAT, votes, liking - 10).argmax(1)
    for _ in range(_ROUNDS):
        chart = _pieces(way, beside)
        small = np.bincount(chart)[chart] < SMALLEST
        votes = _votes(way, beside[chart[beside[:, 0]] != chart[beside[:, 1]]])
        moved = np.where(cosine > FLAT, votes, 0).argmax(1)
        way = np.where(small & ((votes > 0) & (cosine > FLAT)).any(1), moved, way)
    return _pieces(way, beside), way


def _neighbours(surface: Surface) -> Int[np.ndarray, "E 2"]:
    """(E, 2) faces that share an edge, each pair both ways."""
    edges = np.sort(surface.groups[surface.faces][:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    name = edges[:, 0] * (edges.max() + 1) + edges[:, 1]
    order = np.argsort(name, kind="stable")
    same = np.flatnonzero(np.diff(name[order]) == 0)
    pairs = np.stack([order[same], order[same + 1]], axis=1) // 3
    return np.concatenate([pairs, pairs[:, ::-1]])


def _votes(way: np.ndarray, beside: np.ndarray) -> Float[np.ndarray, "F 6"]:
    """How many of a face's neighbours face each way."""
    count = np.bincount(beside[:, 0] * 6 + way[beside[:, 1]], minlength=6 * len(way))
    return count.reshape(-1, 6).astype(np.float64)


def _pieces(way: np.ndarray, beside: np.ndarray) -> Int[np.ndarray, " F"]:
    """(F,) connected faces of one limb that face one way."""
    same = beside[way[beside[:, 0]] == way[beside[:, 1]]]
    links = sparse.coo_array((np.ones(len(same)), same.T), shape=(len(way), len(way)))
    return csgraph.connected_components(links, directed=False)[1].astype(np.int64)


def _across(frames: np.ndarray, way: np.ndarray) -> Float[np.ndarray, "F 2 3"]:
    """(F, 2, 3) the two axes of a face's chart, such that it is seen from outside."""
    first = np.array([1, 2, 0, 2, 0, 1])[way]
    second = np.array([2, 0, 1, 1, 2, 0])[way]
    rows = np.arange(len(way))
    return np.stack([frames[rows, first], frames[rows, second]], axis=1)


def _density(surface: Surface, order: np.ndarray) -> Float[np.ndarray, " N"]:
    """(N,) how many times the usual texels there are to a metre."""
    if surface.parts is None:
        return np.ones(len(order))
    factor = np.array([FINER.get(name, 1.0) for name in SMPL22.joints])
    return factor[surface.parts[order]]


def _packed(places: Float[np.ndarray, "N 2"], chart: np.ndarray, size: int) -> Float[np.ndarray, "N 2"]:
    """uv (N, 2): charts upright, on shelves of falling height, as large as a square holds."""
    count = chart.max() + 1
    low = np.full((count, 2), np.inf)
    high = -low
    np.minimum.at(low, chart, places)
    np.maximum.at(high, chart, places)
    spans = high - low
    lying = spans[:, 0] > spans[:, 1]
    spans[lying] = spans[lying, ::-1]
    local, turn = places - low[chart], lying[chart]
    local[turn] = np.stack([local[turn, 1], spans[chart[turn], 1] - local[turn, 0]], axis=1)
    small, large = 0.0, size / float(spans.max())
    for _ in range(24):
        middle = (small + large) / 2
        fits = _shelves(spans * middle + 2 * GAP, size) is not None
        small, large = (middle, large) if fits else (small, middle)
    corners = _shelves(spans * small + 2 * GAP, size)
    assert corners is not None
    return (corners[chart] + GAP + local * small) / size


def _shelves(spans: Float[np.ndarray, "C 2"], size: float) -> Float[np.ndarray, "C 2"] | None:
    """(C, 2) corners of boxes set on shelves from the highest to the lowest; None where they do not fit."""
    corners = np.zeros_like(spans)
    left, top, shelf = 0.0, 0.0, 0.0
    for box in np.argsort(-spans[:, 1], kind="stable"):
        width, height = spans[box]
        if left + width > size:
            left, top, shelf = 0.0, top + shelf, 0.0
        if width > size or top + height > size:
            return None
        corners[box] = left, top
        left, shelf = left + width, max(shelf, height)
    return corners


def _filled(flat: Surface, front: Front | None, size: int) -> UInt8[np.ndarray, "h w 3"]:
    """(size, size, 3) the picture where it is sure, the vertices' colours elsewhere, carried on beyond the charts."""
    assert flat.uv is not None and flat.colours is not None
    laid = np.c_[flat.uv * (1, -1), np.zeros(len(flat.uv))]
    shown = rasterised(laid, flat.faces, View(size, (0.0, 0.0)), (size, size))
    colours = interpolated(shown, flat.faces, flat.colours)
    if front is not None:
        points = interpolated(shown, flat.faces, flat.vertices)
        normals = interpolated(shown, flat.faces, flat.normals)
        sure = front.sureness(points, normals)[:, None]
        colours = sure * front.colours(points) + (1 - sure) * colours
    texture = np.zeros((size, size, 3), np.uint8)
    texture[shown.mask] = np.round(colours).clip(0, 255)
    return carried_on(texture, shown.mask)
