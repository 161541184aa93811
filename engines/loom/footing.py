"""Steps as long as the feet call for: a body moves over the ground by what the feet that stand on it fall back."""

from __future__ import annotations

import numpy as np
import torch
from jaxtyping import Float
from scipy.ndimage import gaussian_filter1d

from engines.loom.representation import LAYOUT, kinematics
from engines.skeletons import SMPL22

SWAYS, STANDS = 0.3, 0.7
"""Contact up to which a foot says nothing of where the body goes, and from which it has the last word."""
EASE = 1.5
"""Deviation, frames, over which a body goes over from its own velocity to that of its feet."""
_POINTS = [SMPL22.index(name) for foot in SMPL22.feet for name in foot]


def on_feet(features: Float[np.ndarray, "T D"]) -> Float[np.ndarray, "T D"]:
    """Features (T, D), not normalised, with the velocity at which feet in contact stay where they are.

    Where no foot stands the velocity keeps what it is; poses, turning and contacts are not changed.
    """
    if len(features) < 2:
        return features
    turns, height = (torch.from_numpy(LAYOUT.read(features, name)) for name in ("turns", "height"))
    feet = kinematics(turns, height).numpy()[:, _POINTS]
    velocity, contacts = LAYOUT.read(features, "velocity"), LAYOUT.read(features, "contacts")
    cos, sin = np.cos(velocity[1:, 2, None]), np.sin(velocity[1:, 2, None])
    x, z = feet[1:, :, 0], feet[1:, :, 2]
    fallen = feet[:-1][..., [0, 2]] - np.stack([cos * x + sin * z, cos * z - sin * x], axis=-1)
    share = np.clip((np.minimum(contacts[1:], contacts[:-1]) - SWAYS) / (STANDS - SWAYS), 0.0, 1.0)
    mean = (fallen * share[..., None]).sum(axis=1) / np.maximum(share.sum(axis=1), 1e-6)[:, None]
    change = share.max(axis=1)[:, None] * (mean - velocity[1:, :2])
    moved = np.array(features)
    LAYOUT.read(moved, "velocity")[1:, :2] += gaussian_filter1d(change, EASE, axis=0, mode="nearest")
    return moved
