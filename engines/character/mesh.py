"""Surface: a triangle mesh with colours, and what is done to other people's meshes before they are used."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Float, Int, Integer, UInt8
from scipy import sparse
from scipy.sparse import csgraph
from scipy.spatial import KDTree

from engines.errors import MeshError, MissingDependencyError, OutOfRangeError
from engines.geometry.skins import vertex_normals

MAX_FACES = 2_000_000
"""No mesh with more faces is taken: in memory it would be several times its file."""
EASY_FACES = 60_000
"""Meshes with more faces are simplified to so many before a body is fitted to them."""
LARGEST_TEXTURE = 8192
"""Longest side of a texture, pixels."""
CRUMB = 0.002
"""Pieces with a smaller share of the area are dropped: what reconstructions leave floating in the air."""


@dataclass(frozen=True, eq=False)
class Surface:
    """A triangle mesh in house axes: metres, Y up, the person facing +Z.

    Raises:
        MeshError: no faces, too many, faces that point nowhere, places that are not numbers, arrays of other lengths.
    """

    vertices: Float[np.ndarray, "N 3"]
    """(N, 3) places, metres."""
    faces: Integer[np.ndarray, "F 3"]
    """(F, 3) vertex indices, counter-clockwise from outside."""
    colours: UInt8[np.ndarray, "N 3"] | None = None
    """(N, 3) sRGB."""
    uv: Float[np.ndarray, "N 2"] | None = None
    """(N, 2) places in `texture`, 0 to 1: u to the right, v down from its top left corner, as glTF has them."""
    texture: UInt8[np.ndarray, "h w 3"] | None = None
    """(h, w, 3) sRGB."""
    parts: Int[np.ndarray, " N"] | None = None
    """(N,) the nearest joint of the house skeleton, by index."""

    def __post_init__(self) -> None:
        _numbers("vertices", self.vertices, 3)
        _numbers("faces", self.faces, 3)
        count, faces = len(self.vertices), len(self.faces)
        if not faces:
            raise MeshError("the mesh has no faces (points alone, or nothing); accepted: a closed triangle mesh.")
        if faces > MAX_FACES or count > 3 * MAX_FACES:
            raise MeshError(
                f"the mesh has {faces:,} faces and {count:,} vertices; accepted: at most {MAX_FACES:,} faces. "
                "Simplify it first: a body needs some twenty thousand."
            )
        hold = {"vertices": np.float64, "faces": np.int64, "colours": np.uint8, "uv": np.float32, "parts": np.int64}
        for name, kind in hold.items():
            value = getattr(self, name)
            if value is not None:
                array = np.array(value, dtype=kind)
                if name != "faces" and len(array) != count:
                    raise MeshError(f"the mesh has {count:,} vertices and {len(array):,} {name}; accepted: as many.")
                array.setflags(write=False)
                object.__setattr__(self, name, array)
        self._check_values()

    def _check_values(self) -> None:
        bad = int((~np.isfinite(self.vertices).all(axis=1)).sum())
        if bad:
            raise MeshError(f"{bad:,} of {len(self.vertices):,} vertices of the mesh are no finite numbers.")
        if self.faces.min() < 0 or self.faces.max() >= len(self.vertices):
            wrong = int(((self.faces < 0) | (self.faces >= len(self.vertices))).any(axis=1).sum())
            raise MeshError(f"{wrong:,} of {len(self.faces):,} faces of the mesh point at vertices it has not.")
        if (self.texture is None) != (self.uv is None):
            raise MeshError("a texture needs uv for every vertex, and uv a texture.")
        if self.texture is not None:
            shape = self.texture.shape
            if len(shape) != 3 or shape[2] != 3 or not 1 <= min(shape[:2]) <= max(shape[:2]) <= LARGEST_TEXTURE:
                raise MeshError(
                    f"the texture has shape {shape}; accepted: (h, w, 3), at most {LARGEST_TEXTURE} a side."
                )

    def replaced(self, **changes: Any) -> Surface:
        """A copy with some fields changed."""
        return replace(self, **changes)

    @cached_property
    def normals(self) -> Float[np.ndarray, "N 3"]:
        """(N, 3) unit normals, area-weighted; vertices at one place share theirs. Zero where no face is."""
        return vertex_normals(self.vertices, self.faces, self.groups).astype(np.float64)

    @cached_property
    def groups(self) -> Int[np.ndarray, " N"]:
        """(N,) one number for all vertices at one place (to 0.01 mm), as where a texture's seam splits them."""
        return np.unique(np.round(self.vertices, 5), axis=0, return_inverse=True)[1].ravel()

    @cached_property
    def areas(self) -> Float[np.ndarray, " F"]:
        """(F,) of the faces, square metres."""
        corners = self.vertices[self.faces]
        return np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2

    @property
    def open_edges(self) -> int:
        """Edges that only one face has: the rims of holes; 0 of a closed mesh."""
        edges = np.sort(self.groups[self.faces][:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        return int((np.unique(edges, axis=0, return_counts=True)[1] == 1).sum())

    def coloured(self) -> Surface:
        """With the texture's colours at the vertices; as it is where there is no texture."""
        if self.texture is None or self.uv is None:
            return self
        height, width = self.texture.shape[:2]
        places = np.clip(self.uv * (width, height), 0, (width - 1, height - 1)).astype(np.int64)
        return self.replaced(colours=self.texture[places[:, 1], places[:, 0]])


def cleaned(surface: Surface) -> Surface:
    """Vertices at one place made one, faces without area, unused vertices and floating crumbs dropped.

    A texture cannot survive that, since its seams split vertices: its colours stay at the vertices.

    Raises:
        MeshError: nothing is left.
    """
    surface = surface.coloured()
    first = np.unique(surface.groups, return_index=True)[1]
    faces = surface.groups[surface.faces]
    proper = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    faces, areas = faces[proper], surface.areas[proper]
    if not len(faces) or not areas.sum():
        raise MeshError("no face of the mesh has an area; accepted: a closed triangle mesh.")
    ends = (faces[:, :2].T.ravel(), faces[:, 1:].T.ravel())
    links = sparse.coo_array((np.ones(2 * len(faces)), ends), shape=(len(first), len(first)))
    piece = csgraph.connected_components(links, directed=False)[1][faces[:, 0]]
    share = np.bincount(piece, weights=areas) / areas.sum()
    faces = faces[share[piece] >= min(CRUMB, share.max())]
    used, index = np.unique(faces, return_inverse=True)
    return _taken(surface.replaced(uv=None, texture=None), first[used], index.reshape(-1, 3))


def simplified(surface: Surface, faces: int = EASY_FACES) -> Surface:
    """At most about `faces` faces, by quadric error; colours and parts come from the nearest vertex there was.

    Raises:
        MissingDependencyError: the extra `character` is not installed.
        OutOfRangeError: a number of faces that is no use.
    """
    if faces < 100:
        raise OutOfRangeError("faces", faces, "100 or more")
    if len(surface.faces) <= faces:
        return surface
    try:
        import fast_simplification
    except ImportError:
        raise MissingDependencyError("fast-simplification", "character", "simplifying a mesh") from None
    shape = surface.vertices.astype(np.float64), surface.faces.astype(np.int32)
    points, kept = fast_simplification.simplify(*shape, target_count=faces)[:2]
    surface = surface.coloured()
    nearest = np.asarray(KDTree(surface.vertices).query(points)[1])
    few = surface.replaced(uv=None, texture=None)
    return _taken(few, nearest, kept).replaced(vertices=points)


def _taken(surface: Surface, order: np.ndarray, faces: np.ndarray) -> Surface:
    """The vertices `order` of a surface, under other faces."""
    chosen = {
        name: getattr(surface, name)[order]
        for name in ("vertices", "colours", "uv", "parts")
        if getattr(surface, name) is not None
    }
    return replace(surface, faces=faces, **chosen)


def _numbers(name: str, array: Any, width: int) -> None:
    kinds = "iu" if name == "faces" else "fiu"
    if not isinstance(array, np.ndarray) or array.ndim != 2 or array.shape[1] != width or array.dtype.kind not in kinds:
        told = f"{array.dtype} of shape {array.shape}" if isinstance(array, np.ndarray) else type(array).__name__
        raise MeshError(f"{name} of the mesh are {told}; accepted: numbers of shape (N, {width}).")
