"""What a session does with projects, with a library and without."""

from __future__ import annotations

import time

import pytest
from sqlalchemy import event

from studio.library import open_library
from studio.session import Session
from studio.wording import counted, since


@pytest.fixture
def library(tmp_path):
    made = open_library(str(tmp_path / "library.db"))
    yield made
    made.close()


@pytest.fixture
def begin(engine, queue, library, settle):
    """`begin("key")`: a session on the library, once its first work is done."""
    sessions = []

    def new(project: str = "", take: str = "", asked: bool = False, compared=(), **options) -> Session:
        session = Session(queue=queue, library=library, **options)
        sessions.append(session)
        session.start(project, take, asked, compared)
        settle(session)
        return session

    yield new
    for session in sessions:
        session.close()


def ids(session) -> list[str]:
    return [take.id for take in session.state.takes]


def listed(session) -> list[str]:
    session.projects.list()
    return [project["name"] for project in session.state.projects]


def test_a_newcomer_gets_a_project_that_is_saved_at_once(begin, library):
    state = begin().state
    assert (state.saved, len(state.takes)) == ("saved", 4)
    assert library.place in state.saved_note
    assert len(library.shelf(state.project).read()) == 4
    assert library.projects() == [], "but which is listed only once something was done in it"


def test_two_newcomers_get_a_project_each(begin):
    assert begin().state.project != begin().state.project


def test_a_reload_and_a_restart_bring_everything_back(begin, engine, settle):
    first = begin()
    first.toggle("take-2", "favourite")
    first.tag("take-3", ["Good", "good", "old  man"])
    first.state.scene = "Morning scene"
    first.delete("take-1")
    pictures = first.state.thumbnails
    first.close()
    calls = len(engine.calls)
    again = begin(first.state.project, "take-3")
    state = again.state
    assert ids(again) == ["take-2", "take-3", "take-4"]
    assert (state.scene, state.selected) == ("Morning scene", "take-3")
    assert state.take("take-2").favourite
    assert state.take("take-3").tags == ("good", "old man")
    assert state.thumbnails == pictures, "drawn once, then kept"
    assert (state.undo_name, len(engine.calls)) == ("delete take 1", calls)
    assert state.engine_ready
    again.undo()
    assert ids(again) == ["take-1", "take-2", "take-3", "take-4"]


def test_ticks_come_back_as_far_as_their_takes_are_there(begin):
    first = begin()
    first.compare_these(["take-1", "take-3"])
    first.delete("take-4")
    again = begin(first.state.project, "take-3", compared=("take-1", "take-3", "take-4", "take-77")).state
    assert (again.compared, again.shown, again.stage_mode) == (["take-1", "take-3"],) * 2 + ("compare",)


def test_blocks_that_were_not_made_yet_come_back_whichever_take_is_picked(begin, settle):
    first = begin()
    first.state.compose_tab = "sequence"
    first.arranging.add({"what": "walk"})
    first.generate()
    settle(first)
    made = first.state.selected
    first.arranging.add({"what": "run"})
    again = begin(first.state.project, made)
    assert [block.what for block in again.state.sequence.blocks] == ["walk", "run"]
    again.select("take-1")
    again.select(made)
    assert [block.what for block in again.state.sequence.blocks] == ["walk", "run"]


def test_pictures_that_were_never_drawn_are_drawn_now(begin, library, settle):
    session = begin()
    key = session.state.project
    library.shelf(key).keep_pictures(dict.fromkeys(range(1, 5), None))
    again = begin(key)
    settle(again)
    assert set(again.state.thumbnails) == {"take-1", "take-2", "take-3", "take-4"}


def test_a_link_to_a_project_that_is_gone_says_so_and_shows_a_new_one(begin, library):
    session = begin("feed", "take-3", asked=True)
    assert session.state.message == "The project of that link is not in this library."
    assert len(session.state.takes) == 4
    key = library.create("Gone")
    library.delete(key)
    other = begin(key, asked=True)
    assert other.state.message == "“Gone” was deleted; Projects brings it back."
    assert other.state.project != key
    assert begin(key).state.message == "", "a cookie is nobody's wish"


def test_a_new_project_is_empty_and_the_old_one_is_a_click_away(begin):
    session = begin()
    state, first = session.state, session.state.project
    session.state.scene = "First"
    session.compare("take-1")
    session.projects.new()
    assert (state.takes, state.selected, state.compared, state.undo_name, state.thumbnails) == ((), "", [], "", {})
    assert (state.scene, state.saved) == ("Untitled scene", "saved")
    assert listed(session) == ["Untitled scene", "First"]
    session.projects.open(first, "take-2")
    assert (state.scene, state.selected, len(state.takes)) == ("First", "take-2", 4)
    session.projects.open(first, "take-4")
    assert state.selected == "take-4", "the open one again: only the take is picked"


def test_a_draw_under_way_goes_where_it_was_asked_for(begin, settle, library):
    session = begin()
    first = session.state.project
    waiting = []
    dispatch, session.dispatch = session.dispatch, waiting.append
    session.generate()
    settle(session)
    job = session._drawing
    assert job.wait(10)
    session.projects.new()
    session.dispatch = dispatch
    for act in waiting:
        act()
    settle(session)
    assert session.state.takes == ()
    assert len(library.shelf(first).read()) == 8
    assert not session.state.generating


def test_a_name_is_trimmed_and_never_empty(begin, library):
    session = begin()
    session.state.scene = "  A   " + "long " * 20
    assert session.state.scene == ("A " + "long " * 20)[:60].strip()
    session.state.scene = "  "
    assert session.state.scene == "Untitled scene"
    assert library.project(session.state.project).name == "Untitled scene"


def test_deleting_and_bringing_back(begin):
    session = begin()
    state, first = session.state, session.state.project
    state.scene = "First"
    session.projects.new()
    state.scene = "Second"
    session.projects.delete(state.project)
    assert (state.scene, listed(session)) == ("First", ["First"])
    assert state.message == "Deleted “Second”. Projects brings it back."
    (gone,) = state.deleted_projects
    session.projects.restore(gone["key"])
    assert sorted(listed(session)) == ["First", "Second"]
    session.projects.delete(gone["key"])
    session.projects.delete(first)
    assert (state.scene, state.takes) == ("Untitled scene", ())
    session.projects.delete("nobody")
    assert listed(session) == ["Untitled scene"]


def test_a_search_goes_over_names_and_takes(begin):
    session = begin()
    state, first = session.state, session.state.project
    state.scene = "Morning walk"
    session.tag("take-2", ["good"])
    session.projects.new()
    state.scene = "Evening"
    state.projects_search = "evening"
    assert listed(session) == ["Evening"]
    state.projects_search = "tag:good"
    session.projects.list()
    (project,) = state.projects
    assert (project["key"], project["found"]) == (first, [{"id": "take-2", "text": "take 2 · walk"}])
    state.projects_search = "walk"
    session.projects.list()
    assert [len(project["found"]) for project in state.projects] == [4]
    state.projects_search = ""
    assert sorted(listed(session)) == ["Evening", "Morning walk"]


def test_takes_are_found_on_the_shelf(begin):
    session = begin()
    state = session.state
    assert state.found is None
    session.tag("take-2", ["good"])
    state.search = "good"
    assert state.found == ["take-2"]
    session.tag("take-3", ["good too"])
    assert state.found == ["take-2", "take-3"]
    state.search = ""
    assert state.found is None


def test_what_another_browser_does_appears(begin):
    one = begin()
    one.toggle("take-1", "favourite")
    other = begin(one.state.project)
    other.delete("take-2")
    other.state.scene = "Ours"
    assert ids(one) == ["take-1", "take-2", "take-3", "take-4"]
    one.projects.refresh()
    assert (ids(one), one.state.scene) == (["take-1", "take-3", "take-4"], "Ours")
    assert one.state.undo_name == "delete take 2"


def test_a_full_disk_is_shown_and_saved_again_once_there_is_room(begin, library):
    session = begin()
    state = session.state

    def limit(connection):
        connection.exec_driver_sql("pragma max_page_count = 1")

    event.listen(library.engine, "begin", limit)
    session.tag("take-1", [f"{i} {'x' * 30}" for i in range(20)])
    session.tag("take-2", [f"{i} {'y' * 30}" for i in range(20)])
    for number in range(40):
        if state.saved == "unsaved":
            break
        session.tag("take-3", [f"{number} {i} {'z' * 30}" for i in range(20)])
    assert state.saved == "unsaved"
    assert "the disk is full; free some space. The last steps are kept in memory and tried again." in state.saved_note
    session.projects.refresh()
    assert state.saved == "unsaved"
    event.remove(library.engine, "begin", limit)
    library.engine.dispose()
    session.projects.refresh()
    assert (state.saved, state.message) == ("saved", "Everything is saved again.")
    assert len(library.shelf(state.project).read()[1].tags) == 20


def test_without_a_library_takes_are_in_memory_and_that_is_said(session, settle):
    session.start("abc", "take-2", asked=True)
    settle(session)
    state = session.state
    assert (state.saved, state.project, len(state.takes)) == ("memory", "", 4)
    assert "Takes are kept in memory: export what you need." in state.saved_note
    session.projects.list()
    assert state.projects == []
    session.projects.new()
    assert state.takes == ()
    state.scene = "Name"
    session.projects.delete("x")
    session.projects.restore("x")
    session.projects.refresh()
    assert state.scene == "Name"


def test_a_motion_that_cannot_be_read_is_said(begin, library, monkeypatch):
    from studio.library import LibraryError
    from studio.library.motions import Cache

    session = begin()
    again = begin(session.state.project)
    library.cache = Cache()
    monkeypatch.setattr("studio.library.motions.fetch", lambda *_: (_ for _ in ()).throw(LibraryError("gone")))
    fresh = library.shelf(again.state.project).read()[0]
    object.__setattr__(fresh.held, "cache", Cache())
    assert again.editing.motion(fresh) is None
    assert again.state.message == "Take 1 cannot be shown: gone"


def test_numbers_and_times_in_words():
    now = time.mktime((2026, 3, 5, 12, 0, 0, 0, 0, -1))
    assert (counted(1, "take"), counted(2000, "take")) == ("1 take", "2,000 takes")
    words = [since(now - gone, now) for gone in (5, 90, 3700, 30 * 3600, 90 * 86400, -5)]
    assert words == ["just now", "1 minute ago", "1 hour ago", "1 day ago", "5 December 2025", "just now"]
