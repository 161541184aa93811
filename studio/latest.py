"""Asks off the page's thread, of what was asked last only; what is asked meanwhile waits for the answer."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Generic, TypeVar

if TYPE_CHECKING:
    from studio.jobs import Job
    from studio.session import Session

Asked = TypeVar("Asked")


class Latest(Generic[Asked]):
    """One question at a time.

    Args:
        session: whose page it is.
        title: of the job.
        work: finds the answer, off the page's thread.
        tell: hears what was asked and the finished job; none of nothing (None), which needs no answer.
    """

    def __init__(
        self,
        session: Session,
        title: str,
        work: Callable[[Asked], Any],
        tell: Callable[[Asked | None, Job | None], None],
    ) -> None:
        self._session, self._title, self._work, self._tell = session, title, work, tell
        self.asked: Asked | None = None
        """What was asked last."""
        self._told: Asked | None = None
        self._busy = False

    def ask(self, asked: Asked | None) -> None:
        """Ask that, unless it is what was answered last."""
        self.asked = asked
        self._go_on()

    def _go_on(self) -> None:
        if self._busy or self.asked == self._told:
            return
        asked = self.asked
        if asked is None:
            self._told = None
            self._tell(None, None)
            return
        self._busy = True

        def show(job: Job) -> None:
            if not job.finished:
                return
            self._busy, self._told = False, asked
            self._tell(asked, job)
            self._go_on()  # something else was asked meanwhile

        self._session.submit(self._title, lambda *_: self._work(asked), show)
