"""What happens when a person asks an engine for motions from a notebook. No widgets in here."""

from __future__ import annotations

import random
import threading
import uuid
from collections.abc import Callable
from typing import Any

import param

from engines import Motion
from engines.errors import MotionloomError, OutOfRangeError, UnknownLabelError
from studio import draws, tasks
from studio.attention import Attention
from studio.captioning import Captioning
from studio.given import Given
from studio.jobs import Cancel, Job, JobQueue, Progress, Work, shared_queue
from studio.pinning import Pinning
from studio.settings import MAX_STRENGTH, GenerateSettings, usual_engine
from studio.state import StudioState
from studio.takes import Take, TakeList
from studio.wording import counted

BEGIN = ("action", "style", "prompt", "seconds", "count", "seed", "guidance", "best_of", "bone_scale")
"""Settings that a maker may begin with."""
MANNER = ("motion", "style", "like", "strength", "tempo", "count", "seed")
"""The same where a motion is put in another manner."""


class Manner(StudioState):
    """The state where an engine puts a motion in another manner, instead of making one."""

    motion = param.ClassSelector(class_=Given, doc="That motion.")
    like = param.ClassSelector(class_=Given, doc="One whose manner it takes; None: the style's, or one by chance.")
    strength = param.Number(1.0, bounds=(0, MAX_STRENGTH), doc="How much of it.")
    tempo = param.Boolean(False, doc="Whether it becomes as fast as the style is.")

    def problem(self) -> str:
        """Why Generate cannot be pressed; empty when it can."""
        return "" if self.motion else "Give a motion: panel(engine, motion=walk)."

    def generate_settings(self) -> GenerateSettings:
        """What Generate would ask for."""
        return GenerateSettings(
            engine=self.engine, variant=self.variant, action="", style="" if self.like else self.style, seed=self.seed,
            count=self.count, given=self.motion, like=self.like, strength=self.strength, tempo=self.tempo,
        )  # fmt: skip

    def forecast(self) -> str:
        """One line on what Generate will bring."""
        return f"{counted(self.count, 'take')}: {self.generate_settings().subject} × {self.strength:g}"


class Maker:
    """An engine, what it is asked, and the takes it made.

    `state` is what the controls show and change, as in the app. Work runs on the job queue's threads, and what comes
    of it is put into the state there, under `lock`; whoever changes the state from elsewhere holds it too.

    Args:
        engine: name of an engine, or one that is loaded.
        queue: where work runs; the process's shared one unless given.
        settings: to begin with, of `BEGIN`.

    Raises:
        UnknownLabelError: no such engine, setting, action or style.
        OutOfRangeError: a value that is not accepted.
    """

    def __init__(self, engine: Any = "", queue: JobQueue | None = None, **settings: Any) -> None:
        named = isinstance(engine, str)
        self.engine = tasks.load_engine(engine or usual_engine()) if named else engine
        self.queue = queue or shared_queue()
        self.lock = threading.RLock()
        self.takes = TakeList(on_change=self._takes_changed)
        only_stylises = "stylise" in self.engine.capabilities and "actions" not in self.engine.capabilities
        kind = Manner if only_stylises else StudioState
        self.state = kind(engine=self.engine.name)
        # one that was brought along has its own weights; another variant would be another engine
        self.choice = tuple(getattr(self.engine, "variants", ())) if named else ()
        # of a session these use the state, the takes and the queue alone
        self.pins = Pinning(self)  # type: ignore[arg-type]
        self.captioning = Captioning(self)  # type: ignore[arg-type]
        self.attention = Attention(self, lambda take: take.motion)  # type: ignore[arg-type]
        self._id = uuid.uuid4().hex
        self._drawing: Job | None = None
        self._settled = threading.Event()
        self._settled.set()
        self._describe()
        self.state.param.watch(self._expect, ["prompt", "action", "request", "as_long", "pinned", "variant"])
        self._begin(settings)
        self._expect()
        self._draws = 0

    # ---- asking -------------------------------------------------------------------------------------------

    def generate(self) -> None:
        """Draw takes by the state's settings; a seed that is not locked is changed first (not on the first draw).

        Raises:
            MotionloomError: something is asked that cannot be; the message says what.
        """
        with self.lock:
            state = self.state
            if state.generating:
                return
            if state.problem():
                raise MotionloomError(state.problem())
            if self._draws and not state.seed_locked:
                state.seed = random.randrange(10_000)
            self._draws += 1
            asked = state.generate_settings()
            self._settled.clear()
            state.param.update(generating=True, generate_progress=0.0, generate_error="", generate_note="", tool="none")
            title = f"{asked.count} × {asked.subject[:60]}"
            self._drawing = self.queue.submit(
                self._id, title, lambda *told: self._draw(asked, *told), on_change=self._heard
            )

    def cancel(self) -> None:
        """Stop the draw under way."""
        if self._drawing is not None:
            self._drawing.cancel()

    def wait(self, timeout: float | None = None) -> bool:
        """Block until no draw is under way; False when the time ran out first."""
        return self._settled.wait(timeout)

    def load(self, variant: str) -> None:
        """Another variant of the engine.

        Raises:
            CheckpointError: its weights are missing.
        """
        with self.lock:
            if variant != self.engine.variant:
                self.engine = tasks.load_engine(self.engine.name, variant)
                self._describe()

    def choose(self, take_id: str) -> None:
        """Pick a take."""
        with self.lock:
            if take_id in self.takes:
                self.state.selected = take_id

    @property
    def drawn(self) -> tuple[Take, ...]:
        """The takes of the draw of the chosen one."""
        return self.takes.group_of(self.state.selected)

    def submit(self, title: str, work: Work, show: Callable[[Job], None], lane: str = "generate") -> Job:
        """Run work in the queue; `show(job)` is called under the lock, with progress and at the end."""

        def heard(job: Job) -> None:
            with self.lock:
                show(job)

        return self.queue.submit(self._id, title, work, lane=lane, on_change=heard)

    # ---- what comes of it ---------------------------------------------------------------------------------

    def _draw(self, asked: GenerateSettings, progress: Progress, cancel: Cancel) -> Any:
        made = tasks.generate_with(self.engine, asked, progress, cancel)
        return asked, made, [dict(tasks.measure(motion)) for motion in made]

    def _heard(self, job: Job) -> None:
        with self.lock:
            if job is not self._drawing:
                return
            state = self.state
            state.generate_progress = job.fraction
            if not job.finished:
                return
            try:
                if job.status == "failed":
                    state.generate_error = job.error
                elif job.status == "cancelled":
                    state.message = f"Cancelled: {job.title}"
                else:
                    asked, motions, metrics = job.result
                    made = self.takes.add(motions, group=uuid.uuid4().hex, settings=asked, metrics=metrics)
                    state.param.update(selected=made[0].id, generate_note=draws.note_of(motions), message="")
            finally:
                state.generating = False
                self._settled.set()

    def _takes_changed(self, takes: TakeList) -> None:
        self.state.takes = takes.all

    # ---- what the engine can do ---------------------------------------------------------------------------

    def _describe(self) -> None:
        """Copy what the engine says about itself into the state."""
        self.state.describe(self.engine, self.choice)
        self.state.request = "action" if self.state.actions else "text"

    def _expect(self, *_: Any) -> None:
        """Say how long the motion will be, where the engine finds that."""
        if not self.state.finds_length or self.state.problem():
            return
        try:
            frames = tasks.expected_frames(self.state.generate_settings(), self.engine)
        except MotionloomError:
            frames = 0  # the draw will say what is wrong with the prompt
        self.state.expect(frames)

    def _begin(self, given: dict[str, Any]) -> None:
        known = MANNER if isinstance(self.state, Manner) else BEGIN
        for name in given:
            if name not in known:
                raise UnknownLabelError("setting", name, known)
        if given.get("prompt") and given.get("action"):
            raise MotionloomError("an action and a prompt cannot be asked at once; give one of them.")
        told = {name: given[name] for name in ("style", "prompt", "guidance", "best_of", "bone_scale") if name in given}
        tasks.told(GenerateSettings(engine=self.engine.name, **told), self.engine)
        if given.get("style") and given["style"] not in self.state.styles:
            raise UnknownLabelError("style", given["style"], self.state.styles)
        for name, value in given.items():
            self._set(name, value)
        if given and self.state.problem():
            raise MotionloomError(self.state.problem())

    def _set(self, name: str, value: Any) -> None:
        if name == "seconds":
            name, value = "frames", round(float(value) * self.state.fps)
            self.state.as_long = False
        if isinstance(value, Motion):
            value = Given.of(value, value.provenance.source or name, self.state.fps)
        try:
            self.state.param.update(**{name: value})
        except ValueError:
            bounds = getattr(self.state.param[name], "bounds", None)
            accepted = (
                f"{bounds[0]:,} to {bounds[1]:,}" if bounds else f"a value like {self.state.param[name].default!r}"
            )
            raise OutOfRangeError(name, value, accepted) from None
        if name == "prompt" and value:
            self.state.request = "text"
