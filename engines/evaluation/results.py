"""What an evaluation has found so far: written after every repeat, so that one that was stopped goes on."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from engines.errors import FormatError
from engines.formats.files import atomic_path
from engines.metrics import protocol
from engines.metrics.protocol import Estimate

VERSION = 1


@dataclass(frozen=True)
class Repeat:
    """What one repeat gave for one row."""

    figures: dict[str, float]
    """By their names in `protocol.METRICS`."""
    accuracy: list[float] = field(default_factory=list)
    """Of each action, where engines go by actions: share of its motions that are recognised."""
    frechet: list[float] = field(default_factory=list)
    """Of each action: Frechet distance to its real motions in a few principal components."""
    confusion: list[list[int]] = field(default_factory=list)
    """[action, answer, how many], those that are not 0; answers count the recogniser's labels."""
    seconds: float = 0.0


@dataclass
class Row:
    """A line of the table."""

    name: str
    kind: Literal["real", "made"]
    weights: str = ""
    """SHA-256 of an engine's weights."""
    facts: dict[str, Any] = field(default_factory=dict)
    """What a reader wants to know of it besides."""
    repeats: list[Repeat] = field(default_factory=list)

    @property
    def estimates(self) -> dict[str, Estimate]:
        """Mean and interval of each figure over the repeats."""
        names = self.repeats[0].figures if self.repeats else {}
        return {name: protocol.estimate([r.figures[name] for r in self.repeats]) for name in names}

    def of_actions(self, what: Literal["accuracy", "frechet"]) -> np.ndarray:
        """(actions,) means over the repeats."""
        return np.mean([getattr(r, what) for r in self.repeats], axis=0)

    def confusion(self, actions: int, answers: int) -> np.ndarray:
        """(actions, answers) counts over all repeats."""
        counts = np.zeros((actions, answers), dtype=np.int64)
        for each in self.repeats:
            for action, answer, count in each.confusion:
                counts[action, answer] += count
        return counts


@dataclass
class Results:
    """The rows of an evaluation and what they rest on."""

    basis: dict[str, Any]
    """Everything that changes the figures: actions, data, evaluator, motions, frames, seed."""
    answers: tuple[str, ...]
    """The recogniser's labels; none where sentences are judged."""
    rows: dict[str, Row] = field(default_factory=dict)

    @property
    def actions(self) -> tuple[str, ...]:
        """What was asked for, where engines go by actions."""
        return tuple(self.basis.get("actions", ()))

    def row(self, name: str, kind: Literal["real", "made"], weights: str = "", **facts: Any) -> Row:
        """The row of that name; without what was found for other weights."""
        if name not in self.rows or self.rows[name].weights != weights:
            self.rows[name] = Row(name, kind, weights)
        self.rows[name].facts = facts
        return self.rows[name]

    def shown(self, names: Sequence[str], repeats: int) -> list[Row]:
        """The rows of some engines after those of real motions, each with so many repeats at most."""
        real = [row for row in self.rows.values() if row.kind == "real"]
        rows = real + [self.rows[name] for name in names if name in self.rows]
        return [replace(row, repeats=row.repeats[:repeats]) for row in rows if row.repeats]

    def save(self, path: Path) -> None:
        """Write all of it, whole or not at all."""
        values = {"version": VERSION, "basis": self.basis, "answers": self.answers, "rows": list(self.rows.values())}
        with atomic_path(path) as temporary:
            temporary.write_text(json.dumps(values, default=asdict), encoding="utf-8")

    def go_on_from(self, path: Path) -> None:
        """Take over the rows of a file of the same evaluation, where there is one.

        Raises:
            FormatError: it is of another one, or damaged.
        """
        if not path.is_file():
            return
        try:
            values = json.loads(path.read_text(encoding="utf-8"))
            before, version = values["basis"], values["version"]
            rows = [Row(**{**row, "repeats": [Repeat(**r) for r in row["repeats"]]}) for row in values["rows"]]
        except (OSError, ValueError, TypeError, KeyError) as error:
            raise FormatError(path, f"cannot be read ({error}); --fresh begins anew.") from error
        differing = changed(before, self.basis) if version == VERSION else f"it has version {version}, not {VERSION}"
        if differing:
            raise FormatError(path, f"is of another evaluation ({differing}); choose another --out, or --fresh.")
        self.rows |= {row.name: row for row in rows}


def changed(before: Mapping[str, Any], now: Mapping[str, Any]) -> str:
    """In words, the first few values that differ between two mappings; empty where none does."""
    same_type = json.loads(json.dumps(now))
    names = [name for name in {**before, **same_type} if before.get(name) != same_type.get(name)]
    return ", ".join(f"{name} {_short(before.get(name))}, now {_short(same_type.get(name))}" for name in names[:3])


def _short(value: Any) -> str:
    return f"{len(value)} names" if isinstance(value, list) else str(value)
