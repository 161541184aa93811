"""Action2Motion's protocol on made-up clips: who is asked for what, seeds, stopping and going on."""

from __future__ import annotations

import copy
from dataclasses import replace

import numpy as np
import pytest

from engines.errors import Cancelled, MotionloomError, OutOfRangeError, UnknownLabelError
from engines.evaluation import ActionBench, Options, Results, evaluate
from engines.evaluation.real import STEP, RealMotions
from engines.evaluation.rounds import REAL, TRAINING
from engines.metrics import physical
from tests.engines.action2motion import tiny
from tests.engines.evaluation import small


@pytest.fixture(scope="module")
def engine():
    return tiny.engine()


def figures(results: Results) -> dict:
    """All but the time it took."""
    return {name: [replace(repeat, seconds=0.0) for repeat in row.repeats] for name, row in results.rows.items()}


def run(engines, path=None, repeats=2, **options) -> Results:
    bench = small.bench(engines)
    results = Results(bench.basis("0" * 64), bench.recogniser.labels)
    if path:
        results.go_on_from(path)
    evaluate(bench, engines, results, repeats=repeats, finished=lambda _: path and results.save(path), **options)
    return results


def test_actions_are_asked_for_evenly(engine) -> None:
    bench = small.bench({"a": engine})
    extra = set()
    for repeat in range(6):
        labels = bench.labels(repeat)
        counts = np.bincount(labels, minlength=5)
        assert counts.sum() == 13
        assert sorted(counts) == [2, 2, 3, 3, 3]
        extra |= {tuple(counts)}
    assert len(extra) > 1, "not always the same actions have one more"


def test_the_engine_is_asked_for_just_that(engine) -> None:
    asked = []

    class Watched:
        name, licence, weights_hash, capabilities, actions = "w", "", "1", engine.capabilities, engine.actions

        def generate_many(self, action, **request):
            asked.append((action, request))
            return engine.generate_many(action, **request)

    run({"w": Watched()}, repeats=1)
    labels = small.bench({"a": engine}).labels(0)
    assert [action for action, _ in asked] == [a for a in tiny.ACTIONS if a != "throw"]
    assert [request["count"] for _, request in asked] == np.bincount(labels).tolist()
    assert {request["frames"] for _, request in asked} == {12}
    assert len({request["seed"] for _, request in asked}) == len(asked)


def test_left_out_actions_are_named_with_the_reason(engine) -> None:
    class Other:
        capabilities = frozenset({"actions"})
        actions = engine.actions[1:]

    knows = small.recogniser(("turn left", "throw", "wave left hand"))
    bench = ActionBench({"a": engine, "b": Other()}, small.clips(), knows, small.OPTIONS)
    assert bench.actions == ("turn left", "wave left hand")
    assert bench.left_out == {
        "not known to every engine": ("walk",),
        "without a held-out clip": ("throw",),
        "not known to the recogniser": ("turn right", "wave right hand"),
    }


def test_rows_figures_and_counts(engine) -> None:
    results = run({"one": engine})
    assert list(results.rows) == [REAL, TRAINING, "one"]
    for row in results.rows.values():
        assert len(row.repeats) == 2
        found = row.repeats[0].figures
        assert {"fid", "accuracy_top1", "accuracy_top5", "diversity", "multimodality", "foot_skate"} <= found.keys()
        assert all(np.isfinite(value) for value in found.values())
        counts = row.confusion(5, 7)
        assert counts.sum() == 26
        share = np.average(row.repeats[0].accuracy, weights=np.bincount(small.bench({"a": engine}).labels(0)))
        assert share == pytest.approx(found["accuracy_top1"], abs=1e-5)
    assert results.rows[REAL].estimates["fid"].mean < results.rows["one"].estimates["fid"].mean
    assert results.rows["one"].facts["variant"] == "glmi-m"


def test_a_seed_gives_the_same_table_and_another_another(engine) -> None:
    first, again = run({"one": engine}), run({"one": engine})
    assert figures(first) == figures(again)
    bench = small.bench({"one": engine}, replace(small.OPTIONS, seed=4))
    other = Results(bench.basis("0" * 64), bench.recogniser.labels)
    evaluate(bench, {"one": engine}, other, repeats=1)
    assert figures(other)["one"][0].figures != figures(first)["one"][0].figures


def test_rows_meet_the_same_draw(engine) -> None:
    results = run({"one": engine, "same": engine}, repeats=1)
    kept = figures(results)
    assert kept["one"] == kept["same"]


def test_stopped_and_gone_on_with_it_is_the_same_table(engine, tmp_path) -> None:
    whole = run({"one": engine})
    asked = iter([False] * 12)
    path = tmp_path / "rows.json"
    with pytest.raises(Cancelled, match="goes on there"):
        run({"one": engine}, path, cancel=lambda: next(asked, True))
    half = Results(whole.basis, whole.answers)
    half.go_on_from(path)
    assert [len(row.repeats) for row in half.rows.values()] == [2, 2, 1]
    calls = []
    done = run({"one": engine}, path, progress=lambda *facts: calls.append(facts))
    assert figures(done) == figures(whole)
    assert calls[-1] == (13, 13, "one"), "only the missing repeat is made"
    again = Results(whole.basis, whole.answers)
    again.go_on_from(path)
    assert figures(again) == figures(whole)


def test_fewer_repeats_show_fewer_and_keep_all(engine, tmp_path) -> None:
    path = tmp_path / "rows.json"
    run({"one": engine}, path)
    results = run({"one": engine}, path, repeats=1)
    assert [len(row.repeats) for row in results.shown(["one"], 1)] == [1, 1, 1]
    assert [len(row.repeats) for row in results.rows.values()] == [2, 2, 2]


def test_other_weights_begin_their_row_anew(engine, tmp_path) -> None:
    path = tmp_path / "rows.json"
    first = run({"one": engine}, path, repeats=1)
    changed = copy.copy(engine)
    changed.weights_hash = "1" * 64
    second = run({"one": changed}, path, repeats=1)
    assert second.rows["one"].weights != first.rows["one"].weights
    assert len(second.rows["one"].repeats) == 1


@pytest.mark.parametrize(
    ("content", "says"),
    [("{}", "cannot be read"), ('{"version": 1, "basis": {"seed": 9}, "rows": []}', "seed 9, now 3"), ("x", "--fresh")],
)
def test_rows_of_something_else_are_refused(engine, tmp_path, content, says) -> None:
    (tmp_path / "rows.json").write_text(content)
    with pytest.raises(MotionloomError, match=says):
        run({"one": engine}, tmp_path / "rows.json", repeats=1)
    assert (tmp_path / "rows.json").read_text() == content


def test_drift_of_bones_where_an_engine_tells_it(engine) -> None:
    class Loose:
        name, licence, weights_hash, capabilities, actions = "w", "", "1", engine.capabilities, engine.actions
        generate_many = staticmethod(engine.generate_many)

        @staticmethod
        def generate_joints(action, **request):
            growing = np.linspace(1.0, 1.1, request["frames"])[:, None, None]
            return [motion.positions * growing for motion in engine.generate_many(action, **request)]

    found = run({"loose": Loose(), "rigid": engine}, repeats=1).rows
    assert found["loose"].repeats[0].figures["bone_length_drift"] > 1.0
    assert "bone_length_drift" not in found["rigid"].repeats[0].figures


def test_stretches_of_clips() -> None:
    pool = RealMotions(small.clips(), tiny.ACTIONS[:5], 12, small.recogniser())
    lengths = {len(s.motion) for s in pool.stretches}
    assert lengths == {8, 12}
    long = RealMotions([tiny.clip("walk", 12 + 2 * STEP + 5)], ["walk"], 12, small.recogniser())
    assert [s.start for s in long.stretches] == [0, STEP, 2 * STEP]
    chosen = long.draw(np.zeros(300, dtype=int), np.random.default_rng(0))
    assert set(chosen) == {0, 1, 2}
    expected = np.mean([physical.jitter(long.stretches[i].motion) for i in chosen[:5]])
    assert long.physical(chosen[:5])["jitter"] == pytest.approx(expected)
    alone = small.recogniser().recognised([long.stretches[i].motion for i in chosen[:4]])
    np.testing.assert_allclose(long.recognised(chosen[:4]).features, alone.features, atol=1e-5)


@pytest.mark.parametrize(
    ("options", "error", "says"),
    [
        (Options(data="train"), UnknownLabelError, "held-out"),  # pyright: ignore
        (Options(motions=9, frames=12), OutOfRangeError, "10 or more"),
        (Options(frames=3), OutOfRangeError, "4 or more"),
        (Options(seed=-1), OutOfRangeError, "0 to"),
    ],
)
def test_options_that_are_not_accepted(engine, options, error, says) -> None:
    with pytest.raises(error, match=says):
        small.bench({"a": engine}, options)


def test_engines_that_cannot_be_tested(engine) -> None:
    class Dumb:
        capabilities, actions = frozenset({"text"}), ()

    with pytest.raises(MotionloomError, match=r"does not go by actions.*text"):
        small.bench({"dumb": Dumb()})
    with pytest.raises(MotionloomError, match="none of the 6 actions"):
        ActionBench({"a": engine}, tiny.clips(), small.recogniser(), small.OPTIONS)
    with pytest.raises(OutOfRangeError, match="repeats is 0"):
        run({"a": engine}, repeats=0)
