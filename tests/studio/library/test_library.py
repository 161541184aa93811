"""Projects, and what is found in them."""

from __future__ import annotations

import sqlite3

import pytest

from engines.errors import OutOfRangeError
from studio.library import LibraryError, Query, open_library
from studio.library.library import KEPT_DELETED, KEPT_UNTOUCHED
from studio.library.query import tag, tags
from studio.settings import GenerateSettings
from studio.takes import Take, TakeList
from tests.studio.fakes import sway


def names(library, **which) -> list[str]:
    return [project.name for project in library.projects(**which)]


def test_projects_are_made_renamed_deleted_and_brought_back(library, draw):
    first, second = library.create("  First   scene "), library.create("Second")
    draw(TakeList(library.shelf(first)), 3)
    assert names(library) == ["First scene", "Second"], "last changed first"
    assert [project.takes for project in library.projects()] == [3, 0]
    library.rename(second, "Other")
    assert names(library) == ["Other", "First scene"]
    library.delete(first)
    assert (names(library), names(library, deleted=True)) == (["Other"], ["First scene"])
    assert library.project(first).deleted
    library.restore(first)
    assert names(library) == ["Other", "First scene"]
    assert len(library.shelf(first).read()) == 3


@pytest.mark.parametrize("name", ["", "   ", "x" * 61])
def test_a_project_has_a_name(library, name):
    with pytest.raises(OutOfRangeError, match="name of the project"):
        library.create(name)


@pytest.mark.parametrize("what", ["rename", "delete", "restore"])
def test_a_project_that_is_not_there(library, what):
    with pytest.raises(LibraryError, match="there is no project 'nobody'"):
        getattr(library, what)("nobody", *(["x"] if what == "rename" else []))
    assert library.project("nobody") is None


def test_what_a_newcomer_is_shown_is_no_project_until_something_is_done(library, draw):
    key = library.create(touched=False)
    takes = TakeList(library.shelf(key))
    draw(takes, 4)
    assert names(library) == []
    assert library.search("walk") == []
    assert len(library.shelf(key).read()) == 4, "it is kept all the same"
    takes.mark("take-1", favourite=True)
    assert names(library) == ["Untitled scene"]


def test_a_new_name_is_something_done(library):
    library.rename(library.create(touched=False), "Mine")
    assert names(library) == ["Mine"]


def test_tidying_lets_go_of_what_nobody_misses(library, draw):
    kept, gone, shown = library.create("Kept"), library.create("Gone"), library.create(touched=False)
    for key in (kept, gone, shown):
        draw(TakeList(library.shelf(key)), 1)
    library.delete(gone)
    library.tidy()
    assert library.project(gone)
    assert library.project(shown)
    with sqlite3.connect(library.place) as connection:
        connection.execute("update projects set deleted = deleted - ?", (KEPT_DELETED + 1,))
        connection.execute("update projects set changed = changed - ? where not touched", (KEPT_UNTOUCHED + 1,))
    library.tidy()
    assert [library.project(key) is not None for key in (kept, gone, shown)] == [True, False, False]
    with sqlite3.connect(library.place) as connection:
        assert connection.execute("select project from takes").fetchall() == [(kept,)]
        assert connection.execute("select distinct project from steps").fetchall() == [(kept,)]


def test_two_libraries_are_told_apart_and_one_is_the_same_again(tmp_path):
    one, other = open_library(str(tmp_path / "a.db")), open_library(str(tmp_path / "b.db"))
    assert one.id != other.id
    one.close()
    again = open_library(f"sqlite:///{tmp_path / 'a.db'}")
    assert again.id == one.id
    for library in (other, again):
        library.close()


# ---- search -------------------------------------------------------------------------------------------------


@pytest.fixture
def filled(library, draw):
    """Six takes in two projects, and a deleted one."""
    morning, evening, gone = (library.create(name) for name in ("Morning", "Evening", "Gone"))
    takes = TakeList(library.shelf(morning))
    draw(takes, 2, action="walk", style="old")
    draw(takes, 1, seed=2, action="", prompt="A person WAVES, 100% sure", engine="tm2t")
    takes.add([sway(frames=8)], group="f", source="Straße_7.bvh")
    takes.mark("take-2", tags=tags(["good", "old man"]), favourite=True)
    takes.mark("take-3", accepted=True)
    draw(TakeList(library.shelf(evening)), 2, action="run")
    draw(TakeList(library.shelf(gone)), 1, action="walk")
    library.delete(gone)
    return library, takes


FITS = {
    "": [1, 2, 3, 4],
    "walk": [1, 2],
    "WALK  old": [1, 2],
    "walk -": [],
    "waves": [3],
    "100%": [3],
    "100_": [],
    "strasse_7": [4],
    '"take 2"': [2],
    "good": [2],
    "tag:good": [2],
    'tag:"old man"': [2],
    '"old man"': [2],
    '"man old"': [],
    "tag:walk": [],
    "style:old": [1, 2],
    "style:old tag:good": [2],
    "engine:tm2t": [3],
    "action:walk": [1, 2],
    "prompt:sure": [3],
    "is:starred": [2],
    "is:kept": [3],
    "is:imported": [4],
    "is:starred is:kept": [],
    "is:odd": [],
    "colour:blue": [],
    'open "quote': [],
    'tag:"': [1, 2, 3, 4],
}  # fmt: skip


@pytest.mark.parametrize("text", FITS)
def test_a_search_fits_the_same_on_the_shelf_and_in_the_library(filled, text):
    library, takes = filled
    query = Query.parse(text)
    assert [take.number for take in takes if query.matches(take)] == FITS[text]
    found = [take for take in library.search(text) if take.name == "Morning"]
    assert sorted(take.number for take in found) == FITS[text]


def test_a_search_goes_over_all_projects_but_deleted_ones(filled):
    library, _takes = filled
    found = library.search("engine:loom")
    assert [(take.name, take.id, take.subject) for take in found] == [
        ("Evening", "take-2", "run"), ("Evening", "take-1", "run"), ("Morning", "take-2", "walk"),
        ("Morning", "take-1", "walk"),
    ]  # fmt: skip
    assert len(library.search("", limit=3)) == 3


def test_nothing_typed_is_no_search():
    assert not Query.parse("  ")
    assert Query.parse("x")


def test_tags_are_plain_words():
    assert tags(["  Good ", "good", 'a "b", c\\d', "", "\n", "Größe", "x" * 99]) == (
        "good",
        "a b c d",
        "grösse",
        "x" * 40,
    )
    assert tag("\x00\x1f") == ""


def test_a_take_without_settings_is_found_by_its_file():
    take = Take(1, sway(frames=4), "g", source="Kick.bvh")
    assert Query.parse("kick is:imported").matches(take)
    assert not Query.parse("engine:loom").matches(take)
    drawn = Take(2, sway(frames=4), "g", GenerateSettings(engine="loom", action="kick"))
    assert Query.parse("kick engine:loo").matches(drawn)
