"""Takes: every motion a session made or imported, with undo and redo of one step each.

The list of takes is an immutable tuple; each change replaces it and remembers the one before. Where the tuple is kept
is behind `TakeStore`: here in memory; a library in a database implements the same three methods.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Protocol

from engines import Motion
from engines.errors import OutOfRangeError
from studio.settings import GenerateSettings

UNDO_STEPS = 100


@dataclass(frozen=True, eq=False)
class Take:
    """One motion on the shelf."""

    number: int
    """Counted from 1 through the session; never used twice."""
    motion: Motion
    """The motion itself."""
    group: str
    """Key shared by the takes of one draw or one imported file; they stand together in the gallery."""
    settings: GenerateSettings | None = None
    """What made it; None for an imported motion."""
    source: str = ""
    """File it was imported from; empty for a generated one."""
    metrics: Mapping[str, float] = field(default_factory=dict)
    """Quality measures; see `engines.metrics.physical.summary`."""
    favourite: bool = False
    """Starred."""
    accepted: bool = False
    """Kept: "Clear" leaves it where it is."""

    @property
    def id(self) -> str:
        """Key of the take, and stem of its files: `take-2`."""
        return f"take-{self.number}"

    @property
    def title(self) -> str:
        """Name for a person: "Take 2"."""
        return f"Take {self.number}"

    @property
    def subject(self) -> str:
        """What it shows: the action, the prompt, or the imported file."""
        if self.settings is not None:
            return self.settings.subject
        return self.source or self.motion.label_at(0) or "motion"


class TakeStore(Protocol):
    """Where takes are kept. A write happens at every step, undo and redo included."""

    def read(self) -> tuple[Take, ...]:
        """The takes as last written."""
        ...

    def write(self, takes: tuple[Take, ...]) -> None:
        """Keep these takes; those no longer among them are gone."""
        ...

    def next_number(self) -> int:
        """A number never given before."""
        ...


class MemoryStore:
    """Takes kept for as long as the session lives."""

    def __init__(self) -> None:
        self._takes: tuple[Take, ...] = ()
        self._numbers = 0

    def read(self) -> tuple[Take, ...]:
        """The takes as last written."""
        return self._takes

    def write(self, takes: tuple[Take, ...]) -> None:
        """Keep these takes."""
        self._takes = takes

    def next_number(self) -> int:
        """A number never given before."""
        self._numbers += 1
        return self._numbers


class TakeList:
    """The takes of a session and their history.

    Args:
        store: where they are kept; in memory unless given.
        on_change: called after every change with the list.
    """

    def __init__(self, store: TakeStore | None = None, on_change: Callable[[TakeList], None] | None = None) -> None:
        self.store = store or MemoryStore()
        self.on_change = on_change
        self._undo: list[tuple[str, tuple[Take, ...]]] = []
        self._redo: list[tuple[str, tuple[Take, ...]]] = []

    # ---- reading ------------------------------------------------------------------------------------------

    def __len__(self) -> int:
        return len(self.all)

    def __iter__(self):
        return iter(self.all)

    def __contains__(self, take_id: str) -> bool:
        return any(take.id == take_id for take in self.all)

    @property
    def all(self) -> tuple[Take, ...]:
        """Every take, oldest first."""
        return self.store.read()

    def get(self, take_id: str) -> Take | None:
        """The take of that id, or None."""
        return next((take for take in self.all if take.id == take_id), None)

    def group_of(self, take_id: str) -> tuple[Take, ...]:
        """The takes of the same draw, that one included; empty when there is no such take."""
        take = self.get(take_id)
        return tuple(t for t in self.all if take is not None and t.group == take.group)

    @property
    def undo_name(self) -> str:
        """What the next undo takes back ("delete take 2"); empty when there is nothing."""
        return self._undo[-1][0] if self._undo else ""

    @property
    def redo_name(self) -> str:
        """What the next redo brings back; empty when there is nothing."""
        return self._redo[-1][0] if self._redo else ""

    # ---- changing, one step each ----------------------------------------------------------------------------

    def add(
        self,
        motions: Iterable[Motion],
        *,
        group: str,
        settings: GenerateSettings | None = None,
        source: str = "",
        metrics: Iterable[Mapping[str, float]] = (),
    ) -> list[Take]:
        """Add the motions of one draw, or of one file, as one step. `settings` is that of the whole draw."""
        measured = list(metrics)
        made = []
        for place, motion in enumerate(motions):
            own = None if settings is None else replace(settings, take=settings.take or place + 1)
            values = measured[place] if place < len(measured) else {}
            number = self.store.next_number()
            made.append(Take(number, motion, group, own, source, values))
        if not made:
            raise OutOfRangeError("number of motions", 0, "1 or more")
        verb = "generate" if settings is not None else "import"
        self._step(f"{verb} {made[0].subject}", (*self.all, *made))
        return made

    def remove(self, take_id: str) -> None:
        """Delete a take."""
        take = self.get(take_id)
        if take is not None:
            self._step(f"delete {take.title.lower()}", tuple(t for t in self.all if t.id != take_id))

    def clear(self) -> int:
        """Delete every take that is neither kept nor a favourite. Returns how many went."""
        stay = tuple(t for t in self.all if t.accepted or t.favourite)
        gone = len(self.all) - len(stay)
        if gone:
            self._step(f"clear {gone} takes", stay)
        return gone

    def mark(self, take_id: str, **flags: bool) -> None:
        """Set `favourite` or `accepted` of a take."""
        take = self.get(take_id)
        if take is None or all(getattr(take, name) == value for name, value in flags.items()):
            return
        words = {
            ("favourite", True): "star", ("favourite", False): "unstar",
            ("accepted", True): "keep", ("accepted", False): "unkeep",
        }  # fmt: skip
        name, value = next(iter(flags.items()))
        changed = replace(take, **flags)
        self._step(
            f"{words[name, value]} {take.title.lower()}", tuple(changed if t.id == take_id else t for t in self.all)
        )

    def undo(self) -> str:
        """Take the last step back. Returns its name, empty when there was none."""
        return self._travel(self._undo, self._redo)

    def redo(self) -> str:
        """Bring the last step taken back again. Returns its name, empty when there was none."""
        return self._travel(self._redo, self._undo)

    def _travel(self, source: list, target: list) -> str:
        if not source:
            return ""
        name, takes = source.pop()
        target.append((name, self.all))
        self._write(takes)
        return name

    def _step(self, name: str, takes: tuple[Take, ...]) -> None:
        self._undo.append((name, self.all))
        del self._undo[:-UNDO_STEPS]
        self._redo.clear()
        self._write(takes)

    def _write(self, takes: tuple[Take, ...]) -> None:
        self.store.write(takes)
        if self.on_change is not None:
            self.on_change(self)
