"""What a skin over a skeleton needs: matrices that carry it, weights on few joints, normals."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Float32, Integer

from engines.skeletons.skeleton import Skeleton

INFLUENCES = 4
"""Joints a vertex may hang on; the number every graphics API is happy with."""


def skinning_matrices(
    skeleton: Skeleton, positions: Float[np.ndarray, "*batch J 3"], turns: Float[np.ndarray, "*batch J 3 3"]
) -> Float32[np.ndarray, "*batch J 3 4"]:
    """Matrices that carry rest-pose points with each joint.

    Args:
        skeleton: gives the rest positions (J, 3).
        positions: (..., J, 3) joint positions, metres.
        turns: (..., J, 3, 3) global rotations.

    Returns:
        (..., J, 3, 4) float32 rows [R | p - R rest].
    """
    moved = positions - np.einsum("...jab,jb->...ja", turns, skeleton.rest_positions)
    return np.concatenate([turns, moved[..., None]], axis=-1).astype(np.float32)


def blended(
    matrices: Float[np.ndarray, "J 3 4"], indices: Integer[np.ndarray, "N 4"], weights: Float[np.ndarray, "N 4"]
) -> Float[np.ndarray, "N 3 4"]:
    """(N, 3, 4) each vertex's own matrix: those of its joints (N, 4), weighted (N, 4)."""
    return np.einsum("nk,nkab->nab", weights, np.asarray(matrices, np.float64)[indices])


def strongest(weights: Float[np.ndarray, "N J"]) -> tuple[Integer[np.ndarray, "N 4"], Float[np.ndarray, "N 4"]]:
    """The four strongest joints (N, 4) of full weights (N, J), and their weights (N, 4) summing to one.

    What is left out fades as it becomes the fifth: the weakest of the four are lessened by it, so that
    neighbours that keep different fours stay close.
    """
    order = np.argsort(-weights, axis=1, kind="stable")[:, : INFLUENCES + 1]
    kept = np.take_along_axis(weights, order, axis=1)
    kept = np.maximum(kept[:, :INFLUENCES] - kept[:, INFLUENCES:], 0.0)
    return order[:, :INFLUENCES], kept / kept.sum(1, keepdims=True)


def vertex_normals(
    vertices: Float[np.ndarray, "V 3"],
    faces: Integer[np.ndarray, "F 3"],
    groups: Integer[np.ndarray, " V"] | None = None,
) -> Float32[np.ndarray, "V 3"]:
    """(V, 3) float32 unit normals, area-weighted; vertices of one group (same place, split by colour) share theirs."""
    corners = vertices[faces].astype(np.float64)
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    where = faces if groups is None else groups[faces]
    total = np.zeros((len(vertices), 3))
    for corner in range(3):
        np.add.at(total, where[:, corner], flat)
    if groups is not None:
        total = total[groups]
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return (total / np.where(length > 0, length, 1.0)).astype(np.float32)
