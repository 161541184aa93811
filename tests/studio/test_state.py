from __future__ import annotations

import pytest

from engines.actions import VOCABULARY
from studio.state import StudioState


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
    state.param.update(export_format="gif", export_size=(720, 720), export_camera="front")
    asked = state.export_settings()
    assert (asked.formats, asked.width, asked.height, asked.camera) == (("gif",), 720, 720, "front")
