"""One browser session: what happens when a person asks for something.

Views set parameters of `state` and call the methods here; the work itself runs in the job queue, and its outcome
comes back through `dispatch`, which the app points at the document's own thread.
"""

from __future__ import annotations

import logging
import random
import threading
import uuid
from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import replace
from typing import Any

import engines
from studio import draws, tasks
from studio.arranging import Arranging
from studio.attention import Attention
from studio.captioning import Captioning, kept
from studio.casting import Casting
from studio.dressing import Dressing
from studio.editing import Editing
from studio.exchange import Exchange
from studio.jobs import Job, JobQueue, Work, shared_queue
from studio.library import Library, Query
from studio.library.query import tags as clean_tags
from studio.pinning import Pinning
from studio.projects import Projects
from studio.settings import GenerateSettings
from studio.state import StudioState
from studio.styling import Styling
from studio.take_pictures import TakePictures
from studio.takes import Take, TakeList, TakeStore
from studio.varying import Varying
from studio.wording import counted

log = logging.getLogger(__name__)

STAGE_LIMIT = 16
"""Most takes the stage shows at once."""


class Session:
    """The takes, the jobs and the files of one browser tab.

    Args:
        state: parameters the views watch.
        queue: where long work runs; the process's shared one unless given.
        dispatch: runs a function on the thread that owns `state`; at once unless given.
        library: where projects are kept; in memory only unless given.
        problem: why there is no library, for a person.
    """

    def __init__(
        self,
        state: StudioState | None = None,
        queue: JobQueue | None = None,
        dispatch: Callable[[Callable[[], None]], Any] | None = None,
        library: Library | None = None,
        problem: str = "",
    ) -> None:
        self.id = uuid.uuid4().hex
        self.state = state or StudioState()
        self.queue = queue or shared_queue()
        self.dispatch = dispatch or (lambda act: act())
        self.takes = TakeList(on_change=self._takes_changed)
        self.files = Exchange(self)
        self.pins = Pinning(self)
        self.editing = Editing(self)
        self.varying = Varying(self)
        self.styling = Styling(self)
        self.arranging = Arranging(self)
        self.dressing = Dressing(self)
        self.casting = Casting(self)
        self.pictures = TakePictures(self)
        self.captioning = Captioning(self)
        self.attention = Attention(self, self.editing.motion)
        self.projects = Projects(self, library, problem)
        self._drawing: Job | None = None
        self._draws = 0
        self._loaded = ("", "")
        self.state.param.watch(self._restage, ["selected", "stage_mode", "compared"])
        self.state.param.watch(self._engine_asked, ["engine", "variant"])
        self.state.param.watch(self._search, ["takes", "search"])

    # ---- life ---------------------------------------------------------------------------------------------

    def start(self, project: str = "", take: str = "", asked: bool = False, compared: Sequence[str] = ()) -> None:
        """Open a project and load the engine; only once.

        In an empty project that nobody worked in takes are drawn at once, so that a newcomer sees people moving.

        Args:
            project: key of the project to open; a new one where it is not there.
            take: id of the take to pick.
            asked: a link names them.
            compared: ids of the takes to tick.
        """
        if self.state.engines:
            return
        self.state.engines = engines.available()
        self.projects.first(project, asked)
        self.select(take)
        self.arranging.enter()
        if compared:
            self.compare_these(list(compared))
        self._load_engine(then=None if self.state.takes or self.takes.undo_name else self.generate)

    def enter(self, store: TakeStore) -> None:
        """Show the takes of another store."""
        self.cancel_generate()
        self.takes = TakeList(store, self._takes_changed)
        self.state.param.update(selected="", compared=[], search="", thumbnails=store.pictures(), generate_note="")
        self.state.captions = kept(store)
        self._takes_changed(self.takes)
        self.arranging.enter()
        self.pictures.renew()

    def close(self) -> None:
        """Stop the work, remove the files of this session, and save what waits."""
        self.queue.cancel_all(self.id)
        self.files.close()
        self.projects.close()

    # ---- generating ---------------------------------------------------------------------------------------

    def generate(self) -> None:
        """Draw takes by the state's settings; a seed that is not locked is changed first (not on the first draw)."""
        state = self.state
        if state.generating or state.problem():
            return
        if self._draws and not state.seed_locked and state.request != "sequence":
            state.seed = random.randrange(10_000)
        self._draws += 1
        self.ask(state.generate_settings())

    def ask(self, asked: GenerateSettings) -> None:
        """Draw takes by settings of any kind."""
        state = self.state
        if state.generating:
            return
        state.param.update(
            generating=True, generate_progress=0.0, generate_error="", vary_error="", generate_note="", tool="none"
        )
        takes = self.takes
        self._drawing = self.submit(
            f"{asked.count} × {asked.subject[:60]}",
            lambda progress, cancel: draws.draw(asked, takes.store, progress, cancel),
            lambda job: self._drawn(job, takes),
        )

    def cancel_generate(self) -> None:
        """Stop the draw under way."""
        if self._drawing is not None:
            self._drawing.cancel()

    def again(self, take_id: str = "") -> None:
        """Draw once more with the settings of a take, on another seed."""
        take = self.state.take(take_id)
        if take is None or take.settings is None:
            return
        made = take.settings
        if made.blend:
            return
        if made.sequence:
            self.ask(self.arranging.again(made))
            return
        if made.then or made.given or (made.constraints and "constraints" not in self.state.capabilities):
            self.ask(replace(made, seed=random.randrange(10_000), take=None))
            return
        self.restore(take.id)
        self.state.seed_locked = False
        self.generate()

    def restore(self, take_id: str = "") -> None:
        """Put the settings of a take back into the controls."""
        take = self.state.take(take_id)
        if take is None or take.settings is None:
            return
        made = take.settings
        if made.sequence:
            self.state.compose_tab = "sequence"
            return
        tab = "text" if made.prompt and not made.action else "action"
        self.state.param.update(
            engine=made.engine, variant=made.variant, action=made.action or self.state.action,
            frames=made.frames or self.state.frames, as_long=made.frames is None, seed=made.seed, count=made.count,
            bone_scale=dict(made.bone_scale), style=made.style, prompt=made.prompt or self.state.prompt,
            guidance=made.guidance, best_of=made.best_of, pinned=made.constraints, request=tab, compose_tab=tab,
        )  # fmt: skip

    def _drawn(self, job: Job, takes: TakeList) -> None:
        """A draw is under way or done; its takes go where they were asked for, though another project be open."""
        state = self.state
        state.generate_progress = job.fraction
        if not job.finished:
            return
        state.generating = False
        if job.status == "failed":
            state.param.update(generate_error=job.error, vary_error=job.error)
        elif job.status == "cancelled":
            state.message = f"Cancelled: {job.title}"
        else:
            drawn: draws.Drawn = job.result
            state.generate_rate = drawn.rate
            made = takes.add(
                drawn.held, group=uuid.uuid4().hex, settings=drawn.asked, metrics=drawn.metrics,
                edits=self.styling.edits(drawn.asked),
            )  # fmt: skip
            self.shelve(made, takes)
            self.styling.beside(made)
            state.generate_note = drawn.note if takes is self.takes else ""

    def shelve(self, made: list[Take], takes: TakeList, pick: bool = True) -> None:
        """Show new takes, unless told otherwise, and have their pictures drawn."""
        if takes is not self.takes:
            return
        if pick:
            mode = "all" if self.state.stage_mode == "compare" else self.state.stage_mode
            self.state.param.update(selected=made[0].id, stage_mode=mode)
        self.pictures.draw(made)

    def keep(self, motion: engines.Motion, settings: GenerateSettings, failed: Callable[[str], None]) -> None:
        """Make a take of a motion that is there already.

        Args:
            motion: what it shows.
            settings: what makes it again.
            failed: hears why it cannot be kept.
        """
        takes = self.takes

        def work(_progress: Any, _cancel: Any) -> tuple[Any, dict]:
            return takes.store.hold([motion])[0], dict(tasks.measure(motion))

        def show(job: Job) -> None:
            if job.status == "failed":
                failed(job.error)
            elif job.status == "done":
                held, metrics = job.result
                edits = self.styling.edits(settings)
                made = takes.add([held], group=uuid.uuid4().hex, settings=settings, metrics=[metrics], edits=edits)
                self.shelve(made, takes)
                self.styling.beside(made)

        self.submit("keep", work, show)

    # ---- takes --------------------------------------------------------------------------------------------

    def select(self, take_id: str) -> None:
        """Pick a take."""
        if take_id in self.takes:
            self.state.selected = take_id

    def toggle(self, take_id: str, flag: str) -> None:
        """Turn `favourite` or `accepted` of a take over."""
        take = self.takes.get(take_id)
        if take is not None:
            self.takes.mark(take_id, **{flag: not getattr(take, flag)})

    def tag(self, take_id: str, texts: list[str]) -> None:
        """Give a take these tags, in place of those it had."""
        self.takes.mark(take_id, tags=clean_tags(texts))

    def compare(self, take_id: str) -> None:
        """Tick or untick a take for comparison; the stage follows."""
        ticked = [i for i in self.state.compared if i != take_id]
        self.compare_these(ticked if take_id in self.state.compared else [*ticked, take_id])

    def compare_these(self, take_ids: list[str]) -> None:
        """Tick these takes for comparison and no others; the stage follows."""
        ticked = [i for i in dict.fromkeys(take_ids) if i in self.takes]
        if len(ticked) > STAGE_LIMIT:
            self.state.message = f"At most {STAGE_LIMIT} takes are compared at once."
        self.state.param.update(compared=ticked[:STAGE_LIMIT], stage_mode="compare" if ticked else "all")

    def delete(self, take_id: str) -> None:
        """Delete a take; undo brings it back."""
        take = self.takes.get(take_id)
        if take is not None:
            self.takes.remove(take_id)
            self.state.message = f"Deleted {take.title.lower()}. Undo brings it back."

    def clear(self) -> None:
        """Delete the takes that are neither kept nor starred; undo brings them back."""
        gone = self.takes.clear()
        what = counted(gone, "take")
        self.state.message = f"Cleared {what}. Undo brings them back." if gone else "Nothing to clear."

    def undo(self) -> None:
        """Take the last step back."""
        name = self.takes.undo()
        if name:
            self.state.message = f"Undid: {name}"

    def redo(self) -> None:
        """Bring the last step taken back again."""
        name = self.takes.redo()
        if name:
            self.state.message = f"Redid: {name}"

    def takes_moved(self) -> None:
        """Others changed the takes."""
        self._takes_changed(self.takes)

    def _search(self, *_: Any) -> None:
        query = Query.parse(self.state.search)
        self.state.found = [take.id for take in self.state.takes if query.matches(take)] if query else None

    def _takes_changed(self, takes: TakeList) -> None:
        self.projects.show_saved()
        if takes is not self.takes:
            return
        state = self.state
        before = [take.id for take in state.takes]
        now = takes.all
        ids = [take.id for take in now]
        state.param.update(takes=now, undo_name=takes.undo_name, redo_name=takes.redo_name)
        if state.selected not in ids:
            place = before.index(state.selected) if state.selected in before else len(ids)
            left = [i for i in before[place + 1 :] + before[:place][::-1] if i in ids]
            newest = [take.id for take in takes.group_of(ids[-1])] if ids else [""]
            state.selected = (left or newest)[0]
        self.dressing.follow()
        self.arranging.follow()
        if any(i not in ids for i in state.compared):
            state.compared = [i for i in state.compared if i in ids]
        self._restage()

    def _restage(self, *_: Any) -> None:
        """Which takes the stage shows: the draw of the selected one, that one alone, or those ticked."""
        state = self.state
        if state.stage_mode == "compare" and state.compared:
            ids = list(state.compared)
        elif state.stage_mode == "one":
            ids = [state.selected] if state.selected else []
        else:
            ids = [take.id for take in self.takes.group_of(state.selected)]
        if ids[:STAGE_LIMIT] != state.shown:
            state.shown = ids[:STAGE_LIMIT]

    # ---- plumbing -----------------------------------------------------------------------------------------

    def _engine_asked(self, *_: Any) -> None:
        if (self.state.engine, self.state.variant) != self._loaded:
            self._load_engine()

    def _load_engine(self, then: Callable[[], None] | None = None) -> None:
        state = self.state
        name, variant = state.engine, state.variant
        state.param.update(engine_ready=False, generate_error="")

        def show(job: Job) -> None:
            if (name, variant) != (state.engine, state.variant):
                return
            if job.status == "failed":
                state.generate_error = job.error
            elif job.status == "done":
                self._loaded = (name, job.result.variant)
                state.describe(job.result)
                if then is not None:
                    then()

        self.submit(f"load {name}", lambda _progress, _cancel: tasks.load_engine(name, variant), show)

    def submit(self, title: str, work: Work, show: Callable[[Job], None], lane: str = "generate") -> Job:
        """Run work in the queue; `show(job)` is called on the state's thread, at most once after the end."""
        waiting = threading.Event()
        ended = threading.Event()

        def act(job: Job) -> None:
            waiting.clear()
            if ended.is_set():
                return
            # a copy, since the worker goes on: a job that ends while it is shown must not be shown as ended twice
            seen = copy(job)
            if seen.finished:
                ended.set()
            show(seen)

        def changed(job: Job) -> None:
            if job.finished or not waiting.is_set():
                waiting.set()
                self.dispatch(lambda: act(job))

        return self.queue.submit(self.id, title, work, lane=lane, on_change=changed)
