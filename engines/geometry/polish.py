"""Small changes of a whole motion, applied or left out without loss: smoothed, or ending as it began."""

from __future__ import annotations

import math

import numpy as np
from jaxtyping import Float
from scipy.ndimage import gaussian_filter1d

from engines.errors import OutOfRangeError, SkeletonError
from engines.geometry import rotations
from engines.motion import Motion


def smooth(motion: Motion, seconds: float = 0.08) -> Motion:
    """The motion without its trembling; the first and the last pose stay as they are.

    Args:
        motion: any.
        seconds: standard deviation of the Gaussian that rotations and the root path are averaged with; what lasts much
            longer than that stays.

    Raises:
        OutOfRangeError: `seconds` is not above 0.
    """
    _demand(seconds)
    if len(motion) < 3:
        return motion
    sigma = seconds * motion.fps
    turns = _averaged(rotations.continuous(motion.rotations), sigma)
    return motion.replaced(rotations=rotations.normalise(turns), translation=_averaged(motion.translation, sigma))


def _averaged(values: Float[np.ndarray, " T *rest"], sigma: float) -> Float[np.ndarray, " T *rest"]:
    """Weighted means over time; at the ends what lies beyond is the inside turned about the end, which so stays."""
    margin = math.ceil(4 * sigma)
    beyond = [(margin, margin), *[(0, 0)] * (values.ndim - 1)]
    padded = np.pad(values, beyond, mode="reflect", reflect_type="odd")
    return gaussian_filter1d(padded, sigma, axis=0, mode="nearest")[margin : margin + len(values)]


def close_loop(motion: Motion, seconds: float = 0.5) -> Motion:
    """The motion ending in the pose it began with, so that it can be played again and again.

    Facing and place on the floor go on: a walk still walks away; `Motion.in_place` besides keeps it on the spot.

    Args:
        motion: any.
        seconds: over so much of its end (at most half of it) the pose goes over into the first.

    Raises:
        OutOfRangeError: `seconds` is not above 0.
    """
    _demand(seconds)
    fade = min(max(2, round(seconds * motion.fps)), len(motion) // 2)
    if fade < 1:
        return motion
    x = np.arange(1, fade + 1) / (fade + 1)  # the frame after the last one would be the first again
    share = x * x * (3 - 2 * x)
    first, last = motion.rotations[0].copy(), motion.rotations[-1]
    first[0] = rotations.multiply(rotations.yaw_quaternion(_turned(motion)), first[0])
    gap = rotations.quaternion_to_rotvec(rotations.multiply(first, rotations.invert(last)))
    turns, path = motion.rotations.copy(), motion.translation.copy()
    steps = rotations.rotvec_to_quaternion(share[:, None, None] * gap)
    turns[-fade:] = rotations.multiply(steps, turns[-fade:])
    path[-fade:, 1] += share * (path[0, 1] - path[-1, 1])
    return motion.replaced(rotations=turns, translation=path)


def _turned(motion: Motion) -> float:
    """By how much the body has turned about the vertical, radians; 0 where nobody can say how it faces."""
    try:
        return float(motion.heading[-1] - motion.heading[0])
    except SkeletonError:
        return 0.0


def _demand(seconds: float) -> None:
    if not (math.isfinite(seconds) and seconds > 0):
        raise OutOfRangeError("seconds", seconds, "a number above 0")
