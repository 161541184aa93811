"""The right answers of our features, at the points where the released code's are wrong."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engines import features
from engines.action2motion import representation
from engines.errors import OutOfRangeError
from engines.features import official, official_humanml3d
from engines.features.humanml3d import HUMANML3D
from engines.features.lie import LIE
from engines.features.official_humanml3d import OfficialHumanML3D
from engines.features.official_smplh import SMPLH_OFFICIAL
from engines.features.smplh import SMPLH_HOUSE
from engines.geometry import rotations
from engines.skeletons import SMPL22
from tests.engines.features.movement import apart, spinning, swinging, turned

RELEASED: OfficialHumanML3D = official_humanml3d.HUMANML3D


def path_error(joints: np.ndarray, wanted: np.ndarray) -> float:
    """Largest distance of a joint, metres, of two bodies both canonical at their first frame."""
    return float(np.linalg.norm(joints - wanted[: len(joints)], axis=-1).max())


@settings(max_examples=15, deadline=None)
@given(st.floats(-3.1, 3.1), st.floats(-3.1, 3.1))
def test_yaw_velocity_is_the_whole_angle(rate: float, begin: float) -> None:
    made = HUMANML3D.encode(spinning(6, rate, begin))
    np.testing.assert_allclose(HUMANML3D.layout.read(made, "yaw_velocity"), rate, atol=1e-5)


def test_the_release_keeps_half_the_angle() -> None:
    made = RELEASED.features_of(spinning(240, 0.01).positions)
    middle = RELEASED.layout.read(made, "yaw_velocity")[100:140]  # away from the ends, which the smoothing bends
    np.testing.assert_allclose(np.abs(middle), 0.005, rtol=0.02)
    ours = HUMANML3D.layout.read(HUMANML3D.encode(spinning(240, 0.01)), "yaw_velocity")
    np.testing.assert_allclose(ours, 0.01, atol=1e-6)


def test_a_body_that_turns_through_minus_z_comes_back() -> None:
    """Three turns on the spot: every heading, -z among them."""
    motion = spinning(150, 0.13)
    back = HUMANML3D.decode(HUMANML3D.encode(motion), source="rotations", start=HUMANML3D.start(motion))
    assert apart(back, motion) < 1e-4
    joints = RELEASED.canonical(motion.positions)
    assert path_error(RELEASED.recover_positions(RELEASED.features_of(joints)), joints) > 0.1, "the release does not"
    quarter = RELEASED.canonical(spinning(150, 0.01).positions)
    assert path_error(RELEASED.recover_positions(RELEASED.features_of(quarter)), quarter) < 1e-4, "short of -z it does"


def test_hips_and_shoulders_that_turn_against_each_other_cancel_out() -> None:
    """The heading of a body whose hips turn one way and whose shoulders the other is in between, not beyond."""
    motion = spinning(4, 0.0)
    turns = np.array(motion.rotations)
    twist = rotations.yaw_quaternion(np.array(0.4))
    turns[:, 0] = twist
    turns[:, SMPL22.index("spine1")] = rotations.invert(rotations.multiply(twist, twist))
    twisted = motion.replaced(rotations=turns)
    ours = float(HUMANML3D.start(twisted).yaw)
    assert -0.4 < ours < 0.4
    places = RELEASED._clips(twisted.positions)
    heading = RELEASED.headings(np.concatenate([places, places], axis=-1), smoothing=0.0)[..., -1]
    released = -2 * np.arctan2(heading[2, 0], heading[0, 0])
    assert released < -0.4, "the release looks further than its shoulders do"


def test_every_step_is_in_the_heading_of_its_own_frame() -> None:
    """A body that walks ahead while it turns has no sideways velocity, however fast it turns."""
    motion = spinning(40, 0.3)
    yaw = 0.3 * np.arange(40)
    steps = 0.05 * np.stack([np.sin(yaw), np.zeros(40), np.cos(yaw)], axis=-1)
    walk = motion.replaced(translation=motion.translation + np.cumsum(steps, axis=0) - steps)
    velocity = HUMANML3D.layout.read(HUMANML3D.encode(walk), "root_velocity")
    np.testing.assert_allclose(velocity[:-1], np.tile([0.0, 0.05], (39, 1)), atol=1e-6)


def test_rotations_hold_the_heading_once() -> None:
    """Of a body that turns and does nothing else, rotations stay; the release's first joints turn with it."""
    ours = HUMANML3D.layout.read(HUMANML3D.encode(spinning(60, 0.05)), "rotations")
    assert np.ptp(ours, axis=0).max() < 1e-5
    released = RELEASED.layout.read(RELEASED.features_of(spinning(60, 0.05).positions), "rotations")
    assert np.ptp(released[1:], axis=0).max() > 0.5


def test_twists_come_back_from_the_rotations_and_not_from_the_positions() -> None:
    motion = spinning(5, 0.0)
    turns = np.array(motion.rotations)
    wrist = SMPL22.index("left_wrist")
    turns[:, wrist] = rotations.rotvec_to_quaternion(np.array([0.8, 0.0, 0.0]))
    motion = motion.replaced(rotations=turns)
    made = HUMANML3D.encode(motion)
    assert turned(HUMANML3D.decode(made, source="rotations"), motion).max() < 1e-3
    assert turned(HUMANML3D.decode(made, source="positions"), motion)[wrist] == pytest.approx(0.8, abs=1e-3)


def test_three_frames_are_as_many_as_any_other() -> None:
    """The release takes one cross product along time if there are three frames; ours knows no such number."""
    motion = swinging(0, frames=5)
    whole = HUMANML3D.encode(motion)
    np.testing.assert_allclose(HUMANML3D.encode(motion[:3])[:2, :-4], whole[:2, :-4], atol=1e-6)
    joints = motion.positions
    three = RELEASED.rotations(RELEASED._clips(joints[:3]), RELEASED.headings(RELEASED._clips(joints[:3]))[:, None])
    many = RELEASED.rotations(RELEASED._clips(joints), RELEASED.headings(RELEASED._clips(joints))[:, None])
    assert np.abs(three[:, 4:] - many[:, 4:, :, :3]).max() > 0.1


def test_released_features_of_many_clips_are_as_of_each() -> None:
    joints = np.stack([swinging(seed, frames=12).positions for seed in range(4)]).reshape(2, 2, 12, 22, 3)
    made = RELEASED.features_of(RELEASED.uniform(joints, RELEASED.offsets))
    assert made.shape == (2, 2, 11, 263)
    alone = RELEASED.features_of(RELEASED.uniform(joints[1, 0], RELEASED.offsets))
    np.testing.assert_allclose(made[1, 0], alone, atol=1e-6)
    np.testing.assert_allclose(RELEASED.recover_positions(made)[1, 0], RELEASED.recover_positions(alone), atol=1e-6)


@pytest.mark.parametrize("name", ["humanml3d-official", "kit-official", "style-official"])
def test_released_dialects_speak_motion(name: str) -> None:
    """Poses come back on the house skeleton within what two bodies of other proportions differ by."""
    codec = features.get(name)
    motion = swinging(4, frames=40)
    made = codec.encode(motion)
    wanted = motion.resample(codec.fps)
    assert made.shape == (len(wanted) - 1, codec.layout.size)
    for source in codec.sources:
        back = codec.decode(made, source=source, start=codec.start(motion))
        assert back.skeleton == SMPL22
        centred = [m.positions[: len(made)] - m.positions[: len(made), :1] for m in (back, wanted)]
        away = np.linalg.norm(centred[0] - centred[1], axis=-1)
        assert np.median(away) < 0.12, source
    with pytest.raises(OutOfRangeError, match="frames"):
        codec.encode(motion[:1])


def test_lie_features_are_what_the_engine_is_trained_on() -> None:
    motion = swinging(7, turning=0.3)
    made, wanted = LIE.encode(motion), representation.encode(motion)
    read = LIE.layout.read
    np.testing.assert_allclose(read(made, "rotations"), wanted.lie, atol=1e-6)
    np.testing.assert_allclose(made[:, :3], wanted.velocity, atol=1e-6)
    np.testing.assert_allclose(read(made, "root_height"), wanted.height, atol=1e-6)
    np.testing.assert_array_equal(read(made, "contacts"), wanted.contacts)
    turns, path = representation.decode(wanted.height, wanted.matrices, wanted.velocity)
    back = LIE.decode(made, source="rotations")
    np.testing.assert_allclose(back.translation, path, atol=1e-5)
    np.testing.assert_allclose(np.abs((back.rotations * turns).sum(-1)), 1, atol=1e-6)


def test_face_front_canonicalisation_keeps_the_ground() -> None:
    motion = swinging(9, turning=0.1)
    made = SMPLH_HOUSE.encode(motion, anchor=5)
    back = SMPLH_HOUSE.decode(made, source="rotations")
    assert back.heading[5] == pytest.approx(0, abs=1e-5)
    np.testing.assert_allclose(back.positions[..., 1], motion.positions[..., 1], atol=1e-5)
    np.testing.assert_allclose(back.rotations[:, 1:], SMPLH_HOUSE.fitted(motion).rotations[:, 1:], atol=1e-4)
    assert np.abs(back.positions[5, 0, [0, 2]]).max() < 1e-5
    fingers = SMPLH_HOUSE.layout.read(made, "rotations")[:, 21:]
    assert (fingers == [1, 0, 0, 0, 1, 0]).all()


def test_what_the_release_writes_it_does_not_read() -> None:
    motion = swinging(10)
    made = SMPLH_OFFICIAL.encode(motion)
    turns, path = SMPLH_OFFICIAL.decode_input(made)
    np.testing.assert_allclose(path, motion.translation, atol=1e-5)
    assert rotations.angle(rotations.multiply(rotations.invert(turns), motion.rotations)).max() < 2e-3
    assert turned(SMPLH_OFFICIAL.decode(made, source="rotations"), motion).max() > 1
    height = SMPLH_OFFICIAL.layout.read(made, "translation")[:, 2]
    np.testing.assert_allclose(height, motion.translation[:, 1], atol=1e-5, err_msg="Z is up")


def test_every_representation_of_ours_with_a_dialect_has_its_layout() -> None:
    for name, dialect in official.CODECS.items():
        assert dialect.layout.names == features.get(name).layout.names
        assert dialect.fps == features.get(name).fps
