"""How two sets of motions are spread in an evaluator's feature space: FID, diversity, multimodality.

All in float64, whatever the evaluator's own precision. Letters: N items, D features.

Two of these are means over random pairs. The papers draw pairs in ways that may hold a motion beside itself; here a
pair is always two different items, so that the expected value does not depend on how many there are. With
`pairs=None` there is no draw at all: the mean over all pairs, which is that expected value. The draws of the released
code are in `official_scores`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial.distance import cdist, pdist

from engines.errors import OutOfRangeError
from engines.metrics import checks

CHUNK = 4096
"""Rows compared with all others at a time; up to so many, every pair is looked at only once."""


class FeatureStatistics:
    """Mean and covariance of features that come in batches; those of several processes can be merged.

    Args:
        features: (N, D) a first batch, optional.
    """

    def __init__(self, features: Any = None) -> None:
        self.count = 0
        self._mean, self._scatter = np.zeros(0), np.zeros((0, 0))
        if features is not None:
            self.add(features)

    def add(self, features: Any) -> FeatureStatistics:
        """One more batch (N, D); returns itself.

        Raises:
            OutOfRangeError: not finite, or of another size than before.
        """
        batch = checks.features(features)
        mean = batch.mean(axis=0)
        centred = batch - mean
        return self._join(len(batch), mean, centred.T @ centred)

    def merge(self, other: FeatureStatistics) -> FeatureStatistics:
        """Those of another set added to these; returns itself."""
        return self._join(other.count, other._mean, other._scatter) if other.count else self

    def _join(self, count: int, mean: np.ndarray, scatter: np.ndarray) -> FeatureStatistics:
        # Chan, Golub, LeVeque 1983: nothing is lost where the mean is large beside the spread
        if self.count == 0:
            self.count, self._mean, self._scatter = count, mean, scatter
            return self
        checks.same_size(self._mean, mean, ("the features so far", "the new features"))
        total, shift = self.count + count, mean - self._mean
        self._scatter = self._scatter + scatter + np.outer(shift, shift) * (self.count * count / total)
        self._mean = self._mean + shift * (count / total)
        self.count = total
        return self

    @property
    def mean(self) -> np.ndarray:
        """(D,)."""
        return self._mean

    @property
    def covariance(self) -> np.ndarray:
        """(D, D), divided by N - 1.

        Raises:
            OutOfRangeError: fewer than two items so far.
        """
        if self.count < 2:
            raise OutOfRangeError("number of features", self.count, "2 or more: a covariance needs them")
        return self._scatter / (self.count - 1)


def frechet_distance(first: FeatureStatistics, second: FeatureStatistics) -> float:
    """Frechet distance of two normal distributions: |m1 - m2|^2 + tr(C1 + C2 - 2 (C1 C2)^(1/2)).

    The trace of the root of a product that is not symmetric is taken from the symmetric C1^(1/2) C2 C1^(1/2), which
    has the same eigenvalues: real, never below 0, and exact where a covariance is singular.

    Source: Dowson, Landau 1982; Heusel et al. 2017, "GANs trained by a two time-scale update rule", equation 6.

    Raises:
        OutOfRangeError: sizes differ, or fewer than two items in either.
    """
    checks.same_size(first.mean, second.mean, ("the first features", "the second features"))
    one, other = first.covariance, second.covariance
    values, vectors = np.linalg.eigh(one)
    half = vectors * np.sqrt(np.maximum(values, 0.0))
    shared = np.sqrt(np.maximum(np.linalg.eigvalsh(half.T @ other @ half), 0.0)).sum()
    apart = np.square(first.mean - second.mean).sum()
    return float(max(apart + np.trace(one) + np.trace(other) - 2.0 * shared, 0.0))


def fid(real: Any, made: Any) -> float:
    """Frechet distance of real and made features; 0 where mean and covariance agree.

    Estimates grow as items get fewer, so compare only figures of equally many, well above D of them.

    Args:
        real: (N, D) features of real motions.
        made: (M, D) features, of the same evaluator, of generated motions. Transitions between actions are judged by
            the same distance, over features of the stretches between two actions (MultiAct, table 3).

    Raises:
        OutOfRangeError: fewer than two items, values that are not finite, or sizes that differ.
    """
    return frechet_distance(FeatureStatistics(real), FeatureStatistics(made))


def diversity(features: Any, pairs: int | None = 300, seed: int | np.random.Generator = 0) -> float:
    """Mean Euclidean distance of pairs of motions, whatever their labels; to be near that of real motions.

    Source: Action2Motion, equation 10 (200 pairs); 300 in Text2Motion.

    Args:
        features: (N, D), two rows or more.
        pairs: how many to draw; None for all there are, without a draw.
        seed: of the draw.

    Raises:
        OutOfRangeError: too few items, or no pairs asked for.
    """
    values = checks.features(features, least=2)
    if pairs is None:
        return _mean_distance(values)
    first, second = distinct_pairs(len(values), pairs, np.random.default_rng(seed))
    return pair_distance(values, first, second)


def multimodality(features: Any, labels: Any, pairs: int | None = 20, seed: int | np.random.Generator = 0) -> float:
    """Mean Euclidean distance of pairs that share a label (action or sentence), each label counting alike.

    Source: Action2Motion, equation 11 (20 pairs a label); 10 pairs a sentence in Text2Motion.

    Args:
        features: (N, D).
        labels: (N,) whole numbers.
        pairs: how many to draw for each label; None for all there are, without a draw.
        seed: of the draw.

    Raises:
        OutOfRangeError: a label with only one item, or no pairs asked for.
    """
    values = checks.features(features, least=2)
    known, group, sizes = np.unique(checks.labels(labels, len(values)), return_inverse=True, return_counts=True)
    if sizes.min() < 2:
        lone = [int(label) for label in known[sizes < 2]]
        raise OutOfRangeError("labels with a single item", lone, "2 or more items of every label")
    rng = np.random.default_rng(seed)
    means = []
    for index, size in enumerate(sizes):
        members = values[group == index]
        means.append(
            _mean_distance(members) if pairs is None else pair_distance(members, *distinct_pairs(size, pairs, rng))
        )
    return float(np.mean(means))


def multimodality_of_repeats(features: Any, pairs: int | None = 10, seed: int | np.random.Generator = 0) -> float:
    """`multimodality` of several motions for each of several prompts.

    Args:
        features: (prompts, repeats, D).
        pairs: see `multimodality`.
        seed: see `multimodality`.

    Raises:
        OutOfRangeError: another shape, or fewer than two repeats.
    """
    array = checks.as_array(features)
    if array.ndim != 3 or array.shape[1] < 2:
        raise OutOfRangeError("shape of features", array.shape, "(prompts, 2 or more repeats, size)")
    prompts, repeats, size = array.shape
    return multimodality(array.reshape(-1, size), np.repeat(np.arange(prompts), repeats), pairs, seed)


def distinct_pairs(count: int, pairs: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Indices (pairs,) and (pairs,) of pairs drawn evenly from all pairs of two different items out of `count`.

    Raises:
        OutOfRangeError: fewer than two items or one pair.
    """
    if count < 2:
        raise OutOfRangeError("number of items", count, "2 or more")
    if pairs < 1:
        raise OutOfRangeError("pairs", pairs, "1 or more, or None for all")
    first, second = rng.integers(count, size=pairs), rng.integers(count - 1, size=pairs)
    return first, second + (second >= first)


def pair_distance(features: Any, first: np.ndarray, second: np.ndarray) -> float:
    """Mean Euclidean distance of the pairs of rows `first[i]`, `second[i]` of features (N, D)."""
    values = checks.features(features)
    return float(np.linalg.norm(values[first] - values[second], axis=1).mean())


def _mean_distance(values: np.ndarray) -> float:
    """Mean distance of all pairs of different rows."""
    count = len(values)
    if count <= CHUNK:
        return float(pdist(values).mean())
    total = sum(cdist(values[start : start + CHUNK], values).sum() for start in range(0, count, CHUNK))
    return float(total / (count * (count - 1)))
