from __future__ import annotations

import pytest

from engines.actions import VOCABULARY
from studio.pinned import JointPin, Kept, Pinned
from studio.state import StudioState
from tests.studio.fakes import ConstrainedEngine, sway


@pytest.fixture
def state():
    return StudioState(actions=VOCABULARY[:20], engine_ready=True, max_frames=400)


def test_forecast_says_what_comes_and_how_long_it_took_before(state):
    assert state.forecast() == "4 × 60 frames at 20 fps"
    state.generate_rate = 800.0
    assert state.forecast() == "4 × 60 frames at 20 fps · about 0.3 s on this machine"
    state.generate_rate = 1e6
    assert "under 0.1 s" in state.forecast()


def test_unknown_action_is_named_with_the_nearest(state):
    state.action = "wlak"
    assert state.problem().startswith("“wlak” is not an action this engine knows. Nearest: “walk”")
    assert state.nearest_actions()[0] == "walk"


@pytest.mark.parametrize("typed", ["walk", " Walk ", "WALK   backward"])
def test_case_and_blanks_do_not_matter(state, typed):
    state.action = typed
    assert state.problem() == ""
    assert state.nearest_actions() == []


def test_what_stands_in_the_way_is_said(state):
    state.frames = 500
    assert state.problem() == "This engine makes at most 20 s."
    state.param.update(frames=60, action="  ")
    assert state.problem() == "Choose an action."
    state.engine_ready = False
    assert state.problem() == "Loading the engine…"


def test_export_settings_follow_the_controls(state):
    state.param.update(export_format="gif", export_size=(720, 720), export_camera="front", export_views="around")
    asked = state.export_settings()
    told = (asked.formats, asked.width, asked.height, asked.camera, asked.views)
    assert told == (("gif",), 720, 720, "front", "around")


@pytest.fixture
def able(state):
    """The state with an engine that takes styles, words and pins."""
    state.param.update(
        capabilities=ConstrainedEngine.capabilities, styles=["happy"], style="happy", guidance=4.0, best_of=2,
        prompt="  a person\n waves ", max_pinned=200, bone_scale={"left_knee": 1.1},
        pinned=Pinned(path=((0.0, 0.0), (0.0, 2.0))),
    )  # fmt: skip
    return state


def test_what_an_engine_cannot_be_told_is_not_asked_of_it(able):
    able.capabilities = frozenset({"actions"})
    asked = able.generate_settings()
    assert (asked.style, asked.prompt, asked.guidance, asked.best_of, asked.bone_scale) == ("", "", 3.0, 1, {})
    assert not asked.constraints


def test_an_action_or_words_are_asked_by_the_tab_last_open(able):
    asked = able.generate_settings()
    assert (asked.action, asked.prompt, asked.style, asked.guidance, asked.best_of) == ("walk", "", "happy", 4.0, 2)
    able.compose_tab = "text"
    able.compose_tab = "import"
    asked = able.generate_settings()
    assert (asked.action, asked.prompt) == ("", "a person waves")
    assert asked.constraints.length == 2.0
    assert "the best of 2 each" in able.forecast()


def test_an_empty_prompt_is_said_and_the_action_does_not_matter_then(able):
    able.param.update(compose_tab="text", action="nonsense")
    assert able.problem() == ""
    able.prompt = "  "
    assert able.problem() == "Describe the motion."
    able.prompt = "a" * 1001
    assert able.problem() == "A prompt has at most 1,000 letters."


def test_what_is_pinned_lies_in_a_motion_of_the_length_that_is_shown(able):
    able.frames = 70
    assert able.generate_settings().frames == 70
    able.pinned = Pinned()
    assert able.generate_settings().frames is None
    able.capabilities -= {"lengths"}
    assert able.generate_settings().frames == 70, "an engine that finds no length is told one"


def test_pins_that_do_not_fit_the_length_are_said(able):
    able.frames = 201
    assert able.problem() == "With something pinned, a motion lasts at most 10 s."
    able.param.update(frames=40, pinned=Pinned(pins=(JointPin("head", 40, (0, 1.7, 0)),)))
    assert able.problem() == "The pin of head at 2.0 s lies behind the end of the motion at 2.0 s."
    able.pinned = Pinned((Kept.of(sway(frames=60), 50, 51, 50, "take 1"),))
    assert able.problem() == "The pose of take 1 at 2.5 s lies behind the end of the motion at 2.0 s."
    able.pinned = Pinned((Kept.of(sway(frames=60), 0, 50, 0, "take 1"),))
    assert able.problem() == "All 40 frames are kept; make the motion longer, or keep fewer."
    able.frames = 51
    assert able.problem() == ""
