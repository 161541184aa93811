"""Long work off the UI thread: generation, pictures and exports, with progress, cancel and fairness.

One `JobQueue` serves every browser session. It has lanes, each with its own threads, so that a video of one person
never holds up the thumbnails of another; inside a lane the owners take turns. Pictures and words of takes wait a while
for draws, so that many who draw at once all have their takes first. No Panel in here: whoever listens to a
job decides on which thread to act (the app hops to the document's thread, a test acts at once).
"""

from __future__ import annotations

import logging
import threading
import time
from collections import OrderedDict, deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Literal

from engines.errors import Cancelled, MotionloomError

log = logging.getLogger(__name__)

JobStatus = Literal["queued", "running", "done", "failed", "cancelled"]
Progress = Callable[[int, int | None], None]
"""Called with steps done and in all; None where nobody knows."""
Cancel = Callable[[], bool]
Work = Callable[[Progress, Cancel], Any]

LANES = {
    "generate": 2,
    # one thread, so that its OpenGL context (bound to the thread that made it) is made once and kept
    "still": 1,
    "file": 2,
    "caption": 1,
}
"""Lane -> number of threads."""
AFTER = {"still": "generate", "caption": "generate"}
"""Lane -> the one that goes first: takes of all are there before pictures and words of any."""
PATIENCE = 5.0
"""Seconds for which a job lets others go first, from when it was asked for."""

_NOTIFY_EVERY = 0.05


@dataclass(eq=False)
class Job:
    """One piece of work: its state, how far it is, and what came of it. Read it from any thread."""

    owner: str
    """Who asked (a browser session); owners take turns."""
    title: str
    """What is being done, for a person: "4 × walk", "take-2.mp4"."""
    work: Work
    """`work(progress, cancel) -> result`, run on a lane's thread."""
    lane: str = "generate"
    status: JobStatus = "queued"
    done: int = 0
    """Steps done so far."""
    total: int = 0
    """Steps in all; 0 while unknown."""
    error: str = ""
    """One line for the person, when failed."""
    result: Any = None
    asked: float = field(default_factory=time.monotonic)
    """When, on the clock `time.monotonic`."""
    on_change: Callable[[Job], None] | None = None
    """Called on the worker's thread when the status or progress changes (progress at most 20 times a second)."""
    _cancel: threading.Event = field(default_factory=threading.Event, repr=False)
    _finished: threading.Event = field(default_factory=threading.Event, repr=False)
    _lock: threading.Lock = field(default_factory=threading.Lock, repr=False)
    _told: float = 0.0

    @property
    def finished(self) -> bool:
        """Done, failed or cancelled."""
        return self.status in ("done", "failed", "cancelled")

    @property
    def fraction(self) -> float:
        """How much is done, 0 to 1."""
        return min(1.0, self.done / self.total) if self.total else float(self.status == "done")

    def cancel(self) -> None:
        """Ask the work to stop: at once while it waits in line, else at its next step."""
        self._cancel.set()
        with self._lock:
            waiting = self.status == "queued"
            if waiting:
                self.status = "cancelled"
        if waiting:
            self._finish("cancelled")

    def cancel_asked(self) -> bool:
        """Was `cancel` called?"""
        return self._cancel.is_set()

    def wait(self, timeout: float | None = None) -> bool:
        """Block until it is finished; False when the time ran out first."""
        return self._finished.wait(timeout)

    def _progress(self, done: int, total: int | None) -> None:
        if self._cancel.is_set():
            raise Cancelled(f"{self.title} was cancelled")
        self.done, self.total = int(done), int(total or 0)
        now = time.monotonic()
        # the last step is as good as the end, which is told by itself
        if now - self._told >= _NOTIFY_EVERY and self.done != self.total:
            self._told = now
            self._notify()

    def _notify(self) -> None:
        if self.on_change is None:
            return
        try:
            self.on_change(self)
        except Exception:
            # a listener whose browser has gone must not take the worker down with it
            log.exception("listener of job %r failed", self.title)

    def _run(self) -> None:
        with self._lock:
            if self.status != "queued":
                return
            self.status = "running"
        self._notify()
        try:
            self.result = self.work(self._progress, self._cancel.is_set)
        except Cancelled:
            self._finish("cancelled")
        except MotionloomError as problem:
            self._finish("failed", str(problem))
        except Exception as problem:
            log.exception("job %r failed", self.title)
            self._finish("failed", f"{self.title} failed: {type(problem).__name__}: {problem}")
        else:
            self._finish("done")

    def _finish(self, status: JobStatus, error: str = "") -> None:
        self.error, self.status = error, status
        self._finished.set()
        self._notify()


class _Lane:
    """Threads that take jobs from the owners in turn; those of the lane `before` go first."""

    def __init__(self, name: str, threads: int, before: _Lane | None = None) -> None:
        self.name, self.before = name, before
        self.waiting: OrderedDict[str, deque[Job]] = OrderedDict()
        self.running: list[Job] = []
        lock = threading.Lock()
        self.ready, self.rest = threading.Condition(lock), threading.Condition(lock)
        self.closed = False
        self.threads = [
            threading.Thread(target=self._serve, name=f"motionloom-{name}-{i}", daemon=True) for i in range(threads)
        ]
        for thread in self.threads:
            thread.start()

    def put(self, job: Job) -> None:
        with self.ready:
            if self.closed:
                raise RuntimeError("the job queue is closed")
            self.waiting.setdefault(job.owner, deque()).append(job)
            self.ready.notify()

    def _take(self) -> Job | None:
        """The next job: of the owners waiting, the one with the least running; of those, the one served longest ago."""
        with self.ready:
            while not self.waiting:
                if self.closed:
                    return None
                self.ready.wait()
            busy = [job.owner for job in self.running]
            owner = min(self.waiting, key=busy.count)
            line = self.waiting.pop(owner)
            job = line.popleft()
            if line:
                self.waiting[owner] = line  # to the back
            self.running.append(job)
            return job

    def _serve(self) -> None:
        while (job := self._take()) is not None:
            try:
                if self.before is not None:
                    self.before.let_rest(job.asked + PATIENCE - time.monotonic())
                job._run()
            finally:
                with self.ready:
                    self.running.remove(job)
                    self.rest.notify_all()

    def let_rest(self, seconds: float) -> None:
        """Wait until nothing is in line or at work here, for so many seconds at most."""
        with self.rest:
            self.rest.wait_for(lambda: self.closed or not (self.waiting or self.running), max(0.0, seconds))

    def of(self, owner: str) -> list[Job]:
        with self.ready:
            return [job for job in self.running if job.owner == owner] + list(self.waiting.get(owner, ()))

    def close(self) -> None:
        with self.ready:
            self.closed = True
            for job in [*self.running, *(job for line in self.waiting.values() for job in line)]:
                job.cancel()
            self.ready.notify_all()
            self.rest.notify_all()


class JobQueue:
    """The lanes, their threads started when first needed.

    Args:
        lanes: lane name -> number of threads.
    """

    def __init__(self, lanes: dict[str, int] | None = None) -> None:
        self._sizes = dict(LANES if lanes is None else lanes)
        self._lanes: dict[str, _Lane] = {}
        self._lock = threading.Lock()

    def submit(
        self,
        owner: str,
        title: str,
        work: Work,
        *,
        lane: str = "generate",
        on_change: Callable[[Job], None] | None = None,
    ) -> Job:
        """Put work in line.

        Args:
            owner: who asks; owners take turns within a lane.
            title: what it is, for a person.
            work: `work(progress, cancel) -> result`. `progress(done, total)` raises Cancelled once the job is
                cancelled, so work that reports progress can be stopped without asking `cancel()`.
            lane: "generate", "still" or "file".
            on_change: called on the worker's thread at every change.
        """
        job = Job(owner, title, work, lane, on_change=on_change)
        self._lane(lane).put(job)
        return job

    def _lane(self, name: str) -> _Lane:
        """The lane of that name, made when first asked for."""
        before = self._lane(AFTER[name]) if AFTER.get(name) in self._sizes else None
        with self._lock:
            if name not in self._lanes:
                self._lanes[name] = _Lane(name, self._sizes[name], before)
            return self._lanes[name]

    def jobs(self, owner: str) -> list[Job]:
        """The owner's unfinished jobs, running ones first."""
        return [job for lane in list(self._lanes.values()) for job in lane.of(owner)]

    def cancel_all(self, owner: str) -> None:
        """Cancel everything an owner asked for (its browser has gone)."""
        for job in self.jobs(owner):
            job.on_change = None
            job.cancel()

    def close(self) -> None:
        """Cancel everything and let the threads end."""
        for lane in self._lanes.values():
            lane.close()


_shared: JobQueue | None = None
_shared_lock = threading.Lock()


def shared_queue() -> JobQueue:
    """The queue all sessions of this process share."""
    global _shared  # noqa: PLW0603 (one queue a process is the point)
    with _shared_lock:
        if _shared is None:
            _shared = JobQueue()
        return _shared
