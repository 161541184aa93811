"""Equation 3.12 as one sparse problem: colours that stay near a guess and near their neighbours."""

from __future__ import annotations

import numpy as np
from jaxtyping import Bool, Float
from scipy import sparse
from scipy.spatial import KDTree

from engines.character.mesh import Surface

NEIGHBOURS = 10
ROUNDS = 8
"""Times the weights are made anew."""
CLOSE, MOST_STEPS = 1e-4, 200
"""Of each round's solution: relative residual at which it is good enough, and steps until it has to be."""
SMALL = 2.0
"""Steps of 255 below which a distance counts as squared: the norm has no slope at zero."""


def completed(
    surface: Surface,
    colours: Float[np.ndarray, "N 3"],
    known: Bool[np.ndarray, " N"],
    guess: Float[np.ndarray, "N 3"],
    weight: float,
) -> Float[np.ndarray, "N 3"]:
    """Minimise sum_x ||c_x - c_x^p|| + weight / |N_x| sum_x' ||c_x - c_x'|| over the unknown colours (eq. 3.12).

    The norms are not squared, so an edge may stay an edge. Iteratively reweighted least squares: every round solves one
    sparse symmetric system for all vertices and the three channels together.

    Args:
        surface: gives the places; the neighbours are the ten nearest that face the same way.
        colours: (N, 3) those known; the others do not count.
        known: (N,) which are known and stay.
        guess: (N, 3) c^p; NaN where there is none and only the neighbours count.
        weight: lambda_nn.

    Returns:
        (N, 3) colours.
    """
    unknown = np.flatnonzero(~known)
    if not len(unknown):
        return colours
    guided = np.asarray(np.isfinite(guess).all(axis=1))
    start, end = _pairs(surface, unknown)
    share = weight / np.bincount(start, minlength=len(colours))[start]
    target = np.where(guided[:, None], guess, 0.0)
    near, own = share, np.where(guided, 1.0, 1e-9)  # squares at first, which do not depend on the beginning
    for _ in range(ROUNDS):
        colours = _solved(colours, known, target, own, (start, end, near))
        near = share / _length(colours[start] - colours[end])
        own = np.where(guided, 1.0 / _length(colours - target), 1e-9)
    return colours


def _pairs(surface: Surface, unknown: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Each unknown vertex and its nearest vertices that do not face away from it."""
    count = min(3 * NEIGHBOURS, len(surface.vertices) - 1)
    found = np.asarray(KDTree(surface.vertices).query(surface.vertices[unknown], k=count + 1)[1])
    facing = np.einsum("nkc,nc->nk", surface.normals[found], surface.normals[unknown]) > 0
    alike = facing & (found != unknown[:, None])
    chosen = alike & (np.cumsum(alike, axis=1) <= NEIGHBOURS)
    chosen[:, 1] |= ~chosen.any(axis=1)
    return np.repeat(unknown, chosen.sum(1)), found[chosen]


def _solved(
    colours: np.ndarray, known: np.ndarray, guess: np.ndarray, own: np.ndarray,
    links: tuple[np.ndarray, np.ndarray, np.ndarray],
) -> np.ndarray:  # fmt: skip
    """One round's least squares: own (N,) pulls to the guess, links (start, end, weight) pull neighbours together."""
    start, end, near = links
    count = len(colours)
    pull = sparse.coo_array((near, (start, end)), shape=(count, count)).tocsr()
    pull = pull + pull.T
    free = np.flatnonzero(~known)
    diagonal = own + pull.sum(axis=1)
    matrix = sparse.diags_array(diagonal[free]) - pull[free][:, free]
    right = (own[:, None] * guess)[free] + pull[free][:, known] @ colours[known]
    result = colours.copy()
    result[free] = _conjugate_gradients(sparse.csr_array(matrix), right, colours[free], diagonal[free, None])
    return result


def _conjugate_gradients(
    matrix: sparse.csr_array, right: np.ndarray, start: np.ndarray, diagonal: np.ndarray
) -> Float[np.ndarray, "N 3"]:
    """Solves matrix x = right for the three channels at once, preconditioned by the diagonal.

    SciPy's takes one channel at a time, and its dot products are BLAS's, whose threads wait for each other longer than
    they compute where the cores are busy.
    """
    found = start.copy()
    rest = right - matrix @ found
    step = rest / diagonal
    size = np.einsum("nc,nc->c", rest, step)
    goal = (CLOSE**2) * np.maximum(np.einsum("nc,nc->c", right, right / diagonal), 1e-12)
    for _ in range(MOST_STEPS):
        if (size <= goal).all():
            break
        ahead = matrix @ step
        length = size / np.maximum(np.einsum("nc,nc->c", step, ahead), 1e-300)
        found += length * step
        rest -= length * ahead
        scaled = rest / diagonal
        size, before = np.einsum("nc,nc->c", rest, scaled), size
        step = scaled + size / np.maximum(before, 1e-300) * step
    return found


def _length(difference: np.ndarray) -> np.ndarray:
    return np.maximum(np.linalg.norm(difference, axis=-1), SMALL)
