"""Takes: every motion a project holds, with undo and redo of one step each.

A step is a list of changes, each of a few fields of one take; undo sets those fields back and leaves all else as it is.
So steps that two browsers, or two programs, do in one project do not undo each other. Where takes and steps are kept is
behind `TakeStore`: here in memory, in `studio.library.shelf` in a database.
"""

from __future__ import annotations

import uuid
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

from engines import Motion
from engines.errors import OutOfRangeError
from studio.settings import GenerateSettings
from studio.wording import counted

UNDO_STEPS = 100
CHANGING = ("favourite", "accepted", "tags", "edits")
"""Fields of a take that a person changes after it was made."""
PRESENT = "present"
"""Stands in a change for the take itself being on the shelf."""
PROJECT = 0
"""Number that stands in a change for the project itself; no take has it."""
BODY, SEQUENCE = "body", "sequence"
"""Fields of a project: the body its takes are shown with, `{"name": "anny", "shape": {"weight": 0.7}}`, empty: as it
comes; the blocks on its timeline, as `studio.sequence.Sequence.to_json` gives them."""


class Held(Protocol):
    """A motion that lies elsewhere and is fetched when it is looked at."""

    @property
    def frames(self) -> int:
        """Number of frames."""
        ...

    @property
    def fps(self) -> float:
        """Frames a second."""
        ...

    def motion(self) -> Motion:
        """The motion itself."""
        ...


@dataclass(frozen=True, eq=False)
class Take:
    """One motion on the shelf."""

    number: int
    """Counted from 1 through the project; never used twice."""
    held: Motion | Held
    """The motion, or what fetches it."""
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
    tags: tuple[str, ...] = ()
    """Words a person gave it; see `studio.library.query.tag`."""
    edits: tuple[str, ...] = ()
    """What is done to it before it is shown and exported, the motion itself staying as it is; see `studio.edits`."""

    @property
    def id(self) -> str:
        """Key of the take, and stem of its files: `take-2`."""
        return f"take-{self.number}"

    @property
    def title(self) -> str:
        """Name for a person: "Take 2"."""
        return f"Take {self.number}"

    @property
    def motion(self) -> Motion:
        """The motion, as it was made.

        Raises:
            MotionloomError: it lies in a library and cannot be fetched.
        """
        return self.held if isinstance(self.held, Motion) else self.held.motion()

    @property
    def frames(self) -> int:
        """Number of frames; the motion is not fetched for that."""
        return self.held.frames

    @property
    def duration(self) -> float:
        """Seconds it lasts."""
        return self.held.frames / self.held.fps

    @property
    def subject(self) -> str:
        """What it shows: the action, the prompt, or the imported file."""
        if self.settings is not None:
            return self.settings.subject
        return self.source or self.motion.label_at(0) or "motion"


@dataclass(frozen=True)
class Change:
    """What a step does to one take, or to the project."""

    number: int
    """Of the take, or `PROJECT`."""
    fields: Mapping[str, tuple[Any, Any]]
    """Name -> (value before, value after), of `CHANGING`, or `PRESENT`; of a project, `BODY` or `SEQUENCE`."""


@dataclass(frozen=True)
class Step:
    """One thing a person did, to be undone as one."""

    name: str
    """For a person: "delete take 2"."""
    changes: tuple[Change, ...]
    uid: str = field(default_factory=lambda: uuid.uuid4().hex)


class TakeStore(Protocol):
    """Where takes and steps are kept. Every step is written as it is done, undo and redo included."""

    @property
    def undo_name(self) -> str:
        """What the next undo takes back; empty when there is nothing."""
        ...

    @property
    def redo_name(self) -> str:
        """What the next redo brings back; empty when there is nothing."""
        ...

    @property
    def body(self) -> Mapping[str, Any]:
        """The body that the takes are shown with, as `BODY` says; empty: the usual one."""
        ...

    @property
    def sequence(self) -> Mapping[str, Any]:
        """The blocks on the timeline, as `SEQUENCE` says; empty: none."""
        ...

    def read(self) -> tuple[Take, ...]:
        """The takes on the shelf, oldest first."""
        ...

    def next_number(self) -> int:
        """A number never given before, as far as is known here."""
        ...

    def hold(self, motions: Sequence[Motion]) -> Sequence[Motion | Held]:
        """What takes long about keeping motions, done beforehand; to be called off the UI thread."""
        ...

    def do(self, step: Step, new: Sequence[Take] = ()) -> list[Take]:
        """Keep new takes and do a step. Returns the new ones as they are kept (their numbers may have moved on)."""
        ...

    def undo(self) -> str:
        """Take the last step back. Returns its name, empty when there was none."""
        ...

    def redo(self) -> str:
        """Do the last step taken back again. Returns its name, empty when there was none."""
        ...

    def pictures(self) -> dict[str, str]:
        """Thumbnails kept, as data URIs by the take's id."""
        ...

    def keep_pictures(self, pictures: Mapping[int, str]) -> None:
        """Keep thumbnails, by the take's number; may be called off the UI thread."""
        ...

    def captions(self) -> dict[str, dict[str, Any]]:
        """What is said of takes (`studio.captions.Description` as JSON values), by the take's id."""
        ...

    def keep_captions(self, captions: Mapping[int, Mapping[str, Any]]) -> None:
        """Keep what is said of takes, by their numbers; may be called off the UI thread."""
        ...


class MemoryStore:
    """Takes kept for as long as the session lives."""

    def __init__(self) -> None:
        self.known: dict[int, Take] = {}
        """Takes by number, those taken off the shelf included while a step still knows them."""
        self.present: set[int] = set()
        self.done: list[Step] = []
        self.undone: list[Step] = []
        self.numbers = 0
        self.body: Mapping[str, Any] = {}
        self.sequence: Mapping[str, Any] = {}

    @property
    def undo_name(self) -> str:
        """What the next undo takes back."""
        return self.done[-1].name if self.done else ""

    @property
    def redo_name(self) -> str:
        """What the next redo brings back."""
        return self.undone[-1].name if self.undone else ""

    def read(self) -> tuple[Take, ...]:
        """The takes on the shelf, oldest first."""
        return tuple(self.known[number] for number in sorted(self.present))

    def next_number(self) -> int:
        """A number never given before."""
        self.numbers += 1
        return self.numbers

    def hold(self, motions: Sequence[Motion]) -> Sequence[Motion | Held]:
        """They are held as they are."""
        return motions

    def do(self, step: Step, new: Sequence[Take] = ()) -> list[Take]:
        """Keep new takes and do a step."""
        self.known |= {take.number: take for take in new}
        self._apply(step, after=True)
        self.done.append(step)
        del self.done[:-UNDO_STEPS]
        self.undone.clear()
        self._forget()
        return list(new)

    def undo(self) -> str:
        """Take the last step back."""
        return self._travel(self.done, self.undone, after=False)

    def redo(self) -> str:
        """Do the last step taken back again."""
        return self._travel(self.undone, self.done, after=True)

    def pictures(self) -> dict[str, str]:
        """None: whoever shows them keeps them."""
        return {}

    def keep_pictures(self, pictures: Mapping[int, str]) -> None:
        """Nothing to do."""

    def captions(self) -> dict[str, dict[str, Any]]:
        """None: whoever shows them keeps them."""
        return {}

    def keep_captions(self, captions: Mapping[int, Mapping[str, Any]]) -> None:
        """Nothing to do."""

    def _travel(self, source: list[Step], target: list[Step], after: bool) -> str:
        if not source:
            return ""
        step = source.pop()
        self._apply(step, after)
        target.append(step)
        return step.name

    def _apply(self, step: Step, after: bool) -> None:
        for change in step.changes:
            if change.number == PROJECT:
                vars(self).update({name: pair[after] for name, pair in change.fields.items()})
            take = self.known.get(change.number)
            if take is None:
                continue
            values = {name: pair[after] for name, pair in change.fields.items()}
            present = values.pop(PRESENT, change.number in self.present)
            self.present = self.present | {change.number} if present else self.present - {change.number}
            self.known[change.number] = replace(take, **values) if values else take

    def _forget(self) -> None:
        """Takes that no undo can bring back."""
        wanted = self.present | {change.number for step in self.done for change in step.changes}
        self.known = {number: take for number, take in self.known.items() if number in wanted}


class TakeList:
    """The takes of a session and their history.

    Args:
        store: where they are kept; in memory unless given.
        on_change: called after every change with the list.
    """

    def __init__(self, store: TakeStore | None = None, on_change: Callable[[TakeList], None] | None = None) -> None:
        self.store = store or MemoryStore()
        self.on_change = on_change

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
        return self.store.undo_name

    @property
    def redo_name(self) -> str:
        """What the next redo brings back; empty when there is nothing."""
        return self.store.redo_name

    # ---- changing, one step each ----------------------------------------------------------------------------

    def add(  # noqa: PLR0913 (a take's fields)
        self,
        motions: Iterable[Motion | Held],
        *,
        group: str,
        settings: GenerateSettings | None = None,
        source: str = "",
        metrics: Iterable[Mapping[str, float]] = (),
        edits: tuple[str, ...] = (),
    ) -> list[Take]:
        """Add the motions of one draw, or of one file, as one step. `settings` is that of the whole draw."""
        measured = list(metrics)
        made = []
        for place, motion in enumerate(motions):
            own = None if settings is None else replace(settings, take=settings.take or place + 1)
            values = measured[place] if place < len(measured) else {}
            made.append(Take(self.store.next_number(), motion, group, own, source, values, edits=edits))
        if not made:
            raise OutOfRangeError("number of motions", 0, "1 or more")
        verb = "generate" if settings is not None else "import"
        changes = [Change(take.number, {PRESENT: (False, True)}) for take in made]
        return self._do(f"{verb} {made[0].subject}", changes, made)

    def remove(self, take_id: str) -> None:
        """Delete a take."""
        take = self.get(take_id)
        if take is not None:
            self._do(f"delete {take.title.lower()}", [Change(take.number, {PRESENT: (True, False)})])

    def clear(self) -> int:
        """Delete every take that is neither kept nor a favourite. Returns how many went."""
        others = [take for take in self.all if not (take.accepted or take.favourite)]
        gone = [Change(take.number, {PRESENT: (True, False)}) for take in others]
        if gone:
            self._do(f"clear {counted(len(gone), 'take')}", gone)
        return len(gone)

    def mark(self, take_id: str, **fields: Any) -> None:
        """Set `favourite`, `accepted`, `tags` or `edits` of a take."""
        take = self.get(take_id)
        if take is None:
            return
        changed = {name: (getattr(take, name), value) for name, value in fields.items() if getattr(take, name) != value}
        if changed:
            name, (_before, after) = next(iter(changed.items()))
            self._do(f"{_verb(name, after)} {take.title.lower()}", [Change(take.number, changed)])

    def dress(self, body: Mapping[str, Any], what: str = "change the body") -> None:
        """Show the takes with another body, as `BODY` says; `what` names the step."""
        before = dict(self.store.body)
        if dict(body) != before:
            self._do(what, [Change(PROJECT, {BODY: (before, dict(body))})])

    def arrange(self, sequence: Mapping[str, Any], what: str) -> None:
        """Put other blocks on the timeline, as `SEQUENCE` says; `what` names the step."""
        before = self.store.sequence
        if sequence != before:
            self._do(what, [Change(PROJECT, {SEQUENCE: (before, sequence)})])

    def undo(self) -> str:
        """Take the last step back. Returns its name, empty when there was none."""
        return self._told(self.store.undo())

    def redo(self) -> str:
        """Bring the last step taken back again. Returns its name, empty when there was none."""
        return self._told(self.store.redo())

    def _do(self, name: str, changes: Sequence[Change], new: Sequence[Take] = ()) -> list[Take]:
        made = self.store.do(Step(name, tuple(changes)), new)
        self._told(name)
        return made

    def _told(self, name: str) -> str:
        if name and self.on_change is not None:
            self.on_change(self)
        return name


def _verb(field_name: str, value: Any) -> str:
    words = {"favourite": ("unstar", "star"), "accepted": ("unkeep", "keep"), "tags": ("untag", "tag")}
    return words.get(field_name, ("restore", "edit"))[bool(value)]
