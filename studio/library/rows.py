"""Takes and steps as rows, and back."""

from __future__ import annotations

import json
import logging
import time
from collections.abc import Mapping, Sequence
from typing import Any

from sqlalchemy import Row

from engines.errors import MotionloomError
from studio.library.query import described, json_tags
from studio.settings import Settings, parse_settings
from studio.takes import PRESENT, Change, Held, Step, Take

log = logging.getLogger(__name__)

_LISTS = ("tags", "edits")


def of_take(project: str, take: Take, motion: str) -> dict[str, Any]:
    """The row of a new take, not yet on the shelf; `motion` is the hash of its motion."""
    told = described(take)
    return {
        "project": project,
        "number": take.number,
        "motion": motion,
        "draw": take.group,
        "made": time.time(),
        "settings": Settings(take.settings).to_json() if take.settings else None,
        "source": take.source,
        "metrics": json.dumps({name: float(value) for name, value in take.metrics.items()}),
        **told,
        PRESENT: False,
        "favourite": take.favourite,
        "accepted": take.accepted,
        "tags": json_tags(take.tags),
        "edits": json.dumps(list(take.edits)),
        "picture": None,
        "caption": None,
    }


def to_take(row: Row[Any], held: Held) -> Take:
    """A take of its row; without its settings, where they are not understood (a later version wrote them)."""
    made = None
    if row.settings:
        try:
            made = parse_settings(row.settings, f"take {row.number}").generate
        except MotionloomError as problem:
            log.warning("settings of a take are left out: %s", problem)
    return Take(row.number, held, row.draw, made, row.source, json.loads(row.metrics), **changing(row))


def changing(row: Row[Any]) -> dict[str, Any]:
    """The fields of a row that change after a take was made."""
    return {
        "favourite": bool(row.favourite),
        "accepted": bool(row.accepted),
        "tags": tuple(json.loads(row.tags)),
        "edits": tuple(json.loads(row.edits)),
    }


def of_step(project: str, step: Step) -> dict[str, Any]:
    """The row of a step."""
    changes = [[change.number, {name: list(pair) for name, pair in change.fields.items()}] for change in step.changes]
    text = json.dumps(changes, ensure_ascii=False)
    return {"project": project, "uid": step.uid, "name": step.name, "changes": text, "undone": False}


def to_step(row: Row[Any]) -> Step:
    """A step of its row."""
    return Step(row.name, tuple(_change(number, fields) for number, fields in json.loads(row.changes)), row.uid)


def _change(number: int, fields: Mapping[str, Sequence[Any]]) -> Change:
    def value(name: str, held: Any) -> Any:
        return tuple(held) if name in _LISTS else held

    return Change(number, {name: (value(name, before), value(name, after)) for name, (before, after) in fields.items()})


def columns(fields: Mapping[str, Any]) -> dict[str, Any]:
    """Values of a take's changing fields as their columns hold them."""
    return {
        name: json_tags(tuple(value)) if name == "tags" else json.dumps(list(value)) if name == "edits" else value
        for name, value in fields.items()
    }
