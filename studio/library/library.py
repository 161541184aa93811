"""A library: its projects, and what is found in them."""

from __future__ import annotations

import logging
import secrets
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Engine, delete, func, insert, select, update

from engines import Motion
from engines.errors import OutOfRangeError
from studio.library import database, motions, schema
from studio.library.database import LibraryError
from studio.library.motions import Cache, Stored
from studio.library.query import Query
from studio.library.shelf import Shelf

log = logging.getLogger(__name__)

UNTITLED = "Untitled scene"
"""Name of a project that was not given one."""
LONGEST_NAME = 60
KEPT_DELETED = 30 * 24 * 3600.0
"""Seconds a deleted project can be brought back."""
KEPT_UNTOUCHED = 24 * 3600.0
"""Seconds a project stays in which nobody did anything: what the first look at the studio makes."""


@dataclass(frozen=True)
class Project:
    """A project as lists show it."""

    key: str
    """Names it in addresses."""
    name: str
    takes: int
    """How many are on its shelf."""
    made: float
    """Seconds since 1970."""
    changed: float
    deleted: bool = False
    touched: bool = True
    """A person did something in it."""


@dataclass(frozen=True)
class Found:
    """A take that a search found."""

    project: str
    """Key of its project."""
    name: str
    """Name of its project."""
    number: int
    subject: str
    """Its action, prompt or file."""

    @property
    def id(self) -> str:
        """As `Take.id`."""
        return f"take-{self.number}"


class Library:
    """Projects in a database. Any thread may use it.

    Args:
        engine: a database that `database.set_up` made ready.
    """

    def __init__(self, engine: Engine) -> None:
        self.engine = engine
        self.cache = Cache()
        with database.reading(engine) as connection:
            self.id: str = connection.execute(select(schema.about.c.id)).scalar_one()

    @property
    def place(self) -> str:
        """Where it is, for a person."""
        return database.place(self.engine.url)

    # ---- projects -----------------------------------------------------------------------------------------

    def create(self, name: str = UNTITLED, touched: bool = True) -> str:
        """A new project. Returns its key.

        Raises:
            OutOfRangeError: no name, or a long one.
            LibraryError: it cannot be written.
        """
        key, now = secrets.token_hex(6), time.time()
        with database.writing(self.engine) as connection:
            connection.execute(
                insert(schema.projects).values(
                    key=key, name=_named(name), made=now, changed=now, touched=touched, numbers=0, revision=0
                )
            )
        return key

    def project(self, key: str) -> Project | None:
        """The project of that key, deleted or not; None if there is none."""
        found = self._listed(schema.projects.c.key == key)
        return found[0] if found else None

    def projects(self, deleted: bool = False) -> list[Project]:
        """The projects (or those deleted), last changed first; without those in which nobody did anything."""
        rows = schema.projects.c
        return self._listed(rows.touched, rows.deleted.is_not(None) if deleted else rows.deleted.is_(None))

    def _listed(self, *which: Any) -> list[Project]:
        rows = schema.projects.c
        count = (
            select(func.count())
            .where(schema.takes.c.project == rows.key, schema.takes.c.present)
            .scalar_subquery()
        )  # fmt: skip
        asked = select(schema.projects, count.label("takes")).where(*which).order_by(rows.changed.desc())
        with database.reading(self.engine) as connection:
            found = connection.execute(asked).all()
        return [
            Project(row.key, row.name, row.takes, row.made, row.changed, row.deleted is not None, bool(row.touched))
            for row in found
        ]

    def rename(self, key: str, name: str) -> None:
        """Give a project another name; errors as `create`."""
        self._change(key, name=_named(name), touched=True, changed=time.time())

    def delete(self, key: str) -> None:
        """Delete a project; `restore` brings it back within thirty days."""
        self._change(key, deleted=time.time(), touched=True)

    def restore(self, key: str) -> None:
        """Bring a deleted project back."""
        self._change(key, deleted=None)

    def _change(self, key: str, **values: Any) -> None:
        rows = schema.projects.c
        values["revision"] = rows.revision + 1
        with database.writing(self.engine) as connection:
            done = connection.execute(update(schema.projects).where(rows.key == key).values(**values))
        if not done.rowcount:
            raise LibraryError(f"Library {self.place}: there is no project {key!r}.")

    def shelf(self, key: str) -> Shelf:
        """The takes of a project.

        Raises:
            LibraryError: no such project, or it cannot be read.
        """
        return Shelf(self, key)

    # ---- takes of all projects ------------------------------------------------------------------------------

    def search(self, query: Query | str, limit: int = 200) -> list[Found]:
        """Takes of all projects that fit, newest first."""
        wanted = Query.parse(query) if isinstance(query, str) else query
        rows, whose = schema.takes.c, schema.projects.c
        asked = (
            select(rows.project, whose.name, rows.number, rows.action, rows.prompt, rows.source)
            .join(schema.projects, rows.project == whose.key)
            .where(rows.present, whose.deleted.is_(None), whose.touched, wanted.condition())
            .order_by(rows.made.desc())
            .limit(limit)
        )
        with database.reading(self.engine) as connection:
            found = connection.execute(asked).all()
        return [
            Found(row.project, row.name, row.number, row.action or row.prompt or row.source or "motion")
            for row in found
        ]

    # ---- motions ------------------------------------------------------------------------------------------

    def stored(self, key: str, frames: int, fps: float) -> Stored:
        """What fetches a motion."""
        return Stored(self.engine, self.cache, key, frames, fps)

    def hold(self, given: Sequence[Motion]) -> list[Stored]:
        """Motions put in, not yet on any shelf. Long ones take a while: call it off the UI thread.

        Raises:
            LibraryError: they cannot be written.
        """
        packed = [motions.pack(motion) for motion in given]
        with database.writing(self.engine) as connection:
            motions.put_in(connection, packed)
        for one, motion in zip(packed, given, strict=True):
            self.cache.put(one.hash, motion)
        return [self.stored(one.hash, one.frames, one.fps) for one in packed]

    # ---- housekeeping -------------------------------------------------------------------------------------

    def tidy(self) -> None:
        """Let go of what nobody can get back: projects deleted long ago or never used, motions no take shows."""
        rows, now = schema.projects.c, time.time()
        with database.writing(self.engine) as connection:
            for gone in (
                rows.deleted < now - KEPT_DELETED,
                (~rows.touched) & (rows.changed < now - KEPT_UNTOUCHED),
            ):
                connection.execute(delete(schema.projects).where(gone))
            count = motions.drop_unused(connection)
        if count:
            log.info("%d motions that no take shows were let go", count)

    def close(self) -> None:
        """Close every connection."""
        self.engine.dispose()


def open_library(url: str | None = None) -> Library:
    """Open a library; made if there is none yet, brought forward if it is of an older version.

    Args:
        url: a SQLAlchemy URL or the path of a SQLite file; `default_url()` unless given.

    Raises:
        LibraryError: it cannot be used; the message says why and what would help.
        MissingDependencyError: the driver of the database is not installed.
    """
    engine = database.connect(database.parse_url(url or database.default_url()))
    try:
        database.set_up(engine)
        library = Library(engine)
        library.tidy()
    except BaseException:
        engine.dispose()
        raise
    return library


def _named(name: str) -> str:
    clean = " ".join(name.split())
    if not 1 <= len(clean) <= LONGEST_NAME:
        raise OutOfRangeError("name of the project", name, f"1 to {LONGEST_NAME} letters")
    return clean
