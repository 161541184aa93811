"""What a session makes of takes: blends, another action, other ways on."""

from __future__ import annotations

from dataclasses import replace

import pytest

from studio import tasks
from studio.session import Session
from studio.settings import BLEND_STEPS, GenerateSettings
from studio.varying import PICTURES, alone, apart
from tests.studio.fakes import sway
from tests.studio.test_variations import Varying


@pytest.fixture
def varied(engine, queue, settle, monkeypatch):
    """A session with four takes of an engine that can do everything, on the tab of variations."""
    fake = Varying()
    monkeypatch.setattr(tasks, "load_engine", lambda _name, _variant="": fake)
    session = Session(queue=queue)
    session.start()
    settle(session)
    session.state.compose_tab = "vary"
    session.fake = fake
    fake.calls.clear()
    yield session
    session.close()


def ids(session) -> list[str]:
    return [take.id for take in session.takes]


def test_two_takes_chosen_bring_what_lies_between(varied, settle):
    state = varied.state
    state.blend_from = "take-3"
    assert (state.preview, varied.fake.calls) == ((), [])
    state.blend_to = "take-2"
    assert state.blending
    settle(varied)
    assert not state.blending
    assert state.blend_ready
    assert [call["steps"] for call in varied.fake.calls] == [BLEND_STEPS]
    assert (varied.fake.calls[0]["a"], varied.fake.calls[0]["b"]) == (("walk", 7, 60, 2), ("walk", 7, 60, 1))
    assert [name for name, _ in state.preview] == ["Take 3", "50 % of the way", "Take 2"]
    assert [motion.translation[0, 0] for _, motion in state.preview] == [0, 10, 20]
    assert len(state.blend_strip) == PICTURES
    state.blend_share = 0.2
    assert state.preview[1][0] == "20 % of the way"
    assert state.preview[1][1].translation[0, 0] == 4
    assert len(varied.fake.calls) == 1, "worked out once"


def test_what_is_kept_is_a_take_that_can_be_made_again(varied, settle):
    state = varied.state
    state.param.update(blend_from="take-1", blend_to="take-4", blend_share=0.35)
    settle(varied)
    varied.varying.keep()
    settle(varied)
    take = varied.takes.get("take-5")
    assert state.selected == "take-5"
    assert state.preview == (), "the take itself is shown"
    assert take.settings.blend == {"seed": 7, "take": 4, "share": 0.35}
    assert (take.settings.seed, take.settings.take) == (7, 1)
    (again,) = tasks.generate(take.settings)
    assert (again.translation == take.motion.translation).all()
    assert "foot_skate" in take.metrics
    state.blend_share = 0.6
    assert state.preview[1][0] == "60 % of the way", "the slider shows the blend again"
    varied.varying.keep()
    settle(varied)
    assert ids(varied)[-1] == "take-6"
    varied.again("take-5")
    settle(varied)
    assert len(varied.takes) == 6, "a blend has no other seed"


def test_nothing_chosen_nothing_kept(varied, settle):
    varied.varying.keep()
    settle(varied)
    assert len(varied.takes) == 4


def test_the_preview_goes_with_the_tab_and_comes_back(varied, settle):
    state = varied.state
    state.param.update(blend_from="take-1", blend_to="take-4")
    settle(varied)
    assert state.preview
    state.compose_tab = "action"
    assert state.preview == ()
    state.compose_tab = "vary"
    state.blend_share = 0.1
    assert state.preview
    varied.select("take-2")
    assert state.preview == ()
    varied.delete("take-4")
    assert (state.blend_ready, state.blend_strip) == (False, [])


def test_others_chosen_meanwhile_are_worked_out_next(varied, settle):
    state = varied.state
    state.param.update(blend_from="take-1", blend_to="take-4")
    state.blend_to = "take-2"
    settle(varied)
    assert [name for name, _ in state.preview] == ["Take 1", "50 % of the way", "Take 2"]


def test_an_engine_that_cannot_blend_says_so(varied, settle, monkeypatch):
    monkeypatch.setattr(Varying, "capabilities", frozenset({"actions", "outpaint"}))
    varied.state.param.update(blend_from="take-1", blend_to="take-4")
    settle(varied)
    assert varied.state.blend_problem.startswith("fake cannot go over from one draw to another")
    assert not varied.state.blend_ready


def test_takes_that_do_not_go_together_are_named(varied, settle):
    varied.state.action = "jump"
    varied.generate()
    settle(varied)
    (imported,) = varied.takes.add([sway()], group="f", source="walk.bvh")
    one, jump = varied.takes.get("take-1"), varied.takes.get("take-5")
    assert apart(one, jump) == ("Take 1 and take 5 are of different actions; a blend is between two draws of the same.")
    assert apart(one, one) == "Choose two takes."
    assert alone(imported) == "Take 9 was imported; only what an engine drew can be blended."
    assert imported not in varied.varying.sources()
    varied.state.param.update(blend_from="take-1", blend_to="take-5")
    assert varied.state.blend_problem == apart(one, jump)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"blend": {"seed": 1, "take": 1, "share": 0.5}}, "Take 5 is a blend itself."),
        ({"then": (("run", 3),)}, "Take 5 is a sequence of actions."),
        ({"best_of": 4}, "Take 5 is the best of 4 draws; only single draws can be blended."),
    ],
)
def test_takes_that_are_no_single_draws_are_named(varied, changes, words):
    (take,) = varied.takes.add([sway()], group="x", settings=GenerateSettings(engine="fake", take=1, **changes))
    assert alone(take) == words


def test_going_on_keeps_the_start_and_asks_for_ways_on(varied, settle):
    state = varied.state
    varied.select("take-2")
    state.param.update(playhead=1.5, next_action="run", next_seconds=2.0, count=3)
    varied.varying.go_on()
    settle(varied)
    (call,) = varied.fake.calls
    assert (call["action"], call["keep"], call["frames"]) == ("run", 30, 70)
    assert ids(varied)[4:] == ["take-5", "take-6", "take-7"]
    made = varied.takes.get("take-5").settings
    assert made.constraints.kept[0].source == "take 2"
    varied.again("take-5")
    settle(varied)
    assert varied.fake.calls[-1]["keep"] == 30
    assert varied.fake.calls[-1]["seed"] != call["seed"]


def test_going_on_from_an_import_shows_what_was_to_be_done(varied, settle):
    (take,) = varied.takes.add([sway("jump")], group="f", source="jump.bvh")
    varied.select(take.id)
    varied.state.param.update(playhead=0.0, next_action="")
    varied.varying.go_on()
    settle(varied)
    assert (varied.fake.calls[0]["action"], varied.fake.calls[0]["keep"]) == ("jump", 1)
    varied.select(take.id)
    varied.varying.change()
    assert varied.state.vary_error == "Take 5 has no action that could change."


def test_a_change_of_action_at_the_playhead(varied, settle):
    state = varied.state
    varied.select("take-2")
    state.param.update(playhead=1.0, next_action="Run", next_seconds=1.5, count=2)
    varied.varying.change()
    settle(varied)
    parts = [("walk", 20), ("run", 30)]
    assert varied.fake.calls == [{"segments": parts, "seed": 7}, {"segments": parts, "seed": 8}]
    assert varied.takes.get("take-5").settings.then == (("run", 30),)
    state.param.update(playhead=2.0, next_action="bow")
    varied.varying.change()
    settle(varied)
    assert varied.fake.calls[-1]["segments"] == [("walk", 20), ("run", 20), ("bow", 30)]
    varied.again("take-5")
    settle(varied)
    assert varied.fake.calls[-1]["segments"] == parts
    assert varied.fake.calls[-1]["seed"] not in (7, 8)


def test_a_take_as_long_as_it_took_changes_its_action_too(varied, settle):
    take = varied.takes.get("take-2")
    varied.keep(take.motion, replace(take.settings, frames=None), pytest.fail)
    settle(varied)
    varied.state.param.update(playhead=1.0, next_action="Run", next_seconds=1.5, count=1)
    varied.varying.change()
    settle(varied)
    assert varied.fake.calls == [{"segments": [("walk", 20), ("run", 30)], "seed": 7}]


def test_what_goes_wrong_is_said(varied, settle, monkeypatch):
    varied.state.param.update(next_action="moonwalk", playhead=1.0)
    monkeypatch.setattr(varied.fake, "outpaint", lambda *_a, **_k: 1 / 0)
    varied.varying.go_on()
    settle(varied)
    assert "ZeroDivisionError" in varied.state.vary_error
    varied.state.selected = ""
    varied.varying.go_on()
    assert varied.state.vary_error == "Pick a take first."


def test_an_engine_without_any_of_it_says_so(session, settle):
    session.start()
    settle(session)
    assert session.varying.go_problem() == f"{session.state.engine} cannot go on from a start."
    assert session.varying.change_problem() == f"{session.state.engine} cannot change its action on the way."
    session.varying.go_on()
    assert session.state.vary_error == f"{session.state.engine.capitalize()} cannot go on from a start."
