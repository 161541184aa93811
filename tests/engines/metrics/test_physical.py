"""Physical figures of motions whose figures are known."""

from __future__ import annotations

import numpy as np
import pytest

from engines.errors import SkeletonError
from engines.geometry import canonical, rotations
from engines.metrics import physical
from engines.motion import Motion
from engines.skeletons import SMPL22, Skeleton


def stand(path: np.ndarray | None = None, frames: int = 30, fps: float = 20.0) -> Motion:
    """A T-pose, soles on y = 0, its root moved along `path` (T, 3)."""
    turns = np.tile(rotations.IDENTITY, (frames, 22, 1))
    height = canonical.toe_clearance(SMPL22) - SMPL22.rest_positions[SMPL22.index("left_foot"), 1]
    root = np.tile([0, height, 0], (frames, 1)) + (0 if path is None else path)
    return Motion(SMPL22, turns, root, fps)


def along(axis: int, values: np.ndarray) -> np.ndarray:
    path = np.zeros((30, 3))
    path[:, axis] = values
    return path


TIMES = np.arange(30) / 20.0


def test_a_still_stand_is_perfect() -> None:
    assert physical.summary(stand()) == pytest.approx(
        {"foot_skate": 0, "jitter": 0, "ground_penetration": 0, "floating": 0}, abs=1e-9
    )


@pytest.mark.parametrize("speed", [0.3, 1.0, 2.5])
@pytest.mark.parametrize("axis", [0, 2])
def test_a_stand_slid_along_the_floor_skates_at_its_speed(speed: float, axis: int) -> None:
    assert physical.foot_skate(stand(along(axis, speed * TIMES))) == pytest.approx(speed)


def test_skating_fades_with_height() -> None:
    slid = along(0, TIMES)
    at = [physical.foot_skate(stand(slid + np.array([0, height, 0]))) for height in (0, 0.0125, 0.025, 0.5)]
    assert at[0] == pytest.approx(1)
    assert at[1] == pytest.approx(2 - 2**0.5)
    assert at[2:] == pytest.approx([0, 0])


def test_going_up_and_down_is_no_skating() -> None:
    assert physical.foot_skate(stand(along(1, 0.02 * np.sin(TIMES)))) == 0


@pytest.mark.parametrize("depth", [0.01, 0.2])
def test_penetration_is_the_depth(depth: float) -> None:
    sunk = stand(along(1, np.full(30, -depth)))
    assert physical.ground_penetration(sunk) == pytest.approx(depth)
    assert physical.floating(sunk) == 0
    half = stand(along(1, np.where(np.arange(30) < 15, -depth, 0.0)))
    assert physical.ground_penetration(half) == pytest.approx(depth / 2)


def test_floating_is_the_height() -> None:
    raised = stand(along(1, np.full(30, 0.3)))
    assert physical.floating(raised) == pytest.approx(0.3)
    assert physical.ground_penetration(raised) == 0


def test_jitter_of_a_cubic_is_its_third_derivative() -> None:
    assert physical.jitter(stand(along(2, 0.7 * TIMES**3))) == pytest.approx(6 * 0.7)
    assert physical.jitter(stand(along(2, 3 * TIMES**2 - TIMES))) == pytest.approx(0, abs=1e-6)
    assert physical.jitter(stand(frames=3)) == 0


def test_one_frame_and_no_feet() -> None:
    assert physical.foot_skate(stand(frames=1)) == 0
    rod = Skeleton("rod", ("a", "b"), (-1, 0), np.array([[0, 0, 0], [0, 1.0, 0]]))
    motion = Motion(rod, np.tile(rotations.IDENTITY, (5, 2, 1)), np.full((5, 3), -2.0), 20.0)
    assert set(physical.summary(motion).values()) == {0.0}


@pytest.mark.parametrize(("speed", "found"), [(0.0, 0.0), (0.2, 0.2), (1.0, 0.0)])
def test_skating_in_contact_counts_only_contacts(speed: float, found: float) -> None:
    """A foot that glides fast is in contact with nothing, by the definition of contact."""
    slid = stand(along(0, speed * TIMES))
    assert physical.contact_skate(slid) == pytest.approx(found)
    assert slid.contacts.any() == (speed < 0.35)


def test_skating_in_contact_leaves_out_the_air() -> None:
    path = np.zeros((30, 3))
    path[15:] = [0, 0.5, 0] + np.arange(1, 16)[:, None] * np.array([0.2, 0, 0])
    assert physical.contact_skate(stand(path)) == pytest.approx(0, abs=1e-9)
    assert physical.contact_skate(stand(frames=1)) == 0


def test_bones_of_a_motion_are_rigid_and_stretched_ones_drift() -> None:
    motion = stand(along(0, TIMES))
    assert physical.bone_length_drift(motion.positions, SMPL22) == pytest.approx(0, abs=1e-12)
    stretched = np.array(motion.positions)
    hand = SMPL22.index("left_wrist")
    away = stretched[0, hand] - stretched[0, SMPL22.index("left_elbow")]
    swing = np.where(np.arange(30) % 3 == 0, 0.03, 0.0)  # the median is the length at rest
    stretched[:, hand] += swing[:, None] * away / np.linalg.norm(away)
    assert physical.bone_length_drift(stretched, SMPL22) == pytest.approx(0.03 / 3 / 21)
    point = Skeleton("point", ("a",), (-1,), np.zeros((1, 3)))
    assert physical.bone_length_drift(np.zeros((4, 1, 3)), point) == 0


@pytest.mark.parametrize("wrong", [np.zeros((5, 21, 3)), np.zeros((0, 22, 3)), np.full((5, 22, 3), np.nan), 3.0])
def test_wrong_positions_are_told(wrong) -> None:
    with pytest.raises(SkeletonError, match=r"accepted: finite numbers \(frames, 22, 3\)"):
        physical.bone_length_drift(wrong, SMPL22)


def test_a_table_has_its_own_units() -> None:
    motion = stand(along(0, 0.1 * TIMES))
    table = physical.table(motion, motion.positions * 1.0)
    assert table["foot_skate"] == pytest.approx(10)
    assert table["contact_skate"] == pytest.approx(10)
    assert table["bone_length_drift"] == pytest.approx(0, abs=1e-9)
    sunk = physical.table(stand(along(1, np.full(30, -0.02))))
    assert sunk["ground_penetration"] == pytest.approx(2)
    assert "bone_length_drift" not in sunk
