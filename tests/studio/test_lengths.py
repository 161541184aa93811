"""How long motions of the typed prompt may be is shown where the engine knows, and taken over by a press."""

from __future__ import annotations

import numpy as np
import pytest
from panel.models.esm import DataEvent

from engines.errors import MotionloomError
from engines.text2motion.engine import Lengths
from studio.lengths import Guess, LengthGuess, guess
from studio.session import Session
from studio.views.lengths import lengths
from tests.engines.text2motion import tiny


@pytest.fixture
def shown(constrained, queue, settle):
    """A session of an engine that guesses a length by the number of letters, and its histogram."""

    def say(prompt: str) -> Lengths:
        if prompt == "???":
            raise MotionloomError("cannot be read")
        frames = np.arange(20, 100, 4)
        chances = np.exp(-0.5 * ((frames - 10 * len(prompt)) / 6) ** 2)
        return Lengths(frames, chances / chances.sum())

    constrained.lengths = say
    session = Session(queue=queue)
    session.start()
    settle(session)
    yield session, lengths(session)
    session.close()


def test_it_follows_the_prompt_in_the_text_tab_only(shown, settle):
    session, part = shown
    session.state.prompt = "walk"
    settle(session)
    assert not part.visible
    session.state.compose_tab = "text"
    settle(session)
    assert part.visible
    assert part.likeliest == 2.0
    assert sum(part.chances) == pytest.approx(1, abs=1e-3)
    assert part.words == "Likeliest 2.0 s; half last 1.8 s to 2.2 s."
    session.state.prompt = "walk a lot"
    settle(session)
    assert part.likeliest > 4
    session.state.prompt = ""
    settle(session)
    assert not part.visible


def test_a_length_that_is_there_is_taken_over_and_no_other(shown, settle):
    session, part = shown
    session.state.param.update(compose_tab="text", prompt="walk")
    settle(session)
    for seconds in (2.0, 777.0):
        part._process_event(DataEvent(None, {"do": "take", "seconds": seconds}))
    assert session.state.frames == 40
    assert not session.state.as_long


def test_a_prompt_that_cannot_be_read_has_none(shown, settle):
    session, part = shown
    session.state.param.update(compose_tab="text", prompt="???")
    settle(session)
    assert not part.visible


def test_an_engine_that_knows_no_lengths_is_left_alone(constrained, queue, settle):
    session, said = Session(queue=queue), []
    session.start()
    settle(session)
    LengthGuess(session, said.append)
    session.state.param.update(compose_tab="text", prompt="hop")
    settle(session)
    assert set(said) == {Guess()}
    session.close()


def test_what_text2motion_knows_is_what_is_shown():
    engine = tiny.engine()
    found, known = guess(engine, "A person does throw."), engine.lengths("A person does throw.")
    assert found.likeliest == known.likeliest / engine.fps
    assert len(found.seconds) == len(known.frames)
