"""What the metrics accept: finite features of the right shape and labels in range, or an error in words."""

from __future__ import annotations

from typing import Any

import numpy as np

from engines.errors import OutOfRangeError


def as_array(values: Any) -> np.ndarray:
    """A NumPy array of numbers, lists or a torch tensor (wherever it is), type kept."""
    return np.asarray(values.detach().cpu() if hasattr(values, "detach") else values)


def features(values: Any, name: str = "features", least: int = 1) -> np.ndarray:
    """Features (N, D) as float64.

    Raises:
        OutOfRangeError: another shape, fewer than `least` rows, no columns, or values that are not finite.
    """
    array = as_array(values)
    if array.ndim != 2 or array.shape[1] == 0 or array.dtype.kind not in "fiub":
        raise OutOfRangeError(f"shape of {name}", array.shape, "(items, size of a feature vector), real numbers")
    if len(array) < least:
        raise OutOfRangeError(f"number of {name}", len(array), f"{least} or more")
    array = array.astype(np.float64)
    bad = np.flatnonzero(~np.isfinite(array).all(axis=1))
    if bad.size:
        wrong = next(float(value) for value in array[bad[0]] if not np.isfinite(value))
        raise OutOfRangeError(f"a number in row {bad[0]} of {name}", wrong, f"finite ones ({bad.size} such rows)")
    return array


def same_size(first: np.ndarray, second: np.ndarray, names: tuple[str, str]) -> None:
    """Feature vectors of two sets are as long as each other, so that they can come from one evaluator.

    Raises:
        OutOfRangeError: they are not.
    """
    if first.shape[-1] != second.shape[-1]:
        raise OutOfRangeError(
            f"size of {names[1]}", second.shape[-1], f"{first.shape[-1]}, that of {names[0]} (one evaluator for both)"
        )


def pairs(first: Any, second: Any, names: tuple[str, str], least: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Two sets of features (N, D), row for row about the same thing, as float64.

    Raises:
        OutOfRangeError: see `features`; or the shapes differ.
    """
    one, other = features(first, names[0], least), features(second, names[1], least)
    same_size(one, other, names)
    if len(one) != len(other):
        raise OutOfRangeError(f"number of {names[1]}", len(other), f"{len(one)}, one for each of the {names[0]}")
    return one, other


def labels(values: Any, count: int, classes: int | None = None, name: str = "labels") -> np.ndarray:
    """Labels (N,) as int64, one for each of `count` items.

    Raises:
        OutOfRangeError: not whole numbers, another count, or outside 0 ... classes - 1.
    """
    array = as_array(values)
    if array.ndim != 1 or len(array) != count:
        raise OutOfRangeError(f"shape of {name}", array.shape, f"({count},), one label an item")
    if array.dtype.kind not in "iub":
        raise OutOfRangeError(f"type of {name}", str(array.dtype), "whole numbers")
    array = array.astype(np.int64)
    if count and (array.min() < 0 or (classes is not None and array.max() >= classes)):
        accepted = "0 or more" if classes is None else f"0 to {classes - 1}"
        raise OutOfRangeError(name, sorted({int(array.min()), int(array.max())}), accepted)
    return array
