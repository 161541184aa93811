"""What is pinned, as the network is told it; what cannot be, in words."""

from __future__ import annotations

import math

import numpy as np
import pytest

from engines.errors import MotionloomError, OutOfRangeError, UnknownLabelError
from engines.loom.constraints import Constraints, Keep, Known, Path, Pin, compile_known
from engines.loom.known import PARTS, draw
from engines.loom.representation import KNOWN, LAYOUT, frames_of
from engines.skeletons import SMPL22
from tests.engines.action2motion.tiny import movement

MEAN, STD = np.zeros(LAYOUT.size, dtype=np.float32), np.ones(LAYOUT.size, dtype=np.float32)


def compiled(constraints: Constraints, frames: int = 60, **options: float) -> Known:
    return compile_known(constraints, frames, MEAN, STD, **options)


def part(known: Known, name: str) -> np.ndarray:
    return KNOWN.read(known.facts.numpy(), name)


def test_kept_frames_start_the_motion_where_they_stand() -> None:
    motion = movement(12)
    known = compiled(Constraints(kept=(Keep(motion),)))
    found = frames_of(motion)
    assert (known.start.yaw, tuple(known.start.ground)) == (float(found.yaw[0]), tuple(found.ground[0]))
    assert part(known, "turns_known")[:12].all() and not part(known, "turns_known")[12:].any()
    np.testing.assert_allclose(part(known, "turns")[:12], found.turns, atol=1e-6)
    np.testing.assert_allclose(part(known, "ground")[0], 0, atol=1e-6)
    np.testing.assert_allclose(part(known, "facing")[0], [1, 0], atol=1e-6)
    moved = np.linalg.norm(found.ground[11] - found.ground[0])
    assert np.linalg.norm(part(known, "ground")[11]) == pytest.approx(moved, abs=1e-5)


def test_a_part_of_the_body_is_kept_without_its_place() -> None:
    known = compiled(Constraints(kept=(Keep(movement(60), parts=("left arm",)),)))
    assert sorted(np.flatnonzero(part(known, "turns_known")[0])) == sorted(PARTS["left arm"])
    assert not part(known, "ground_known").any() and not part(known, "height_known").any()


def test_a_path_is_followed_from_its_first_point_the_way_it_goes() -> None:
    known = compiled(Constraints(path=Path(np.array([[1.0, 2.0], [4.0, 2.0]]))))
    assert known.start.yaw == pytest.approx(math.pi / 2)  # along +X
    ground = part(known, "ground")
    np.testing.assert_allclose(ground[[0, -1]], [[0, 0], [0, 3]], atol=1e-5)  # ahead is +Z as seen from the start
    assert part(known, "ground_known").all() and not known.unmet
    backward = compiled(Constraints(path=Path(np.array([[1.0, 2.0], [4.0, 2.0]]))), facing=math.pi)
    np.testing.assert_allclose(part(backward, "ground")[-1], [0, -3], atol=1e-5)


def test_waypoints_are_known_at_their_frames_only() -> None:
    known = compiled(Constraints(path=Path(np.array([[0.0, 0], [0, 1], [1, 1]]), (0, 20, 59))))
    assert np.flatnonzero(part(known, "ground_known")[:, 0]).tolist() == [0, 20, 59]


def test_the_path_of_a_motion_there_is_may_be_as_fast_as_it_was() -> None:
    points, at = np.array([[0.0, 0.0], [0.0, 0.4]]), (0, 1)  # 8 m/s
    with pytest.raises(MotionloomError, match="nobody here runs faster"):
        compiled(Constraints(path=Path(points, at)), 30)
    told = compiled(Constraints(path=Path(points, at, recorded=True)), 30)
    assert not told.unmet


def test_a_path_faster_than_anyone_runs_is_cut_short_and_said_so() -> None:
    known = compiled(Constraints(path=Path(np.array([[0.0, 0], [0, 100]]))))
    assert part(known, "ground")[-1, 1] == pytest.approx(7.0 * 59 / 20, abs=1e-3)
    assert "100.0 m long" in known.unmet[0] and "33.9 m/s" in known.unmet[0]


def test_a_pose_under_the_floor_is_set_on_it_and_said_so() -> None:
    sunk = movement(1).moved((0.0, -5.0, 0.0))
    known = compiled(Constraints(kept=(Keep(sunk, 30),)))
    low = movement(1).positions[..., 1].min()
    assert part(known, "height")[30, 0] == pytest.approx(float(movement(1).positions[0, 0, 1] - low), abs=1e-4)
    assert "frame 30" in known.unmet[0] and "under the floor" in known.unmet[0]


def test_a_pin_is_seen_from_the_start() -> None:
    start = Keep(movement(1).moved((3.0, 0.0, -2.0), yaw=1.0))
    x, _, z = start.motion.positions[0, 0]
    known = compiled(Constraints(kept=(start,), pins=(Pin("left_wrist", 10, (float(x), 1.2, float(z)), 15),)))
    column = SMPL22.index("left_wrist") - 1
    assert np.flatnonzero(part(known, "joints_known")[:, column]).tolist() == [10, 11, 12, 13, 14]
    np.testing.assert_allclose(part(known, "joints")[10, column], [0, 1.2, 0], atol=1e-5)


@pytest.mark.parametrize(
    ("constraints", "error", "said"),
    [
        (Constraints(pins=(Pin("left_wing", 0, (0, 1, 0)),)), UnknownLabelError, "left_wrist"),
        (Constraints(pins=(Pin("head", 60, (0, 1, 0)),)), OutOfRangeError, "from 0 to 60"),
        (Constraints(pins=(Pin("head", 1, (0, math.nan, 0)),)), OutOfRangeError, "finite"),
        (Constraints(kept=(Keep(movement(3), 60),)), OutOfRangeError, "0 to 59"),
        (Constraints(kept=(Keep(movement(3), 0, ("tail",)),)), UnknownLabelError, "head"),
        (Constraints(path=Path(np.zeros((1, 2)))), OutOfRangeError, "two or more points"),
        (Constraints(path=Path(np.zeros((2, 2)), (5, 5))), OutOfRangeError, "rising"),
        (Constraints(path=Path(np.array([[0, 0], [0, 50.0]]), (0, 20))), MotionloomError, "50.0 m/s"),
        (Constraints(kept=(Keep(movement(5)), Keep(movement(5, seed=4), 2))), MotionloomError, "two different poses"),
    ],
)
def test_what_cannot_be_is_refused_in_words(constraints: Constraints, error: type, said: str) -> None:
    with pytest.raises(error, match=said):
        compiled(constraints)


def test_places_too_far_apart_are_named() -> None:
    far = Keep(movement(1).moved((40.0, 0.0, 0.0)), 20)
    assert "frame 0 to 20" in compiled(Constraints(kept=(Keep(movement(1)), far))).unmet[0]


def test_training_masks_stay_within_their_windows_and_leave_the_rest_alone() -> None:
    lengths = np.random.default_rng(0).integers(8, 57, 400)
    masks = draw(np.random.default_rng(1), lengths, 64, 0.5)
    beyond = np.arange(64) >= lengths[:, None]
    told = np.zeros(len(lengths), dtype=bool)
    for name in ("turns", "height", "ground", "facing", "joints"):
        held = getattr(masks, name).reshape(len(lengths), 64, -1)
        assert not held[beyond].any(), name
        assert held.any(), name
        told |= held.any(axis=(1, 2))
    assert 0.4 < told.mean() < 0.6


def test_a_pose_far_away_is_walked_to_from_where_it_can_be_reached() -> None:
    far, near = (Keep(movement(1).moved((x, 0.0, 0.0)), 40) for x in (50.0, 0.3))
    begun = compiled(Constraints(kept=(far,)))
    place = frames_of(far.motion).ground[0]
    assert np.linalg.norm(place - begun.start.ground) == pytest.approx(1.2 * 2.0, abs=1e-3)
    assert not begun.unmet
    assert tuple(compiled(Constraints(kept=(near,))).start.ground) == (0.0, 0.0)
