"""The time counter c_t: how much of an action is done (thesis section 3.2.1, eq. 3.7)."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

_BAND = (0.3, 0.7)
"""An action that goes on stays within this part of itself until its last stretch."""
_SLOWEST = 1.5
"""One performance is drawn out to this many times its usual length before it is done again."""

_SHORTEST = 4
"""Frames below which a performance has no beginning, middle and end."""


def progress_of(frames: int, nominal: int, repeats: bool) -> np.ndarray:
    """c_t of `frames` model frames, (frames,) in 0..1.

    In training c_t runs from 0 at a clip's first frame to 1 at its last, so it says how far the performance is. Up to
    one and a half times the usual length `nominal`, a motion is one performance. A longer one is, for an action that
    goes on (walking), a beginning, a middle in which c_t sways, and an end; one that is done once (a throw) is done
    again, as often as it fits.
    """
    nominal = max(_SHORTEST, nominal)
    if frames <= int(_SLOWEST * nominal):
        # a request shorter than usual shows the first part of the action at its own pace rather than a hurried whole
        return np.arange(frames) / max(1, max(frames, int(0.7 * nominal)) - 1)
    if repeats:
        return _swaying(frames, nominal)
    times = max(1, round(frames / nominal))
    bounds = np.linspace(0, frames, times + 1).round().astype(int)
    return np.concatenate([np.arange(b - a) / max(1, b - a - 1) for a, b in pairwise(bounds)])


def _swaying(frames: int, nominal: int) -> np.ndarray:
    low, high = _BAND
    head, tail = int(low * nominal), int((1 - high) * nominal)
    rise = np.arange(head) / nominal
    middle = frames - head - tail
    phase = np.arange(middle) / (nominal * (high - low)) % 2.0
    sway = low + (high - low) * np.where(phase < 1, phase, 2 - phase)
    end = sway[-1] + (1 - sway[-1]) * (np.arange(tail) + 1) / tail
    return np.concatenate([rise, sway, end])
