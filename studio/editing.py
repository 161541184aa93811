"""Takes as they are shown: with the edits a person switched on, worked out off the UI thread and kept at hand."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from engines import Motion
from engines.errors import MotionloomError
from studio import edits, tasks
from studio.jobs import Job
from studio.settings import EDITS
from studio.takes import Held, Take

if TYPE_CHECKING:
    from studio.session import Session

_Key = tuple[Motion | Held, tuple[str, ...]]
_Edited = tuple[Motion, Mapping[str, float]]

AT_HAND = 64
"""Edited motions that are kept."""


class Editing:
    """The edited takes of one session.

    Args:
        session: whose takes they are; `state.edited` counts what was worked out.
    """

    def __init__(self, session: Session) -> None:
        self.session = session
        # by what the motion is held by, which stays while a take is marked and tagged
        self._done: OrderedDict[_Key, _Edited] = OrderedDict()
        self._under_way: set[_Key] = set()

    def set(self, take_id: str, names: list[str]) -> None:
        """Switch edits of a take on and off: those named are on."""
        take = self.session.takes.get(take_id)
        if take is not None:
            self.session.takes.mark(take_id, edits=tuple(name for name in EDITS if name in names))

    def motion(self, take: Take) -> Motion | None:
        """A take's motion as it is to be shown: as it was made until its edits are worked out.

        None, and a word on why, where the library does not give it.
        """
        try:
            plain = take.motion
        except MotionloomError as problem:
            self.session.state.message = f"{take.title} cannot be shown: {problem}"
            return None
        done = self._looked_up(take) if take.edits else (plain, take.metrics)
        if done is None:
            self._work_out(take, plain)
            return plain
        return done[0]

    def metrics(self, take: Take) -> Mapping[str, float]:
        """Quality measures of a take as it is shown."""
        done = self._looked_up(take) if take.edits else None
        return take.metrics if done is None else done[1]

    def _looked_up(self, take: Take) -> _Edited | None:
        key = (take.held, take.edits)
        if key in self._done:
            self._done.move_to_end(key)
        return self._done.get(key)

    def _work_out(self, take: Take, plain: Motion) -> None:
        key = (take.held, take.edits)
        if key in self._under_way:
            return
        self._under_way.add(key)

        def work(_progress: Any, _cancel: Any) -> _Edited:
            edited = edits.apply(plain, take.edits)
            # feet that stay on the spot slide, which says nothing about them
            moving = [name for name in take.edits if name != "in_place"]
            return edited, dict(tasks.measure(edits.apply(plain, moving)))

        def show(job: Job) -> None:
            if not job.finished:
                return
            self._under_way.discard(key)
            if job.status == "failed":
                self.session.state.message = f"{take.title} is shown as it was made: {job.error}"
                self._done[key] = (plain, take.metrics)
            elif job.status == "done":
                self._done[key] = job.result
            while len(self._done) > AT_HAND:
                self._done.popitem(last=False)
            self.session.state.edited += 1

        self.session.submit(f"edit {take.id}", work, show, lane="file")
