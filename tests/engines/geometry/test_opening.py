"""Reference poses at the beginning of a capture."""

from __future__ import annotations

import numpy as np
import pytest

from engines.geometry.opening import opening
from engines.motion import Motion
from engines.skeletons import SMPL22
from tests.engines.action2motion.tiny import movement


def opened(motion: Motion, frames: int) -> Motion:
    """The motion with its skeleton's rest pose, half in the floor, in front of it."""
    rest = np.zeros((frames, len(SMPL22), 4))
    rest[..., 0] = 1.0
    return motion.replaced(
        rotations=np.concatenate([rest, motion.rotations]),
        translation=np.concatenate([np.zeros((frames, 3)), motion.moved((0.0, 0.9, 2.0)).translation]),
        labels=(),
    )


@pytest.mark.parametrize("frames", [1, 2])
def test_a_reference_pose_is_told(frames):
    assert opening(opened(movement(30), frames)) == frames


def test_a_motion_is_left_alone():
    assert opening(movement(30)) == 0
    assert opening(movement(30)[:1]) == 0
