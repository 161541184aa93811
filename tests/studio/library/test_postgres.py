"""The same library in PostgreSQL, where its programs and the driver are installed."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from studio.library import Library, open_library
from studio.takes import TakeList
from tests.studio.fakes import sway
from tests.studio.library.test_shelf import seen

NOBODY = 65534


def programs() -> Path | None:
    """The folder of initdb and pg_ctl."""
    found = shutil.which("initdb")
    folders = [Path(found).parent] if found else sorted(Path("/usr/lib/postgresql").glob("*/bin"))
    return next((folder for folder in reversed(folders) if (folder / "initdb").exists()), None)


def _as_somebody() -> None:
    """The server refuses to run as root."""
    if os.geteuid() == 0:
        os.setgid(NOBODY)
        os.setuid(NOBODY)


@pytest.fixture(scope="module")
def server() -> Iterator[str]:
    """Address of a server of our own, reached by a socket in its folder."""
    pytest.importorskip("psycopg")
    folder = programs()
    if folder is None:
        pytest.skip("no PostgreSQL: install it to test libraries in it")
    with tempfile.TemporaryDirectory(prefix="pg-", dir="/tmp") as home:
        if os.geteuid() == 0:
            os.chown(home, NOBODY, NOBODY)
        data = f"{home}/data"
        options = f"-c listen_addresses='' -c unix_socket_directories='{home}' -c fsync=off"

        def run(*command: str) -> None:
            done = subprocess.run(
                command, check=False, capture_output=True, text=True, preexec_fn=_as_somebody, cwd=home, timeout=120,
                stdin=subprocess.DEVNULL,
            )  # fmt: skip
            assert done.returncode == 0, done.stdout + done.stderr

        run(str(folder / "initdb"), "-D", data, "-U", "anna", "-A", "trust", "--no-sync", "-E", "UTF8", "--locale=C")
        run(str(folder / "pg_ctl"), "-D", data, "-w", "-l", f"{home}/log", "-o", options, "start")
        yield f"postgresql://anna@/postgres?host={home}"
        run(str(folder / "pg_ctl"), "-D", data, "-m", "immediate", "stop")


@pytest.fixture
def library(server) -> Iterator[Library]:
    made = open_library(server)
    yield made
    made.close()


def test_takes_history_and_search(library, server, draw):
    key = library.create("Scene")
    takes = TakeList(library.shelf(key))
    draw(takes, 3, action="", prompt="waves, 100% sure")
    takes.mark("take-2", favourite=True, tags=("good",))
    takes.remove("take-1")
    takes.undo()
    draw(takes, 1, seed=7)
    takes.store.keep_pictures({1: "data:one"})
    other = open_library(server)
    again = TakeList(other.shelf(key))
    assert seen(again) == seen(takes)
    assert (again.undo_name, again.redo_name) == ("generate walk", "")
    assert (again.get("take-4").motion.rotations == sway("walk", 8, 7, 0).rotations).all()
    assert other.shelf(key).pictures() == {"take-1": "data:one"}
    assert [take.number for take in other.search("100% tag:good is:starred")] == [2]
    other.rename(key, "Other name")
    assert [project.name for project in library.projects()] == ["Other name"]
    library.delete(key)
    library.tidy()
    assert [project.key for project in other.projects(deleted=True)] == [key]
    other.close()


def test_two_programs_in_one_project(library, server, draw):
    key = library.create("Scene")
    libraries = [open_library(server) for _ in range(2)]

    def work(number: int) -> None:
        takes = TakeList(libraries[number].shelf(key))
        for seed in range(10):
            (made,) = draw(takes, 1, seed=seed, group=f"{number}-")
            takes.mark(made, favourite=True)
            assert takes.store.problem == ""

    workers = [threading.Thread(target=work, args=(number,)) for number in range(2)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join(100)
    takes = TakeList(library.shelf(key))
    assert [take.number for take in takes] == list(range(1, 21))
    assert all(take.favourite for take in takes)
    assert sorted(take.group for take in takes) == sorted(f"{n}-{seed}" for n in range(2) for seed in range(10))
    for one in libraries:
        one.close()
