"""What is in the database, its version, and how older ones are brought forward.

Motions are kept by the hash of their bytes and never changed. A take is one row; deleting it clears `present`, and the
row goes once no step can bring it back. A step is a row with its changes as JSON, field by field.
"""

from __future__ import annotations

import secrets
import time
from collections.abc import Callable

from sqlalchemy import (
    Boolean,
    Column,
    Connection,
    Float,
    ForeignKey,
    ForeignKeyConstraint,
    Integer,
    LargeBinary,
    MetaData,
    String,
    Table,
    Text,
    insert,
    select,
    update,
)  # fmt: skip

VERSION = 4
"""Version of the schema written; later ones are refused, earlier ones brought forward."""

tables = MetaData()

about = Table(
    "library",
    tables,
    Column("id", String(32), primary_key=True, comment="Tells libraries apart, in cookies for example."),
    Column("version", Integer, nullable=False),
    Column("made", Float, nullable=False, comment="Seconds since 1970, as all times here."),
    Column("opened", Float, nullable=False, comment="Last time; writing it proves that it can be written to."),
)

projects = Table(
    "projects",
    tables,
    Column("key", String(32), primary_key=True),
    Column("name", String(200), nullable=False),
    Column("made", Float, nullable=False),
    Column("changed", Float, nullable=False),
    Column("deleted", Float, comment="When; empty while it is not."),
    Column("touched", Boolean, nullable=False, comment="A person did something in it."),
    Column("numbers", Integer, nullable=False, comment="Highest number a take of it ever had."),
    Column("revision", Integer, nullable=False, comment="Grows with every write."),
    Column("body", Text, comment="JSON: the body its takes are shown with, and its shape; empty: as it comes."),
    Column("sequence", Text, comment="JSON: the blocks on its timeline; empty: none."),
)

motions = Table(
    "motions",
    tables,
    Column("hash", String(64), primary_key=True, comment="SHA-256 of the data."),
    Column("frames", Integer, nullable=False),
    Column("fps", Float, nullable=False),
    Column("data", LargeBinary, nullable=False, comment="The project's own .npz."),
    Column("used", Float, nullable=False, comment="When it was last put in."),
)

takes = Table(
    "takes",
    tables,
    Column("project", String(32), ForeignKey("projects.key", ondelete="CASCADE"), primary_key=True),
    Column("number", Integer, primary_key=True),
    Column("motion", String(64), ForeignKey("motions.hash"), nullable=False, index=True),
    Column("draw", String(64), nullable=False, comment="Shared by the takes of one draw."),
    Column("made", Float, nullable=False),
    Column("settings", Text, comment="The settings file that makes it again; empty for an imported one."),
    Column("source", Text, nullable=False),
    Column("metrics", Text, nullable=False, comment="JSON object."),
    Column("words", Text, nullable=False, comment="What a search looks through, case folded."),
    Column("action", Text, nullable=False),
    Column("prompt", Text, nullable=False),
    Column("style", Text, nullable=False),
    Column("engine", Text, nullable=False),
    Column("present", Boolean, nullable=False),
    Column("favourite", Boolean, nullable=False),
    Column("accepted", Boolean, nullable=False),
    Column("tags", Text, nullable=False, comment="JSON list."),
    Column("edits", Text, nullable=False, comment="JSON list."),
    Column("picture", Text, comment="Thumbnail as a data URI."),
    Column("caption", Text, comment="JSON: what is said of it, see studio.captions; empty: nothing yet."),
)

steps = Table(
    "steps",
    tables,
    Column("id", Integer, primary_key=True, autoincrement=True),
    Column("project", String(32), nullable=False, index=True),
    Column("uid", String(32), nullable=False, unique=True, comment="A step sent twice is done once."),
    Column("name", Text, nullable=False),
    Column("changes", Text, nullable=False, comment="JSON: [[number, {field: [before, after]}], ...]; 0: the project."),
    Column("undone", Boolean, nullable=False),
    ForeignKeyConstraint(["project"], ["projects.key"], ondelete="CASCADE"),
)


def _add_body(connection: Connection) -> None:
    connection.exec_driver_sql("alter table projects add column body text")


def _add_sequence(connection: Connection) -> None:
    connection.exec_driver_sql("alter table projects add column sequence text")


def _add_caption(connection: Connection) -> None:
    connection.exec_driver_sql("alter table takes add column caption text")


MIGRATIONS: dict[int, Callable[[Connection], None]] = {1: _add_body, 2: _add_sequence, 3: _add_caption}
"""Version -> what brings a database of it to the next one."""


def create(connection: Connection) -> None:
    """Make the tables of a new library."""
    tables.create_all(connection)
    now = time.time()
    connection.execute(insert(about).values(id=secrets.token_hex(8), version=VERSION, made=now, opened=now))


def version_of(connection: Connection) -> int:
    """The version a library was written in."""
    return int(connection.execute(select(about.c.version)).scalar_one())


def bring_forward(connection: Connection) -> None:
    """Bring an older library to `VERSION`, a version at a time, within the caller's transaction."""
    for version in range(version_of(connection), VERSION):
        MIGRATIONS[version](connection)
        connection.execute(update(about).values(version=version + 1))
