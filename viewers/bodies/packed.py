"""The baked body as a small file, and back: positions in 16 bits, weights and normals in 8."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from engines.geometry.skins import strongest
from engines.skeletons import SMPL22
from viewers.bodies.body import Body, eight_bit_weights

if TYPE_CHECKING:
    from viewers.bodies.baking.dress import Dressed

UNIT = 1.0 / 32000
"""Metres of one step of the stored positions; bodies reach 1 m from the pelvis."""


def save(dressed: Dressed, path: Path) -> None:
    """Write a freshly baked body beside `path`, then rename."""
    garments = dressed.garments
    faces = _in_order(garments.vertices, garments.faces)
    coarse = [_in_order(garments.vertices, level) for level in garments.coarse]
    order, number = _by_first_use(np.concatenate([faces, *coarse]), len(garments.vertices))
    index, weights = strongest(garments.weights[order])
    arrays = {
        "vertices": np.round(garments.vertices[order] / UNIT).astype(np.int16),
        "normals": np.round(garments.normals[order] * 127).astype(np.int8),
        "faces": number[faces].astype(np.uint16),
        "skin_indices": index.astype(np.uint8),
        "skin_weights": eight_bit_weights(weights),
        "colours": dressed.colours[order],
        "tint": np.round(dressed.tint[order] * 255).astype(np.uint8),
    }
    for level, less in enumerate(coarse):
        arrays[f"coarse{level}"] = number[less].astype(np.uint16)
    part = path.with_suffix(".part.npz")
    np.savez_compressed(part, **arrays)
    part.replace(path)


def unpack(path: Path, name: str, licence: str) -> Body:
    """The body in a file that `save` wrote."""
    with np.load(path, allow_pickle=False) as stored:
        levels = sorted(key for key in stored.files if key.startswith("coarse"))
        normals = stored["normals"].astype(np.float32)
        return Body(
            name=name,
            skeleton=SMPL22,
            vertices=stored["vertices"] * np.float32(UNIT),
            faces=stored["faces"],
            normals=normals / np.linalg.norm(normals, axis=1, keepdims=True),
            skin_indices=stored["skin_indices"],
            skin_weights=stored["skin_weights"] / np.float32(255),
            colours=stored["colours"],
            tint=stored["tint"] / np.float32(255),
            coarse=tuple(stored[key] for key in levels),
            licence=licence,
        )


@dataclass(frozen=True)
class Moves:
    """What one end of a slider moves."""

    slider: str
    value: float
    """Of the slider, at that end."""
    vertices: np.ndarray
    """(V, 3) metres."""
    offsets: np.ndarray
    """(J, 3) change of the joints' offsets, metres."""


STEP = 1e-4
"""Metres of one step of stored moves."""


def save_moves(moves: Sequence[Moves], path: Path) -> None:
    """Write the moves of sliders beside `path`, then rename.

    Neighbours in the file are neighbours on the body, so differences from one to the next are small and pack well;
    high and low bytes apart pack better still.
    """
    steps = np.round(np.stack([move.vertices for move in moves]) / STEP).astype(np.int16)
    changes = np.diff(steps, axis=1, prepend=np.int16(0)).astype("<i2")
    folded = np.ascontiguousarray(((changes << 1) ^ (changes >> 15)).transpose(0, 2, 1)).view(np.uint8)
    part = path.with_suffix(".part.npz")
    np.savez_compressed(
        part,
        low=folded[..., 0::2],
        high=folded[..., 1::2],
        offsets=np.stack([move.offsets for move in moves]).astype(np.float32),
        sliders=np.array([move.slider for move in moves]),
        values=np.array([move.value for move in moves], np.float32),
    )
    part.replace(path)


def read_moves(path: Path) -> list[Moves]:
    """The moves in a file that `save_moves` wrote."""
    with np.load(path, allow_pickle=False) as stored:
        folded = stored["low"].astype(np.uint16) | stored["high"].astype(np.uint16) << 8
        changes = (folded >> 1).astype(np.int16) ^ -(folded & 1).astype(np.int16)
        vertices = np.cumsum(changes, axis=2, dtype=np.int16).transpose(0, 2, 1) * STEP
        parts = (stored["sliders"], stored["values"], vertices, stored["offsets"].astype(np.float64))
        return [
            Moves(str(name), round(float(value), 4), move, bone) for name, value, move, bone in zip(*parts, strict=True)
        ]


def _in_order(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Faces sorted along a space-filling curve, so that neighbours are drawn, and compressed, together."""
    middle = vertices[faces].mean(1)
    cells = np.clip((middle - middle.min(0)) / (np.ptp(middle, axis=0).max() + 1e-9) * 1023, 0, 1023).astype(np.int64)
    code = np.zeros(len(faces), np.int64)
    for bit in range(10):
        for axis in range(3):
            code |= ((cells[:, axis] >> bit) & 1) << (3 * bit + axis)
    return faces[np.argsort(code, kind="stable")]


def _by_first_use(faces: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Order of vertices by the first face that uses them, and each vertex's number in that order."""
    used, first = np.unique(faces.ravel(), return_index=True)
    order = used[np.argsort(first)]
    number = np.zeros(count, np.int64)
    number[order] = np.arange(len(order))
    return order, number
