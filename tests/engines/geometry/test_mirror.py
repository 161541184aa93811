"""Left for right: reflections, words, and rigs that cannot be mirrored."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engines.errors import SkeletonError
from engines.formats import bvh
from engines.geometry import mirror
from engines.motion import Motion
from engines.skeletons import SMPL22, Skeleton


def test_words_trade_sides_and_keep_capitals() -> None:
    pairs = [
        ("wave left hand", "wave right hand"),
        ("Left foot, then the right.", "Right foot, then the left."),
        ("draw circle clockwise", "draw circle counterclockwise"),
        ("he left-turns", "he right-turns"),
    ]
    for text, mirrored in pairs:
        assert mirror.mirror_words(text) == mirrored
        assert mirror.mirror_words(mirrored) == text
    for unsided in ("walk", "leftover", "bright", "squat"):
        assert mirror.mirror_words(unsided) == unsided


def test_the_house_skeleton_is_its_own_mirror_image() -> None:
    assert mirror.asymmetry(SMPL22).max() < 1e-12


def test_bones_along_x_are_refused_with_the_joint_named() -> None:
    offsets = np.array([[0, 0, 0], [0.5, 0, 0], [0.4, 0.2, 0.1], [0.4, -0.2, 0.1]])
    rig = Skeleton(
        "rig", ("hips", "head", "arm_l", "arm_r"), (-1, 0, 0, 0), offsets, mirror_pairs=(("arm_l", "arm_r"),)
    )
    motion = Motion(rig, np.tile([1.0, 0, 0, 0], (2, 4, 1)), np.zeros((2, 3)), 30.0)
    with pytest.raises(SkeletonError, match=r"'rig' cannot be mirrored.*'head' is 1.00 m off.*retarget"):
        motion.mirror()


def test_a_body_uneven_by_a_centimetre_may_be_mirrored() -> None:
    offsets = np.array(SMPL22.offsets)
    offsets[SMPL22.index("left_knee"), 1] -= 0.01
    uneven = SMPL22.replaced(offsets=offsets)
    motion = Motion(uneven, np.tile([1.0, 0, 0, 0], (1, 22, 1)), np.zeros((1, 3)), 30.0)
    reflected = motion.positions[:, uneven.mirror_index] * np.array([-1, 1, 1])
    assert np.abs(motion.mirror().positions - reflected).max() < 0.011


@pytest.mark.data
def test_a_cmu_rig_mirrors_and_bandai_namcos_does_not(real_clips: Path) -> None:
    motion = bvh.read(real_clips / "cmu/bvh/26_01.bvh")[1:40]
    reflected = motion.positions[:, motion.skeleton.mirror_index] * np.array([-1, 1, 1])
    assert np.abs(motion.mirror().positions - reflected).max() < 0.05
    rig = bvh.read(next(real_clips.rglob("dataset-1_walk_normal_001.bvh")))
    with pytest.raises(SkeletonError, match="cannot be mirrored"):
        rig.mirror()
