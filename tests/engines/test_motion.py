"""Motion: what it checks, what it never changes, and what its operations mean."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engines.errors import OutOfRangeError, SkeletonError
from engines.geometry import rotations
from engines.motion import Motion, Provenance, Segment
from engines.skeletons import SMPL22, Skeleton

CALM = settings(deadline=None, max_examples=15)
LABELS = (
    Segment(0, 6, "action", "wave left hand"),
    Segment(6, 10, "action", "walk"),
    Segment(2, 8, "style", "elderly"),
)


def make(frames: int = 10, seed: int = 0, fps: float = 30.0, labels=LABELS, **changes) -> Motion:
    rng = np.random.default_rng(seed)
    turns = rotations.normalise(rotations.IDENTITY + rng.normal(size=(frames, 22, 4)) * 0.3)
    fields = {"skeleton": SMPL22, "rotations": turns, "translation": rng.normal(size=(frames, 3)), "fps": fps}
    return Motion(**{**fields, "labels": labels, **changes})


def test_arrays_are_copies_that_cannot_be_written() -> None:
    turns, path = np.tile(rotations.IDENTITY, (4, 22, 1)), np.zeros((4, 3))
    motion = Motion(SMPL22, turns, path, 30)
    turns[:], path[:] = 9, 9
    assert motion.rotations[0, 0].tolist() == [1, 0, 0, 0]
    assert not motion.translation.any()
    for array in (motion.rotations, motion.translation, motion.positions, motion.global_rotations):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0
    with pytest.raises(dataclasses.FrozenInstanceError):
        motion.fps = 20.0  # type: ignore[misc]
    assert turns.flags.writeable


@pytest.mark.parametrize(
    ("changes", "error", "message"),
    [
        ({"rotations": np.zeros((10, 21, 4))}, SkeletonError, r"accepted: \(frames, 22, 4\)"),
        ({"rotations": np.zeros((10, 22, 3))}, SkeletonError, r"rotations have shape \(10, 22, 3\)"),
        ({"translation": np.zeros((9, 3))}, SkeletonError, r"accepted: \(10, 3\)"),
        ({"rotations": np.zeros((0, 22, 4)), "translation": np.zeros((0, 3))}, OutOfRangeError, "1 or more"),
        ({"rotations": np.zeros((10, 22, 4))}, SkeletonError, "zero quaternions"),
        ({"rotations": np.full((10, 22, 4), np.nan)}, SkeletonError, "not finite"),
        ({"translation": np.full((10, 3), np.inf)}, SkeletonError, "not finite"),
        ({"fps": 0}, OutOfRangeError, "positive"),
        ({"fps": -30}, OutOfRangeError, "positive"),
        ({"fps": np.nan}, OutOfRangeError, "positive"),
    ],
)
def test_what_is_refused(changes: dict, error: type, message: str) -> None:
    with pytest.raises(error, match=message):
        make(**changes)


def test_quaternions_are_made_unit() -> None:
    motion = make(rotations=np.tile([2.0, 0, 0, 0], (10, 22, 1)))
    np.testing.assert_array_equal(motion.rotations, np.tile(rotations.IDENTITY, (10, 22, 1)))


def test_length_duration_and_words_for_people() -> None:
    motion = make(provenance=Provenance("walk.bvh"))
    assert len(motion) == motion.frames == 10
    assert motion.duration == pytest.approx(1 / 3)
    assert repr(motion) == "<Motion 10 frames at 30 fps (0.33 s), smpl22, wave left hand, walk, elderly, from walk.bvh>"


def test_label_at() -> None:
    motion = make()
    assert [motion.label_at(i) for i in (0, 5, 6, 9)] == ["wave left hand", "wave left hand", "walk", "walk"]
    assert motion.label_at(2, "style") == "elderly"
    assert motion.label_at(9, "style") is None
    assert motion.label_at(10) is None


@CALM
@given(st.integers(0, 9), st.integers(1, 10), st.integers(1, 3))
def test_a_slice_cuts_frames_and_labels_alike(start: int, stop: int, step: int) -> None:
    motion = make()
    if stop <= start:
        with pytest.raises(OutOfRangeError, match="1 or more frames"):
            motion[start:stop:step]
        return
    part = motion[start:stop:step]
    chosen = list(range(10))[start:stop:step]
    np.testing.assert_array_equal(part.rotations, motion.rotations[chosen])
    np.testing.assert_array_equal(part.positions, motion.positions[chosen])
    assert part.fps == motion.fps / step
    for kind in ("action", "style"):
        assert [part.label_at(i, kind) for i in range(len(part))] == [motion.label_at(i, kind) for i in chosen]
    assert all(s.end > s.start for s in part.labels)


def test_slices_of_other_kinds() -> None:
    motion = make()
    assert len(motion[-3:]) == 3
    with pytest.raises(TypeError, match=r"motion\[i:i\+1\]"):
        motion[3]  # type: ignore[index]
    with pytest.raises(OutOfRangeError):
        motion[::-1]


@CALM
@given(st.integers(2, 40), st.sampled_from([10.0, 20.0, 24.0, 60.0]), st.integers(0, 99))
def test_resampled_labels_are_those_of_the_moments_shown(frames: int, fps: float, seed: int) -> None:
    cut = 1 + seed % (frames - 1)
    labels = (Segment(0, cut, "action", "walk"), Segment(cut, frames, "action", "run"))
    motion = make(frames, seed, labels=labels)
    other = motion.resample(fps)
    assert other.fps == fps
    at = [min(int(np.floor(i * 30.0 / fps + 1e-6)), frames - 1) for i in range(len(other))]
    assert [other.label_at(i) for i in range(len(other))] == [motion.label_at(i) for i in at]
    assert all(0 <= s.start < s.end <= len(other) for s in other.labels)
    np.testing.assert_allclose(other.positions[0], motion.positions[0], atol=1e-9)


def test_resample_to_the_same_rate_and_to_none() -> None:
    motion = make()
    assert motion.resample(30.0) is motion
    for fps in (0.0, -5.0, np.inf):
        with pytest.raises(OutOfRangeError, match="positive"):
            motion.resample(fps)


def test_concat_puts_frames_and_labels_behind_each_other() -> None:
    a, b = make(10), make(6, seed=1, labels=(Segment(1, 4, "action", "jump"),))
    joined = a.concat(b, a)
    assert len(joined) == 26
    np.testing.assert_array_equal(joined.positions[10:16], b.positions)
    assert joined.labels == (
        *a.labels, Segment(11, 14, "action", "jump"), *(s.moved(16) for s in a.labels)
    )  # fmt: skip
    assert a.concat().labels == a.labels
    slow = make(9, seed=2, fps=15.0, labels=())
    assert len(a.concat(slow)) == 10 + 17, "brought to the first motion's rate"


def test_concat_refuses_another_skeleton() -> None:
    other = make().scale_bones({"*": 1.1})
    with pytest.raises(SkeletonError, match="retarget it first"):
        make().concat(other)


@CALM
@given(st.integers(0, 999))
def test_mirror_is_the_reflection_and_its_own_inverse(seed: int) -> None:
    motion = make(seed=seed)
    mirrored = motion.mirror()
    np.testing.assert_allclose(
        mirrored.positions, motion.positions[:, SMPL22.mirror_index] * np.array([-1, 1, 1]), atol=1e-12
    )
    assert mirrored.label_at(0) == "wave right hand"
    back = mirrored.mirror()
    np.testing.assert_array_equal(back.rotations, motion.rotations)
    np.testing.assert_array_equal(back.translation, motion.translation)
    assert back.labels == motion.labels


@CALM
@given(st.integers(0, 99), st.floats(-3, 3))
def test_moved_turns_about_the_origin_and_then_shifts(seed: int, yaw: float) -> None:
    offsets = np.array(SMPL22.offsets)
    offsets[0] = [0.3, 0.2, -0.1]
    motion = make(seed=seed, skeleton=SMPL22.replaced(offsets=offsets))
    moved = motion.moved((1.0, 2.0, 3.0), yaw)
    expected = rotations.rotate(rotations.yaw_quaternion(np.array(yaw)), motion.positions) + np.array([1.0, 2.0, 3.0])
    np.testing.assert_allclose(moved.positions, expected, atol=1e-9)


def test_in_place_keeps_height_and_turning() -> None:
    motion = make()
    still = motion.in_place()
    np.testing.assert_array_equal(still.translation[:, [0, 2]], np.tile(motion.translation[0, [0, 2]], (10, 1)))
    np.testing.assert_array_equal(still.translation[:, 1], motion.translation[:, 1])
    np.testing.assert_array_equal(still.rotations, motion.rotations)


def test_scale_bones_scales_bones_and_the_path_with_the_legs() -> None:
    motion = make()
    double = motion.scale_bones({"*": 2.0})
    np.testing.assert_allclose(double.positions, 2 * motion.positions, atol=1e-12)
    arm = motion.scale_bones({"left_wrist": 1.5})
    np.testing.assert_array_equal(arm.translation, motion.translation)
    elbow, wrist = SMPL22.index("left_elbow"), SMPL22.index("left_wrist")
    np.testing.assert_allclose(
        np.linalg.norm(arm.positions[:, wrist] - arm.positions[:, elbow], axis=-1), 1.5 * SMPL22.bone_lengths[wrist]
    )


def test_face_front_and_ground_are_those_of_geometry() -> None:
    front = make().face_front(3)
    assert np.sin(front.heading[3] / 2) == pytest.approx(0, abs=1e-9)
    np.testing.assert_allclose(front.positions[3, 0, [0, 2]], 0, atol=1e-9)


@CALM
@given(st.integers(0, 99))
def test_from_positions_is_exact(seed: int) -> None:
    motion = make(seed=seed)
    again = Motion.from_positions(motion.positions, SMPL22, 30.0, LABELS)
    np.testing.assert_allclose(again.positions, motion.positions, atol=1e-9)
    assert again.labels == LABELS


def test_labels_are_values() -> None:
    assert Segment(1, 2, "action", "walk") == Segment(1, 2, "action", "walk")
    assert Segment(1, 2, "action", "walk") != Segment(1, 2, "style", "walk")
    assert Segment(1, 2, "action", "walk").moved(3) == Segment(4, 5, "action", "walk")
    assert make().labelled("fast", "style").labels[-1] == Segment(0, 10, "style", "fast")


def test_provenance_travels_with_every_operation() -> None:
    made = Provenance("action2motion", "ab" * 32, "jump", 7, 3, {"frames": 60})
    motion = make(provenance=made)
    others = [motion[2:5], motion.resample(20), motion.concat(motion), motion.mirror(), motion.moved((1, 0, 0)),
              motion.in_place(), motion.on_ground(), motion.face_front(), motion.scale_bones({"*": 1.1})]  # fmt: skip
    assert all(other.provenance == made for other in others)
    assert made != dataclasses.replace(made, seed=8)


def test_operations_leave_the_motion_as_it_was() -> None:
    motion = make()
    before = (motion.rotations.tobytes(), motion.translation.tobytes(), motion.labels)
    motion.moved((1, 0, 0), 0.4)
    motion.mirror()
    motion.in_place()
    motion.face_front()
    motion.concat(motion)
    assert (motion.rotations.tobytes(), motion.translation.tobytes(), motion.labels) == before


def test_any_skeleton_will_do() -> None:
    rod = Skeleton("rod", ("a", "b"), (-1, 0), np.array([[0, 0, 0], [0, 1.0, 0]]))
    turns = np.tile(rotations.IDENTITY, (2, 2, 1))
    turns[1, 0] = rotations.rotvec_to_quaternion(np.array([0, 0, np.pi / 2]))
    motion = Motion(rod, turns, np.zeros((2, 3)), 10)
    np.testing.assert_allclose(motion.positions[:, 1], [[0, 1, 0], [-1, 0, 0]], atol=1e-12)
