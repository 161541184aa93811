"""Where the reference numbers are: files found by pattern, and a loud skip where there are none."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from torch import Tensor

from tests.conftest import find_shared


def cases(topic: str, pattern: str = "public*.npz"):
    """One parameter for each file of a topic of the shared folder."""
    shared = find_shared()
    files = sorted((shared / "golden" / topic).glob(pattern)) if shared else []
    if not files:
        reason = f"no golden/{topic}/{pattern}: put the shared folder beside the checkout or set MOTIONLOOM_SHARED"
        return [pytest.param(None, marks=pytest.mark.skip(reason=reason), id="absent")]
    return [pytest.param(file, id=file.stem) for file in files]


def tensors(path) -> dict[str, Tensor]:
    """All arrays of a file, as tensors of their own type."""
    with np.load(path) as arrays:
        return {name: torch.from_numpy(array) for name, array in arrays.items() if array.dtype.kind in "fiub"}


def close(actual: Tensor, expected: Tensor, tolerance: float, name: str = "") -> None:
    """Within an absolute tolerance, not-a-numbers in the same places."""
    assert actual.shape == expected.shape, name
    torch.testing.assert_close(
        actual, expected, atol=tolerance, rtol=0, equal_nan=True, msg=lambda text: f"{name}: {text}"
    )
