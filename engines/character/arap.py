"""As rigid as possible: a mesh that follows control points while every neighbourhood only turns (thesis eq. 3.18).

Sorkine and Alexa, "As-Rigid-As-Possible Surface Modeling", 2007: rotations and places are solved for in turn; the
matrix for the places is the same in every pose and is factored once.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Integer
from scipy import sparse
from scipy.sparse.linalg import splu

from engines.errors import OutOfRangeError

ROUNDS = 4
"""Times rotations and places are solved for; from a skinned pose more change next to nothing."""
LEAST = 1e-3
"""Cotangent weights are no smaller: obtuse slivers would make them negative."""


class AsRigidAsPossible:
    """A rest shape that is brought to control points.

    Args:
        vertices: (N, 3) the rest shape, metres.
        faces: (F, 3) its faces; vertices no face uses go where they are told.
        hold: (N,) weight of each vertex as a control point, against its edges'; 0 sets it free.

    Raises:
        OutOfRangeError: nothing is held, or by less than nothing.
    """

    def __init__(
        self,
        vertices: Float[np.ndarray, "N 3"],
        faces: Integer[np.ndarray, "F 3"],
        hold: Float[np.ndarray, " N"],
    ) -> None:
        hold = np.asarray(hold, np.float64)
        if not (np.isfinite(hold).all() and hold.min() >= 0 and hold.max() > 0):
            raise OutOfRangeError("hold", [float(hold.min()), float(hold.max())], "weights from 0, not all of them 0")
        self._rest = np.asarray(vertices, np.float64)
        self._hold = hold
        start, end, weight = _edges(self._rest, np.asarray(faces))
        self._ends, self._weight = (start, end), weight
        self._bones = weight[:, None] * (self._rest[start] - self._rest[end])  # k_ij (S_i - S_j)
        count = len(self._rest)
        self._sum = sparse.csr_array((np.ones(len(start)), np.arange(len(start)), _starts(start, count)),
                                     shape=(count, len(start)))  # fmt: skip
        links = sparse.csr_array((weight, (start, end)), shape=(count, count))
        degree = links.sum(axis=1)
        # what hangs on nothing that is held stays put
        matrix = sparse.diags_array(2 * degree + hold + 1e-9) - 2 * links
        self._factor = splu(
            sparse.csc_matrix(matrix), "MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
        )

    def deformed(
        self,
        targets: Float[np.ndarray, "N 3"],
        start: Float[np.ndarray, "N 3"] | None = None,
        rounds: int = ROUNDS,
    ) -> Float[np.ndarray, "N 3"]:
        """The places that minimise sum k_ij ||(s_i - s_j) - R_i (S_i - S_j)||^2 + sum hold ||s_l - targets_l||^2.

        Args:
            targets: (N, 3) where control points should be, metres.
            start: (N, 3) places to begin from; the targets if left out.
            rounds: how often rotations and places are solved for.
        """
        places = np.array(targets if start is None else start, np.float64)
        fixed = self._hold[:, None] * targets + 1e-9 * places
        for _ in range(rounds):
            turns = self._turns(places)
            begin, end = self._ends
            pulls = np.einsum("eab,eb->ea", turns[begin] + turns[end], self._bones)
            places = self._factor.solve(self._sum @ pulls + fixed)
        return places

    def energy(self, places: Float[np.ndarray, "N 3"]) -> float:
        """The first sum above, at the best rotations: how far from rigid a deformed shape is."""
        begin, end = self._ends
        bones = self._bones / self._weight[:, None]
        off = places[begin] - places[end] - np.einsum("eab,eb->ea", self._turns(places)[begin], bones)
        return float((self._weight * (off**2).sum(axis=1)).sum())

    def _turns(self, places: np.ndarray) -> Float[np.ndarray, "N 3 3"]:
        """(N, 3, 3) the rotation of each neighbourhood: the polar part of sum k_ij (S_i - S_j) (s_i - s_j)^T."""
        begin, end = self._ends
        edges = places[begin] - places[end]
        products = (self._bones[:, :, None] * edges[:, None, :]).reshape(len(edges), 9)
        left, _, right = np.linalg.svd((self._sum @ products).reshape(-1, 3, 3))
        turns = np.einsum("nba,ncb->nac", right, left)  # V U^T
        mirrored = np.linalg.det(turns) < 0
        left[mirrored, :, 2] *= -1
        turns[mirrored] = np.einsum("nba,ncb->nac", right[mirrored], left[mirrored])
        return turns


def _edges(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Each edge both ways, by its start: start (E,), end (E,), and half the sum of the cotangents across it (E,)."""
    count = len(vertices)
    total = sparse.csr_array((count, count))
    for corner in range(3):
        apex, one, other = faces[:, corner], faces[:, corner - 2], faces[:, corner - 1]
        a, b = vertices[one] - vertices[apex], vertices[other] - vertices[apex]
        area = np.linalg.norm(np.cross(a, b), axis=1)
        cotangent = (a * b).sum(axis=1) / np.maximum(area, 1e-12)
        total = total + sparse.coo_array((np.clip(cotangent, -10, 10) / 2, (one, other)), shape=(count, count))
    total = sparse.csr_array(total + total.T)
    total.setdiag(0)
    total.eliminate_zeros()
    total.sort_indices()
    links = total.tocoo()
    return links.row.astype(np.int64), links.col.astype(np.int64), np.maximum(links.data, LEAST)


def _starts(owner: np.ndarray, count: int) -> np.ndarray:
    """Where each of `count` owners' runs begin in a sorted list, and where the last ends."""
    return np.searchsorted(owner, np.arange(count + 1))
