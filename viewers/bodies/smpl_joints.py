"""What all bodies of the SMPL family share: the house skeleton's joints are their first 22."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from engines.geometry.skins import strongest
from engines.skeletons import SMPL22
from engines.skeletons.skeleton import Skeleton

COUNT = len(SMPL22)


def house_skeleton(name: str, places: np.ndarray) -> Skeleton:
    """The house skeleton with its joints at `places` (22, 3) of a rest pose, the pelvis at the origin."""
    parents = np.array(SMPL22.parents)
    offsets = np.asarray(places, np.float64) - np.where(parents[:, None] >= 0, places[parents], places[:1])
    return SMPL22.replaced(name=name, offsets=offsets)


def folded(weights: np.ndarray, parents: Sequence[int]) -> tuple[np.ndarray, np.ndarray]:
    """Weights (V, J) of all joints onto the first 22: fingers go to the wrist, jaw and eyes to the head.

    Returns:
        Joints (V, 4) and weights (V, 4), the strongest four.
    """
    home = np.arange(len(parents))
    for joint in range(COUNT, len(parents)):
        home[joint] = home[parents[joint]]
    full = np.zeros((len(weights), COUNT))
    np.add.at(full.T, home, weights.T)
    return strongest(full)
