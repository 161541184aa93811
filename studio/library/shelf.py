"""The takes of one project, kept in the library: every step is on the disk before anybody is told that it is.

What is shown comes from a mirror in memory. A step changes the mirror, and is then written in one transaction. Should
that fail (the disk is full, the network is down) the step waits, `problem` says why, and it is tried again with the
next one or with `refresh`. What others write to the same project is seen by its growing revision and read anew.
"""

from __future__ import annotations

import json
import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from sqlalchemy import Connection, select, update

from engines import Motion
from engines.errors import MotionloomError
from studio.library import database, motions, rows, schema, writes
from studio.library.database import LibraryError
from studio.library.motions import Stored
from studio.takes import Change, Held, MemoryStore, Step, Take

if TYPE_CHECKING:
    from studio.library.library import Library

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class _Waiting:
    """Something to be written: a new step (with its new takes), or an old one undone or done again."""

    step: Step
    what: str
    """do, undo or redo."""
    new: tuple[Take, ...] = ()


class Shelf:
    """A `TakeStore` for one project of a library.

    Args:
        library: where it is.
        key: of the project.

    Raises:
        LibraryError: no such project, or it cannot be read.
    """

    def __init__(self, library: Library, key: str) -> None:
        self.library, self.key = library, key
        self.problem = ""
        """Why the last steps are not saved; empty when they are."""
        self._mirror = MemoryStore()
        self._revision = -1
        self._waiting: list[_Waiting] = []
        self._moved: dict[int, int] = {}
        """Numbers that were given to others meanwhile, and what became of them with the last write."""
        self._load()

    # ---- as every TakeStore -------------------------------------------------------------------------------

    @property
    def body(self) -> Mapping[str, Any]:
        """The body that the takes are shown with."""
        return self._mirror.body

    @property
    def sequence(self) -> Mapping[str, Any]:
        """The blocks on the timeline."""
        return self._mirror.sequence

    @property
    def undo_name(self) -> str:
        """What the next undo takes back."""
        return self._mirror.undo_name

    @property
    def redo_name(self) -> str:
        """What the next redo brings back."""
        return self._mirror.redo_name

    def read(self) -> tuple[Take, ...]:
        """The takes on the shelf, oldest first."""
        return self._mirror.read()

    def next_number(self) -> int:
        """A number never given before, as far as is known here."""
        return self._mirror.next_number()

    def hold(self, motions: Sequence[Motion]) -> Sequence[Motion | Held]:
        """Motions put into the library; as they are where that cannot be done now."""
        try:
            return self.library.hold(motions)
        except MotionloomError as problem:
            log.warning("%s", problem)
            return motions

    def do(self, step: Step, new: Sequence[Take] = ()) -> list[Take]:
        """Keep new takes and do a step."""
        self._mirror.do(step, new)
        self._waiting.append(_Waiting(step, "do", tuple(new)))
        self._moved = {}
        self._write()
        numbers = [self._moved.get(take.number, take.number) for take in new]
        return [self._mirror.known.get(number, take) for number, take in zip(numbers, new, strict=True)]

    def undo(self) -> str:
        """Take the last step back, whoever did it."""
        self.refresh()
        if not self._mirror.done:
            return ""
        return self._travel(_Waiting(self._mirror.done[-1], "undo"), self._mirror.undo())

    def redo(self) -> str:
        """Do the last step taken back again."""
        self.refresh()
        if not self._mirror.undone:
            return ""
        return self._travel(_Waiting(self._mirror.undone[-1], "redo"), self._mirror.redo())

    def _travel(self, waiting: _Waiting, name: str) -> str:
        self._waiting.append(waiting)
        self._write()
        return name

    # ---- and besides --------------------------------------------------------------------------------------

    @property
    def saved(self) -> bool:
        """Whether everything done here is in the library."""
        return not self._waiting

    def refresh(self) -> bool:
        """Try again what could not be saved, and see what others did. Returns whether anything is other than before."""
        if self._waiting:
            return self._write()
        try:
            with database.reading(self.library.engine) as connection:
                revision = writes.revision_of(connection, self.key)
            if revision == self._revision:
                return False
            self._load()
        except LibraryError as problem:
            log.warning("%s", problem)
            return False
        return True

    def pictures(self) -> dict[str, str]:
        """Thumbnails kept, by the take's id."""
        return self._kept("picture")

    def keep_pictures(self, pictures: Mapping[int, str]) -> None:
        """Keep thumbnails by the take's number; where that fails they are drawn again another time."""
        self._keep("picture", pictures)

    def captions(self) -> dict[str, dict[str, Any]]:
        """What is said of takes and kept, by the take's id."""
        return {take: json.loads(said) for take, said in self._kept("caption").items()}

    def keep_captions(self, captions: Mapping[int, Mapping[str, Any]]) -> None:
        """Keep what is said of takes, by their numbers; where that fails it is found again another time."""
        self._keep("caption", {number: json.dumps(said, ensure_ascii=False) for number, said in captions.items()})

    def _kept(self, name: str) -> dict[str, str]:
        """A column of the takes, where it holds anything, by the take's id."""
        held = schema.takes.c
        asked = select(held.number, held[name]).where(held.project == self.key, held[name].is_not(None))
        try:
            with database.reading(self.library.engine) as connection:
                return {f"take-{number}": value for number, value in connection.execute(asked)}
        except LibraryError as problem:
            log.warning("%s", problem)
            return {}

    def _keep(self, name: str, values: Mapping[int, str | None]) -> None:
        """Write a column of takes, by their numbers."""
        held = schema.takes.c
        try:
            with database.writing(self.library.engine) as connection:
                for number, value in values.items():
                    mine = (held.project == self.key) & (held.number == number)
                    connection.execute(update(schema.takes).where(mine).values({name: value}))
        except LibraryError as problem:
            log.warning("%s", problem)

    # ---- the database -------------------------------------------------------------------------------------

    def _load(self) -> None:
        """Mirror the project as it is in the library."""
        before = self._mirror.known
        with database.reading(self.library.engine) as connection:
            project = writes.project(connection, self.key)
            if project is None:
                raise LibraryError(f"Library {self.library.place}: there is no project {self.key!r}.")
            held = writes.takes_of(connection, self.key)
            steps = writes.steps_of(connection, self.key)
        mirror = MemoryStore()
        mirror.numbers = max(project.numbers, self._mirror.numbers)
        for row in held:
            mirror.known[row.number] = self._take(row, before.get(row.number))
        mirror.present = {row.number for row in held if row.present}
        for row in steps:
            (mirror.undone if row.undone else mirror.done).append(rows.to_step(row))
        mirror.undone.reverse()
        mirror.body = json.loads(project.body) if project.body else {}
        mirror.sequence = json.loads(project.sequence) if project.sequence else {}
        self._mirror, self._revision = mirror, project.revision

    def _take(self, row, known: Take | None) -> Take:
        """A take of its row; what never changes is taken from the one known before."""
        if known is None or known.group != row.draw:
            return rows.to_take(row, self.library.stored(row.motion, row.frames, row.fps))
        fresh = rows.changing(row)
        return known if all(getattr(known, name) == value for name, value in fresh.items()) else replace(known, **fresh)

    def _write(self) -> bool:
        """Write everything that waits, in one transaction. Returns whether the takes are other than they were."""
        try:
            held = [take.held for one in self._waiting for take in one.new]
            packed = {motion: motions.pack(motion) for motion in held if isinstance(motion, Motion)}
            with database.writing(self.library.engine) as connection:
                project = writes.project(connection, self.key, lock=True)
                if project is None:
                    raise LibraryError(f"Library {self.library.place}: there is no project {self.key!r} any more.")
                others = project.revision != self._revision
                moved = self._clashes(project.numbers) if others else {}
                motions.put_in(connection, packed.values())
                for one in self._waiting:
                    self._write_one(connection, _renumbered(one, moved), packed)
                highest = max([self._mirror.numbers, *moved.values()])
                revision = writes.grow(connection, project, highest)
        except MotionloomError as problem:
            if str(problem) != self.problem:
                log.warning("not saved: %s", problem)
            self.problem = str(problem)
            return False
        self._revision, self._moved, self._waiting, self.problem = revision, moved, [], ""
        self._at_hand(packed)
        if others:
            self._load()
        return others

    def _write_one(self, connection: Connection, one: _Waiting, packed: dict[Motion, motions.Packed]) -> None:
        if one.what == "do":
            new = [(take, packed[take.held].hash if isinstance(take.held, Motion) else _hash(take)) for take in one.new]
            writes.do(connection, self.key, one.step, new)
        else:
            writes.travel(connection, self.key, one.step, back=one.what == "undo")

    def _clashes(self, given: int) -> dict[int, int]:
        """Numbers of new takes that others gave meanwhile, and those they get instead."""
        waiting = [take.number for one in self._waiting for take in one.new]
        free = max([given, *waiting])
        return {number: free + place for place, number in enumerate((n for n in waiting if n <= given), 1)}

    def _at_hand(self, packed: dict[Motion, motions.Packed]) -> None:
        """Motions that were held as they are lie in the library now."""
        for motion, one in packed.items():
            self.library.cache.put(one.hash, motion)
        for number, take in self._mirror.known.items():
            if isinstance(take.held, Motion) and take.held in packed:
                one = packed[take.held]
                self._mirror.known[number] = replace(take, held=self.library.stored(one.hash, one.frames, one.fps))


def _renumbered(one: _Waiting, moved: dict[int, int]) -> _Waiting:
    """The same with other numbers of its takes."""
    if not moved:
        return one
    new = tuple(replace(take, number=moved.get(take.number, take.number)) for take in one.new)
    changes = tuple(Change(moved.get(change.number, change.number), change.fields) for change in one.step.changes)
    return replace(one, new=new, step=replace(one.step, changes=changes))


def _hash(take: Take) -> str:
    """Under which its motion lies in the library."""
    if not isinstance(take.held, Stored):
        raise TypeError(f"{take.title} is held by {type(take.held).__name__}, which no library keeps")
    return take.held.hash
