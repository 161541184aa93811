from __future__ import annotations

import numpy as np
import pytest

from engines import SMPL22
from engines.errors import MotionloomError, OutOfRangeError, UnknownLabelError
from studio import tasks
from studio.pinned import NOTHING, JointPin, Kept, Pinned
from studio.pinning import as_shown, parse_path
from studio.settings import GenerateSettings
from tests.studio.fakes import ConstrainedEngine, FakeEngine, sway

WAY = ((0.0, 0.0), (0.0, 2.0), (1.5, 2.0))


def pose(at: int = 30, source: str = "take 2") -> Kept:
    return Kept.of(sway(frames=60), at, at + 1, at, source)


def test_everything_pinned_is_listed_in_plain_words():
    own = Kept.of(sway(frames=60), 12, 13, 40, "walk.bvh")
    pinned = Pinned((Kept.of(sway(), 0, 21, 0, "take 1"), pose(), own), WAY, (JointPin("left_wrist", 40, (0, 1, 0)),))
    assert [words for _, words in pinned.listed(20.0)] == [
        "frames 0–20 of take 1", "pose of take 2 at 1.5 s", "pose of walk.bvh (its 0.6 s) at 2.0 s", "path of 3.5 m",
        "left wrist at 2.0 s",
    ]  # fmt: skip


def test_each_thing_listed_can_be_taken_away_alone():
    pinned = Pinned((pose(10), pose(20)), WAY, (JointPin("head", 1, (0, 1, 0)), JointPin("neck", 1, (0, 1, 0))))
    keys = [key for key, _ in pinned.listed(20.0)]
    assert len(set(keys)) == 5
    for key, words in pinned.listed(20.0):
        left = [text for _, text in pinned.without(key).listed(20.0)]
        assert left == [text for other, text in pinned.listed(20.0) if other != key], words
    assert pinned.without("nonsense 9") == pinned


def test_a_pose_gives_way_to_another_at_the_same_time_only():
    pinned = NOTHING.with_kept(pose(10, "take 1")).with_kept(pose(10, "take 2")).with_kept(pose(20, "take 3"))
    assert [kept.source for kept in pinned.kept] == ["take 2", "take 3"]
    pinned = pinned.with_kept(Kept.of(sway(), 0, 11, 0, "take 4")).with_kept(Kept.of(sway(), 0, 5, 0, "take 5"))
    assert [kept.source for kept in pinned.kept] == ["take 2", "take 3", "take 5"]
    place = NOTHING.with_pin(JointPin("head", 3, (0, 1, 0))).with_pin(JointPin("head", 3, (0, 2, 0)))
    assert [pin.position[1] for pin in place.pins] == [2.0]


def test_kept_frames_are_those_of_the_motion_at_the_engines_rate():
    motion = sway(frames=60).resample(40.0)
    kept = Kept.of(motion, 10, 15, 0, fps=20.0)
    again = kept.motion(20.0)
    assert (len(kept), kept.start) == (5, 10)
    np.testing.assert_allclose(again.positions, motion.positions[20:30:2], atol=2e-5)


def test_other_bone_lengths_come_onto_the_house_skeleton():
    tall = sway(frames=10).scale_bones({"left_knee": 1.3, "right_knee": 1.3})
    assert Kept.of(tall, 3, 4, 3).motion(20.0).skeleton == SMPL22


@pytest.mark.parametrize(("start", "stop"), [(-1, 2), (5, 5), (58, 61)])
def test_frames_that_are_not_there_are_named(start, stop):
    with pytest.raises(OutOfRangeError, match="0 to 59"):
        Kept.of(sway(frames=60), start, stop, 0, "take 1")


@pytest.mark.parametrize("points", [((0, 0), (0.1, 0.1)), ((1.0, 1.0),), ((0, 0),) * 5])
def test_a_path_too_short_to_go_is_refused(points):
    with pytest.raises(OutOfRangeError, match=r"length of the path .* 0\.3 m or more"):
        Pinned(path=points)


@pytest.mark.parametrize("text", ["", "0,0", "0,0 1", "0,0 a,b", "0 0 1 1", "0;0"])
def test_a_typed_path_says_how_it_is_written(text):
    with pytest.raises(OutOfRangeError, match="0,0 1,2 2,2"):
        parse_path(text)


def test_a_typed_path_with_blanks_and_signs():
    assert parse_path(" 0,0   -1.5,2e0 ") == ((0.0, 0.0), (-1.5, 2.0))


def test_a_joint_that_is_not_there_is_named_with_the_nearest():
    with pytest.raises(UnknownLabelError, match="left_wrist"):
        JointPin("left wirst", 0, (0, 1, 0))
    with pytest.raises(UnknownLabelError):
        JointPin("pelvis", 0, (0, 1, 0))


def test_the_engine_is_given_what_was_pinned():
    pinned = Pinned((pose(), Kept.of(sway(), 0, 11, 0)), WAY, (JointPin("head", 7, (0.1, 1.6, 0.2), 12),), True)
    given = pinned.to_engine(20.0)
    assert [(keep.at, len(keep.motion), keep.placed) for keep in given.kept] == [(30, 1, True), (0, 11, True)]
    np.testing.assert_allclose(given.kept[0].motion.positions[0], sway(frames=60).positions[30], atol=1e-5)
    np.testing.assert_array_equal(given.path.points, WAY)
    assert [(p.joint, p.frame, p.position, p.until) for p in given.pins] == [("head", 7, (0.1, 1.6, 0.2), 12)]
    assert given.loop


def test_an_engine_is_told_only_what_it_can_be_told():
    assert tasks.told(GenerateSettings(), FakeEngine()) == {}
    settings = GenerateSettings(action="", prompt="walk", style="old", guidance=1.0, constraints=Pinned(path=WAY))
    told = tasks.told(settings, ConstrainedEngine())
    assert told.keys() == {"prompt", "style", "guidance", "best_of", "constraints"}
    assert tasks.told(GenerateSettings(), ConstrainedEngine()) == {"guidance": 3.0, "best_of": 1}


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ({"style": "old"}, "takes no style"), ({"prompt": "hop"}, "takes no prompt"),
        ({"best_of": 2}, "best of several"), ({"guidance": 4.0}, "guidance"),
        ({"constraints": Pinned(loop=True)}, "takes no pins"),
    ],
)  # fmt: skip
def test_what_it_cannot_be_told_is_not_silently_left_out(asked, words):
    with pytest.raises(MotionloomError, match=words):
        tasks.told(GenerateSettings(**asked), FakeEngine())


def test_the_player_is_shown_line_poses_and_places():
    pinned = Pinned((Kept.of(sway(), 0, 41, 0), pose(50)), WAY, (JointPin("head", 7, (0.1, 1.6, 0.2)),))
    shown = as_shown(pinned, 20.0)
    assert [p["frame"] for p in shown["poses"]] == [0, 20, 40, 50]
    assert all(len(p["rotations"]) == 22 * 4 for p in shown["poses"])
    assert shown["stretches"] == [[0, 41]]
    assert shown["joints"] == [{"joint": "head", "frame": 7, "place": (0.1, 1.6, 0.2)}]
    assert shown["path"] == WAY
