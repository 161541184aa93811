"""What holds for every representation of ours: exact round trips, batches, streams, placing."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engines import features
from engines.errors import OutOfRangeError
from engines.features import Codec, Start, heading
from engines.features.heading import HeadingCodec
from engines.geometry import retarget
from engines.skeletons import SMPL22
from tests.engines.features.movement import apart, stepping, swinging, turned

OURS = ("humanml3d", "kit", "style", "smplh", "lie")
HOUSE = ("humanml3d", "style", "smplh", "lie")
"""Those that need no retargeting, which is slow."""
FEW = settings(max_examples=6, deadline=None)


@pytest.mark.parametrize("name", OURS)
def test_a_motion_comes_back_where_it_was(name: str) -> None:
    codec = features.get(name)
    motion = codec.fitted(swinging(5, turning=0.2))
    made = codec.encode(motion)
    assert made.shape == (len(motion), codec.layout.size)
    assert made.dtype == np.float32
    for source in codec.sources:
        back = codec.decode(made, source=source, start=codec.start(motion))
        assert back.fps == codec.fps
        assert back.skeleton == codec.skeleton
        assert apart(back, motion) < 2e-5
        assert ((back.rotations[1:] * back.rotations[:-1]).sum(-1) > 0).all(), "signs jump"
    joints = codec.positions(made, codec.start(motion))
    assert np.abs(joints - motion.positions).max() < 2e-5


@FEW
@given(st.integers(0, 2**31), st.floats(-2.5, 2.5))
def test_rotations_come_back_with_their_twists(seed: int, turning: float) -> None:
    for name in HOUSE:
        codec = features.get(name)
        motion = codec.fitted(swinging(seed, frames=9, turning=turning))
        back = codec.decode(codec.encode(motion), source="rotations", start=codec.start(motion))
        kept = [joint for joint, part in enumerate(motion.skeleton.joints) if name != "style" or part[:5] != "spine"]
        assert turned(back, motion)[kept].max() < 2e-3, name  # the style features leave out one joint of the spine
        assert apart(back, motion) < 2e-5, name


@pytest.mark.parametrize("name", HOUSE)
def test_many_clips_at_once_are_as_each_by_itself(name: str) -> None:
    codec = features.get(name)
    motions = [codec.fitted(swinging(seed, turning=0.1)) for seed in range(6)]
    turns = np.stack([m.rotations for m in motions]).reshape(2, 3, -1, 22, 4)
    path = np.stack([m.translation for m in motions]).reshape(2, 3, -1, 3)
    made = codec.encode_arrays(turns, path)
    alone = np.stack([codec.encode(motion) for motion in motions])
    np.testing.assert_allclose(made.reshape(alone.shape), alone, atol=1e-6)
    starts = [codec.start(motion) for motion in motions]
    yaw = np.array([start.yaw for start in starts]).reshape(2, 3)
    ground = np.array([start.ground for start in starts]).reshape(2, 3, 2)
    back, root, after = codec.decode_arrays(made, source="rotations", start=Start(yaw, ground))
    np.testing.assert_allclose(root, path, atol=1e-5)
    assert np.abs((back * turns).sum(-1)).min() > 0.99999 or name == "style"
    assert np.shape(after.yaw) == (2, 3) or name == "smplh"
    joints = codec.positions(made, Start(yaw, ground))
    assert np.abs(joints.reshape(6, -1, 22, 3)[4] - motions[4].positions).max() < 2e-5


@pytest.mark.parametrize("name", HOUSE)
def test_a_stream_gives_the_same_features_and_the_same_motion(name: str) -> None:
    codec = features.get(name)
    motion = codec.fitted(swinging(3, frames=31, turning=0.15))
    cuts = [(0, 7), (7, 20), (20, len(motion))]
    whole = codec.encode(motion)
    if isinstance(codec, HeadingCodec):
        feet = codec.layout.read(whole, "contacts")
        parts = []
        for a, b in cuts:
            one = slice(a, b + 1)  # with the first frame of the next stretch, where there is one
            made = codec.encode_arrays(motion.rotations[one], motion.translation[one], feet[one])
            parts.append(made[: b - a])
        np.testing.assert_allclose(np.concatenate(parts), whole, atol=1e-6)
    start, turns, path = codec.start(motion), [], []
    for a, b in cuts:
        one, root, start = codec.decode_arrays(whole[a:b], source="rotations", start=start)
        turns.append(one)
        path.append(root)
    np.testing.assert_allclose(np.concatenate(path), motion.translation, atol=2e-5)
    once, _, _ = codec.decode_arrays(whole, source="rotations", start=codec.start(motion))
    np.testing.assert_allclose(np.abs((np.concatenate(turns) * once).sum(-1)), 1, atol=1e-6)


@pytest.mark.parametrize("name", ["humanml3d", "style"])
def test_long_clips_are_cut_where_nobody_sees(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    codec = features.get(name)
    motion = codec.fitted(swinging(4, frames=40, turning=0.1))
    whole = codec.encode(motion)
    for block in (2, 7, 13):
        monkeypatch.setattr(heading, "BLOCK", block)
        np.testing.assert_allclose(codec.encode(motion), whole, atol=1e-6)
        back = codec.decode(whole, source="rotations", start=codec.start(motion))
        assert apart(back, motion) < 2e-5


@pytest.mark.parametrize("name", ["humanml3d", "style", "lie"])
def test_where_a_body_stands_and_faces_is_left_out(name: str) -> None:
    codec = features.get(name)
    motion = codec.fitted(swinging(8, turning=0.1))
    moved = motion.moved(yaw=2.7).moved((3.0, 0.0, -9.0))
    np.testing.assert_allclose(codec.encode(moved), codec.encode(motion), atol=2e-5)
    back = codec.decode(codec.encode(moved), source="rotations")
    assert abs(back.positions[0, 0, [0, 2]]).max() < 1e-6


@pytest.mark.parametrize("name", ["humanml3d", "style", "lie"])
def test_contacts_are_those_of_the_motion(name: str) -> None:
    codec = features.get(name)
    walk = codec.fitted(stepping())
    wanted = walk.contacts.reshape(len(walk), -1)
    assert 0.3 < wanted.mean() < 0.9, "a test of nothing"
    np.testing.assert_array_equal(codec.layout.read(codec.encode(walk), "contacts"), wanted)


@pytest.mark.parametrize("name", OURS)
def test_one_frame_is_a_motion_too(name: str) -> None:
    codec = features.get(name)
    motion = codec.fitted(swinging(2, frames=1))
    made = codec.encode(motion)
    assert made.shape == (1, codec.layout.size)
    for part in ("yaw_velocity", "root_velocity", "velocities"):
        if part in codec.layout.slices:
            assert not codec.layout.read(made, part).any()
    assert apart(codec.decode(made, source="rotations", start=codec.start(motion)), motion) < 2e-5


def test_another_rate_and_another_skeleton_are_brought_to_the_codecs() -> None:
    fast = swinging(6, frames=61, fps=60.0)
    assert features.get("humanml3d").encode(fast).shape == (21, 263)
    kit = features.get("kit")
    on_kit = retarget.retarget(fast.resample(12.5), kit.skeleton)
    np.testing.assert_allclose(kit.encode(fast), kit.encode(on_kit), atol=1e-5)
    back = features.get("humanml3d").encode(on_kit.retarget(SMPL22).resample(20.0))
    assert back.shape[1] == 263


@pytest.mark.parametrize("name", ["smplh", "lie"])
def test_without_positions_there_is_no_source_of_that_name(name: str) -> None:
    codec = features.get(name)
    with pytest.raises(OutOfRangeError, match="'rotations' for"):
        codec.decode(np.zeros((2, codec.layout.size)), source="positions")


@pytest.mark.parametrize("name", OURS)
def test_features_that_are_none_are_refused(name: str) -> None:
    codec = features.get(name)
    for bad in (np.zeros((3, codec.layout.size + 1)), np.zeros((2, 3, codec.layout.size))):
        with pytest.raises(OutOfRangeError, match="shape of the features"):
            codec.decode(bad, source="rotations")
    with pytest.raises(OutOfRangeError, match="finite"):
        codec.decode(np.full((3, codec.layout.size), np.inf), source="rotations")


@pytest.mark.parametrize("name", ["humanml3d", "kit", "style", "smplh"])
def test_features_of_nobody_still_give_a_motion(name: str) -> None:
    """An untrained network's output has to be shown, not crash the studio."""
    codec: Codec = features.get(name)
    rng = np.random.default_rng(0)
    noise = rng.normal(size=(6, codec.layout.size)).astype(np.float32)
    for values in (noise, np.zeros_like(noise)):
        for source in codec.sources:
            assert np.isfinite(codec.decode(values, source=source).positions).all()
