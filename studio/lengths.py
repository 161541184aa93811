"""How long motions of the prompt that is being typed may be, where the engine has learned that."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from engines.errors import MotionloomError
from studio import tasks
from studio.wording import duration

if TYPE_CHECKING:
    from studio.jobs import Job
    from studio.session import Session


@dataclass(frozen=True)
class Guess:
    """Lengths and how likely each is."""

    seconds: tuple[float, ...] = ()
    """Ascending; none where nothing is known."""
    chances: tuple[float, ...] = ()
    """Of each; they add to 1."""

    @property
    def likeliest(self) -> float:
        """Seconds."""
        return self.seconds[self.chances.index(max(self.chances))]

    def in_words(self) -> str:
        """The likeliest, and between what half of all lie; empty where nothing is known."""
        if not self.seconds:
            return ""
        low, high = (duration(self._share(share)) for share in (0.25, 0.75))
        return f"Likeliest {duration(self.likeliest)}; half last {low} to {high}."

    def _share(self, share: float) -> float:
        """Seconds that so many are at most as long as."""
        total = 0.0
        for seconds, chance in zip(self.seconds, self.chances, strict=True):
            total += chance
            if total >= share:
                return seconds
        return self.seconds[-1]


class LengthGuess:
    """Asks engines that know it (`lengths(prompt)`), off the page's thread, of the latest prompt only.

    Args:
        session: whose prompt it is.
        tell: hears the guess; an empty one where there is none.
    """

    def __init__(self, session: Session, tell: Callable[[Guess], None]) -> None:
        self.session, self._tell = session, tell
        self._asked = self._told = ("", "", "")
        self._busy = False
        session.state.param.watch(self._look, ["prompt", "compose_tab", "engine", "variant", "capabilities"])

    def _look(self, *_: Any) -> None:
        state = self.session.state
        wanted = state.compose_tab == "text" and "text" in state.capabilities
        self._asked = (state.prompt.strip() if wanted else "", state.engine, state.variant)
        self._go_on()

    def _go_on(self) -> None:
        if self._busy or self._asked == self._told:
            return
        asked = prompt, engine, variant = self._asked
        if not prompt:
            self._told = asked
            self._tell(Guess())
            return
        self._busy = True

        def show(job: Job) -> None:
            if not job.finished:
                return
            self._busy, self._told = False, asked
            self._tell(job.result or Guess())
            self._go_on()  # something else was typed meanwhile

        self.session.submit("lengths", lambda *_: guess(tasks.load_engine(engine, variant), prompt), show)


def guess(engine: Any, prompt: str) -> Guess:
    """What an engine knows of the lengths of a prompt's motions; nothing where it cannot say."""
    if not hasattr(engine, "lengths"):
        return Guess()
    try:
        found = engine.lengths(prompt)
    except MotionloomError:  # weights without it, or a prompt that cannot be read, which is said under the prompt
        return Guess()
    return Guess(tuple((found.frames / engine.fps).round(3).tolist()), tuple(found.chances.round(5).tolist()))
