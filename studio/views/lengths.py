"""Lengths: a histogram under the length, of the prompt that is typed."""

from __future__ import annotations

from typing import Any

from studio.lengths import Guess, LengthGuess
from studio.session import Session
from studio.views.binding import follow
from studio.views.parts import Lengths


def lengths(session: Session) -> Lengths:
    """How long motions of the prompt may be; a press on a bar takes its length."""
    state = session.state
    part = Lengths(sizing_mode="stretch_width", margin=0, visible=False)
    follow(part, state, ["frames", "fps"], lambda: {"asked": state.frames / state.fps})

    def told(guess: Guess) -> None:
        part.param.update(
            seconds=list(guess.seconds), chances=list(guess.chances), words=guess.in_words(),
            likeliest=guess.likeliest if guess.seconds else 0.0, visible=bool(guess.seconds),
        )  # fmt: skip

    def chosen(message: dict[str, Any]) -> None:
        seconds = float(message.get("seconds", 0))
        if seconds in part.seconds:
            state.say_length(round(seconds * state.fps))

    LengthGuess(session, told)
    part.on("take", chosen)
    return part
