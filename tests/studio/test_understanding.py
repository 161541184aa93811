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
