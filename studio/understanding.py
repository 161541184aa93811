"""What the engine makes of the prompt that is being typed, said under it before anything is drawn."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from studio import tasks

if TYPE_CHECKING:
    from studio.jobs import Job
    from studio.session import Session


class Understanding:
    """Asks engines that can say it (`understood(prompt) -> str`), off the page's thread, of the latest prompt only.

    Args:
        session: whose prompt it is.
        tell: hears the sentence for the person; empty where there is nothing to say.
    """

    def __init__(self, session: Session, tell: Callable[[str], None]) -> None:
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
            self._tell("")
            return
        self._busy = True

        def work(_progress: Any, _cancel: Any) -> str:
            say = getattr(tasks.load_engine(engine, variant), "understood", None)
            return say(prompt) if say else ""

        def show(job: Job) -> None:
            if not job.finished:
                return
            self._busy, self._told = False, asked
            self._tell(job.error if job.status == "failed" else job.result or "")
            self._go_on()  # something else was typed meanwhile

        self.session.submit("understand", work, show)
