"""Reference numbers found by what a file holds, whatever it is called."""

from __future__ import annotations

import numpy as np
import pytest

from tests.conftest import find_shared


def cases(topic: str, *keys: str):
    """One parameter for each file of a topic that holds all of these arrays."""
    shared = find_shared()
    files = sorted((shared / "golden" / topic).glob("*.npz")) if shared else []
    found = [file for file in files if set(keys) <= held(file)]
    if not found:
        reason = f"no golden/{topic} with {', '.join(keys)}: put the shared folder beside or set MOTIONLOOM_SHARED"
        return [pytest.param(None, marks=pytest.mark.skip(reason=reason), id="absent")]
    return [pytest.param(file, id=file.stem) for file in found]


def held(path) -> set[str]:
    with np.load(path) as arrays:
        return set(arrays.files)


def load(path) -> dict[str, np.ndarray]:
    with np.load(path) as arrays:
        return {name: arrays[name] for name in arrays.files}


def close(actual: np.ndarray, expected: np.ndarray, tolerance, name: str = "") -> None:
    """Within an absolute tolerance, one for all or one a column."""
    assert np.shape(actual) == expected.shape, name
    assert np.isfinite(expected).all(), name
    off = np.abs(actual - expected) - tolerance
    assert np.isfinite(off).all() and off.max() <= 0, f"{name}: off by {np.abs(actual - expected).max():.3g}"
