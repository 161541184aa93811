"""Blends, sequences and ways on: what engines are asked, and what is refused, in words."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import engines
from engines.errors import FormatError, MotionloomError, OutOfRangeError
from studio import tasks
from studio.pinned import Kept, Pinned
from studio.settings import BLEND_STEPS, USUAL_FRAMES, GenerateSettings, Settings, parse_settings
from tests.studio.fakes import FakeEngine, sway

WALK = GenerateSettings(engine="action2motion", action="walk", seed=7, count=4, frames=40)
BLEND = replace(WALK, take=3, blend={"seed": 9, "take": 2, "share": 0.25})


class Varying(FakeEngine):
    """Tells what it is asked; in-betweens are at their number, metres aside."""

    capabilities = frozenset({"actions", "scale_bones", "interpolate", "transition", "outpaint"})

    def latents(self, action, seed=0, frames=60, index=0):
        return (action, seed, frames, index)

    def interpolate(self, action, a, b, steps=5):
        self.calls.append({"action": action, "a": a, "b": b, "steps": steps})
        return [sway(action, a[2]).moved((float(i), 0, 0)) for i in range(steps)]

    def transition(self, segments, seed=0):
        self.calls.append({"segments": segments, "seed": seed})
        return sway(frames=sum(frames for _, frames in segments), seed=seed)

    def outpaint(self, motion, action, *, keep, frames, count, seed):
        self.calls.append({"motion": motion, "action": action, "keep": keep, "frames": frames, "seed": seed})
        return [sway(action, frames, seed, index) for index in range(count)]


@pytest.fixture
def varying(monkeypatch) -> Varying:
    engine = Varying()
    monkeypatch.setattr(tasks, "load_engine", lambda _name, _variant="": engine)
    return engine


def start(frames: int = 8) -> Pinned:
    return Pinned(kept=(Kept.of(sway(frames=20), 0, frames, 0, "take 2"),))


def test_a_blend_asks_for_both_draws_and_takes_the_one_at_its_share(varying):
    (motion,) = tasks.generate(BLEND)
    assert varying.calls == [{"action": "walk", "a": ("walk", 7, 40, 2), "b": ("walk", 9, 40, 1), "steps": BLEND_STEPS}]
    assert motion.translation[0, 0] == pytest.approx(5.0)


def test_a_sequence_is_drawn_with_a_seed_each(varying):
    motions = tasks.generate(replace(WALK, then=(("run", 30), ("bow", 20)), count=2))
    parts = [("walk", 40), ("run", 30), ("bow", 20)]
    assert varying.calls == [{"segments": parts, "seed": 7}, {"segments": parts, "seed": 8}]
    assert [len(motion) for motion in motions] == [90, 90]
    (second,) = tasks.generate(replace(WALK, then=(("run", 30), ("bow", 20)), count=2, take=2))
    assert np.array_equal(second.rotations, motions[1].rotations)


def test_what_is_made_of_parts_has_a_length_also_where_none_is_said(varying):
    tasks.generate(replace(WALK, frames=None, then=(("run", 30),), count=1))
    tasks.generate(replace(BLEND, frames=None))
    tasks.between(replace(BLEND, frames=None))
    assert varying.calls[0]["segments"][0] == ("walk", USUAL_FRAMES)
    assert [call["a"][2] for call in varying.calls[1:]] == [USUAL_FRAMES] * 2


def test_a_start_is_gone_on_from_where_the_engine_knows_only_that(varying):
    motions = tasks.generate(replace(WALK, action="run", constraints=start(), count=3, frames=50))
    (call,) = varying.calls
    assert (call["action"], call["keep"], call["frames"], call["seed"], len(motions)) == ("run", 8, 50, 7, 3)
    assert call["motion"].label_at(0) == "take 2"
    np.testing.assert_allclose(call["motion"].positions, sway(frames=20)[:8].positions, atol=1e-5)


def test_proportions_reach_blends_and_sequences(varying):
    for asked in (BLEND, replace(WALK, then=(("run", 3),))):
        motion = tasks.generate(replace(asked, bone_scale={"left_knee": 1.2}))[0]
        ratio = motion.skeleton.offsets / np.where(sway().skeleton.offsets == 0, 1, sway().skeleton.offsets)
        assert ratio.max() == pytest.approx(1.2)


REFUSED = {
    "blend of a pinned motion": (replace(BLEND, constraints=start()), "what is pinned cannot be blended"),
    "blend of the best": (replace(BLEND, best_of=3), "the best of 3 draws cannot be blended"),
    "two at once": (replace(BLEND, then=(("run", 3),)), "a blend and a sequence of actions cannot be asked at once"),
    "pins and more": (replace(WALK, then=(("run", 3),), constraints=start()), "a sequence of actions cannot be asked"),
    "a pose in the middle": (
        replace(WALK, constraints=Pinned(kept=(Kept.of(sway(frames=20), 0, 1, 9),))), "takes no pins",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_is_refused_in_words(varying, case):
    asked, words = REFUSED[case]
    with pytest.raises(MotionloomError, match=words):
        tasks.generate(asked)


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        (BLEND, "fake cannot go over from one draw to another"),
        (replace(WALK, then=(("run", 3),)), "fake cannot change its action on the way"),
        (replace(WALK, constraints=start()), "fake takes no pins"),
    ],
)
def test_an_engine_that_cannot_is_named(engine, asked, words):
    with pytest.raises(MotionloomError, match=words):
        tasks.generate(asked)


BAD = [
    ({"blend": {"seed": 1, "take": 1}}, "blend is"),
    ({"blend": {"seed": 1, "take": 1, "share": 0.33}}, "in steps of 0.05"),
    ({"blend": {"seed": 1, "take": 1, "share": 1.5}}, "share of the blend is 1.5"),
    ({"blend": {"seed": -1, "take": 1, "share": 0.5}}, "seed of the blend"),
    ({"blend": {"seed": 1, "take": 1, "share": 0.5}, "take": None}, "which of the draw the blend begins with"),
    ({"then": (("run", 0),)}, "frames of an action that follows"),
    ({"then": (("run", 1),) * 33}, "number of actions that follow"),
]


@pytest.mark.parametrize(("changes", "words"), BAD)
def test_settings_that_say_nothing_sensible(changes, words):
    with pytest.raises(OutOfRangeError, match=words):
        replace(WALK, **{"take": 1, **changes})


def test_the_settings_file_holds_them():
    for asked in (BLEND, replace(WALK, then=(("run", 30), ("bow", 20)))):
        assert parse_settings(Settings(asked).to_json()).generate == asked
    with pytest.raises(FormatError, match=r"generate\.then holds"):
        parse_settings('{"generate": {"then": [["run", "30"]]}}')


@pytest.mark.parametrize("name", ["action2motion", "loom"])
def test_the_ends_of_a_blend_are_the_takes_themselves(name):
    """With the engines that ship, whichever of their draws the takes are."""
    if name not in engines.available():
        pytest.skip(f"{name} has no weights here")
    asked = replace(WALK, engine=name)
    draw = tasks.generate(asked)
    for share, place in ((0.0, 2), (1.0, 1)):
        (end,) = tasks.generate(replace(asked, take=3, blend={"seed": 7, "take": 2, "share": share}))
        np.testing.assert_allclose(end.positions, draw[place].positions, atol=1e-4)
    kept = Pinned(kept=(Kept.of(draw[0], 0, 20, 0, "take 1"),))
    for way in tasks.generate(replace(asked, constraints=kept, frames=50, count=2)):
        np.testing.assert_allclose(way.positions[:20], draw[0].positions[:20], atol=1e-4)


def test_the_command_line_says_what_follows(run, varying):
    code, _out, err = run("generate", "walk", "-n", "1", "--frames", "40", "--then", "turn left:30", "-f", "npz")
    assert (code, err) == (0, "")
    assert varying.calls[0]["segments"] == [("walk", 40), ("turn left", 30)]
    code, _out, err = run("generate", "walk", "--then", "run")
    assert (code, "ACTION:FRAMES, as in run:40" in err) == (1, True)
