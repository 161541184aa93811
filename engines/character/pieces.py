"""The pieces a mesh file is made of, brought together: one surface, one texture, metres, Y up."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Integer, UInt8
from PIL import Image

from engines.character.mesh import Surface
from engines.errors import MeshError, OutOfRangeError

ATLAS = 2048
"""Pixels a side of a texture that is made of several."""
EDGE = 2
"""Pixels by which pictures are continued beyond their edges in it, so that neighbours do not show."""
PLAIN = (178, 178, 184)
"""Of pieces that nobody has painted, sRGB."""
TALL = (0.4, 3.0)
"""Heights that are taken for metres; the usual factors lead there from other units."""
UNITS = {"centimetres": 0.01, "millimetres": 0.001}
USUAL_HEIGHT = 1.7
"""Metres of what is of no unit that anybody uses."""


@dataclass(frozen=True, eq=False)
class Piece:
    """Some triangles and what they are painted with: a picture, colours at the vertices, or one colour."""

    vertices: Float[np.ndarray, "N 3"]
    faces: Integer[np.ndarray, "F 3"]
    colour: tuple[int, int, int] | None = None
    """Of all of it, sRGB."""
    colours: UInt8[np.ndarray, "N 3"] | None = None
    """Of the vertices, sRGB."""
    uv: Float[np.ndarray, "N 2"] | None = None
    """Places in `picture`, v down from its top; beyond 0 to 1 it goes on as it began."""
    picture: UInt8[np.ndarray, "h w 3"] | None = None
    joints: Integer[np.ndarray, "N 4"] | None = None
    """What the vertices hang on; None of a piece that is no skin."""
    weights: Float[np.ndarray, "N 4"] | None = None

    def taken(self, order: np.ndarray, faces: np.ndarray) -> Piece:
        """The vertices `order`, under other faces."""
        named = ("vertices", "colours", "uv", "joints", "weights")
        chosen = {name: getattr(self, name)[order] for name in named if getattr(self, name) is not None}
        return replace(self, faces=faces, **chosen)


def joined(pieces: Iterable[Piece]) -> Surface:
    """All pieces as one surface, their pictures side by side in one texture.

    Raises:
        MeshError: nothing is there, or it makes no surface.
    """
    pieces = prepared(pieces)
    if not pieces:
        raise MeshError("the file has no faces (points or lines alone, or nothing); accepted: a triangle mesh.")
    starts = np.cumsum([0, *(len(piece.vertices) for piece in pieces)])
    faces = [piece.faces + start for piece, start in zip(pieces, starts, strict=False)]
    vertices = np.concatenate([piece.vertices for piece in pieces])
    if pieces[0].picture is not None:
        uv, texture = _atlas(pieces)
        return Surface(vertices, np.concatenate(faces), uv=uv, texture=texture)
    plain = all(piece.colours is None and piece.colour is None for piece in pieces)
    colours = None if plain else np.concatenate([_vertex_colours(piece) for piece in pieces])
    return Surface(vertices, np.concatenate(faces), colours=colours)


def prepared(pieces: Iterable[Piece]) -> list[Piece]:
    """The pieces as `joined` takes them, vertex for vertex: all with a picture where one has, uv from 0 to 1."""
    pieces = [piece for piece in pieces if len(piece.faces)]
    if not any(piece.picture is not None for piece in pieces):
        return pieces
    return [_within_unit(_pictured(piece)) for piece in pieces]


def standing(surface: Surface, known_up: bool = False, height: float | None = None) -> tuple[Surface, tuple[str, ...]]:
    """A body as it stands: metres, Y up, its lowest point on the floor and its middle over the origin.

    Units and axes are in no mesh file that can be relied on, so they are told from the size: people are between 0.4
    and 3 m tall, in metres, centimetres or millimetres, and far less deep than tall.

    Args:
        surface: as the file has it.
        known_up: its Y axis is known to point up.
        height: metres, where it is known.

    Returns:
        The surface, and what was done in words.

    Raises:
        OutOfRangeError: a height that nobody has.
        MeshError: the surface has none.
    """
    if height is not None and not TALL[0] <= height <= TALL[1]:
        raise OutOfRangeError("height", height, f"{TALL[0]} to {TALL[1]} metres")
    vertices, remarks = np.array(surface.vertices), []
    size = np.ptp(vertices, axis=0)
    if not known_up and size[2] > 1.5 * size[1]:
        vertices = np.stack([vertices[:, 0], vertices[:, 2], -vertices[:, 1]], axis=-1)
        size = size[[0, 2, 1]]
        remarks.append("It lay on its back or front, so its Z axis was taken to point up.")
    factor, words = metres(float(size[1]))
    if words and height is None:
        remarks.append(words)
    vertices *= factor if height is None else height / size[1]
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    vertices -= [(low[0] + high[0]) / 2, low[1], (low[2] + high[2]) / 2]
    return surface.replaced(vertices=vertices), tuple(remarks)


def metres(height: float) -> tuple[float, str]:
    """The factor that brings a body of that height to metres, and words for it; none where it is in metres.

    Raises:
        MeshError: it has no height.
    """
    if not np.isfinite(height) or height <= 0:
        raise MeshError("the mesh is flat: it has no height; accepted: a body that stands upright.")
    if TALL[0] <= height <= TALL[1]:
        return 1.0, ""
    for unit, factor in UNITS.items():
        if TALL[0] <= height * factor <= TALL[1]:
            return factor, f"It is {height:,.0f} tall, which was taken for {unit}."
    return USUAL_HEIGHT / height, f"It is {height:.3g} tall, in no usual unit, and was made {USUAL_HEIGHT} m."


def _vertex_colours(piece: Piece) -> np.ndarray:
    if piece.colours is not None:
        return piece.colours
    return np.tile(np.array(piece.colour or PLAIN, np.uint8), (len(piece.vertices), 1))


def _pictured(piece: Piece) -> Piece:
    """The piece with a picture: of one colour where it had none."""
    if piece.picture is not None and piece.uv is not None:
        return piece
    colour = piece.colour or (PLAIN if piece.colours is None else np.round(piece.colours.mean(axis=0)))
    picture = np.full((2, 2, 3), colour, np.uint8)
    return replace(piece, picture=picture, uv=np.full((len(piece.vertices), 2), 0.5))


def _within_unit(piece: Piece) -> Piece:
    """The piece with uv of 0 to 1: faces that lie in another repetition of the picture are moved to the first.

    A face that reaches over the border of two repetitions is clipped at it.
    """
    assert piece.uv is not None
    uv = np.nan_to_num(np.asarray(piece.uv, np.float64))
    corners = uv[piece.faces]
    beyond = np.abs(corners - 0.5).max(axis=1) > 0.5 + 1e-3  # (F, 2)
    tile = np.where(beyond, np.floor(corners.mean(axis=1)), 0).astype(np.int64)
    if tile.any():
        named = np.concatenate([piece.faces[..., None], np.repeat(tile[:, None], 3, axis=1)], axis=-1).reshape(-1, 3)
        kept, number = np.unique(named, axis=0, return_inverse=True)
        piece = piece.taken(kept[:, 0], number.reshape(-1, 3))
        uv = uv[kept[:, 0]] - kept[:, 1:]
    return replace(piece, uv=np.clip(uv, 0, 1))


def _atlas(pieces: Sequence[Piece]) -> tuple[np.ndarray, np.ndarray]:
    """uv (N, 2) and the texture of all pieces: the picture itself where they share one, else a grid of pictures."""
    pictures: dict[bytes, np.ndarray] = {}
    keys = []
    for piece in pieces:
        assert piece.picture is not None
        keys.append(repr(piece.picture.shape).encode() + piece.picture.tobytes())
        pictures[keys[-1]] = piece.picture
    places = [np.asarray(piece.uv) for piece in pieces]
    if len(pictures) == 1:
        return np.concatenate(places), next(iter(pictures.values()))
    across = int(np.ceil(np.sqrt(len(pictures))))
    cell = ATLAS // across
    inner = cell - 2 * EDGE
    texture = np.zeros((ATLAS, ATLAS, 3), np.uint8)
    corners = {}
    for number, (key, picture) in enumerate(pictures.items()):
        x, y = number % across * cell, number // across * cell
        small = np.asarray(Image.fromarray(picture).resize((inner, inner), Image.Resampling.LANCZOS))
        texture[y : y + cell, x : x + cell] = np.pad(small, ((EDGE, EDGE), (EDGE, EDGE), (0, 0)), mode="edge")
        corners[key] = np.array([x + EDGE, y + EDGE])
    uv = [(corners[key] + place * inner) / ATLAS for key, place in zip(keys, places, strict=True)]
    return np.concatenate(uv), texture
