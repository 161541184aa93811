"""The studio without weights and without a browser."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator

import pytest

from engines import Motion, registry
from engines.metrics import physical
from studio import captions, cli, tasks, thumbnails
from studio.jobs import JobQueue
from studio.session import Session
from tests.studio.fakes import ConstrainedEngine, FakeEngine
from viewers.bodies import Body


@pytest.fixture
def run(monkeypatch, capsys, tmp_path) -> Callable[..., tuple[int, str, str]]:
    """`run("generate", "walk") -> (code, stdout, stderr)`, in an empty folder with an empty cache."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MOTIONLOOM_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv("COLUMNS", "200")
    monkeypatch.setenv("NO_COLOR", "1")

    def call(*arguments: str) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["motionloom", *arguments])
        code: object = 0
        try:
            cli.main()
        except SystemExit as stop:
            code = stop.code
        printed = capsys.readouterr()
        return int(str(code or 0)), printed.out, printed.err

    return call


@pytest.fixture
def engine(monkeypatch: pytest.MonkeyPatch) -> FakeEngine:
    """A fake in place of every engine; thumbnails are a word and captions none, since they have tests of their own."""
    return _in_place_of_every_engine(FakeEngine(), monkeypatch)


@pytest.fixture
def constrained(engine: FakeEngine, monkeypatch: pytest.MonkeyPatch) -> ConstrainedEngine:
    """The same with a fake that takes styles, words and pins."""
    fake = ConstrainedEngine()
    _in_place_of_every_engine(fake, monkeypatch)
    return fake


def _picture(_motion: Motion, colour: str = "", body: str | Body = "anny") -> str:
    shown = body if isinstance(body, str) else f"{body.name} {body.shape}"
    return f"data:image/webp;base64,{colour} {shown}"


def _in_place_of_every_engine(fake: FakeEngine, monkeypatch: pytest.MonkeyPatch) -> FakeEngine:
    def load(_name: str, variant: str = "") -> FakeEngine:
        fake.variant = variant or "plain"
        return fake

    monkeypatch.setattr(tasks, "load_engine", load)
    monkeypatch.setattr(registry, "captioners", dict)
    monkeypatch.setattr(captions, "judge", lambda: None)
    monkeypatch.setattr(thumbnails, "thumbnail", _picture)
    monkeypatch.setattr(physical, "REAL", {"foot_skate": 0.04, "jitter": 40.0, "ground_penetration": 0.001})
    return fake


@pytest.fixture
def queue() -> Iterator[JobQueue]:
    made = JobQueue()
    yield made
    made.close()


@pytest.fixture
def session(engine: FakeEngine, queue: JobQueue) -> Iterator[Session]:
    made = Session(queue=queue)
    yield made
    made.close()


@pytest.fixture
def settle(queue: JobQueue) -> Callable[[Session], None]:
    """Wait until a session has no unfinished work, that which other work brings up included."""

    def wait(session: Session) -> None:
        # twice: work may have gone from a lane not yet looked at to one that was
        while jobs := queue.jobs(session.id) or queue.jobs(session.id):
            assert jobs[0].wait(20), f"{jobs[0].title} does not end"

    return wait
