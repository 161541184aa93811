"""How long motions of the prompt that is being typed may be, where the engine has learned that."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from engines.errors import MotionloomError
from studio import tasks
from studio.latest import Latest
from studio.wording import duration

if TYPE_CHECKING:
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
        self._state = session.state

        def work(asked: tuple[str, str, str]) -> Guess:
            prompt, engine, variant = asked
            return guess(tasks.load_engine(engine, variant), prompt)

        self._latest = Latest(session, "lengths", work, lambda _, job: tell(job.result or Guess() if job else Guess()))
        session.state.param.watch(self._look, ["prompt", "compose_tab", "engine", "variant", "capabilities"])

    def _look(self, *_: Any) -> None:
        state = self._state
        wanted = state.compose_tab == "text" and "text" in state.capabilities
        prompt = state.prompt.strip() if wanted else ""
        self._latest.ask((prompt, state.engine, state.variant) if prompt else None)


def guess(engine: Any, prompt: str) -> Guess:
    """What an engine knows of the lengths of a prompt's motions; nothing where it cannot say."""
    if not hasattr(engine, "lengths"):
        return Guess()
    try:
        found = engine.lengths(prompt)
    except MotionloomError:  # weights without it, or a prompt that cannot be read, which is said under the prompt
        return Guess()
    return Guess(tuple((found.frames / engine.fps).round(3).tolist()), tuple(found.chances.round(5).tolist()))
