"""Takes are put into words: each that is looked at, once, in the background, after it is shown."""

from __future__ import annotations

import logging
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from engines import registry
from engines.geometry.mirror import mirror_words
from studio import captions
from studio.captions import NOTHING_SAID, Description
from studio.jobs import Job
from studio.takes import Take, TakeStore

if TYPE_CHECKING:
    from studio.session import Session

log = logging.getLogger(__name__)

TOGETHER = 16
"""Takes described at a time."""


class Captioning:
    """What is said of the takes of one session.

    Args:
        session: whose takes they are; `state.captions` holds what is said of those looked at so far.
    """

    def __init__(self, session: Session) -> None:
        self.session = session
        self._busy = False
        self._tried: set[tuple[str, TakeStore]] = set()
        session.state.param.watch(self._look, ["shown", "selected", "generating", "describing"])

    def of(self, take: Take) -> Description:
        """What is said of a take as it is shown; nothing yet is an empty one."""
        said = self.session.state.captions.get(take.id, NOTHING_SAID)
        if "mirror" not in take.edits:
            return said
        # the sentence follows the motion, and does not say what was asked any more
        return replace(said, sentence=mirror_words(said.sentence), prompt_fit=None)

    def _look(self, *_: Any) -> None:
        """Describe what is on the stage, and what was drawn with the picked take; not while takes are drawn."""
        session, state = self.session, self.session.state
        if self._busy or state.generating or not state.describing:
            return
        store = session.takes.store
        speaks = bool(registry.captioners())
        on_stage = [take for take in map(session.takes.get, state.shown) if take]
        seen = {take.id: take for take in (*session.takes.group_of(state.selected), *on_stage)}.values()
        takes = [take for take in seen if (take.id, store) not in self._tried and self._lacks(take, speaks)][:TOGETHER]
        if not takes:
            return
        self._busy = True
        self._tried |= {(take.id, store) for take in takes}

        def work(_progress: Any, _cancel: Any) -> dict[str, Description]:
            prompts = [take.settings.prompt if take.settings else "" for take in takes]
            said = captions.describe([take.motion for take in takes], prompts)
            store.keep_captions({take.number: one.to_json() for take, one in zip(takes, said, strict=True)})
            return {take.id: one for take, one in zip(takes, said, strict=True)}

        def show(job: Job) -> None:
            if not job.finished:
                return
            self._busy = False
            if job.status == "failed":
                log.warning("takes are not described: %s", job.error)
            elif job.status == "done" and store is session.takes.store:
                state.captions = {**state.captions, **job.result}
            self._look()  # others came onto the stage meanwhile

        session.submit("describe takes", work, show, lane="caption")

    def _lacks(self, take: Take, speaks: bool) -> bool:
        """Whether there is something to be said of a take that is not said yet."""
        said = self.session.state.captions.get(take.id)
        return said is None or (speaks and not said.sentence)


def kept(store: TakeStore) -> dict[str, Description]:
    """What is said of takes and kept, by the take's id."""
    return {take: Description(**said) for take, said in store.captions().items()}
