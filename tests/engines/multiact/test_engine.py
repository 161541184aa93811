"""MultiAct as people ask it, on random weights: what holds whatever was learned."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from engines.errors import Cancelled, MotionloomError, OutOfRangeError, UnknownLabelError
from engines.motion import Motion
from engines.multiact import plan
from engines.multiact.cell import MACVAECell
from engines.multiact.engine import MAX_FRAMES, MultiActEngine, load
from engines.multiact.triplets import CHUNK, LONGEST
from tests.engines.action2motion.tiny import movement
from tests.engines.multiact.tiny import model


def begun(action: str, frames: int, seed: int) -> Motion:
    return movement(frames, seed).labelled(action)


@pytest.fixture(scope="module")
def engine() -> MultiActEngine:
    return MultiActEngine(MACVAECell(model()), "0" * 64, begun)


def steps_of(motion: Motion) -> np.ndarray:
    """(T - 1,) how far the joint that moves most moves, metres."""
    return np.linalg.norm(np.diff(motion.positions, axis=0), axis=-1).max(axis=1)


def test_a_sequence_has_its_blocks_its_labels_and_its_lengths(engine: MultiActEngine) -> None:
    made = engine.sequence([("walk", 2.0), ("throw", 1.5), "sit"], seed=5)
    assert made.fps == 20 and len(made) == 40 + 30 + 30
    actions = [(s.start, s.end, s.value) for s in made.labels if s.kind == "action"]
    between = [(s.start, s.end, s.value) for s in made.labels if s.kind == "transition"]
    assert [value for *_, value in actions] == ["walk", "throw", "sit down"]
    assert [value for *_, value in between] == ["walk > throw", "throw > sit down"]
    assert actions[0][:2] == (0, 40) and actions[-1][1] == 100
    for transition, action in zip(between, actions[1:], strict=True):
        assert transition[0] < transition[1] == action[0]
    assert made.provenance.parameters["blocks"] == [["walk", 2.0], ["throw", 1.5], ["sit down", 1.5]]


def test_seeds_repeat_and_differ(engine: MultiActEngine) -> None:
    asked = [("walk", 1.0), ("throw", 1.5)]
    one, again, other = (engine.sequence(asked, seed=seed) for seed in (1, 1, 2))
    assert np.array_equal(one.rotations, again.rotations) and np.array_equal(one.translation, again.translation)
    assert np.abs(one.rotations[30:] - other.rotations[30:]).max() > 1e-3


def test_nothing_jumps_where_steps_meet(engine: MultiActEngine) -> None:
    start = movement(40, turning=0.3)
    made = engine.sequence([("walk", 9.0), ("throw", 2.0)], seed=2, start=start)
    assert np.abs(made.positions[:40] - start.positions).max() < 1e-9
    usual = np.percentile(steps_of(start), 95)
    speed = steps_of(made)
    ends = np.cumsum(
        [40, *(s.frames for s in plan.steps(engine.cell, next(plan.blocks(engine.cell, [("walk", 9.0)]))))]
    )
    for seam in ends:
        assert speed[seam - 1] < 2.5 * max(usual, np.median(speed))


def test_a_continued_motion_is_where_and_how_its_start_was(engine: MultiActEngine) -> None:
    start = movement(30)
    there = engine.continue_from(start.moved((4.0, 0.0, -3.0), yaw=1.2), "walk", 2.0, seed=3)
    here = engine.continue_from(start, "walk", 2.0, seed=3)
    np.testing.assert_allclose(there.positions, here.moved((4.0, 0.0, -3.0), yaw=1.2).positions, atol=2e-4)
    assert here.labels[0].value == "given > walk"


def test_only_the_end_of_a_start_counts(engine: MultiActEngine) -> None:
    start = movement(90)
    long, short = (engine.continue_from(given, "throw", 1.0, seed=2) for given in (start, start[60:]))
    np.testing.assert_allclose(long.positions[90:], short.positions[30:], atol=1e-9)


def test_any_motion_is_a_start_however_short_and_whatever_its_rate(engine: MultiActEngine) -> None:
    for start in (movement(1), movement(3), movement(70, fps=60.0)):
        made = engine.continue_from(start, "throw", 1.0)
        kept = start.resample(20)
        assert len(made) == len(kept) + 20
        np.testing.assert_allclose(made.positions[: len(kept)], kept.positions, atol=1e-9)


def test_a_walk_goes_on_in_steps_no_longer_than_were_learned(engine: MultiActEngine) -> None:
    (block,) = plan.blocks(engine.cell, [("walk", 30.0)])
    parts = plan.steps(engine.cell, block)
    assert sum(p.frames for p in parts) == 600 and max(p.frames for p in parts) <= CHUNK
    assert max(p.frames for p in parts) - min(p.frames for p in parts) <= 1
    made = engine.sequence([("walk", 30.0)], seed=0)
    # it steps ahead to the end: no stretch of a second stands still
    seconds = np.linalg.norm(made.translation[20::20] - made.translation[:-20:20], axis=-1)
    assert seconds.min() > 0.3 and [s.kind for s in made.labels] == ["action"] * len(parts)


def test_what_is_done_once_is_done_again_as_it_fits_and_a_seat_is_kept(engine: MultiActEngine) -> None:
    def of(name: str, seconds: float) -> list[plan.Step]:
        return plan.steps(engine.cell, next(plan.blocks(engine.cell, [(name, seconds)])))

    assert [s.frames for s in of("throw", 4.5)] == [30, 30, 30]
    assert [s.frames for s in of("throw", 0.5)] == [10]
    sat = of("sit down", 10.0)
    assert [s.held for s in sat] == [False, True, True] and sum(s.frames for s in sat) == 200
    assert sat[0].frames == 40
    made = engine.sequence(["walk", ("sit down", 5.0), ("throw", 1.0)], seed=1)
    held = made.positions[-20 - 40 : -20]
    assert np.abs(held - held[0]).max() < 1e-9


def test_frames_come_one_by_one_and_without_end(engine: MultiActEngine) -> None:
    asked = [("walk", 3.0), ("throw", 1.5), "turn right"]
    whole = engine.sequence(asked, seed=4)
    frames = list(engine.iter_frames(asked, seed=4))
    assert [len(frame) for frame in frames] == [1] * len(whole)
    np.testing.assert_array_equal(np.concatenate([frame.rotations for frame in frames]), whole.rotations)
    assert [frame.label_at(0) for frame in frames] == [whole.label_at(i) for i in range(len(whole))]
    endless = engine.iter_frames(itertools.cycle(["walk", ("throw", 1.0)]), seed=0)
    assert sum(1 for _ in itertools.islice(endless, 500)) == 500


def test_transitions_are_as_long_as_asked(engine: MultiActEngine) -> None:
    made = engine.sequence([("walk", 1.0), ("throw", 3.0), ("walk", 0.5)], transition=0.6)
    assert [s.end - s.start for s in made.labels if s.kind == "transition"] == [12, 5]


def test_the_studio_asks_in_frames(engine: MultiActEngine) -> None:
    assert len(engine.transition([("walk", 30), ("throw", 25)], seed=1)) == 55
    many = engine.generate_many("throw", 3, 45, seed=7)
    assert [len(m) for m in many] == [45] * 3
    assert np.abs(many[0].rotations - many[1].rotations).max() > 1e-3
    np.testing.assert_array_equal(many[0].rotations, engine.generate("throw", 45, 7).rotations)
    start = movement(50)
    ways = engine.outpaint(start, "walk", keep=20, frames=60, count=2, seed=1)
    assert [len(way) for way in ways] == [60, 60]
    np.testing.assert_allclose(ways[1].positions[:20], start.positions[:20], atol=1e-9)
    assert ways[0].provenance.parameters["keep"] == 20


class Standing:
    """A cell that stands still: what a great many blocks ask of the engine alone."""

    names, usual, sees, longest = ("bow", "throw"), ((10, 20, 30),) * 2, 2, 100

    def advance(self, previous: Motion, action: int, frames: int, transition: int | None, rng) -> tuple[Motion, int]:
        return previous[-1:].concat(*[previous[-1:]] * (frames - 1)), 1


def test_a_thousand_blocks() -> None:
    told: list[tuple[int, int]] = []
    engine = MultiActEngine(Standing(), "0" * 64, begun)
    made = engine.sequence([("bow", 0.3), ("throw", 0.2)] * 500, progress=lambda *now: told.append(now))
    assert len(made) == 5000 and told[-1] == (1000, 1000) and len(told) == 1000
    assert len([s for s in made.labels if s.kind == "transition"]) == 999


@pytest.mark.parametrize(
    ("blocks", "error", "said"),
    [
        ([], OutOfRangeError, "one or more actions"),
        ([("wlak", 2.0)], UnknownLabelError, "'walk'"),
        ([""], UnknownLabelError, "did you mean"),
        ([("walk", 0.0)], OutOfRangeError, "block 1, 'walk'.*0.1 to 600"),
        (["walk", ("throw", -2)], OutOfRangeError, "block 2"),
        ([("walk", float("nan"))], OutOfRangeError, "nan"),
        ([("walk", "long")], MotionloomError, "block 1 lasts 'long'"),
        ([("walk", True)], MotionloomError, "a number"),
        ([3], MotionloomError, "block 1 is 3"),
        ([("walk", 600.0)] * 20, OutOfRangeError, "iter_frames"),
    ],
)
def test_bad_blocks_are_told(engine: MultiActEngine, blocks: list, error: type, said: str) -> None:
    with pytest.raises(error, match=said):
        engine.sequence(blocks)


def test_other_mistakes_are_told(engine: MultiActEngine, tmp_path) -> None:
    assert MAX_FRAMES < 20 * 600 * 20 and LONGEST >= CHUNK
    for transition in (0.0, 3.0, -1.0):
        with pytest.raises(OutOfRangeError, match="transition"):
            engine.sequence(["walk", "throw"], transition=transition)
    with pytest.raises(OutOfRangeError, match="seed"):
        engine.sequence(["walk"], seed=-1)
    with pytest.raises(Cancelled, match="nothing was kept"):
        engine.sequence(["walk", "throw"], cancel=lambda: True)
    with pytest.raises(UnknownLabelError, match="small"):
        load("large")
    with pytest.raises(MotionloomError, match="motionloom train multiact"):
        load(checkpoint=tmp_path / "none.safetensors")
