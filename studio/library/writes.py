"""What is read and written of one project, within a transaction that somebody else began."""

from __future__ import annotations

import json
import time
from collections.abc import Iterable, Sequence
from typing import Any

from sqlalchemy import Connection, Row, delete, insert, select, update

from studio.library import rows, schema
from studio.takes import PROJECT, UNDO_STEPS, Step, Take

_takes, _steps, _projects = schema.takes.c, schema.steps.c, schema.projects.c


# ---- reading ----------------------------------------------------------------------------------------------


def project(connection: Connection, key: str, lock: bool = False) -> Row[Any] | None:
    """The row of a project; locked, where the database has such locks, so that writers take turns."""
    asked = select(schema.projects).where(_projects.key == key)
    return connection.execute(asked.with_for_update() if lock else asked).one_or_none()


def revision_of(connection: Connection, key: str) -> int | None:
    """A number that grows with every write to a project."""
    return connection.execute(select(_projects.revision).where(_projects.key == key)).scalar_one_or_none()


def takes_of(connection: Connection, key: str) -> Sequence[Row[Any]]:
    """The rows of a project's takes, those taken off the shelf included, with length and rate of their motions."""
    own = [column for column in schema.takes.c if column.name not in ("picture", "caption")]
    asked = (
        select(*own, schema.motions.c.frames, schema.motions.c.fps)
        .join(schema.motions, _takes.motion == schema.motions.c.hash)
        .where(_takes.project == key)
        .order_by(_takes.number)
    )
    return connection.execute(asked).all()


def steps_of(connection: Connection, key: str) -> Sequence[Row[Any]]:
    """The rows of a project's steps, oldest first."""
    return connection.execute(select(schema.steps).where(_steps.project == key).order_by(_steps.id)).all()


# ---- writing ----------------------------------------------------------------------------------------------


def do(connection: Connection, key: str, step: Step, new: Iterable[tuple[Take, str]]) -> None:
    """Write a step and the takes it brings, each with the hash of its motion; nothing if that was done before."""
    if connection.execute(select(_steps.id).where(_steps.uid == step.uid)).first() is not None:
        return
    fresh = [rows.of_take(key, take, motion) for take, motion in new]
    if fresh:
        connection.execute(insert(schema.takes), fresh)
    _apply(connection, key, step, after=True)
    redone = connection.execute(delete(schema.steps).where(_steps.project == key, _steps.undone)).rowcount
    connection.execute(insert(schema.steps).values(**rows.of_step(key, step)))
    if _trim(connection, key) or redone:
        _forget(connection, key)


def travel(connection: Connection, key: str, step: Step, back: bool) -> None:
    """Undo a step, or do it again; nothing if somebody else already did."""
    mine = (_steps.uid == step.uid) & (_steps.undone == (not back))
    if connection.execute(update(schema.steps).where(mine).values(undone=back)).rowcount:
        _apply(connection, key, step, after=not back)


def grow(connection: Connection, before: Row[Any], numbers: int) -> int:
    """Note that a project changed. Returns its new revision."""
    values = {
        "revision": before.revision + 1,
        "numbers": max(numbers, before.numbers),
        "changed": time.time(),
        # the first step of a project may be what the studio draws for a newcomer; any other is a person's
        "touched": bool(before.touched) or before.revision > 0,
    }
    connection.execute(update(schema.projects).where(_projects.key == before.key).values(**values))
    return before.revision + 1


def _apply(connection: Connection, key: str, step: Step, after: bool) -> None:
    for change in step.changes:
        if change.number == PROJECT:
            told = {name: json.dumps(pair[after], ensure_ascii=False) for name, pair in change.fields.items()}
            connection.execute(update(schema.projects).where(_projects.key == key).values(**told))
            continue
        values = rows.columns({name: pair[after] for name, pair in change.fields.items()})
        mine = (_takes.project == key) & (_takes.number == change.number)
        connection.execute(update(schema.takes).where(mine).values(**values))


def _trim(connection: Connection, key: str) -> int:
    """Drop the steps that are too long ago. Returns how many."""
    old = select(_steps.id).where(_steps.project == key).order_by(_steps.id.desc()).offset(UNDO_STEPS).limit(10_000)
    gone = list(connection.execute(old).scalars())
    if gone:
        connection.execute(delete(schema.steps).where(_steps.id.in_(gone)))
    return len(gone)


def _forget(connection: Connection, key: str) -> None:
    """Drop takes that no undo can bring back."""
    gone = connection.execute(select(_takes.number).where(_takes.project == key, ~_takes.present)).scalars().all()
    if not gone:
        return
    wanted = {number for row in steps_of(connection, key) for number, _fields in json.loads(row.changes)}
    lost = [number for number in gone if number not in wanted]
    for start in range(0, len(lost), 500):
        mine = (_takes.project == key) & _takes.number.in_(lost[start : start + 500])
        connection.execute(delete(schema.takes).where(mine))
