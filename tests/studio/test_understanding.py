"""What the engine makes of a prompt is said while it is typed."""

from __future__ import annotations

import pytest

from studio.session import Session
from studio.understanding import Understanding


@pytest.fixture
def heard(constrained, queue, settle):
    """A session of an engine that repeats what it is told, and what was said under the prompt."""
    constrained.asked = []

    def understood(prompt: str) -> str:
        constrained.asked.append(prompt)
        if prompt == "trouble":
            raise ValueError("no such word")
        return f"Understood as: {prompt}."

    constrained.understood = understood
    session = Session(queue=queue)
    session.start()
    settle(session)
    said: list[str] = []
    Understanding(session, said.append)
    yield session, said
    session.close()


def test_it_is_said_in_the_text_tab_only(heard, settle):
    session, said = heard
    session.state.prompt = "hop"
    settle(session)
    assert set(said) <= {""}
    session.state.compose_tab = "text"
    settle(session)
    assert said[-1] == "Understood as: hop."
    session.state.prompt = "  "
    settle(session)
    assert said[-1] == ""


def test_the_last_prompt_wins(heard, settle, constrained):
    session, said = heard
    session.state.compose_tab = "text"
    for prompt in ("h", "ho", "hop", "hop on"):
        session.state.prompt = prompt
    settle(session)
    assert said[-1] == "Understood as: hop on."
    assert len(constrained.asked) <= 4


def test_an_engine_that_does_not_say_is_left_alone(heard, settle, constrained):
    session, said = heard
    del constrained.understood
    session.state.param.update(compose_tab="text", prompt="hop")
    settle(session)
    assert set(said) <= {""}


def test_the_length_that_will_come_is_said_and_a_length_that_is_typed_stays(heard, settle, constrained):
    session, _ = heard
    state = session.state
    state.action = "jump"
    settle(session)
    assert state.frames == 30
    assert state.forecast().startswith("4 × 30 frames at 20 fps")
    state.param.update(compose_tab="text", prompt="a person hops on one foot")
    settle(session)
    assert (state.frames, state.generate_settings().frames) == (60, None)
    session.generate()
    settle(session)
    assert (constrained.calls[-1]["frames"], session.takes.get("take-5").frames) == (None, 60)
    state.say_length(45)
    state.prompt = "a person hops"
    settle(session)
    assert (state.as_long, state.frames, state.generate_settings().frames) == (False, 45, 45)
    state.as_long = True
    settle(session)
    assert state.frames == 30
    session.restore("take-5")
    settle(session)
    assert (state.as_long, state.prompt, state.frames) == (True, "a person hops on one foot", 60)


def test_an_engine_that_finds_a_length_only_while_it_draws_says_none(heard, settle, constrained, monkeypatch):
    session, _ = heard
    monkeypatch.delattr(type(constrained), "expected_frames")
    session.state.param.update(compose_tab="text", prompt="hop")
    settle(session)
    assert session.state.forecast() == "4 × as long as it takes at 20 fps"
    assert session.state.generate_settings().frames is None
