from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engines.errors import OutOfRangeError
from studio.settings import GenerateSettings
from studio.takes import UNDO_STEPS, MemoryStore, TakeList
from tests.studio.fakes import METRICS, sway

MOTION = sway(frames=4)
WALK = GenerateSettings(action="walk", count=2)


def drawn(takes: TakeList, count: int = 2, group: str = "g") -> list[str]:
    made = takes.add([MOTION] * count, group=group, settings=GenerateSettings(count=count), metrics=[METRICS] * count)
    return [take.id for take in made]


def test_each_take_knows_which_of_the_draw_it_is():
    takes = TakeList()
    made = takes.add([MOTION, MOTION], group="g", settings=WALK, metrics=[METRICS, {}])
    assert [take.settings.take for take in made] == [1, 2]
    assert [take.id for take in made] == ["take-1", "take-2"]
    assert [dict(take.metrics) for take in made] == [METRICS, {}]
    assert made[0].subject == "walk"


def test_imported_take_is_named_after_its_file():
    take = TakeList().add([MOTION], group="g", source="jump.bvh")[0]
    assert (take.settings, take.subject, take.title) == (None, "jump.bvh", "Take 1")


def test_nothing_to_add_is_refused():
    with pytest.raises(OutOfRangeError):
        TakeList().add([], group="g")


def test_undo_and_redo_are_one_step_each_and_named():
    takes = TakeList()
    drawn(takes)
    takes.mark("take-2", favourite=True)
    takes.remove("take-1")
    assert takes.undo_name == "delete take 1"
    assert takes.undo() == "delete take 1"
    assert [take.id for take in takes] == ["take-1", "take-2"]
    assert takes.undo() == "star take 2"
    assert not takes.get("take-2").favourite
    assert takes.redo_name == "star take 2"
    assert takes.redo() == "star take 2"
    assert takes.get("take-2").favourite
    assert takes.undo() == "star take 2"
    assert takes.undo() == "generate walk"
    assert (len(takes), takes.undo(), takes.undo_name) == (0, "", "")


def test_a_new_step_forgets_what_was_undone():
    takes = TakeList()
    drawn(takes)
    takes.undo()
    drawn(takes, 1)
    assert takes.redo_name == ""
    assert [take.number for take in takes] == [3], "numbers are never used twice"


def test_marking_what_is_already_so_is_no_step():
    takes = TakeList()
    drawn(takes, 1)
    takes.mark("take-1", accepted=True)
    takes.mark("take-1", accepted=True)
    takes.mark("take-9", accepted=True)
    takes.remove("take-9")
    assert takes.undo() == "keep take 1"
    assert takes.undo_name == "generate walk"


def test_clear_leaves_the_kept_and_the_starred():
    takes = TakeList()
    drawn(takes, 4)
    takes.mark("take-2", accepted=True)
    takes.mark("take-3", favourite=True)
    assert takes.clear() == 2
    assert [take.id for take in takes] == ["take-2", "take-3"]
    assert takes.clear() == 0
    takes.undo()
    assert len(takes) == 4


def test_groups_stand_together():
    takes = TakeList()
    drawn(takes, 2, "a")
    drawn(takes, 3, "b")
    assert [take.number for take in takes.group_of("take-4")] == [3, 4, 5]
    assert takes.group_of("take-99") == ()
    assert "take-4" in takes
    assert "take-99" not in takes


def test_history_is_bounded():
    takes = TakeList()
    drawn(takes, 1)
    for i in range(UNDO_STEPS + 20):
        takes.mark("take-1", favourite=i % 2 == 0)
    steps = 0
    while takes.undo():
        steps += 1
    assert steps == UNDO_STEPS


def test_every_change_is_told_and_stored():
    store, told = MemoryStore(), []
    takes = TakeList(store, on_change=lambda takes: told.append(len(takes)))
    drawn(takes)
    takes.remove("take-1")
    takes.undo()
    assert told == [2, 1, 2]
    assert len(TakeList(store)) == 2


@settings(max_examples=60, deadline=None)
@given(st.lists(st.sampled_from(["add", "star", "keep", "remove", "clear", "undo", "redo"]), max_size=25), st.data())
def test_undoing_all_and_redoing_all_comes_back(steps, data):
    takes = TakeList()
    for step in steps:
        ids = [take.id for take in takes] or ["none"]
        chosen = data.draw(st.sampled_from(ids))
        {
            "add": lambda: drawn(takes, 1),
            "star": lambda chosen=chosen: takes.mark(chosen, favourite=True),
            "keep": lambda chosen=chosen: takes.mark(chosen, accepted=True),
            "remove": lambda chosen=chosen: takes.remove(chosen),
            "clear": takes.clear,
            "undo": takes.undo,
            "redo": takes.redo,
        }[step]()
    while takes.redo():
        pass

    def shelf():
        return [(take.id, take.favourite, take.accepted) for take in takes]

    end = shelf()
    while takes.undo():
        pass
    assert takes.all == ()
    while takes.redo():
        pass
    assert shelf() == end
