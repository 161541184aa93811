from __future__ import annotations

import threading

import pytest

from engines.errors import Cancelled, OutOfRangeError
from studio.jobs import Job, JobQueue, shared_queue


def test_result_and_progress_arrive(queue):
    seen = []

    def work(progress, _cancel):
        progress(1, 4)
        progress(4, 4)
        return threading.current_thread().name

    job = queue.submit("me", "count", work, on_change=lambda job: seen.append((job.status, job.fraction)))
    assert job.wait(10)
    assert job.status == "done"
    assert job.result.startswith("motionloom-generate")
    assert seen[0] == ("running", 0.0)
    assert seen[-1] == ("done", 1.0)


def test_a_mistake_is_told_in_its_own_words_and_a_fault_with_its_kind(queue):
    def mistaken(_progress, _cancel):
        raise OutOfRangeError("frames", 1, "2 or more")

    def faulty(_progress, _cancel):
        raise KeyError("left_wing")

    first, second = queue.submit("me", "a", mistaken), queue.submit("me", "draw", faulty)
    assert first.wait(10)
    assert second.wait(10)
    assert (first.status, first.error) == ("failed", "frames is 1; accepted: 2 or more.")
    assert (second.status, second.error) == ("failed", "draw failed: KeyError: 'left_wing'")


def test_cancel_stops_running_work_at_its_next_step(queue):
    going, steps = threading.Event(), []

    def work(progress, _cancel):
        for step in range(1000):
            steps.append(step)
            progress(step, 1000)
            going.set()
            threading.Event().wait(0.005)

    job = queue.submit("me", "long", work)
    assert going.wait(10)
    job.cancel()
    assert job.wait(10)
    assert job.status == "cancelled"
    assert len(steps) < 1000


def test_cancel_of_waiting_work_is_at_once_and_it_never_runs():
    queue = JobQueue({"generate": 1})
    gate, ran = threading.Event(), []
    try:
        queue.submit("me", "gate", lambda _p, _c: gate.wait(10))
        waiting = queue.submit("me", "waiting", lambda _p, _c: ran.append(1))
        waiting.cancel()
        assert waiting.status == "cancelled"
        gate.set()
        last = queue.submit("me", "last", lambda _p, _c: None)
        assert last.wait(10)
        assert ran == []
    finally:
        gate.set()
        queue.close()


def test_owners_take_turns_in_a_lane():
    queue = JobQueue({"generate": 1})
    gate, order = threading.Event(), []
    try:
        queue.submit("hog", "gate", lambda _p, _c: gate.wait(10))
        jobs = [queue.submit("hog", f"hog {i}", lambda _p, _c, i=i: order.append(f"hog {i}")) for i in range(4)]
        jobs.append(queue.submit("guest", "guest", lambda _p, _c: order.append("guest")))
        gate.set()
        assert all(job.wait(10) for job in jobs)
        assert order.index("guest") <= 1, order
    finally:
        queue.close()


def test_one_owner_does_not_hold_every_thread_while_another_waits():
    queue = JobQueue({"generate": 2})
    gate, started = threading.Event(), threading.Semaphore(0)
    order = []

    def hold(name):
        def work(_progress, _cancel):
            order.append(name)
            started.release()
            gate.wait(10)

        return work

    try:
        queue.submit("hog", "hog 0", hold("hog"))
        assert started.acquire(timeout=10)
        gate2 = queue.submit("hog", "hog 1", hold("hog"))
        assert started.acquire(timeout=10)
        queue.submit("hog", "hog 2", hold("hog again"))
        guest = queue.submit("guest", "guest", hold("guest"))
        gate.set()
        assert guest.wait(10)
        assert gate2.wait(10)
        assert order.index("guest") < order.index("hog again")
    finally:
        gate.set()
        queue.close()


def test_lanes_do_not_hold_each_other_up(queue):
    gate = threading.Event()
    try:
        for _ in range(8):
            queue.submit("me", "video", lambda _p, _c: gate.wait(10), lane="file")
        still = queue.submit("me", "still", lambda _p, _c: "drawn", lane="still")
        assert still.wait(10)
        assert still.result == "drawn"
    finally:
        gate.set()


@pytest.mark.parametrize("lane", ["still", "caption"])
def test_pictures_and_words_wait_until_all_draws_are_done(queue, lane):
    gate, order = threading.Event(), []
    try:
        draws = [
            queue.submit(f"owner {i}", "draw", lambda _p, _c: gate.wait(10) and order.append("draw")) for i in "ab"
        ]
        draws += [queue.submit(f"owner {i}", "draw", lambda _p, _c: order.append("draw")) for i in "cd"]
        later = queue.submit("owner a", "later", lambda _p, _c: order.append("later"), lane=lane)
        assert not later.wait(0.2)
        gate.set()
        assert later.wait(10)
        assert all(job.wait(10) for job in draws)
        assert order == ["draw"] * 4 + ["later"]
    finally:
        gate.set()


def test_pictures_do_not_wait_for_draws_forever(queue, monkeypatch):
    monkeypatch.setattr("studio.jobs.PATIENCE", 0.05)
    gate = threading.Event()
    try:
        queue.submit("me", "draw", lambda _p, _c: gate.wait(10))
        still = queue.submit("me", "still", lambda _p, _c: "drawn", lane="still")
        assert still.wait(10)
        assert still.result == "drawn"
    finally:
        gate.set()


def test_stills_are_drawn_on_one_thread_always(queue):
    jobs = [queue.submit(f"owner {i}", "still", lambda _p, _c: threading.get_ident(), lane="still") for i in range(12)]
    assert all(job.wait(10) for job in jobs)
    assert len({job.result for job in jobs}) == 1


def test_a_broken_listener_does_not_take_the_worker_down(queue):
    def gone(_job):
        raise RuntimeError("the browser has gone")

    assert queue.submit("me", "a", lambda _p, _c: 1, on_change=gone).wait(10)
    after = queue.submit("me", "b", lambda _p, _c: 2)
    assert after.wait(10)
    assert after.result == 2


def test_cancel_all_is_only_for_its_owner_and_silences_listeners():
    queue = JobQueue({"generate": 1})
    gate, told = threading.Event(), []
    try:
        queue.submit("other", "gate", lambda _p, _c: gate.wait(10))
        mine = queue.submit("me", "mine", lambda _p, _c: 1, on_change=told.append)
        other = queue.submit("other", "theirs", lambda _p, _c: 2)
        queue.cancel_all("me")
        gate.set()
        assert other.wait(10)
        assert (mine.status, other.status, told) == ("cancelled", "done", [])
        assert queue.jobs("me") == []
    finally:
        gate.set()
        queue.close()


def test_progress_is_told_at_a_bounded_rate():
    job = Job("me", "many", lambda progress, _cancel: [progress(i, 10_000) for i in range(10_000)])
    told = []
    job.on_change = lambda job: told.append(job.done)
    job._run()
    assert job.status == "done"
    assert len(told) < 200
    assert job.done == 9_999


def test_progress_of_a_cancelled_job_raises():
    job = Job("me", "x", lambda *_: None)
    job._cancel.set()
    with pytest.raises(Cancelled):
        job._progress(1, 2)


def test_closed_queue_takes_no_more():
    queue = JobQueue()
    queue.submit("me", "a", lambda _p, _c: 1).wait(10)
    queue.close()
    with pytest.raises(RuntimeError, match="closed"):
        queue.submit("me", "b", lambda _p, _c: 1)


def test_sessions_share_one_queue():
    assert shared_queue() is shared_queue()
