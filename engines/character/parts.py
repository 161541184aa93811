"""Joints of the house skeleton taken together, as skin, clothes and correspondences need them."""

from __future__ import annotations

import numpy as np
from jaxtyping import Int

from engines.skeletons.smpl22 import SMPL22

LONG = ("shoulder", "elbow", "wrist", "hip", "knee")
"""Endings of joints whose segment has a direction of its own; the others stand upright."""
_ARM, _LEG, _FOOT = ("shoulder", "elbow", "wrist"), ("hip", "knee", "ankle", "foot"), ("ankle", "foot")


def _numbers(segments: bool) -> Int[np.ndarray, " J"]:
    names = []
    for joint in SMPL22.joints:
        side, _, kind = joint.rpartition("_")
        if segments and kind in _ARM + _LEG:
            names.append(f"{side} foot" if kind in _FOOT else joint)
        elif kind in _ARM + _LEG:
            names.append(f"{side} arm" if kind in _ARM else f"{side} leg")
        else:
            names.append("head" if joint == "head" else "trunk")
    first = {name: names.index(name) for name in names}
    return np.array([first[name] for name in names])


SEGMENTS = _numbers(segments=True)
"""(J,) the first joint of each joint's segment: head, trunk with neck and collars, both feet, and every long bone."""
LIMBS = _numbers(segments=False)
"""(J,) the first joint of each joint's limb: head, trunk, both arms, both legs."""
