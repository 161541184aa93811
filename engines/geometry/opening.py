"""Reference poses at the beginning of captures (a T-pose at the origin, say), which are no part of the motion."""

from __future__ import annotations

import numpy as np

from engines.motion import Motion

WITHIN = 0.1
"""A reference pose is left within this time, seconds."""
SPEED = 12.0
"""... by a joint faster than this, m/s, which no captured motion reaches that early."""


def opening(motion: Motion) -> int:
    """How many frames at the beginning are a reference pose, or a quick blend out of one; mostly none."""
    begun = motion[: 1 + round(WITHIN * motion.fps)]
    speed = np.linalg.norm(np.diff(begun.positions, axis=0), axis=-1).max(axis=1) * motion.fps
    quick = np.flatnonzero(speed > SPEED)
    return 1 + int(quick[-1]) if quick.size else 0
