"""Is a motion physically plausible: sliding feet, jitter, feet through the floor.

Smaller is better; real clips are not at 0.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from engines.errors import SkeletonError
from engines.geometry import canonical
from engines.geometry.contacts import joint_speed
from engines.motion import Motion
from engines.skeletons.skeleton import Skeleton

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


def jerk(motion: Motion) -> Float[np.ndarray, "N J"]:
    """(T - 3, J) size of the third derivative of joint positions, m/s^3; of four frames or more."""
    return np.linalg.norm(np.diff(motion.positions, n=3, axis=0), axis=-1) * motion.fps**3


def jitter(motion: Motion) -> float:
    """Mean size of the third derivative of joint positions, m/s^3, over joints and frames; 0 below four frames."""
    if len(motion) < 4:
        return 0.0
    return float(jerk(motion).mean())


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


def contact_skate(motion: Motion) -> float:
    """Mean horizontal speed, m/s, of foot joints over the frames in which they are in contact; 0 without contacts.

    Contact is `Motion.contacts`, which a joint that slides faster than `contacts.SPEED_LIMIT` loses: a foot that glides
    like a skater's shows in `foot_skate`, not here.

    Source: generative stylization, table 5.7 of the thesis ("foot skating").
    """
    feet, _ = _feet(motion)
    touching = motion.contacts.reshape(len(motion), -1)
    if not touching.any() or len(motion) < 2:
        return 0.0
    return float(joint_speed(feet[..., [0, 2]], motion.fps)[touching].mean())


def bone_length_drift(positions: Float[np.ndarray, "T J 3"], skeleton: Skeleton) -> float:
    """Mean distance, metres, of each bone's length from its own median over the frames.

    For what a network gives as joint positions; the bones of a Motion are rigid, so of `motion.positions` it is 0.

    Args:
        positions: (T, J, 3), metres.
        skeleton: says which joints a bone joins.

    Raises:
        SkeletonError: another number of joints, or positions that are not finite.
    """
    places = np.asarray(positions, dtype=np.float64)
    if places.ndim != 3 or len(places) == 0 or places.shape[1:] != (len(skeleton), 3) or not np.isfinite(places).all():
        raise SkeletonError(
            f"positions have shape {places.shape}; accepted: finite numbers (frames, {len(skeleton)}, 3)."
        )
    children = [joint for joint, parent in enumerate(skeleton.parents) if parent >= 0]
    if not children:
        return 0.0
    parents = [skeleton.parents[joint] for joint in children]
    lengths = np.linalg.norm(places[:, children] - places[:, parents], axis=-1)
    return float(np.abs(lengths - np.median(lengths, axis=0)).mean())


def summary(motion: Motion) -> dict[str, float]:
    """The figures by which the studio judges a take, SI units."""
    return {
        "foot_skate": foot_skate(motion),
        "jitter": jitter(motion),
        "ground_penetration": ground_penetration(motion),
        "floating": floating(motion),
    }


def table(motion: Motion, positions: Float[np.ndarray, "T J 3"] | None = None) -> dict[str, float]:
    """The figures in the units of a table (`protocol.METRICS`): cm/s, cm, mm and m/s^3.

    Args:
        motion: judged.
        positions: (T, J, 3) the joints a network gave before they became this motion, metres; with them the drift of
            the bone lengths is told too.
    """
    figures = {
        "foot_skate": 100 * foot_skate(motion),
        "contact_skate": 100 * contact_skate(motion),
        "jitter": jitter(motion),
        "ground_penetration": 100 * ground_penetration(motion),
        "floating": 100 * floating(motion),
    }
    if positions is not None:
        figures["bone_length_drift"] = 1000 * bone_length_drift(positions, motion.skeleton)
    return figures


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
