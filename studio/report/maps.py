"""Features of motions as points on a plane."""

from __future__ import annotations

import importlib.util

import numpy as np


def principal(features: np.ndarray) -> tuple[np.ndarray, float]:
    """Points (N, 2) along the two directions in which features (N, D) vary most, and the share of variance they hold.

    Each direction points to where the largest feature weight is positive, so that the same features give one picture.
    """
    centred = features - features.mean(axis=0)
    _, sizes, directions = np.linalg.svd(centred, full_matrices=False)
    first = directions[:2]
    first = first * np.sign(first[np.arange(len(first)), np.abs(first).argmax(axis=1)])[:, None]
    total = float(np.square(sizes).sum())
    return centred @ first.T, float(np.square(sizes[:2]).sum() / total) if total > 0 else 1.0


def can_neighbours() -> bool:
    """Whether scikit-learn is there, which the extra `reports` brings."""
    return importlib.util.find_spec("sklearn") is not None


def neighbours(features: np.ndarray, seed: int = 0) -> np.ndarray:
    """Points (N, 2) that keep near what is near in features (N, D): t-SNE, from the principal components.

    Source: van der Maaten, Hinton 2008, as scikit-learn has it.
    """
    from sklearn.manifold import TSNE

    perplexity = min(30.0, max(1.0, (len(features) - 1) / 3))
    made = TSNE(init="pca", perplexity=perplexity, random_state=seed).fit_transform(features.astype(np.float32))
    return np.asarray(made, dtype=np.float64)
