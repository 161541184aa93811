"""Is a motion taken for what was asked: top-k accuracy and confusion, from a classifier's scores.

Letters: N items, C classes, D features.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from engines.errors import OutOfRangeError
from engines.metrics import checks


class Recognised(NamedTuple):
    """What an evaluator says of a set of motions."""

    features: Any
    """(N, D) its last hidden layer."""
    logits: Any
    """(N, C) its scores of the classes, the highest is its answer."""


def hits(logits: Any, labels: Any, k: int = 1, accepted: Any = None) -> np.ndarray:
    """Is the label among the k highest scores: (N,) from 0 to 1.

    Where scores tie across place k, a hit counts as much as its chance when ties are broken at random: a classifier
    that scores all classes alike has k / C, wherever its label stands.

    Args:
        logits: (N, C), two classes or more.
        labels: (N,) from 0 to C - 1.
        k: places that count.
        accepted: (C, C) booleans, optional: `accepted[label, answer]` says which other answers count for a label
            (MultiAct's table of synonyms such as "step back" and "step backward"). A label itself always counts.
            The k answers are then the k first of the sorted scores, ties in the order of the classes.

    Raises:
        OutOfRangeError: shapes, labels or k do not fit.
    """
    scores, truth = _scores(logits, labels)
    classes = scores.shape[1]
    if not 1 <= k <= classes:
        raise OutOfRangeError("k", k, f"1 to {classes}, the number of classes")
    if accepted is None:
        own = scores[np.arange(len(scores)), truth][:, None]
        higher, alike = (scores > own).sum(axis=1), (scores == own).sum(axis=1)
        return np.clip((k - higher) / alike, 0.0, 1.0)
    table = checks.as_array(accepted)
    if table.shape != (classes, classes):
        raise OutOfRangeError("shape of accepted", table.shape, f"({classes}, {classes}), labels by answers")
    table = table.astype(bool) | np.eye(classes, dtype=bool)
    answers = np.argsort(-scores, axis=1, kind="stable")[:, :k]
    return np.asarray(table[truth[:, None], answers].any(axis=1), dtype=np.float64)


def accuracy(logits: Any, labels: Any, k: int = 1, accepted: Any = None) -> float:
    """Share of items whose label is among the k highest scores; see `hits`."""
    return float(hits(logits, labels, k, accepted).mean())


def accuracies(logits: Any, labels: Any, accepted: Any = None) -> dict[str, float]:
    """Top-1 and top-5 accuracy as {"accuracy_top1": ..., "accuracy_top5": ...}; no top-5 of five classes or fewer."""
    places = [k for k in (1, 5) if k == 1 or k < checks.features(logits, "logits").shape[1]]
    return {f"accuracy_top{k}": accuracy(logits, labels, k, accepted) for k in places}


def confusion(logits: Any, labels: Any) -> np.ndarray:
    """(C, C) counts: rows are labels, columns the classifier's answers (of tied scores the first)."""
    scores, truth = _scores(logits, labels)
    classes = scores.shape[1]
    return np.bincount(truth * classes + scores.argmax(axis=1), minlength=classes**2).reshape(classes, classes)


def class_accuracy(confusion_counts: Any) -> np.ndarray:
    """(C,) share of each label's items that were answered right; NaN for a label without items.

    Args:
        confusion_counts: (C, C) of `confusion`.

    Raises:
        OutOfRangeError: not square.
    """
    counts = checks.as_array(confusion_counts)
    if counts.ndim != 2 or counts.shape[0] != counts.shape[1]:
        raise OutOfRangeError("shape of confusion", counts.shape, "(classes, classes)")
    total = counts.sum(axis=1)
    return np.where(total > 0, np.diag(counts) / np.maximum(total, 1), np.nan)


def _scores(logits: Any, labels: Any) -> tuple[np.ndarray, np.ndarray]:
    scores = checks.features(logits, "logits")
    if scores.shape[1] < 2:
        raise OutOfRangeError("number of classes", scores.shape[1], "2 or more")
    return scores, checks.labels(labels, len(scores), scores.shape[1])
