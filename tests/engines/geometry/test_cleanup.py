"""Feet that stand are held: on made motions, where it is known what is right, and on real ones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from engines.errors import SkeletonError
from engines.geometry import rotations
from engines.geometry.cleanup import plant_feet, travel_on_feet
from engines.motion import Motion
from engines.skeletons import SMPL22
from tests.engines.action2motion.tiny import movement

LEGS = {SMPL22.index(f"{side}_{name}") for side in ("left", "right") for name in ("hip", "knee", "ankle")}
FEET = [SMPL22.index(name) for foot in SMPL22.feet for name in foot]


def sliding(frames: int = 40, bent: float = 0.4, speed: float = 0.2) -> Motion:
    """Knees a little bent, the whole body gliding sideways over the floor."""
    turns = np.tile(np.array([1.0, 0, 0, 0]), (frames, len(SMPL22), 1))
    for side in ("left", "right"):
        for name, angle in (("hip", -bent), ("knee", 2 * bent), ("ankle", -bent)):
            turns[:, SMPL22.index(f"{side}_{name}")] = rotations.rotvec_to_quaternion(np.array([angle, 0.0, 0.0]))
    path = np.zeros((frames, 3))
    path[:, 0] = speed * np.arange(frames) / 20
    path[:, 1] = 0.9
    return Motion(SMPL22, turns, path, 20.0).on_ground()


def test_a_gliding_body_gets_standing_feet() -> None:
    before = sliding(24)
    after = plant_feet(before)
    feet = after.positions[:, FEET]
    assert np.ptp(feet[2:-2, :, [0, 2]], axis=0).max() < 0.004
    assert np.ptp(before.positions[:, FEET, 0], axis=0).max() > 0.1
    np.testing.assert_allclose(after.translation, before.translation)


def test_only_legs_bend_and_bones_keep_their_length() -> None:
    before, held = movement(30), np.zeros((30, 2, 2), dtype=bool)
    held[10:20] = True
    after = plant_feet(before, held)
    others = [i for i in range(len(SMPL22)) if i not in LEGS]
    assert np.abs(np.abs((after.rotations * before.rotations).sum(-1)[:, others]) - 1).max() < 1e-9
    # feet keep their own direction in the world
    for toe in ("left_foot", "right_foot"):
        np.testing.assert_allclose(
            after.global_rotations[:, SMPL22.index(toe)], before.global_rotations[:, SMPL22.index(toe)], atol=1e-6
        )


def test_far_from_any_contact_nothing_changes() -> None:
    before = movement(60).moved((0.0, 3.0, 0.0))  # above the floor throughout
    held = np.zeros((60, 2, 2), dtype=bool)
    held[25:35, 0] = True
    after = plant_feet(before, held, fade=0.3)
    gap = np.abs(after.positions - before.positions).max((1, 2))
    assert gap[:15].max() < 1e-6 and gap[45:].max() < 1e-6 < gap[25:35].max()
    assert np.abs(np.diff(gap)).max() < 0.5 * gap.max()  # it comes and goes gently


def test_no_foot_stays_under_the_floor() -> None:
    before = sliding(20, speed=0.0).moved((0.0, -0.07, 0.0))
    after = plant_feet(before)
    assert before.positions[:, FEET, 1].min() < 0
    standing = SMPL22.rest_positions[FEET, 1].min()
    assert after.positions[:, FEET, 1].min() > 0.0 > standing


def test_nothing_to_hold_is_left_alone() -> None:
    before = movement(20).moved((0.0, 5.0, 0.0))
    after = plant_feet(before, np.zeros((20, 2, 2), dtype=bool))
    np.testing.assert_allclose(after.positions, before.positions, atol=1e-9)
    assert after.labels == before.labels and after.provenance == before.provenance


def test_a_leg_that_cannot_reach_gives_way() -> None:
    before = sliding(40, bent=0.1, speed=4.0)  # far faster than a leg is long
    after = plant_feet(before, np.ones((40, 2, 2), dtype=bool))
    assert np.isfinite(after.positions).all()
    bones = np.linalg.norm(after.positions[:, SMPL22.index("left_knee")] - after.positions[:, 1], axis=-1)
    np.testing.assert_allclose(bones, bones[0], atol=1e-9)


def test_a_skeleton_without_feet_is_refused() -> None:
    bare = replace(movement(5), skeleton=replace(SMPL22, feet=()))
    with pytest.raises(SkeletonError, match="no feet"):
        plant_feet(bare)


def test_a_body_goes_where_its_standing_feet_call_for() -> None:
    """Poses with deeper knees, on a path that glides: feet that stood in what they were made of stand again."""
    given = sliding(40, bent=0.4, speed=0.0)
    made = sliding(40, bent=0.7, speed=0.2).moved((0.0, 0.2, 0.0))
    after = travel_on_feet(made, given)
    assert given.contacts.all()
    np.testing.assert_allclose(after.rotations, made.rotations)
    np.testing.assert_allclose(np.ptp(after.positions[:, FEET][..., [0, 2]], axis=0), 0.0, atol=1e-6)
    np.testing.assert_allclose(after.positions[:, FEET, 1].mean(), given.positions[:, FEET, 1].mean(), atol=1e-6)


def test_what_nothing_was_done_to_and_what_flies_keep_their_path() -> None:
    given = movement(40)
    np.testing.assert_allclose(travel_on_feet(given, given).translation, given.translation, atol=1e-9)
    flying = sliding(40, speed=0.2).moved((0.0, 3.0, 0.0))
    made = sliding(40, bent=0.7, speed=0.5).moved((0.0, 3.0, 0.0))
    np.testing.assert_allclose(travel_on_feet(made, flying).translation, made.translation)
    with pytest.raises(SkeletonError, match="was not made of one of"):
        travel_on_feet(made, made.scale_bones({"left_knee": 1.2}))
    footless = made.replaced(skeleton=replace(SMPL22, feet=()))
    with pytest.raises(SkeletonError, match="no feet to stand on"):
        travel_on_feet(footless, footless)
