"""The released evaluation code's way of counting, where it departs from the definitions in the other modules.

For tables that must be comparable to the digit with published ones:

- `fid`: the mean in the features' own float32, and the matrix root of a product that is not symmetric; can come out
  slightly below 0, and moves by about 1 % with the root's algorithm where a covariance is singular;
- `distances`, `r_precision_hits`, `matching_score`: Euclidean distances from -2ab + a^2 + b^2 in float32, NaN where
  rounding makes it negative; pools are blocks of 32 in the order of the data, a last smaller one is left out; each text
  ranks the motions (the papers: each motion ranks the texts);
- `subset_pairs`: two draws without repetition that know nothing of each other, so a motion may be compared with
  itself; `action_pairs`: the same, with repetition, within each action;
- `class_multimodality`: divided by all classes, also those without motions (MultiAct);
- `interval`: 1.96 times the biased deviation over the root of the number of repeats;
- `geodesic_distance`: arc cosine of a trace that is kept 1e-7 away from +-1 in float32: equal rotations are 5e-4 apart;
- `bleu_items`, `bleu`: tiny constants where nothing matches; `rouge_l_items`: best precision and best recall, even of
  two different references.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from scipy import linalg

from engines.errors import OutOfRangeError
from engines.metrics import checks, language

TINY, SMALL = 1e-15, 1e-9
"""Added to matched and to all n-grams by the caption evaluation's BLEU."""
TRACE_MARGIN = 1e-7


def fid(real: Any, made: Any) -> float:
    """Frechet distance of features (N, D) and (M, D), kept in the precision they come in."""
    first, second = checks.as_array(real), checks.as_array(made)
    checks.features(first, "real features", 2)
    checks.features(second, "made features", 2)
    checks.same_size(first, second, ("real features", "made features"))
    shift = first.mean(axis=0) - second.mean(axis=0)
    one, other = np.cov(first, rowvar=False), np.cov(second, rowvar=False)
    root = np.asarray(linalg.sqrtm(one @ other))
    if not np.isfinite(root).all():
        bump = 1e-6 * np.eye(len(one))
        root = np.asarray(linalg.sqrtm((one + bump) @ (other + bump)))
    return float(shift @ shift + np.trace(one) + np.trace(other) - 2 * np.trace(np.real(root)))


# ---- texts and motions --------------------------------------------------------------------------------------


def distances(first: Any, second: Any) -> np.ndarray:
    """(N, M) Euclidean distances of rows (N, D) and (M, D), in their own precision; NaN where rounding undercuts 0."""
    one, other = checks.as_array(first), checks.as_array(second)
    checks.features(one, "the first features")
    checks.features(other, "the second features")
    checks.same_size(one, other, ("the first features", "the second features"))
    squares = -2 * one @ other.T + np.square(one).sum(axis=1, keepdims=True) + np.square(other).sum(axis=1)
    with np.errstate(invalid="ignore"):
        return np.sqrt(squares)


def r_precision_hits(texts: Any, motions: Any, pool: int = 32, top: int = 3) -> np.ndarray:
    """(top,) counts of texts whose own motion is among the 1, 2, ... top nearest of its block of `pool` motions."""
    found = np.zeros(top, dtype=np.int64)
    for block in _blocks(texts, motions, pool):
        order = np.argsort(block, axis=1)[:, :top]
        found += np.cumsum(order == np.arange(pool)[:, None], axis=1).sum(axis=0)
    return found


def matching_score(texts: Any, motions: Any, pool: int = 32) -> float:
    """Sum of the distances of the pairs that `r_precision_hits` looks at; divide by their number for the mean."""
    return float(sum(np.trace(block) for block in _blocks(texts, motions, pool)))


def _blocks(texts: Any, motions: Any, pool: int) -> list[np.ndarray]:
    one, other = checks.as_array(texts), checks.as_array(motions)
    checks.pairs(one, other, ("texts", "motions"), least=pool)
    return [distances(one[at : at + pool], other[at : at + pool]) for at in range(0, len(one) - pool + 1, pool)]


# ---- pairs --------------------------------------------------------------------------------------------------


def subset_pairs(count: int, pairs: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Text2Motion's pairs: two draws of `pairs` out of `count`, each without repetition.

    Raises:
        OutOfRangeError: more pairs than items.
    """
    if not 1 <= pairs <= count:
        raise OutOfRangeError("pairs", pairs, f"1 to {count}, the number of items")
    return rng.choice(count, pairs, replace=False), rng.choice(count, pairs, replace=False)


def action_pairs(labels: Any, quota: int, draw: Callable[[], int]) -> np.ndarray:
    """(classes * quota, 2) Action2Motion's and MultiAct's pairs of motions of one action, in the order they come up.

    A first motion is drawn until its action has pairs left, a second one until its action is the same; it may be the
    same motion. The release never comes back if an action has no motions; here only actions that have some count.

    Args:
        labels: (N,) actions.
        quota: pairs an action.
        draw: gives an index from 0 to N - 1 at each call.

    Raises:
        OutOfRangeError: no quota, or labels that are none.
    """
    actions = checks.labels(labels, len(labels))
    if quota < 1 or len(actions) == 0:
        raise OutOfRangeError("quota", quota, "1 or more, of 1 or more motions")
    left = {int(action): quota for action in np.unique(actions)}
    drawn = []
    while any(left.values()):
        first = draw()
        action = int(actions[first])
        if left[action] == 0:
            continue
        second = draw()
        while actions[second] != action:
            second = draw()
        left[action] -= 1
        drawn.append((first, second))
    return np.array(drawn)


def shared_multimodality(features: Any, first: np.ndarray, second: np.ndarray) -> float:
    """Mean distance of repeats `first[i]`, `second[i]` in (prompts, repeats, D): the same pairs for every prompt."""
    values = checks.as_array(features)
    return float(np.linalg.norm(values[:, first] - values[:, second], axis=-1).astype(np.float64).mean())


def class_multimodality(features: Any, pairs: np.ndarray, quota: int, classes: int) -> float:
    """Sum of the distances of `pairs` (P, 2) of rows (N, D), divided by quota times classes, whatever P is."""
    values = checks.as_array(features)
    apart = np.linalg.norm(values[pairs[:, 0]] - values[pairs[:, 1]], axis=1)
    return float(apart.sum(dtype=np.float64) / (quota * classes))


def interval(values: Any) -> float:
    """Half width of the 95 % interval of the mean of repeats, as Text2Motion and Action2Motion state it."""
    array = np.asarray(values, dtype=np.float64)
    return float(1.96 * array.std() / np.sqrt(len(array)))


# ---- rotations ----------------------------------------------------------------------------------------------


def geodesic_distance(first: Any, second: Any) -> np.ndarray:
    """(...) angle in radians between rotation matrices (..., 3, 3), never below 5e-4 or above pi - 5e-4."""
    one, other = (checks.as_array(values).astype(np.float32) for values in (first, second))
    cosine = ((one * other).sum(axis=(-2, -1)) - np.float32(1)) / np.float32(2)
    limit = np.float32(1 - TRACE_MARGIN)
    return np.arccos(np.clip(cosine, -limit, limit))


# ---- captions -----------------------------------------------------------------------------------------------


def bleu(candidates: Sequence[str], references: Sequence[Sequence[str]], order: int = 4) -> float:
    """BLEU of a corpus by the MS COCO scorer: as `language.bleu`, but never 0."""
    counts = language.ngram_counts(candidates, references, order)
    precisions = (counts.matched + TINY) / (counts.total + SMALL)
    ratio = (counts.candidate_length + TINY) / (counts.reference_length + SMALL)
    return float(np.exp(np.log(precisions).mean()) * math.exp(min(0.0, 1.0 - 1.0 / ratio)))


def bleu_items(candidates: Sequence[str], references: Sequence[Sequence[str]], order: int = 4) -> np.ndarray:
    """(N,) `bleu` of every sentence alone."""
    language.check(candidates, references)
    return np.array([bleu([one], [item], order) for one, item in zip(candidates, references, strict=True)])


def rouge_l_items(candidates: Sequence[str], references: Sequence[Sequence[str]]) -> np.ndarray:
    """(N,) ROUGE-L of every sentence, from its best precision and its best recall over the references."""
    language.check(candidates, references)
    scores = []
    for candidate, sentences in zip(candidates, references, strict=True):
        words = candidate.split()
        cut = [sentence.split() for sentence in sentences]
        common = [language.common_subsequence(words, sentence) for sentence in cut]
        precision = max(common) / max(len(words), 1)
        recall = max(shared / len(sentence) for shared, sentence in zip(common, cut, strict=True))
        scores.append(language.f_measure(precision, recall))
    return np.array(scores)
