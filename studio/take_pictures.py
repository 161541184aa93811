"""The pictures of takes: drawn behind everything else, in the body that the project has, and kept with the takes."""

from __future__ import annotations

import hashlib
import json
import logging
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from engines.errors import MotionloomError
from studio import thumbnails
from studio.jobs import Cancel, Job, Progress
from studio.takes import Take

if TYPE_CHECKING:
    from studio.session import Session

log = logging.getLogger(__name__)

_AT_ONCE = 8
"""So many pictures of a long row go to the page together."""
_TYPE = "data:image/webp"


class TakePictures:
    """The pictures of one session's takes.

    A picture says in its own type which body it shows (`data:image/webp;body=1f0c9a2b;base64,...`; the usual one is not
    named), so that those drawn before the project got another are known wherever they come from.

    Args:
        session: whose takes they are.
    """

    def __init__(self, session: Session) -> None:
        self.session = session
        self._renewing: Job | None = None
        session.state.param.watch(self.renew, "worn")

    def renew(self, *_: Any) -> None:
        """Draw what is missing or shows another body, newest first; not while a slider is being dragged."""
        if not self.session.dressing.settled:
            return
        if self._renewing is not None:
            self._renewing.cancel()
        there, body = self.session.state.thumbnails, self._body()
        self._renewing = self.draw([take for take in reversed(self.session.takes.all) if _shown(there, take) != body])

    def draw(self, takes: Sequence[Take]) -> Job | None:
        """Draw takes one after another and keep the pictures."""
        store, worn, body = self.session.takes.store, self.session.state.worn, self._body()
        drawn: dict[str, str] = {}
        if not takes:
            return None

        def work(progress: Progress, _cancel: Cancel) -> None:
            from viewers.scene import PALETTE

            for count, take in enumerate(takes, 1):
                place = (take.settings.take or count) - 1 if take.settings else 0
                picture = _picture(take, PALETTE[place % len(PALETTE)], worn)
                drawn[take.id] = picture.replace(_TYPE, f"{_TYPE};body={body}", 1) if body else picture
                if count % _AT_ONCE == 0 or count == len(takes):
                    last = takes[(count - 1) // _AT_ONCE * _AT_ONCE : count]
                    store.keep_pictures({take.number: drawn[take.id] for take in last})
                progress(count, len(takes))

        def show(job: Job) -> None:
            if job.status == "failed":
                log.warning("no thumbnails: %s", job.error)
            if store is self.session.takes.store and (job.finished or len(drawn) % _AT_ONCE == 0):
                self.session.state.thumbnails = {**self.session.state.thumbnails, **drawn}

        return self.session.submit("thumbnails", work, show, lane="still")

    def _body(self) -> str:
        """Tells bodies apart; empty for the usual one."""
        state = self.session.state
        if isinstance(state.worn, str) and state.worn == state.param.worn.default:
            return ""
        said = json.dumps([state.body, state.shape], sort_keys=True)
        return hashlib.sha256(said.encode()).hexdigest()[:8]


def _shown(pictures: dict[str, str], take: Take) -> str | None:
    """The body that the picture of a take shows; None where there is no picture."""
    if take.id not in pictures:
        return None
    _, named, rest = pictures[take.id].partition(f"{_TYPE};body=")
    return rest.partition(";")[0] if named else ""


def _picture(take: Take, colour: str, worn: Any) -> str:
    """A take in a body; in the usual one where it cannot wear that."""
    from viewers import bodies

    try:
        return thumbnails.thumbnail(take.motion, colour, worn)
    except MotionloomError:
        return thumbnails.thumbnail(take.motion, colour, bodies.DEFAULT)
