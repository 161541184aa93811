"""Sampling a motion at another rate."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from engines.geometry import rotations


def count(frames: int, fps: float, new_fps: float) -> int:
    """How many frames there are at another rate: floor((frames - 1) * new_fps / fps) + 1."""
    return int(np.floor((frames - 1) * new_fps / fps + 1e-6)) + 1


def resample(
    turns: Float[np.ndarray, "T J 4"], path: Float[np.ndarray, "T 3"], fps: float, new_fps: float
) -> tuple[Float[np.ndarray, "N J 4"], Float[np.ndarray, "N 3"]]:
    """Rotations (T, J, 4) by slerp and root path (T, 3) linearly from `fps` to `new_fps`.

    The new frames start at the first frame and stay within the last; N is `count(T, fps, new_fps)`.
    """
    if len(turns) == 1:
        return np.array(turns), np.array(path)
    times = np.arange(len(turns)) / fps
    new_times = np.minimum(np.arange(count(len(turns), fps, new_fps)) / new_fps, times[-1])
    new_path = np.stack([np.interp(new_times, times, path[:, axis]) for axis in range(3)], axis=-1)
    return rotations.slerp(times, turns, new_times), new_path
