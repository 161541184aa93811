"""MultiAct's protocol on made-up clips: what is asked, what the simple ways make, what is counted."""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from engines.errors import MotionloomError, OutOfRangeError
from engines.evaluation import Results, SequenceBench, SequenceOptions, evaluate, sequences, tables
from engines.evaluation.rounds import REAL
from engines.evaluation.ways import ways
from engines.motion import Motion
from engines.multiact.cell import MACVAECell
from engines.multiact.engine import MultiActEngine
from tests.engines.action2motion import tiny
from tests.engines.evaluation import small
from tests.engines.multiact.tiny import model

OPTIONS = SequenceOptions(motions=20, frames=24, seed=3)
CLIPS = [
    replace(tiny.clip(action, 44 + 4 * i, 10 * i + k), split=split)
    for i, action in enumerate(tiny.ACTIONS)
    for k, split in enumerate(("train", "test"))
]


@pytest.fixture(scope="module")
def engines() -> dict[str, Any]:
    simple = ways(tiny.engine())
    ours = MultiActEngine(MACVAECell(model()), "1" * 64, lambda action, frames, seed: tiny.movement(frames, seed))
    return {"multiact": ours, **simple}


@pytest.fixture(scope="module")
def bench(engines: dict[str, Any]) -> SequenceBench:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sequences, "TRIPLETS", 40)
        return SequenceBench(engines, CLIPS, small.recogniser(), OPTIONS)


def test_all_rows_are_asked_the_same_and_no_action_twice_in_a_row(bench: SequenceBench) -> None:
    asked = bench.asked(0)
    assert len(asked) == 1 and asked == bench.asked(0) and asked != bench.asked(1)
    for blocks, _ in asked:
        names = [name for name, _ in blocks]
        assert len(names) == 20 and all(a != b for a, b in itertools.pairwise(names))
        assert set(names) <= set(bench.actions) == {"walk", "turn left", "turn right", "throw"}
        assert {seconds for _, seconds in blocks} == {1.2}


def test_the_simple_ways_join_clips_without_a_gap(engines: dict[str, Any]) -> None:
    blocks = [("walk", 2.0), ("throw", 2.0), ("turn left", 1.5)]
    made = {name: way.sequence(blocks, 5) for name, way in engines.items() if name != "multiact"}
    assert list(made) == [f"action2motion, {w}" for w in ("linear", "slerp", "inertialised", "label switch")]
    for name, motion in made.items():
        assert len(motion) == 110, name
        assert [(s.start, s.end) for s in motion.labels if s.kind == "transition"] == [(40, 50), (80, 90)]
        steps = np.linalg.norm(np.diff(motion.positions, axis=0), axis=-1).max(axis=1)
        assert steps[[39, 49, 79, 89]].max() < 2 * np.percentile(steps, 95) + 1e-3, name
    linear, slerp = (made[f"action2motion, {w}"] for w in ("linear", "slerp"))
    # between two poses a slerp turns as far each frame; the path is a straight line in both
    turns = np.abs(np.einsum("tjc,tjc->tj", slerp.rotations[40:49], slerp.rotations[41:50])).clip(max=1)
    np.testing.assert_allclose(np.arccos(turns), np.arccos(turns[:1]).repeat(9, 0), atol=1e-6)
    for motion in (linear, slerp):
        pace = np.diff(motion.translation[39:51], axis=0)
        np.testing.assert_allclose(pace, pace[:1].repeat(11, 0), atol=1e-5)
    assert np.abs(linear.rotations[44] - slerp.rotations[44]).max() > 1e-5


def test_passages_are_what_lies_around_transitions() -> None:
    motion = ways(tiny.engine())["action2motion, slerp"].sequence([("walk", 2.0), ("throw", 2.0), ("walk", 1.0)], 1)
    first, second = sequences.passages(motion)
    assert (len(first.seam), len(first.action), first.name) == (30, 30, "throw")
    assert (len(second.seam), len(second.action), second.name) == (30, 10, "walk")


def test_a_jerk_is_seen_and_a_parabola_has_none() -> None:
    motion = tiny.movement(30)
    path = np.zeros((30, 3))
    path[:, 2] = (np.arange(30) / 20) ** 2
    still = motion.replaced(rotations=motion.rotations[:1].repeat(30, 0), translation=path)
    assert sequences.peak_jerk(still) < 1e-6
    path[15:, 2] += 0.01
    assert sequences.peak_jerk(still.replaced(translation=path)) == pytest.approx(2 * 0.01 * 20**3, rel=0.01)


def test_a_table_of_all_rows(bench: SequenceBench, engines: dict[str, Any]) -> None:
    results = Results(bench.basis("e"), bench.recogniser.labels)
    evaluate(bench, engines, results, repeats=1)
    rows = results.shown(list(engines), 1)
    assert [row.name for row in rows] == [REAL, *engines]
    for row in rows:
        found = row.estimates
        assert {"transition_fid", "accuracy_top1", "seam_jerk", "foot_skate", "jitter"} <= found.keys()
        assert ("accuracy_late" in found) == (row.kind == "made")
        assert 0 <= found["accuracy_top1"].mean <= 1 and found["seam_jerk"].mean > 0
    assert rows[0].estimates["transition_fid"].mean < min(r.estimates["transition_fid"].mean for r in rows[1:])
    text = tables.markdown(results, rows, bench.left_out)
    assert "MultiAct's protocol" in text and "ACTOR + SSMCT" in text and "were captured" in text
    tables.as_json(results, rows, bench.left_out)


def test_mistakes_are_told(engines: dict[str, Any]) -> None:
    class Mute:
        capabilities = frozenset({"actions"})

    with pytest.raises(MotionloomError, match="makes no sequences"):
        SequenceBench({"mute": Mute()}, CLIPS, small.recogniser(), OPTIONS)
    with pytest.raises(MotionloomError, match="needs two actions"):
        SequenceBench(engines, [c for c in CLIPS if c.action == "walk"], small.recogniser(), OPTIONS)
    for changes in ({"motions": 19}, {"frames": 10}, {"seed": -1}):
        with pytest.raises(OutOfRangeError):
            replace(OPTIONS, **changes).check()


def test_an_engine_that_leaves_out_a_transition_is_told(bench: SequenceBench, engines: dict[str, Any]) -> None:
    class Short:
        name = "short"

        def sequence(self, blocks: list, seed: int) -> Motion:
            return engines["action2motion, slerp"].sequence(blocks[:5], seed)

    with pytest.raises(MotionloomError, match="4 transitions between 20"):
        bench.generated(Short(), 0, sequences.Run(None, None, 40))
