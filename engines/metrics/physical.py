"""Is a motion physically plausible: sliding feet, jitter, feet through the floor.

Smaller is better; real clips are not at 0.
"""

from __future__ import annotations

import numpy as np

from engines.geometry import canonical
from engines.geometry.contacts import joint_speed
from engines.motion import Motion

NEAR_FLOOR = 0.025
"""Height above where a foot joint stands at which sliding no longer counts, metres (Zhang et al. 2018, MANN)."""


def foot_skate(motion: Motion) -> float:
    """Mean horizontal speed of foot joints, m/s, weighted by height h: 2 - 2^(h / H), 1 on the floor, 0 from H up.

    Source: Zhang, Starke, Komura, Saito 2018, "Mode-adaptive neural networks for quadruped motion control", section 8.
    """
    feet, standing = _feet(motion)
    if not feet.size or len(motion) < 2:
        return 0.0
    weight = np.clip(2.0 - 2.0 ** (np.maximum(feet[..., 1] - standing, 0.0) / NEAR_FLOOR), 0.0, 1.0)
    return float((joint_speed(feet[..., [0, 2]], motion.fps) * weight).mean())


def jitter(motion: Motion) -> float:
    """Mean size of the third derivative of joint positions, m/s^3, over joints and frames; 0 below four frames."""
    if len(motion) < 4:
        return 0.0
    return float(np.linalg.norm(np.diff(motion.positions, n=3, axis=0), axis=-1).mean() * motion.fps**3)


def ground_penetration(motion: Motion) -> float:
    """Mean depth, metres, by which the lowest foot joint sinks below where it would stand on the floor y = 0."""
    feet, standing = _feet(motion)
    if not feet.size:
        return 0.0
    return float(np.maximum(0.0, standing - feet[..., 1]).max(axis=1).mean())


def floating(motion: Motion) -> float:
    """Mean height, metres, of the lowest foot joint above where it would stand; jumps raise it, so does hovering."""
    feet, standing = _feet(motion)
    if not feet.size:
        return 0.0
    return float(np.maximum(0.0, feet[..., 1] - standing).min(axis=1).mean())


def summary(motion: Motion) -> dict[str, float]:
    """All figures of this module by name."""
    return {
        "foot_skate": foot_skate(motion),
        "jitter": jitter(motion),
        "ground_penetration": ground_penetration(motion),
        "floating": floating(motion),
    }


REAL = {"foot_skate": 0.042, "jitter": 76.8, "ground_penetration": 0.0018, "floating": 0.0108}
"""The same figures of real motion capture: means over the 406 held-out clips of the prepared data at 20 fps."""


def _feet(motion: Motion) -> tuple[np.ndarray, np.ndarray]:
    """Foot joints (T, N, 3) and the height (N,) at which each stands: flat, its sole on the floor."""
    skeleton = motion.skeleton
    names = [name for foot in skeleton.feet for name in foot]
    if not names:
        return np.zeros((len(motion), 0, 3)), np.zeros(0)
    joints = [skeleton.index(name) for name in names]
    rest = skeleton.rest_positions[joints, 1]
    standing = rest - rest.min() + canonical.toe_clearance(skeleton)
    return motion.positions[:, joints], standing
