"""Codes become Motions."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from jaxtyping import Float, Int
from torch import Tensor

from engines.features.humanml3d import HUMANML3D
from engines.geometry.canonical import floor_height
from engines.motion import Motion
from engines.skeletons import SMPL22
from engines.text2motion.model import Text2Motion

FPS = HUMANML3D.fps
_NEAR_FLOOR = 0.1
"""Metres; a motion whose feet stay this near the floor stands on it, any other is up somewhere on purpose."""


@torch.no_grad()
def to_motions(
    codes: Float[Tensor, "B S C"], count: Int[Tensor, " B"], model: Text2Motion, frames: Sequence[int]
) -> list[Motion]:
    """Motions on `smpl22`, on the floor, facing +Z at first; all are decoded at once.

    Args:
        codes: padded.
        count: how many of each motion.
        model: whose codes they are.
        frames: how many of each motion are kept.
    """
    features = model.denormalised(model.decode(codes, count)).cpu().numpy()
    made = []
    for row, kept in zip(features, frames, strict=True):
        motion = HUMANML3D.decode(row[:kept], source="rotations")
        near = abs(floor_height(motion.positions, SMPL22)) < _NEAR_FLOOR
        made.append(motion.on_ground() if near else motion)
    return made
