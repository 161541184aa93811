"""What a library may be instead of one that works: each is said in words, and the studio starts all the same."""

from __future__ import annotations

import os
import sqlite3
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from sqlalchemy import Column, Text, event, update

from engines.errors import MissingDependencyError
from studio import app
from studio.library import LibraryError, database, open_library, schema
from studio.takes import TakeList

ROOT = Path(__file__).resolve().parents[3]
NOBODY = 65534


def refused(url: object) -> str:
    with pytest.raises(LibraryError) as caught:
        open_library(str(url))
    return str(caught.value)


def test_a_file_that_is_no_database(tmp_path):
    file = tmp_path / "library.db"
    file.write_text("these are my notes, and not a database at all " * 40)
    assert refused(file) == f"Library {file}: this file is no library; choose another with --library."
    assert file.read_text().startswith("these are my notes")


def test_a_database_of_something_else_is_left_alone(tmp_path):
    file = tmp_path / "songs.db"
    with sqlite3.connect(file) as connection:
        connection.execute("create table songs (name text)")
    assert "this database is no library" in refused(file)
    with sqlite3.connect(file) as connection:
        assert connection.execute("select name from sqlite_master").fetchall() == [("songs",)]


def test_a_file_cut_in_half(library, file, draw):
    draw(TakeList(library.shelf(library.create("Scene"))), 4)
    library.close()
    whole = file.read_bytes()
    file.write_bytes(whole[: len(whole) // 2 + 100])
    assert "damaged" in refused(file)


def test_a_library_of_a_later_version(library, file):
    with database.writing(library.engine) as connection:
        connection.execute(update(schema.about).values(version=schema.VERSION + 1))
    library.close()
    said = refused(file)
    assert (
        f"written by a later motionloom (version {schema.VERSION + 1}; this one reads up to {schema.VERSION})" in said
    )
    assert "update motionloom" in said


def test_a_place_where_nothing_can_be_made(tmp_path):
    (tmp_path / "file").write_text("")
    assert "its folder cannot be made" in refused(tmp_path / "file" / "library.db")
    assert "cannot be opened or made there" in refused(tmp_path)


def test_a_file_that_may_only_be_read(library, file):
    library.create("Scene")
    library.close()
    said = refused(f"sqlite:///file:{file}?mode=ro&uri=true")
    assert "it cannot be written to; allow it, or choose another place with --library" in said


@pytest.mark.skipif(sys.platform == "win32", reason="folders there have no such rights")
def test_a_folder_that_may_only_be_read(tmp_path):
    folder = tmp_path / "mine"
    folder.mkdir()
    folder.chmod(0o555)
    for parent in folder.parents[:3]:
        parent.chmod(parent.stat().st_mode | 0o055)
    root = os.geteuid() == 0
    if root:
        os.seteuid(NOBODY)  # root may write anywhere
    try:
        said = refused(folder / "library.db")
    finally:
        if root:
            os.seteuid(0)
    assert "cannot be opened or made there; choose another place with --library" in said


@pytest.mark.parametrize(
    ("url", "said"),
    [
        ("sqlite://", "names no file"),
        ("sqlite:///:memory:", "names no file"),
        ("nonsense://x", "is no kind of database known"),
        ("://", "is neither a path nor a database address"),
    ],
)
def test_addresses_that_are_none(url, said):
    assert said in refused(url)


def test_a_driver_that_is_not_installed_is_named_with_what_brings_it(monkeypatch):
    def missing(*_args, **_options):
        raise ModuleNotFoundError("No module named 'psycopg'", name="psycopg")

    monkeypatch.setattr(database, "create_engine", missing)
    with pytest.raises(MissingDependencyError, match=r"psycopg.*motionloom\[postgres\]"):
        open_library("postgresql://localhost/motions")


def test_a_server_that_does_not_answer_and_no_word_of_the_password():
    pytest.importorskip("psycopg")
    said = refused("postgresql://anna:secret@127.0.0.1:9/motions")
    assert "anna:***@127.0.0.1:9/motions" in said
    assert "secret" not in said


def test_the_library_of_a_person_is_where_the_system_keeps_such_things(monkeypatch, tmp_path):
    monkeypatch.delenv("MOTIONLOOM_LIBRARY", raising=False)
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    if sys.platform == "linux":
        assert database.default_url() == str(tmp_path / "motionloom" / "library.db")
    monkeypatch.setenv("MOTIONLOOM_LIBRARY", "elsewhere.db")
    assert database.parse_url(database.default_url()).database == str(Path("elsewhere.db").absolute())


def test_the_studio_starts_without_a_library_and_says_why(tmp_path, session, settle):
    file = tmp_path / "library.db"
    file.write_text("no database " * 100)
    kept = app.keep(str(file))
    assert kept.library is None
    session.projects._problem = kept.problem
    session.start()
    settle(session)
    assert len(session.state.takes) == 4
    assert session.state.saved == "memory"
    assert session.state.saved_note == (
        f"Library {file}: this file is no library; choose another with --library. "
        "Takes are kept in memory: export what you need."
    )


# ---- versions ------------------------------------------------------------------------------------------------


@pytest.fixture
def next_version(monkeypatch):
    """The version after this one, in which projects have notes; as if it were the program's."""

    def bring(connection):
        connection.exec_driver_sql("alter table projects add column notes text not null default 'none yet'")

    monkeypatch.setattr(schema, "VERSION", schema.VERSION + 1)
    monkeypatch.setitem(schema.MIGRATIONS, schema.VERSION - 1, bring)
    yield
    assert Column("notes", Text) is not None


def notes(file: Path) -> list[tuple]:
    with sqlite3.connect(file) as connection:
        return connection.execute("select name, notes from projects").fetchall()


def test_an_older_library_is_brought_forward_after_a_copy(library, file, draw, next_version):
    key = library.create("Scene")
    draw(TakeList(library.shelf(key)), 2)
    library.close()
    newer = open_library(str(file))
    assert len(newer.shelf(key).read()) == 2
    newer.close()
    assert notes(file) == [("Scene", "none yet")]
    copy = file.with_name(f"library.version-{schema.VERSION - 1}.db")
    with sqlite3.connect(copy) as connection:
        assert connection.execute("select version from library").fetchall() == [(schema.VERSION - 1,)]
        assert connection.execute("select count(*) from takes").fetchall() == [(2,)]


def test_a_step_forward_that_fails_leaves_everything_as_it_was(library, file, next_version, monkeypatch):
    library.create("Scene")
    library.close()

    def fails(connection):
        connection.exec_driver_sql("alter table projects add column notes text")
        connection.exec_driver_sql("insert into nowhere values (1)")

    monkeypatch.setitem(schema.MIGRATIONS, schema.VERSION - 1, fails)
    assert "no such table: nowhere" in refused(file)
    with sqlite3.connect(file) as connection:
        assert connection.execute("select version from library").fetchall() == [(schema.VERSION - 1,)]
        columns = [row[1] for row in connection.execute("pragma table_info(projects)")]
    assert "notes" not in columns


def test_programs_that_start_together_make_one_library(file):
    code = f"from studio.library import open_library; library = open_library({str(file)!r}); print(library.id)"
    started = [
        subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, cwd=ROOT, text=True) for _ in range(3)
    ]
    said = {process.communicate(timeout=100)[0] for process in started}
    assert len(said) == 1
    assert [process.returncode for process in started] == [0, 0, 0]


# ---- and stops working later -----------------------------------------------------------------------------------


def full(library) -> None:
    """From now on as on a disk that is full."""

    def limit(connection):
        connection.exec_driver_sql("pragma max_page_count = 1")  # not below what there is: no page more

    event.listen(library.engine, "begin", limit)
    library._limit = limit


def emptied(library) -> None:
    event.remove(library.engine, "begin", library._limit)
    library.engine.dispose()


def test_a_full_disk_is_said_the_takes_stay_and_are_saved_once_there_is_room(library, draw):
    key = library.create("Scene")
    takes = TakeList(library.shelf(key))
    draw(takes, 1)
    full(library)
    draw(takes, 20, seed=2)
    assert takes.store.problem.endswith("library.db: the disk is full; free some space.")
    assert not takes.store.saved
    takes.mark("take-3", favourite=True)
    takes.remove("take-2")
    takes.undo()
    assert (len(takes), takes.redo_name, takes.get("take-3").favourite) == (21, "delete take 2", True)
    assert takes.get("take-9").motion.frames == 8
    assert [take.id for take in TakeList(library.shelf(key))] == ["take-1"], "nothing half written"
    assert not takes.store.refresh()
    assert not takes.store.saved, "still no room"
    emptied(library)
    takes.store.refresh()
    assert (takes.store.saved, takes.store.problem) == (True, "")
    other = TakeList(library.shelf(key))
    assert len(other) == 21
    assert (other.get("take-3").favourite, other.undo_name, other.redo_name) == (True, "star take 3", "delete take 2")


def test_numbers_given_meanwhile_by_others_are_stepped_over_once_there_is_room(library, file, draw):
    key = library.create("Scene")
    takes = TakeList(library.shelf(key))
    full(library)
    draw(takes, 20, seed=2)
    takes.mark("take-2", favourite=True)
    other = open_library(str(file))
    assert draw(TakeList(other.shelf(key)), 2, action="run") == ["take-1", "take-2"]
    other.close()
    emptied(library)
    assert takes.store.refresh(), "they are others now"
    assert [take.subject for take in takes][:3] == ["run", "run", "walk"]
    assert len(takes) == 22
    assert [take.favourite for take in takes].index(True) == 21, "the star went along"
    assert takes.undo() == "star take 2"
    assert takes.undo() == "generate walk"
    assert [take.subject for take in takes] == ["run", "run"]


def test_another_program_that_writes_for_long_is_waited_for_and_then_said(library, file, draw, monkeypatch):
    key = library.create("Scene")
    takes = TakeList(library.shelf(key))
    draw(takes, 1)
    library.engine.dispose()
    event.listen(library.engine, "connect", lambda connection, _record: connection.execute("pragma busy_timeout = 50"))
    holder = sqlite3.connect(file, isolation_level=None)
    holder.execute("begin immediate")
    takes.mark("take-1", favourite=True)
    assert "another program is writing to it" in takes.store.problem
    holder.execute("rollback")
    holder.close()
    takes.store.refresh()
    assert TakeList(library.shelf(key)).get("take-1").favourite


def test_many_threads_put_motions_in_at_once(library, draw):
    takes = [TakeList(library.shelf(library.create(f"Scene {i}"))) for i in range(6)]
    workers = [threading.Thread(target=draw, args=(each, 3), kwargs={"seed": i}) for i, each in enumerate(takes)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join(60)
    assert [(len(each), each.store.problem) for each in takes] == [(3, "")] * 6
