"""Do a text and a motion belong together: R-precision and multimodal distance in a shared feature space.

Source: Text2Motion, section 5.1; TM2T, section 6.3.2 of the thesis.
For text to motion the queries are motions and the candidates texts; for motion to text the other way round.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from engines.errors import OutOfRangeError
from engines.metrics import checks

REAL = {"mean": 0.77, "low": 0.65, "other": 0.50}
"""Similarity of real motions and sentences in our co-embedding, held-out clips and their captions: the mean, what nine
in ten of 1,624 pairs exceed, and what of the same clips with captions of others one in twenty exceeds."""
POOL = 32
"""Candidates a query is shown: its own and 31 others."""
TOP = 3
"""Places reported."""
CHUNK = 8
"""Queries compared at a time: their pools fit the processor's cache."""


def r_precision(
    queries: Any, candidates: Any, *, pool: int = POOL, seed: int | np.random.Generator = 0, identity: Any = None
) -> np.ndarray:
    """(3,) shares of queries whose own candidate is the nearest, among the 2, among the 3 nearest of its pool.

    Every query has a pool of its own: the true candidate and others drawn at random without repetition. Of candidates
    equally near, any order is equally likely: identical ones score k / pool, not 1.

    Args:
        queries: (N, D).
        candidates: (N, D), row i belongs to query i.
        pool: candidates shown to a query.
        seed: of the draw.
        identity: (N,) whole numbers, optional: candidates alike in it (the same sentence for two motions) are never
            set against each other.

    Raises:
        OutOfRangeError: too few candidates to fill a pool, or shapes that do not fit.
    """
    asked, offered = checks.pairs(queries, candidates, ("queries", "candidates"))
    if pool < TOP:
        raise OutOfRangeError("pool", pool, f"{TOP} or more")
    rng = np.random.default_rng(seed)
    others = _others(len(asked), pool - 1, rng, identity)
    total = np.zeros(TOP)
    for start in range(0, len(asked), CHUNK):
        part = slice(start, start + CHUNK)
        own = _squares(offered[part, None] - asked[part, None])
        rivals = _squares(offered[others[part]] - asked[part, None])
        nearer, alike = (rivals < own).sum(axis=1), (rivals == own).sum(axis=1)
        total += np.clip((np.arange(1, TOP + 1) - nearer[:, None]) / (1 + alike[:, None]), 0.0, 1.0).sum(axis=0)
    return total / len(asked)


def multimodal_distance(queries: Any, candidates: Any) -> float:
    """Mean Euclidean distance of texts and motions that belong together, row by row of two (N, D).

    Raises:
        OutOfRangeError: shapes that do not fit.
    """
    one, other = checks.pairs(queries, candidates, ("queries", "candidates"))
    return float(np.linalg.norm(one - other, axis=1).mean())


def _squares(gaps: np.ndarray) -> np.ndarray:
    """Squared lengths (N, M) of (N, M, D); equal vectors give equal numbers, as a matrix product would not."""
    return np.einsum("nmd,nmd->nm", gaps, gaps)


def _others(count: int, needed: int, rng: np.random.Generator, identity: Any) -> np.ndarray:
    """(count, needed) indices, each row without repetition, none of the row's own identity."""
    if identity is None:
        if count <= needed:
            raise OutOfRangeError("number of candidates", count, f"{needed + 1} or more, the size of the pool")
        drawn = np.stack([rng.choice(count - 1, needed, replace=False) for _ in range(count)])
        return drawn + (drawn >= np.arange(count)[:, None])
    same = checks.labels(identity, count, name="identity")
    _, group, sizes = np.unique(same, return_inverse=True, return_counts=True)
    if count - sizes.max() < needed:
        raise OutOfRangeError(
            "number of candidates unlike the most frequent one", int(count - sizes.max()), f"{needed} or more"
        )
    by_group = [np.flatnonzero(group != index) for index in range(len(sizes))]
    return np.stack([rng.choice(by_group[index], needed, replace=False) for index in group])
