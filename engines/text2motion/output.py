"""Codes become Motions."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from jaxtyping import Float, Int
from torch import Tensor

from engines.features.codec import joints_of
from engines.features.humanml3d import HUMANML3D
from engines.geometry.canonical import floor_height
from engines.motion import Motion
from engines.skeletons import SMPL22
from engines.text2motion.model import LAYOUT, Text2Motion

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
    features = LAYOUT.check(model.denormalised(model.decode(codes, count)).cpu().numpy())
    turns, path, _ = HUMANML3D.decode_arrays(features, source="rotations")
    joints = joints_of(turns, path, SMPL22)
    made = []
    for row, kept in enumerate(frames):
        floor = floor_height(joints[row, :kept], SMPL22)
        if abs(floor) < _NEAR_FLOOR:
            path[row, :, 1] -= floor
        made.append(Motion(SMPL22, turns[row, :kept], path[row, :kept], FPS))
    return made
