from __future__ import annotations

import threading
from queue import SimpleQueue

import pytest

from engines.errors import CheckpointError
from studio import tasks, thumbnails
from studio.jobs import JobQueue
from studio.session import STAGE_LIMIT, Session
from tests.studio.fakes import FakeEngine, sway


@pytest.fixture
def started(session, settle):
    session.start()
    settle(session)
    return session


def ids(session):
    return [take.id for take in session.takes]


def test_start_draws_four_takes_of_walk_and_shows_them(started, engine):
    state = started.state
    assert engine.calls == [{"action": "walk", "count": 4, "frames": 60, "seed": 7}]
    assert ids(started) == ["take-1", "take-2", "take-3", "take-4"] == state.shown
    assert state.selected == "take-1"
    assert [take.id for take in state.takes] == ids(started)
    assert set(state.thumbnails) == set(ids(started))
    assert len(set(state.thumbnails.values())) == 4, "each in its colour of the stage"
    assert "foot_skate" in state.takes[0].metrics
    assert not state.generating
    assert (state.weights_hash, state.max_frames) == (engine.weights_hash, 400)


def test_start_twice_draws_once(started, settle):
    started.start()
    settle(started)
    assert len(started.takes) == 4


def test_an_open_seed_changes_with_each_draw_and_a_locked_one_stays(started, engine, settle, monkeypatch):
    monkeypatch.setattr("random.randrange", lambda _limit: 123)
    started.generate()
    settle(started)
    started.state.seed_locked = True
    started.generate()
    settle(started)
    assert [call["seed"] for call in engine.calls] == [7, 123, 123]
    assert started.state.seed == 123


def test_a_locked_seed_gives_the_identical_motion(started, settle):
    started.state.param.update(seed=7, seed_locked=True)
    started.generate()
    settle(started)
    first, again = started.takes.get("take-2").motion, started.takes.get("take-6").motion
    assert (first.rotations == again.rotations).all()
    assert (first.translation == again.translation).all()


def test_one_draw_at_a_time_and_none_that_cannot_be(started, engine, settle):
    started.state.generating = True
    started.generate()
    started.state.generating = False
    started.state.action = "moonwalk"
    started.generate()
    settle(started)
    assert len(engine.calls) == 1
    assert "moonwalk" in started.state.problem()


def test_body_proportions_reach_the_engine_and_the_take(started, engine, settle):
    started.state.bone_scale = {"left_knee": 1.2}
    started.generate()
    settle(started)
    assert engine.calls[-1]["bone_scale"] == {"left_knee": 1.2}
    assert started.state.take().settings.bone_scale == {"left_knee": 1.2}


def test_cancel_of_a_draw_leaves_no_take(session, engine, settle):
    engine.slow = 0.3
    session.start()
    while not session.state.generating:
        threading.Event().wait(0.01)
    session.cancel_generate()
    settle(session)
    assert len(session.takes) == 0
    assert not session.state.generating
    assert "Cancelled" in session.state.message


def test_an_engine_that_cannot_be_loaded_is_told(queue, settle, monkeypatch):
    def missing(_name, _variant=""):
        raise CheckpointError("weights are missing; train them")

    monkeypatch.setattr(tasks, "load_engine", missing)
    session = Session(queue=queue)
    session.start()
    settle(session)
    assert session.state.generate_error == "weights are missing; train them"
    assert session.state.problem() == "The engine could not be loaded."
    session.close()


def test_a_draw_that_fails_is_told_and_the_next_one_runs(started, engine, settle, monkeypatch):
    monkeypatch.setattr(engine, "max_frames", 10**6)
    original = engine.generate_many
    monkeypatch.setattr(engine, "generate_many", lambda *_a, **_k: 1 / 0)
    started.generate()
    settle(started)
    assert "ZeroDivisionError" in started.state.generate_error
    monkeypatch.setattr(engine, "generate_many", original)
    started.generate()
    settle(started)
    assert started.state.generate_error == ""
    assert len(started.takes) == 8


def test_pictures_that_cannot_be_drawn_do_not_cost_the_takes(session, settle, monkeypatch):
    def broken(_motion, _colour, _body):
        raise RuntimeError("no OpenGL here")

    monkeypatch.setattr(thumbnails, "thumbnail", broken)
    session.start()
    settle(session)
    assert len(session.state.takes) == 4
    assert session.state.thumbnails == {}


def test_again_takes_over_the_settings_of_the_take_on_another_seed(started, engine, settle):
    started.state.param.update(action="run", frames=33, count=2)
    started.again("take-3")
    settle(started)
    call = engine.calls[-1]
    assert (call["action"], call["frames"], call["count"]) == ("walk", 60, 4)
    assert call["seed"] == started.state.seed
    assert started.state.selected == "take-5"


def test_stage_shows_the_draw_one_take_or_those_compared(started, settle):
    state = started.state
    started.generate()
    settle(started)
    assert state.shown == ["take-5", "take-6", "take-7", "take-8"]
    started.select("take-2")
    assert state.shown == ["take-1", "take-2", "take-3", "take-4"]
    state.stage_mode = "one"
    assert state.shown == ["take-2"]
    started.compare("take-2")
    started.compare("take-7")
    assert (state.stage_mode, state.shown) == ("compare", ["take-2", "take-7"])
    started.compare("take-2")
    assert state.shown == ["take-7"]
    started.compare("take-7")
    assert (state.stage_mode, state.shown) == ("all", ["take-1", "take-2", "take-3", "take-4"])
    started.select("take-99")
    assert state.selected == "take-2"


def test_stage_holds_no_more_than_it_can_show(started, settle):
    started.state.count = 20
    started.generate()
    settle(started)
    assert len(started.state.shown) == STAGE_LIMIT


def test_deleting_the_picked_take_picks_its_neighbour(started):
    state = started.state
    started.select("take-2")
    started.compare("take-2")
    started.delete("take-2")
    assert (state.selected, state.compared) == ("take-3", [])
    started.select("take-4")
    started.delete("take-4")
    assert state.selected == "take-3"
    started.delete("take-3")
    started.delete("take-1")
    assert (state.selected, state.shown, state.takes) == ("", [], ())
    started.undo()
    assert state.selected == "take-1"
    assert state.redo_name == "delete take 1"


def test_undo_of_a_draw_and_redo(started):
    started.undo()
    assert started.state.takes == ()
    assert started.state.redo_name == "generate walk"
    started.redo()
    assert len(started.state.takes) == 4
    assert started.state.shown
    assert started.state.message == "Redid: generate walk"


def test_keep_star_and_clear(started):
    started.toggle("take-2", "accepted")
    started.toggle("take-3", "favourite")
    started.toggle("take-3", "favourite")
    started.clear()
    assert ids(started) == ["take-2"]
    started.clear()
    assert started.state.message == "Nothing to clear."


def test_another_variant_is_loaded_and_its_takes_say_so(started, engine, settle):
    started.state.variant = "other"
    settle(started)
    assert started.state.engine_ready
    started.generate()
    settle(started)
    assert started.state.take().settings.variant == "other"


def test_outcomes_are_dispatched_not_applied_on_the_worker(engine, queue, settle):
    waiting = []
    session = Session(queue=queue, dispatch=waiting.append)
    session.start()
    settle(session)
    assert not session.state.engine_ready, "nothing happens before the document's thread says so"
    for _ in range(20):
        settle(session)
        while waiting:
            waiting.pop(0)()
    assert len(session.state.takes) == 4
    session.close()


def test_a_job_that_ends_while_it_is_shown_is_shown_as_ended_once(engine, queue):
    news, gate, seen = SimpleQueue(), threading.Event(), []
    session = Session(queue=queue, dispatch=news.put)

    def show(job):
        before = job.status
        gate.set()
        assert real.wait(10)
        seen.append((before, job.status))

    real = session.submit("work", lambda _progress, _cancel: gate.wait(10), show)
    while not seen or seen[-1][1] == "running":
        news.get(timeout=10)()
    while not news.empty():
        news.get()()
    assert seen == [("running", "running"), ("done", "done")]
    session.close()


def test_two_sessions_do_not_wait_for_each_other(engine, monkeypatch):
    gate = threading.Event()
    slow = FakeEngine("slow")  # else the session goes back to "plain" once it is loaded
    monkeypatch.setattr(slow, "generate_many", lambda *_a, **_k: gate.wait(20) and [sway()])
    monkeypatch.setattr(tasks, "load_engine", lambda name, variant="": slow if variant == "slow" else engine)
    queue = JobQueue()
    busy, other = Session(queue=queue), Session(queue=queue)
    try:
        busy.state.variant = "slow"
        busy.start()
        other.start()
        deadline = threading.Event()
        for _ in range(400):
            if len(other.takes) == 4:
                break
            deadline.wait(0.02)
        assert len(other.takes) == 4
        assert busy.state.takes == ()
    finally:
        gate.set()
        busy.close()
        other.close()
        queue.close()


def test_closing_removes_the_files(session, settle):
    session.start()
    settle(session)
    assert session.files.folder is None, "no folder before there is a file"
    session.state.export_format = "bvh"
    session.files.export()
    settle(session)
    folder = session.files.folder
    assert [path.name for path in folder.rglob("*.bvh")] == ["take-1-walk.bvh"]
    session.close()
    assert not folder.exists()


def test_a_row_of_takes_is_compared_up_to_what_the_stage_holds(started, settle):
    started.compare_these(["take-3", "take-1", "take-3", "take-9"])
    assert started.state.shown == ["take-3", "take-1"]
    started.state.count = 20
    started.generate()
    settle(started)
    started.compare_these(ids(started))
    assert len(started.state.shown) == len(started.state.compared) == STAGE_LIMIT
    assert started.state.message == "At most 16 takes are compared at once."
    started.compare("take-24")
    assert started.state.compared == ids(started)[:STAGE_LIMIT], "one more is not taken"
    started.compare_these([])
    assert (started.state.compared, started.state.stage_mode) == ([], "all")
