"""Takes of a project: kept bit for bit, each step saved as it is done, history and all."""

from __future__ import annotations

import sqlite3

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from engines import Provenance, Segment
from engines.errors import FormatError
from studio.library import LibraryError, open_library
from studio.library.motions import Cache
from studio.library.shelf import Shelf
from studio.pinned import Kept, Pinned
from studio.settings import GenerateSettings
from studio.takes import UNDO_STEPS, Take, TakeList
from tests.studio.fakes import METRICS, sway


def shelf(library, key: str) -> TakeList:
    return TakeList(library.shelf(key))


def seen(takes: TakeList) -> list[tuple]:
    return [(t.id, t.favourite, t.accepted, t.tags, t.edits) for t in takes]


def stray(library, table: str) -> int:
    with sqlite3.connect(library.place) as connection:
        return connection.execute(f"select count(*) from {table}").fetchone()[0]


def test_a_take_comes_back_as_it_was(library, file):
    motion = sway(frames=33, fps=1 / 3).replaced(
        labels=(Segment(0, 5, "action", "jump"), Segment(3, 11, "text", "he said “no” – наверх")),
        provenance=Provenance("engine", "a" * 64, "jump", 2**63, 3, {"guidance": 0.1, "nested": {"list": [1, None]}}),
    )
    pinned = Pinned(kept=(Kept.of(sway(frames=20), 0, 3, 0, "take 2"),), path=((0.0, 0.0), (0.1, 2.0)))
    asked = GenerateSettings(
        engine="loom", action="", prompt="a person “waves”", style="old", seed=9, count=3, constraints=pinned,
        bone_scale={"left_knee": 1.2},
    )  # fmt: skip
    key = library.create("Scene")
    made = shelf(library, key).add([motion], group="g", settings=asked, metrics=[METRICS])[0]
    library.close()

    again = open_library(str(file))
    (take,) = shelf(again, key)
    assert (take.number, take.group, take.source, take.frames) == (1, "g", "", 33)
    assert (take.settings, dict(take.metrics)) == (made.settings, METRICS)
    assert take.settings.take == 1
    for name in ("rotations", "translation"):
        assert getattr(take.motion, name).tobytes() == getattr(motion, name).tobytes()
    assert take.motion.skeleton == motion.skeleton
    assert (take.motion.labels, take.motion.provenance, take.motion.fps) == (motion.labels, motion.provenance, 1 / 3)
    again.close()


def test_every_step_is_there_at_once_for_others(library, draw):
    key = library.create("Scene")
    takes = shelf(library, key)
    draw(takes, 3)
    takes.mark("take-2", favourite=True)
    takes.mark("take-2", tags=("good", "old man"))
    takes.mark("take-3", accepted=True, edits=("mirror",))
    takes.remove("take-1")
    other = shelf(library, key)
    assert seen(other) == seen(takes) == [
        ("take-2", True, False, ("good", "old man"), ()), ("take-3", False, True, (), ("mirror",)),
    ]  # fmt: skip
    assert other.store.saved


def test_undo_and_redo_survive_a_restart(library, file, draw):
    key = library.create("Scene")
    takes = shelf(library, key)
    draw(takes, 2)
    takes.mark("take-2", favourite=True)
    takes.remove("take-1")
    takes.undo()
    library.close()
    again = open_library(str(file))
    takes = shelf(again, key)
    assert (takes.undo_name, takes.redo_name) == ("star take 2", "delete take 1")
    assert takes.redo() == "delete take 1"
    assert [take.id for take in takes] == ["take-2"]
    assert [takes.undo(), takes.undo(), takes.undo(), takes.undo()] == [
        "delete take 1", "star take 2", "generate walk", "",
    ]  # fmt: skip
    assert len(takes) == 0
    assert [takes.redo(), len(takes)] == ["generate walk", 2]
    assert takes.get("take-1").motion.frames == 8
    again.close()


def change(takes: TakeList, step: str, chosen: str, draw) -> None:
    marks = {"star": {"favourite": True}, "keep": {"accepted": True}, "tag": {"tags": ("good",)}}
    if step in marks:
        takes.mark(chosen, **marks[step])
    else:
        {
            "add": lambda: draw(takes, 1),
            "remove": lambda: takes.remove(chosen),
            "clear": takes.clear,
            "undo": takes.undo,
            "redo": takes.redo,
        }[step]()


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.lists(
        st.sampled_from(["add", "star", "keep", "tag", "remove", "clear", "undo", "redo", "restart"]), max_size=20
    ),
    st.data(),
)  # fmt: skip
def test_it_does_what_the_store_in_memory_does(library, draw, steps, data):
    key = library.create("Scene")
    takes, memory = shelf(library, key), TakeList()
    for step in steps:
        if step == "restart":
            takes = shelf(library, key)
            continue
        chosen = data.draw(st.sampled_from([take.id for take in memory] or ["none"]))
        for both in (takes, memory):
            change(both, step, chosen, draw)
        assert seen(takes) == seen(memory)
        assert (takes.undo_name, takes.redo_name) == (memory.undo_name, memory.redo_name)
    fresh = shelf(library, key)
    assert seen(fresh) == seen(memory)
    assert (fresh.undo_name, fresh.redo_name) == (memory.undo_name, memory.redo_name)


def test_numbers_are_never_used_twice_not_even_after_a_restart(library, draw):
    key = library.create("Scene")
    takes = shelf(library, key)
    draw(takes, 2)
    takes.undo()
    takes = shelf(library, key)
    assert draw(takes, 1) == ["take-3"]


def test_the_same_motion_is_kept_once(library, draw):
    takes = shelf(library, library.create("One"))
    draw(takes, 2)
    draw(shelf(library, library.create("Other")), 2)
    draw(takes, 2)
    assert (stray(library, "takes"), stray(library, "motions")) == (6, 2)


def test_what_no_undo_brings_back_goes(library, draw, monkeypatch):
    key = library.create("Scene")
    takes = shelf(library, key)
    draw(takes, 2)
    takes.undo()
    assert stray(library, "takes") == 2, "redo would bring them back"
    draw(takes, 1, seed=2)
    assert [take.id for take in takes] == ["take-3"]
    assert stray(library, "takes") == 1
    assert stray(library, "motions") == 3
    library.tidy()
    assert stray(library, "motions") == 3, "put in just now: another program may be about to use them"
    monkeypatch.setattr("studio.library.motions.UNUSED", -1.0)
    library.tidy()
    assert stray(library, "motions") == 1
    assert takes.get("take-3").motion.frames == 8


def test_history_is_bounded(library, draw):
    takes = shelf(library, library.create("Scene"))
    draw(takes, 2)
    takes.remove("take-2")
    for i in range(UNDO_STEPS + 3):
        takes.mark("take-1", favourite=i % 2 == 0)
    assert stray(library, "steps") == UNDO_STEPS
    assert stray(library, "takes") == 1, "a take deleted so long ago cannot come back"


# ---- several at once --------------------------------------------------------------------------------------


def test_two_browsers_in_one_project_lose_nothing_of_each_other(library, draw):
    key = library.create("Scene")
    one, other = shelf(library, key), shelf(library, key)
    assert draw(one, 2) == ["take-1", "take-2"]
    assert draw(other, 2, seed=5, action="run") == ["take-3", "take-4"], "numbers given meanwhile are not given again"
    assert one.store.refresh()
    assert not one.store.refresh(), "nothing new since"
    one.mark("take-3", favourite=True)
    other.mark("take-3", accepted=True)
    other.mark("take-1", tags=("mine",))
    one.store.refresh()
    assert seen(one) == seen(other) == [
        ("take-1", False, False, ("mine",), ()), ("take-2", False, False, (), ()), ("take-3", True, True, (), ()),
        ("take-4", False, False, (), ()),
    ]  # fmt: skip
    assert [one.get(f"take-{n}").subject for n in (1, 3)] == ["walk", "run"]
    np.testing.assert_array_equal(one.get("take-3").motion.rotations, sway("run", 8, 5, 0).rotations)


def test_undo_takes_back_the_last_step_whoever_did_it_and_nothing_else(library, draw):
    key = library.create("Scene")
    one, other = shelf(library, key), shelf(library, key)
    draw(one, 2)
    other.store.refresh()
    other.mark("take-1", favourite=True)
    one.mark("take-1", tags=("mine",))
    assert one.undo() == "tag take 1"
    assert one.undo() == "star take 1"
    assert other.undo() == "generate walk"
    one.store.refresh()
    assert (len(one), len(other)) == (0, 0)
    assert one.redo() == "generate walk"


def test_a_step_that_was_saved_though_it_looked_otherwise_is_not_done_twice(library, draw):
    """The connection may break after the commit and before the answer."""
    key = library.create("Scene")
    takes = shelf(library, key)
    draw(takes, 1)
    store = takes.store
    write, waiting = Shelf._write, []

    def breaks_off(self: Shelf) -> bool:
        waiting.extend(self._waiting)
        write(self)
        self._waiting = list(waiting)
        return False

    store._write = breaks_off.__get__(store)
    draw(takes, 2, seed=2)
    takes.mark("take-1", favourite=True)
    del store._write
    store.refresh()
    assert [take.id for take in shelf(library, key)] == ["take-1", "take-2", "take-3"]
    assert stray(library, "steps") == 3


# ---- pictures, motions at hand --------------------------------------------------------------------------


def test_pictures_are_kept_with_the_takes(library, draw):
    key = library.create("Scene")
    takes = shelf(library, key)
    draw(takes, 2)
    takes.store.keep_pictures({1: "data:one", 2: "data:two", 9: "of nobody"})
    assert library.shelf(key).pictures() == {"take-1": "data:one", "take-2": "data:two"}
    assert not takes.store.refresh(), "a picture is no step"


def test_motions_looked_at_longest_ago_make_room():
    motions = [sway(frames=8, seed=i) for i in range(4)]
    size = 4 * (motions[0].rotations.nbytes + motions[0].translation.nbytes)
    cache = Cache(2 * size)
    cache.put("0", motions[0])
    cache.put("1", motions[1])
    assert cache.get("0") is motions[0]
    cache.put("2", motions[2])
    assert [cache.get(key) is not None for key in "012"] == [True, False, True]


def test_takes_are_listed_without_their_motions(library, draw, monkeypatch):
    key = library.create("Scene")
    draw(shelf(library, key), 3)
    library.cache = Cache()
    monkeypatch.setattr("studio.library.motions.fetch", lambda *_: pytest.fail("a motion was fetched"))
    takes = shelf(library, key)
    assert [(take.frames, take.duration, take.subject) for take in takes] == [(8, 0.4, "walk")] * 3


def test_a_damaged_motion_is_named_and_the_others_are_there(library, draw):
    key = library.create("Scene")
    takes = shelf(library, key)
    draw(takes, 2)
    bad = takes.get("take-1").held.hash
    with sqlite3.connect(library.place) as connection:
        connection.execute("update motions set data = substr(data, 1, 300) where hash = ?", (bad,))
    library.cache = Cache()
    takes = shelf(library, key)
    with pytest.raises(FormatError, match=rf"motion {bad[:8]} of the library: "):
        _ = takes.get("take-1").motion
    assert takes.get("take-2").motion.frames == 8


def test_settings_a_later_version_wrote_do_not_hide_the_take(library, draw):
    key = library.create("Scene")
    draw(shelf(library, key), 1)
    with sqlite3.connect(library.place) as connection:
        connection.execute("update takes set settings = ?", ('{"version": 99}',))
    (take,) = shelf(library, key)
    assert (take.settings, take.frames) == (None, 8)


def test_a_shelf_of_no_project(library):
    with pytest.raises(LibraryError, match="there is no project 'abc'"):
        library.shelf("abc")


def test_a_take_held_elsewhere_is_a_mistake_of_ours(library):
    class Elsewhere:
        frames, fps = 3, 20.0

        def motion(self):
            raise AssertionError

    takes = shelf(library, library.create("Scene"))
    with pytest.raises(TypeError, match="held by Elsewhere"):
        takes.store.do(*_step(Take(1, Elsewhere(), "g")))


def _step(take: Take):
    from studio.takes import PRESENT, Change, Step

    return Step("add", (Change(take.number, {PRESENT: (False, True)}),)), [take]
