"""A session with an engine that can be told what to pin."""

from __future__ import annotations

import pytest

from studio.pinned import NOTHING
from studio.session import Session
from studio.views.compose import compose_form
from studio.views.inspector import describe
from studio.views.parts import Constraints, Prompt


@pytest.fixture
def started(constrained, session: Session, settle) -> Session:
    session.start()
    settle(session)
    return session


def words(session: Session) -> list[str]:
    return [text for _, text in session.state.pinned.listed(20.0)]


def test_the_engine_says_what_can_be_asked(started):
    state = started.state
    assert state.styles == ["happy", "old", "tired"]
    assert (state.max_pinned, {"text", "constraints"} <= state.capabilities) == (200, True)


def test_pose_and_frames_of_the_selected_take_at_the_playhead(started):
    started.select("take-2")
    started.state.playhead = 1.5
    started.pins.pose()
    started.state.playhead = 1.0
    started.pins.frames()
    assert words(started) == ["pose of take 2 at 1.5 s", "frames 0–20 of take 2"]
    started.state.playhead = 99.0
    started.pins.pose()
    assert words(started)[-1] == "pose of take 2 at 3.0 s", "past its end: its last pose"
    assert started.state.pinned.kept[-1].at == 59


def test_without_a_take_there_is_nothing_to_pin(constrained, session):
    session.pins.pose()
    assert session.state.pin_error.startswith("Pick a take first")
    assert session.state.pinned == NOTHING


def test_a_drawn_path_and_a_joint_go_into_the_draw(started, settle, constrained):
    started.pins.path([[0, 0], [0, 1], [1, 2]])
    started.pins.joint("left_wrist", (0.3, 1.2, 0.4), 2.0)
    started.pins.loop(True)
    assert words(started) == ["path of 2.4 m", "left wrist at 2.0 s"]
    started.generate()
    settle(started)
    given = constrained.calls[-1]["constraints"]
    assert given.path.points.tolist() == [[0, 0], [0, 1], [1, 2]]
    assert [(pin.joint, pin.frame) for pin in given.pins] == [("left_wrist", 40)]
    assert given.loop
    assert started.state.generate_note == ""
    assert "path of 2.4 m" in describe(started.state.take(), {})
    assert "ends as it began" in describe(started.state.take(), {})


def test_a_long_line_is_thinned_and_keeps_its_ends(started):
    started.pins.path([[0.01 * i, 0] for i in range(1000)])
    path = started.state.pinned.path
    assert len(path) <= 200
    assert (path[0], path[-1]) == ((0.0, 0.0), (9.99, 0.0))


@pytest.mark.parametrize(
    ("act", "says"),
    [
        (lambda pins: pins.path([[0, 0], [0.1, 0]]), "Length of the path is '0.10 m'; accepted: 0.3 m or more."),
        (lambda pins: pins.path_text("0,0 1"), "Point of the path is '1'; accepted: x,z in metres"),
        (lambda pins: pins.joint("left_hand", (0, 1, 0), 1.0), "Unknown joint to pin 'left_hand'; did you mean"),
        (lambda pins: pins.joint("head", (0, 1, 0), -1.0), "Time of the pin is '-1 s'"),
        (lambda pins: pins.joint_text("head", "0, one, 0"), "“0, one, 0” is no place; type three numbers"),
        (lambda pins: pins.joint("head", (0, float("nan"), 0), 1.0), "Place of head"),
    ],
)
def test_what_cannot_be_pinned_is_said_and_changes_nothing(started, act, says):
    act(started.pins)
    assert started.state.pin_error.startswith(says)
    assert started.state.pinned == NOTHING
    started.pins.loop(True)
    assert started.state.pin_error == "", "what works takes the complaint away"


def test_typed_path_and_place(started):
    started.state.playhead = 0.5
    started.pins.path_text("0,0 0,3")
    started.pins.joint_text("right_wrist", "0.3, 1.2 0.4")
    assert words(started) == ["path of 3.0 m", "right wrist at 0.5 s"]
    started.pins.remove("path")
    assert words(started) == ["right wrist at 0.5 s"]
    started.pins.clear()
    assert words(started) == []


def test_what_could_not_be_met_is_said_under_the_button_and_with_the_take(started, settle):
    started.pins.path([[0, 0], [0, 9]])
    started.generate()
    settle(started)
    said = "The path is 9.0 m long; it is followed for 5.0 m."
    assert started.state.generate_note == said
    assert said in describe(started.state.take(), {})
    assert "Not met" not in describe(started.state.take("take-1"), {})
    started.pins.clear()
    started.generate()
    settle(started)
    assert started.state.generate_note == ""


def test_words_and_style_are_asked_and_come_back_with_the_take(started, settle, constrained):
    state = started.state
    state.param.update(compose_tab="text", prompt="a person hops & bows", style="old", guidance=4.0, best_of=3)
    started.pins.path([[0, 0], [0, 2]])
    started.generate()
    settle(started)
    call = constrained.calls[-1]
    assert (call["action"], call["prompt"], call["style"]) == (None, "a person hops & bows", "old")
    assert (call["guidance"], call["best_of"]) == (4.0, 3)
    take = state.take()
    assert take.subject == "a person hops & bows"
    assert "a person hops &amp; bows" in describe(take, {})
    state.param.update(compose_tab="action", prompt="", style="", guidance=2.0, best_of=1, pinned=NOTHING)
    started.restore(take.id)
    assert (state.compose_tab, state.prompt, state.style) == ("text", "a person hops & bows", "old")
    assert (state.guidance, state.best_of, words(started)) == (4.0, 3, ["path of 2.0 m"])
    assert state.generate_settings() == take.settings.__class__(**{**vars(take.settings), "take": None})


def test_an_engine_without_words_closes_their_tab(started, settle, engine, monkeypatch):
    from studio import tasks

    started.state.param.update(compose_tab="text", style="old", tool="path")
    monkeypatch.setattr(tasks, "load_engine", lambda _name, _variant="": engine)
    started.state.variant = "other"
    settle(started)
    state = started.state
    assert (state.compose_tab, state.request, state.style, state.tool) == ("action", "action", "", "none")
    assert state.problem() == ""


def test_controls_are_there_where_the_engine_has_them(started, engine, settle, monkeypatch):
    from studio import tasks
    from studio.views.compose import action_field, compose_tabs

    form, tabs = compose_form(started, action_field(started)), compose_tabs(started)
    (pins,), (prompt,) = form.select(Constraints), form.select(Prompt)
    labels = {part.name: part for part in form.select(lambda part: getattr(part, "label", None)) if part.visible}
    assert {"Style"} <= {part.label for part in labels.values()}
    always = ["sequence", "style", "character", "import"]
    assert [value for value, _ in tabs.options] == ["action", "text", *always]
    assert (pins.visible, prompt.visible) == (True, False)
    started.state.compose_tab = "text"
    assert prompt.visible
    monkeypatch.setattr(tasks, "load_engine", lambda _name, _variant="": engine)
    started.state.variant = "other"
    settle(started)
    assert [value for value, _ in tabs.options] == ["action", *always]
    assert (pins.visible, prompt.visible) == (False, False)
    shown = {part.label for part in form.select(lambda part: getattr(part, "label", None)) if part.visible}
    assert "Style" not in shown
