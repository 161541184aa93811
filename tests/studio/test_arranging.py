"""What a person does on the timeline: steps of the project, takes that show their blocks, new seeds."""

from __future__ import annotations

import pytest

from studio.arranging import as_shown
from studio.library import open_library
from studio.session import Session
from studio.takes import TakeList


@pytest.fixture
def open_session(session: Session, settle) -> Session:
    session.start()
    settle(session)
    session.state.compose_tab = "sequence"
    return session


def names(session: Session) -> list[str]:
    return [block.what for block in session.state.sequence.blocks]


def add(session: Session, *actions: str) -> None:
    for action in actions:
        session.arranging.act({"do": "add", "what": action})


def test_blocks_are_added_behind_the_picked_one_and_each_thing_done_is_a_step(open_session):
    session = open_session
    state = session.state
    assert state.problem() == "Drag actions onto the timeline, or press them."
    add(session, "walk", "run")
    state.block = "1"
    add(session, "jump")
    session.arranging.act({"do": "add", "what": "kick", "at": 0})
    assert names(session) == ["kick", "walk", "jump", "run"]
    session.arranging.act({"do": "move", "id": "1", "to": 3})
    session.arranging.act({"do": "change", "id": "2", "values": {"seconds": 1.25}})
    session.arranging.act({"do": "duplicate", "id": "2"})
    session.arranging.act({"do": "split", "id": "3", "after": 1.0})
    session.arranging.act({"do": "remove", "id": "4"})
    assert state.undo_name == "delete kick"
    after = names(session)
    for _ in range(5):
        session.undo()
    assert names(session) == ["kick", "walk", "jump", "run"]
    for _ in range(5):
        session.redo()
    assert names(session) == after
    session.arranging.clear()
    assert names(session) == []
    session.undo()
    assert names(session) == after


def test_what_cannot_be_done_is_said_and_changes_nothing(open_session):
    session = open_session
    state = session.state
    add(session, "walk")
    session.arranging.act({"do": "change", "id": "1", "values": {"seconds": -3}})
    assert state.sequence_error.startswith("Seconds is -3.0; accepted")
    heard = state.heard
    session.arranging.act({"do": "lock", "id": "1"})
    assert state.sequence_error == ""
    session.arranging.act({"do": "remove", "id": "1"})
    assert state.sequence_error == "Block 1 (walk) is locked; unlock it first."
    assert state.heard == heard + 2, "the timeline hears of what was refused"
    session.arranging.act({"do": "change", "id": "1", "values": {"locked": False}})
    assert "Field of a block is 'locked'" in state.sequence_error
    session.arranging.act({"do": "change", "id": "1", "values": {"seed": "x"}})
    assert state.sequence_error == "Seed is 'x'; accepted: a number."
    session.arranging.act({"do": "fly"})
    assert names(session) == ["walk"]
    add(session, "wlak")
    assert state.problem().startswith("Block 2: “wlak” is not an action this engine knows. Nearest: “walk”")


def test_a_take_of_it_shows_its_blocks_and_work_goes_on_where_it_was(open_session, settle):
    session = open_session
    state = session.state
    add(session, "walk", "run")
    assert not any(block["made"] for block in as_shown(session)["blocks"])
    session.generate()
    add(session, "jump")  # while it is made
    settle(session)
    made = state.take()
    assert made is not None
    assert made.settings is not None
    assert [block.what for block in made.settings.sequence.blocks] == ["walk", "run"]
    assert made.subject == "walk, then run"
    assert names(session) == ["walk", "run", "jump"], "what was done meanwhile is not lost"
    assert [block["made"] for block in as_shown(session)["blocks"]] == [True, True, False]
    session.generate()
    settle(session)
    session.select(made.id)
    assert names(session) == ["walk", "run"]
    session.select("take-1")
    assert names(session) == ["walk", "run", "jump"]
    session.select(made.id)
    session.arranging.act({"do": "remove", "id": "1"})
    session.undo()
    assert names(session) == ["walk", "run", "jump"], "the first change to a take's blocks is one step"
    state.compose_tab = "action"
    session.select("take-1")
    assert as_shown(session) == {}
    session.select(made.id)
    assert len(as_shown(session)["blocks"]) == 2, "a take of a sequence shows it in any tab"
    session.restore(made.id)
    assert (state.compose_tab, state.request) == ("sequence", "sequence")
    state.compose_tab = "vary"
    assert state.request == "action"


def test_regenerate_and_new_seeds_leave_what_is_locked(open_session, engine, settle):
    session = open_session
    add(session, "walk", "run")
    session.arranging.act({"do": "lock", "id": "1"})
    before = session.state.sequence
    session.generate()
    settle(session)
    session.arranging.act({"do": "renew", "id": "1"})
    assert "locked" in session.state.sequence_error
    session.arranging.act({"do": "renew"})
    settle(session)
    now = session.state.sequence
    assert (now.blocks[0], now.blocks[1].seed == before.blocks[1].seed) == (before.blocks[0], False)
    assert len(session.state.takes) == 4 + 2
    last = session.state.take()
    session.again(last.id)
    settle(session)
    newest = session.state.take()
    assert newest.settings.sequence.blocks[0] == before.blocks[0]
    assert newest.settings.sequence.blocks[1].seed != last.settings.sequence.blocks[1].seed


def test_another_engine_for_the_actions_is_a_step(open_session, settle):
    session = open_session
    add(session, "walk", "run", "jump")
    session.arranging.by("multiact")
    assert (session.state.sequence.engine, session.state.undo_name) == ("multiact", "actions by multiact")
    session.arranging.clear()
    assert session.state.sequence.engine == "multiact"
    session.undo()
    session.undo()
    assert session.state.sequence.engine == ""
    session.generate()
    settle(session)

    def made() -> list[bool]:
        return [block["made"] for block in as_shown(session)["blocks"]]

    assert made() == [True, True, True]
    session.arranging.act({"do": "split", "id": "2", "after": 1.0})
    assert made() == [True, True, True, True], "a part of what is in the take is in the take"
    session.arranging.act({"do": "change", "id": "1", "values": {"seed": 3}})
    assert made() == [False, True, True, True]
    session.arranging.by("multiact")
    assert made() == [False, False, False, False]


def test_the_picked_take_becomes_a_clip(open_session):
    session = open_session
    session.arranging.act({"do": "add", "kind": "clip", "take": "take-2"})
    (block,) = session.state.sequence.blocks
    assert (block.kind, block.what, block.seconds) == ("clip", "take 2", 3.0)
    session.arranging.act({"do": "add", "kind": "clip", "take": "take-99"})
    assert session.state.sequence_error.startswith("Pick a take first")


def test_the_blocks_are_kept_with_the_project(tmp_path):
    library = open_library(str(tmp_path / "library.db"))
    mine = library.create("Scene")
    takes = TakeList(library.shelf(mine))
    takes.arrange({"blocks": [{"what": "walk", "id": "1"}]}, "add walk")
    takes.arrange({}, "clear the timeline")
    takes.undo()
    library.close()
    again = open_library(str(tmp_path / "library.db")).shelf(mine)
    assert again.sequence == {"blocks": [{"what": "walk", "id": "1"}]}
    assert (again.undo_name, again.redo_name) == ("add walk", "clear the timeline")
    assert again.body == {}
