"""Opens a database, safely for several programs at once, and puts what goes wrong into words.

SQLite is used with a write-ahead log and `synchronous=FULL`: a transaction that was committed is on the disk, whatever
is killed afterwards, and one that was not leaves nothing. Writers begin with `BEGIN IMMEDIATE`, so that two of them
wait for each other instead of failing halfway.
"""

from __future__ import annotations

import os
import sqlite3
import tempfile
import time
import weakref
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import platformdirs
from sqlalchemy import URL, Connection, Engine, create_engine, event, inspect, make_url
from sqlalchemy.exc import ArgumentError, DBAPIError, NoSuchModuleError, SQLAlchemyError

from engines.errors import MissingDependencyError, MotionloomError
from studio.library import schema

PATIENCE = 4.0
"""Seconds a transaction waits for another program that writes."""
FILE = "library.db"
_SQLITE = {
    "SQLITE_FULL": "the disk is full; free some space",
    "SQLITE_READONLY": "it cannot be written to; allow it, or choose another place with --library",
    "SQLITE_CANTOPEN": "it cannot be opened or made there; choose another place with --library",
    "SQLITE_NOTADB": "this file is no library; choose another with --library",
    "SQLITE_CORRUPT": "the file is damaged; put a copy of it in its place (docs/library.md)",
    "SQLITE_BUSY": "another program is writing to it; it is tried again",
    "SQLITE_LOCKED": "another program is writing to it; it is tried again",
    "SQLITE_IOERR": "the disk reports an error",
    "SQLITE_PERM": "it may not be written to; allow it, or choose another place with --library",
    "SQLITE_TOOBIG": "a motion is larger than the database takes",
}  # fmt: skip


class LibraryError(MotionloomError):
    """The library cannot be opened, read or written; the message says which one, why, and what would help."""


def default_url() -> str:
    """Where the library is unless told: $MOTIONLOOM_LIBRARY, or a file in the user's data folder."""
    folder = Path(platformdirs.user_data_dir("motionloom", appauthor=False))
    return os.environ.get("MOTIONLOOM_LIBRARY") or str(folder / FILE)


def parse_url(text: str) -> URL:
    """A SQLAlchemy URL; a plain path means a SQLite file.

    Raises:
        LibraryError: it is neither.
    """
    if "://" not in text:
        return URL.create("sqlite", database=str(Path(text).expanduser().absolute()))
    try:
        url = make_url(text)
    except (ArgumentError, ValueError) as problem:
        raise LibraryError(f"--library {text!r} is neither a path nor a database address ({problem}).") from None
    if url.drivername in ("postgresql", "postgres"):
        url = url.set(drivername="postgresql+psycopg")
    if url.get_backend_name() == "sqlite" and url.database in (None, "", ":memory:"):
        raise LibraryError(f"--library {text!r} names no file; accepted: a path, or sqlite:///PATH.")
    return url


def connect(url: URL) -> Engine:
    """An engine for a database, nothing opened yet.

    Raises:
        LibraryError: an unknown kind of database, or a folder that cannot be made.
        MissingDependencyError: its driver is not installed.
    """
    sqlite = url.get_backend_name() == "sqlite"
    if sqlite and "uri" not in url.query:
        try:
            Path(str(url.database)).parent.mkdir(parents=True, exist_ok=True)
        except OSError as problem:
            raise LibraryError(_said(url, f"its folder cannot be made: {problem.strerror}")) from None
    options: dict[str, Any] = {"connect_args": {"timeout": PATIENCE}} if sqlite else {"pool_pre_ping": True}
    try:
        engine = create_engine(url, **options)
    except NoSuchModuleError:
        raise LibraryError(
            f"--library: {url.drivername!r} is no kind of database known; accepted: sqlite, postgresql."
        ) from None
    except ModuleNotFoundError as problem:
        purpose = f"a library in {url.get_backend_name()}"
        raise MissingDependencyError(problem.name or "psycopg", "postgres", purpose) from None
    if sqlite:
        event.listen(engine, "connect", _prepare)
        event.listen(engine, "begin", _begin)
    _mind_forks(engine)
    return engine


def _mind_forks(engine: Engine) -> None:
    """A process that is split off opens connections of its own; those it was born with belong to the other."""
    known = weakref.ref(engine)

    def start_anew() -> None:
        mine = known()
        if mine is not None:
            mine.dispose(close=False)

    if hasattr(os, "register_at_fork"):
        os.register_at_fork(after_in_child=start_anew)


def _prepare(connection: sqlite3.Connection, _record: Any) -> None:
    connection.isolation_level = None  # transactions are begun by `_begin`, not by the driver
    connection.execute("PRAGMA foreign_keys = ON")
    _write_ahead(connection)
    connection.execute("PRAGMA synchronous = FULL")


def _write_ahead(connection: sqlite3.Connection) -> None:
    """Switch to the write-ahead log; that alone does not wait for others by itself."""
    end = time.monotonic() + PATIENCE
    while True:
        try:
            connection.execute("PRAGMA journal_mode = WAL").fetchone()
        except sqlite3.OperationalError as problem:
            if problem.sqlite_errorname != "SQLITE_BUSY" or time.monotonic() > end:
                raise
            time.sleep(0.02)
        else:
            return


def _begin(connection: Connection) -> None:
    writes = connection.get_execution_options().get("writes", False)
    connection.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")


@contextmanager
def reading(engine: Engine) -> Iterator[Connection]:
    """A connection to read with, everything as it was at one moment.

    Raises:
        LibraryError: it cannot be read.
    """
    with _in_words(engine), engine.begin() as connection:
        yield connection


@contextmanager
def writing(engine: Engine) -> Iterator[Connection]:
    """A transaction: committed at the end, or not at all.

    Raises:
        LibraryError: it cannot be written to; nothing was.
    """
    with _in_words(engine), engine.execution_options(writes=True).begin() as connection:
        yield connection


@contextmanager
def _in_words(engine: Engine) -> Iterator[None]:
    try:
        yield
    except (SQLAlchemyError, sqlite3.Error) as problem:
        raise LibraryError(explain(engine.url, problem)) from problem


def set_up(engine: Engine) -> None:
    """Make the tables of an empty database; bring an older one forward, after a copy of it.

    Raises:
        LibraryError: a later version, a database of something else, or one that cannot be written to.
    """
    with reading(engine) as connection:
        found = inspect(connection).get_table_names()
        stranger = bool(found) and schema.about.name not in found
        version = schema.version_of(connection) if found and not stranger else schema.VERSION
    if stranger:
        raise LibraryError(_said(engine.url, "this database is no library; choose another with --library"))
    if version > schema.VERSION:
        raise LibraryError(_said(
            engine.url, f"it was written by a later motionloom (version {version}; this one reads up to "
            f"{schema.VERSION}): update motionloom, or choose another with --library",
        ))  # fmt: skip
    if version < schema.VERSION and engine.dialect.name == "sqlite":
        _copy_aside(engine, version)
    with writing(engine) as connection:
        if not inspect(connection).has_table(schema.about.name):
            schema.create(connection)  # unless another program just did
        schema.bring_forward(connection)
        connection.execute(schema.about.update().values(opened=time.time()))


def _copy_aside(engine: Engine, version: int) -> None:
    """Keep the file as it was, before it is brought forward."""
    path = Path(str(engine.url.database))
    aside = path.with_name(f"{path.stem}.version-{version}{path.suffix}")
    if not aside.exists():
        copy(engine, aside)


def copy(engine: Engine, target: Path) -> Path:
    """Copy a SQLite library into a new file, as it is at one moment, while others may write. Returns the file.

    Raises:
        LibraryError: it is in another kind of database, or the copy cannot be written.
    """
    if engine.dialect.name != "sqlite":
        raise LibraryError(_said(engine.url, "copy it with the database's own program, as pg_dump"))
    with tempfile.TemporaryDirectory(prefix=".copy-", dir=target.parent) as folder:
        beside = Path(folder) / target.name
        with _in_words(engine), closing(sqlite3.connect(str(engine.url.database), timeout=PATIENCE)) as connection:
            connection.execute("VACUUM INTO ?", (str(beside),))
        beside.replace(target)
    return target


def explain(url: URL, problem: Exception) -> str:
    """What went wrong with a database, for a person."""
    own = problem.orig if isinstance(problem, DBAPIError) else problem
    name = str(getattr(own, "sqlite_errorname", "") or "")
    for code, words in _SQLITE.items():
        if name.startswith(code):
            return _said(url, words)
    first = (str(own).strip().splitlines() or ["it does not answer"])[0]
    return _said(url, first.rstrip("."))


def place(url: URL) -> str:
    """Where a library is, without passwords."""
    return str(url.database) if url.get_backend_name() == "sqlite" else url.render_as_string(hide_password=True)


def _said(url: URL, words: str) -> str:
    return f"Library {place(url)}: {words}."
