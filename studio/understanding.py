"""What the engine makes of what is asked, said before anything is drawn: what a prompt means, how long it will be."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from studio import tasks
from studio.latest import Latest
from studio.settings import MAX_PROMPT, USUAL_FRAMES, GenerateSettings

if TYPE_CHECKING:
    from studio.jobs import Job
    from studio.session import Session


class Understanding:
    """Asks engines that can say it, off the page's thread, of the latest request only.

    What a prompt means says `engine.understood(prompt) -> str`; how long a motion will be goes into the state.

    Args:
        session: whose request it is.
        tell: hears the sentence for the person; empty where there is nothing to say.
    """

    def __init__(self, session: Session, tell: Callable[[str], None]) -> None:
        self.session, self._tell = session, tell
        self._latest = Latest(session, "understand", _work, self._show)
        watched = ["prompt", "action", "request", "as_long", "pinned", "engine", "variant", "capabilities"]
        session.state.param.watch(self._look, watched)

    def _look(self, *_: Any) -> None:
        state = self.session.state
        words = " ".join(state.prompt.split()) if state.request == "text" and "text" in state.capabilities else ""
        known = state.request == "action" and state.finds_length and not state.nearest_actions()
        asked = GenerateSettings(
            state.engine, state.variant, " ".join(state.action.lower().split()) if known else "",
            prompt=words if len(words) <= MAX_PROMPT else "", frames=None if state.finds_length else USUAL_FRAMES,
        )  # fmt: skip
        self._latest.ask(asked if asked.action or asked.prompt else None)

    def _show(self, asked: GenerateSettings | None, job: Job | None) -> None:
        said, frames = (job.result if job else None) or ("", 0)
        self._tell(job.error if job and job.status == "failed" else said)
        if asked is not None and asked.frames is None and asked == self._latest.asked:
            self.session.state.expect(frames)


def _work(asked: GenerateSettings) -> tuple[str, int]:
    """What the engine says of a prompt, and how long a motion will be, frames."""
    engine = tasks.load_engine(asked.engine, asked.variant)
    say = getattr(engine, "understood", None)
    return say(asked.prompt) if say and asked.prompt else "", tasks.expected_frames(asked, engine)
