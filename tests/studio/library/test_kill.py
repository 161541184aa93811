"""kill -9 at any moment: what was said to be saved is there, nothing is there by halves.

A handful of kills here; MOTIONLOOM_KILLS=100 does it a hundred times.
"""

from __future__ import annotations

import os
import random
import signal
import sqlite3
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

import engines
from studio.library import open_library
from studio.takes import MemoryStore, TakeList
from tests.studio.fakes import sway
from tests.studio.library import worker

ROOT = Path(__file__).resolve().parents[3]
KILLS = int(os.environ.get("MOTIONLOOM_KILLS", "3"))

pytestmark = [
    pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="this system cannot kill so"),
    pytest.mark.timeout(300 + 30 * KILLS),
]


@contextmanager
def working(*arguments: str) -> Iterator[subprocess.Popen]:
    command = [sys.executable, "-m", "tests.studio.library.worker", *arguments]
    process = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True)
    try:
        yield process
    finally:
        process.kill()
        process.wait(20)


def lines(process: subprocess.Popen, seconds: float, first: int = 1) -> list[str]:
    """What a worker says until it is killed, some time after its first lines."""
    said = [process.stdout.readline().strip() for _ in range(first)]
    time.sleep(seconds)
    process.send_signal(signal.SIGKILL)
    rest = process.stdout.read()
    # a line without an end was cut off while it was said
    return said + [line.strip() for line in rest.splitlines(keepends=True) if line.endswith("\n")]


def expected(count: int) -> list[list[tuple]]:
    """The states after 0, 1, ... `count` steps."""
    takes = TakeList(MemoryStore())
    states = [worker.state(takes)]
    for number in range(count):
        worker.step(takes, number)
        states.append(worker.state(takes))
    return states


@pytest.mark.parametrize("kill", range(KILLS))
def test_killed_while_saving(tmp_path, kill):
    """Two programs at work in one library are killed, each in its project."""
    file = tmp_path / "library.db"
    library = open_library(str(file))
    keys = [library.create(f"Scene {i}") for i in range(2)]
    library.close()
    moment = random.Random(kill)
    with working("steps", str(file), keys[0]) as one, working("steps", str(file), keys[1]) as other:
        said = [lines(process, moment.uniform(0, 0.6)) for process in (one, other)]
    again = open_library(str(file))
    for key, done in zip(keys, said, strict=True):
        count = int(done[-1]) + 1
        states = expected(count + 1)
        takes = TakeList(again.shelf(key))
        assert worker.state(takes) in states[count:], f"after {count} steps that were said to be saved"
        assert all(worker.right(take) for take in takes)
    again.close()
    with sqlite3.connect(file) as connection:
        assert connection.execute("pragma integrity_check").fetchone() == ("ok",)
        assert connection.execute("pragma foreign_key_check").fetchall() == []
    assert {path.name for path in tmp_path.iterdir()} <= {"library.db", "library.db-wal", "library.db-shm"}


@pytest.mark.parametrize("kill", range(KILLS))
def test_killed_while_exporting(tmp_path, kill):
    with working("exports", str(tmp_path)) as process:
        done = lines(process, random.Random(kill).uniform(0, 0.5), first=2)
    whole = sway(frames=400)
    found = {path.name for path in tmp_path.iterdir() if not path.name.startswith(".")}
    assert set(done) <= found
    for name in found:
        path = tmp_path / name
        if name.endswith(".csv"):
            text = path.read_text()
            assert text.endswith("\n")
            assert len(text.splitlines()) == 401
        else:
            assert engines.read(path).frames == whole.frames
    assert sum(path.name.startswith(".") for path in tmp_path.iterdir()) <= 1, "the one it was about to write"


def test_a_process_that_is_split_off_writes_through_connections_of_its_own(tmp_path):
    """As a server of several processes does, which is split after the library was opened."""
    library = open_library(str(tmp_path / "library.db"))
    key = library.create("Scene")
    takes = TakeList(library.shelf(key))
    worker.step(takes, 0)
    child = os.fork()
    if child == 0:
        code = 1
        try:
            worker.step(TakeList(library.shelf(key)), 0)
            code = 0
        finally:
            os._exit(code)
    worker.step(takes, 4)
    assert os.waitpid(child, 0)[1] == 0
    takes.store.refresh()
    assert [take.number for take in takes] == list(range(1, 10))
    assert all(worker.right(take) for take in takes)
    library.close()


def test_two_programs_at_work_in_one_project(tmp_path):
    """Each sees the other's steps come in between its own; in the end all is whole."""
    file = tmp_path / "library.db"
    library = open_library(str(file))
    key = library.create("Scene")
    with working("steps", str(file), key) as one, working("steps", str(file), key) as other:
        said = [lines(process, 1.5) for process in (one, other)]
    assert all(len(done) > 3 for done in said)
    takes = TakeList(library.shelf(key))
    assert all(worker.right(take) for take in takes)
    numbers = [take.number for take in takes]
    assert len(set(numbers)) == len(numbers)
    while takes.undo():
        pass
    while takes.redo():
        pass
    assert all(worker.right(take) for take in takes)
    library.close()
    with sqlite3.connect(file) as connection:
        assert connection.execute("pragma integrity_check").fetchone() == ("ok",)
