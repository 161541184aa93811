"""The time counter c_t: how much of an action is done (thesis section 3.2.1, eq. 3.7)."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from jaxtyping import Float

_SLOWEST = 1.5
"""One performance is drawn out to this many times its usual length before it is done again."""

_SHORTEST = 4
"""Frames below which a performance has no beginning, middle and end."""


def progress_of(frames: int, nominal: int, repeats: bool) -> Float[np.ndarray, " frames"]:
    """c_t of `frames` model frames, (frames,) in 0..1.

    In training c_t runs from 0 at a clip's first frame to 1 at its last, so it says how far the performance is. Up to
    one and a half times the usual length `nominal`, a motion is one performance. A longer one is the same drawn out for
    an action that goes on (walking); one that is done once (a throw) is done again, as often as it fits.
    """
    nominal = max(_SHORTEST, nominal)
    if repeats or frames <= int(_SLOWEST * nominal):
        # a request shorter than usual shows the first part of the action at its own pace rather than a hurried whole
        return np.arange(frames) / max(1, max(frames, int(0.7 * nominal)) - 1)
    times = max(1, round(frames / nominal))
    bounds = np.linspace(0, frames, times + 1).round().astype(int)
    return np.concatenate([np.arange(b - a) / max(1, b - a - 1) for a, b in pairwise(bounds)])
