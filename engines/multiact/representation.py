"""What the networks see of a motion: SMPL-H's 315 numbers a frame, fingers left out, places told as steps.

`features.smplh` says where the root is; far from the start its error of a centimetre a frame is a sliding foot. So the
floor place is told as the step from the frame before, and summed up again. Everything is in the face-front canonical
frame of the previous motion's last frame (the anchor: it faces +Z above the origin, heights are kept).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from engines.features.layout import Layout, Part
from engines.features.skeletons import SMPLH52
from engines.features.smplh import SMPLH_HOUSE
from engines.motion import Motion
from engines.skeletons import SMPL22

FPS = SMPLH_HOUSE.fps
LAYOUT = Layout((Part("rotations", (len(SMPL22), 6)), Part("height", (1,)), Part("step", (2,))))
D = LAYOUT.size
_HELD = np.array([SMPLH52.index(name) for name in SMPL22.joints])
_GROUND = [0, 2]


def encode(motion: Motion, anchor: int | None = None) -> np.ndarray:
    """A Motion of two frames or more as (T, D) float32.

    Args:
        motion: any.
        anchor: the frame, at 20 a second, that is to face +Z above the origin; if none, the motion is left as it
            stands, because one of its frames does.
    """
    features = SMPLH_HOUSE.encode(motion, anchor)
    slopes = features[:, : 6 * len(SMPLH52)].reshape(len(features), -1, 6)
    place = SMPLH_HOUSE.layout.read(features, "translation")
    step = np.diff(place[:, _GROUND], axis=0, prepend=2 * place[:1, _GROUND] - place[1:2, _GROUND])
    return LAYOUT.join(rotations=slopes[:, _HELD], height=place[:, 1:2], step=step)


def decode(values: np.ndarray) -> Motion:
    """(T, D) that follow an anchor -> Motion in the anchor's canonical frame."""
    parts = LAYOUT.split(values)
    slopes = np.tile(np.array([1, 0, 0, 0, 1, 0], np.float32), (len(values), len(SMPLH52), 1))
    slopes[:, _HELD] = parts["rotations"]
    ground = summed(parts["step"])
    place = np.stack([ground[:, 0], parts["height"][:, 0], ground[:, 1]], axis=-1)
    features = SMPLH_HOUSE.layout.join(root_rotation=slopes[:, 0], rotations=slopes[:, 1:], translation=place)
    return SMPLH_HOUSE.decode(features, source="rotations")


def summed(step: Any) -> Any:
    """Steps (..., T, 2) after the anchor -> places on the floor (..., T, 2); NumPy or torch."""
    return step.cumsum(-2)
