"""The project a session has open, the list of all projects, and what is said about their being saved."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

from engines.errors import MotionloomError
from studio.library import Found, Library, Project, Shelf
from studio.library.library import LONGEST_NAME, UNTITLED
from studio.takes import MemoryStore
from studio.wording import counted, since

if TYPE_CHECKING:
    from studio.session import Session

log = logging.getLogger(__name__)

_T = TypeVar("_T")

LISTED = 100
"""Most projects the list shows; a search finds the others."""
FOUND = 5
"""Most takes of a project that the list names when one searches."""


class Projects:
    """The projects of one session. Without a library takes live as long as the session does, and that is said.

    Args:
        session: whose takes are kept.
        library: where; None keeps them in memory.
        problem: why there is none, for a person.
    """

    def __init__(self, session: Session, library: Library | None = None, problem: str = "") -> None:
        self.session, self.library = session, library
        self.shelf: Shelf | None = None
        self._problem = problem
        self._quiet = False
        session.state.param.watch(self._renamed, "scene")

    # ---- opening ------------------------------------------------------------------------------------------

    def first(self, key: str = "", asked: bool = False) -> None:
        """Open a project for a session that begins, or a new one where that is not there.

        Args:
            key: of the project; empty for a new one.
            asked: a link names it, so that its absence is worth a word.
        """
        state = self.session.state
        project = self._find(key) if key else None
        if project is not None and not project.deleted and self._attempt(lambda: self._enter(key), False):
            return
        if asked and self.library is not None:
            name = f"“{project.name}” was deleted; Projects brings it back." if project else ""
            state.message = name or "The project of that link is not in this library."
        self._enter_new(touched=False)

    def open(self, key: str, take: str = "") -> None:
        """Open another project, and pick a take of it."""
        if key == self.session.state.project or self._attempt(lambda: self._enter(key), False):
            self.session.select(take)

    def new(self) -> None:
        """Begin an empty project and open it."""
        self._enter_new(touched=True)

    def _enter_new(self, touched: bool) -> None:
        """Make a project and open it; in memory where it cannot be made."""
        library = self.library

        def make() -> bool:
            return library is not None and self._enter(library.create(touched=touched))

        if not self._attempt(make, False):
            self.shelf = None
            self._show(UNTITLED, "")

    def _enter(self, key: str) -> bool:
        """Open a project. Returns whether it is open."""
        if self.library is None:
            return False
        project = self.library.project(key)
        if project is None:
            return False
        self.shelf = self.library.shelf(key)
        self._problem = ""
        self._show(project.name, key)
        return True

    def _show(self, name: str, key: str) -> None:
        self._name(name)
        self.session.state.project = key
        self.session.enter(self.shelf or MemoryStore())
        self.show_saved()

    def _name(self, name: str) -> None:
        """The name, without that being a person's wish."""
        self._quiet = True
        self.session.state.scene = name
        self._quiet = False

    # ---- changing -----------------------------------------------------------------------------------------

    def _renamed(self, event: Any) -> None:
        name = " ".join(event.new.split())[:LONGEST_NAME] or UNTITLED
        if name != event.new:
            self.session.state.scene = name
        elif not self._quiet and self.shelf is not None:
            shelf = self.shelf
            self._attempt(lambda: shelf.library.rename(shelf.key, name), None)

    def delete(self, key: str) -> None:
        """Delete a project; `restore` brings it back. The open one gives way to the one changed last."""
        project = self._find(key)
        if project is None or not self._attempt(lambda: self._change("delete", key), False):
            return
        self.session.state.message = f"Deleted “{project.name}”. Projects brings it back."
        if key == self.session.state.project:
            left = self._listed()
            if not (left and self._attempt(lambda: self._enter(left[0].key), False)):
                self.new()
        self.list()

    def restore(self, key: str) -> None:
        """Bring a deleted project back."""
        if self._attempt(lambda: self._change("restore", key), False):
            self.list()

    def _change(self, what: str, key: str) -> bool:
        if self.library is not None:
            getattr(self.library, what)(key)
        return self.library is not None

    # ---- listing ------------------------------------------------------------------------------------------

    def list(self) -> None:
        """Put the projects, and what a search finds in them, into the state."""
        state = self.session.state
        found = self._found(state.projects_search)
        listed = self._listed()
        words = state.projects_search.casefold().split()
        if words:
            listed = [p for p in listed if p.key in found or all(word in p.name.casefold() for word in words)]
        now = time.time()
        state.param.update(
            projects=[_entry(p, found.get(p.key, []), now) for p in listed[:LISTED]],
            deleted_projects=[_entry(p, [], now) for p in self._listed(deleted=True)[:LISTED]],
        )

    def _listed(self, deleted: bool = False) -> list[Project]:
        library = self.library
        return [] if library is None else self._attempt(lambda: library.projects(deleted), [])

    def _found(self, text: str) -> dict[str, list[Found]]:
        """Takes that fit, by project."""
        library = self.library
        if library is None or not text.strip():
            return {}
        found: dict[str, list[Found]] = {}
        for take in self._attempt(lambda: library.search(text), []):
            found.setdefault(take.project, []).append(take)
        return found

    def _find(self, key: str) -> Project | None:
        library = self.library
        return None if library is None else self._attempt(lambda: library.project(key), None)

    # ---- saved or not -------------------------------------------------------------------------------------

    def refresh(self) -> None:
        """See what others did to the open project, and try again what could not be saved."""
        if self.shelf is None:
            return
        before = self.shelf.problem
        if self.shelf.refresh():
            self.session.takes_moved()
            project = self._find(self.shelf.key)
            if project is not None:
                self._name(project.name)
        if before and self.shelf.saved:
            self.session.state.message = "Everything is saved again."
        self.show_saved()

    def show_saved(self) -> None:
        """Say whether what is shown is in the library; only after it is."""
        state = self.session.state
        if self.shelf is None:
            why = self._problem or "This studio keeps takes in memory only."
            state.param.update(saved="memory", saved_note=f"{why} Takes are kept in memory: export what you need.")
        elif self.shelf.saved:
            place = self.library.place if self.library else ""
            state.param.update(saved="saved", saved_note=f"Every step is saved in {place}.")
        else:
            note = f"{self.shelf.problem} The last steps are kept in memory and tried again."
            state.param.update(saved="unsaved", saved_note=note)

    def close(self) -> None:
        """Try once more to save what waits."""
        if self.shelf is not None and not self.shelf.saved:
            self.shelf.refresh()

    def _attempt(self, act: Callable[[], _T], otherwise: _T) -> _T:
        """What an act with the library gives; where it goes wrong, that is said, and `otherwise`."""
        try:
            return act()
        except MotionloomError as problem:
            log.warning("%s", problem)
            self._problem = str(problem)
            self.session.state.message = str(problem)
            return otherwise


def _entry(project: Project, found: list[Found], now: float) -> dict[str, Any]:
    """What the list shows of a project."""
    return {
        "key": project.key,
        "name": project.name,
        "about": f"{counted(project.takes, 'take')} · {since(project.changed, now)}",
        "found": [{"id": take.id, "text": f"take {take.number} · {take.subject[:40]}"} for take in found[:FOUND]],
        "more": max(0, len(found) - FOUND),
    }
