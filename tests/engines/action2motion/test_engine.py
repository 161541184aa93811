"""What a person can ask of the engine, on random weights; the last tests on the weights that ship."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
import torch

import engines
from engines.action2motion.config import DECODERS
from engines.action2motion.engine import MAX_FRAMES, WEIGHTS, Action2MotionEngine, load
from engines.action2motion.train import export, fit
from engines.errors import Cancelled, CheckpointError, MotionloomError, OutOfRangeError, UnknownLabelError
from engines.geometry import rotations
from engines.motion import Motion
from engines.skeletons import SMPL22
from tests.engines.action2motion import tiny

every_decoder = pytest.mark.parametrize("decoder", DECODERS)


@pytest.fixture(scope="module")
def engine() -> Action2MotionEngine:
    return tiny.engine()


@pytest.fixture(scope="module")
def shipped() -> Action2MotionEngine:
    assert (WEIGHTS / "action2motion-glmi-m.safetensors").is_file(), "the weights ship with the package"
    return load()


def assert_same(one: Motion, other: Motion) -> None:
    np.testing.assert_array_equal(one.rotations, other.rotations)
    np.testing.assert_array_equal(one.translation, other.translation)


def assert_close(one: Motion, other: Motion, atol: float = 1e-3) -> None:
    """Within rounding: batches of different sizes multiply in different orders, and a loop carries that on."""
    np.testing.assert_allclose(one.positions, other.positions, atol=atol)


# ---- generate -------------------------------------------------------------------------------------------------


@every_decoder
def test_the_same_seed_gives_the_same_bits(decoder: str) -> None:
    made = tiny.engine(decoder)
    one, same, other = (made.generate_many("walk", count=3, frames=25, seed=seed) for seed in (8, 8, 9))
    for a, b, c in zip(one, same, other, strict=True):
        assert_same(a, b)
        assert not np.allclose(a.rotations, c.rotations)
        assert (a.skeleton, a.fps, len(a)) == (SMPL22, 20.0, 25)
    assert not np.allclose(one[0].rotations, one[1].rotations)


@every_decoder
def test_a_motion_does_not_depend_on_the_count(decoder: str) -> None:
    made = tiny.engine(decoder)
    many = made.generate_many("throw", count=4, frames=21, seed=3)
    assert_close(made.generate("throw", frames=21, seed=3), many[0])
    assert_close(made.generate_many("throw", count=2, frames=21, seed=3)[1], many[1])
    streams = made._noise(3, range(4), 9)
    assert torch.equal(made._noise(3, [2], 9)[:, 0], streams[:, 2])


@pytest.mark.parametrize("frames", [1, 2, 3, 4, 59, 60, 61, 257])
@pytest.mark.parametrize("fps", [10.0, 20.0])
def test_any_length(frames: int, fps: float) -> None:
    motion = tiny.engine(fps=fps).generate("turn left", frames=frames)
    assert len(motion) == frames
    np.testing.assert_allclose(motion.translation[0, [0, 2]], 0, atol=1e-9)
    assert [(s.start, s.end, s.value) for s in motion.labels] == [(0, frames, "turn left")]


def test_long_motions_are_made_few_at_a_time(engine, monkeypatch) -> None:
    """Memory is bounded: many long motions never run in one batch."""
    rows: list[int] = []
    sample = engine.model.sample

    def watched(conditions, noise, given=None):
        rows.append(noise.shape[0] * noise.shape[1])
        return sample(conditions, noise, given)

    monkeypatch.setattr(engine.model, "sample", watched)
    motions = engine.generate_many("walk", count=14, frames=3000)
    assert [len(motion) for motion in motions] == [3000] * 14
    assert len(rows) == 2
    assert max(rows) <= 64 * 600
    rows.clear()
    engine.generate_many("walk", count=330, frames=10)
    assert len(rows) == 2


def test_labels_and_provenance_make_it_again(engine) -> None:
    made = engine.generate_many("  Walk ", count=2, frames=np.int64(12), seed=4, bone_scale={"left_knee": 1.2})[1]
    origin = made.provenance
    assert (origin.source, origin.weights, origin.prompt) == ("action2motion", "0" * 64, "walk")
    assert (origin.seed, origin.index) == (4, 1)
    told = json.loads(json.dumps(dict(origin.parameters)))
    assert told.pop("variant") == "glmi-m"
    assert_same(engine.generate_many(origin.prompt, count=2, seed=4, **told)[1], made)


def test_bone_scale_changes_bones_not_turns(engine) -> None:
    plain = engine.generate("walk", frames=15, seed=2)
    scaled = engine.generate("walk", frames=15, seed=2, bone_scale={"left_knee": 1.3, "*": 0.8})
    factors = np.full(22, 0.8)
    factors[SMPL22.index("left_knee")] = 1.3
    np.testing.assert_allclose(scaled.skeleton.bone_lengths, SMPL22.bone_lengths * factors)
    np.testing.assert_array_equal(scaled.rotations, plain.rotations)


def test_progress_and_cancel(engine) -> None:
    seen: list[tuple[int, int]] = []
    engine.generate_many("walk", count=330, frames=4, progress=lambda *now: seen.append(now))
    assert seen == [(320, 330), (330, 330)]
    with pytest.raises(Cancelled, match="after 320 of 330"):
        answers = iter([False, True])
        engine.generate_many("walk", count=330, frames=4, cancel=lambda: next(answers))


def test_what_is_refused_and_what_is_near(engine) -> None:
    with pytest.raises(UnknownLabelError, match="did you mean 'turn left'"):
        engine.generate("turn lefft")
    for wrong in ({"frames": 0}, {"frames": MAX_FRAMES + 1}, {"frames": 2.5}, {"seed": -1}, {"frames": True}):
        with pytest.raises(OutOfRangeError, match="accepted"):
            engine.generate("walk", **wrong)
    for count in (0, 1025):
        with pytest.raises(OutOfRangeError, match="count"):
            engine.generate_many("walk", count=count)
    with pytest.raises(OutOfRangeError, match="segments"):
        engine.transition([])
    with pytest.raises(OutOfRangeError, match="frames"):
        engine.transition([("walk", MAX_FRAMES), ("throw", 1)])
    with pytest.raises(OutOfRangeError, match="steps"):
        engine.interpolate("walk", engine.latents("walk", 0, 9), engine.latents("walk", 1, 9), steps=1)
    with pytest.raises(OutOfRangeError, match="second latents"):
        engine.interpolate("walk", engine.latents("walk", 0, 9), engine.latents("walk", 1, 19))


# ---- interpolate ----------------------------------------------------------------------------------------------


@every_decoder
@pytest.mark.parametrize(("action", "frames"), [("walk", 1), ("walk", 24), ("throw", 100)])
@pytest.mark.parametrize("whole", [True, False])
def test_the_ends_of_an_interpolation_are_the_draws(decoder: str, action: str, frames: int, whole: bool) -> None:
    made = tiny.engine(decoder)
    a, b = made.latents(action, 1, frames), made.latents(action, 2, frames)
    between = made.interpolate(action, a, b, steps=3, whole=whole)
    assert len(between) == 3
    assert_close(between[0], made.generate(action, frames=frames, seed=1))
    if whole:
        assert_close(between[-1], made.generate(action, frames=frames, seed=2))


@every_decoder
def test_each_motion_of_a_draw_has_latents_of_its_own(decoder: str) -> None:
    made = tiny.engine(decoder)
    draw = made.generate_many("walk", count=3, frames=24, seed=5)
    a, b = (made.latents("walk", 5, 24, index) for index in (2, 1))
    between = made.interpolate("walk", a, b, steps=2)
    assert_close(between[0], draw[2])
    assert_close(between[1], draw[1])
    with pytest.raises(OutOfRangeError):
        made.latents("walk", 5, 24, -1)


# ---- done again -----------------------------------------------------------------------------------------------


@every_decoder
def test_an_action_is_done_again_from_the_pose_it_ended_in(decoder: str) -> None:
    """The second performance is an own sample of the model, given the last pose of the first."""
    made = tiny.engine(decoder)
    plan = made._plan([(made._label("throw"), 100)])
    first, *others = plan.performances
    assert others and first.start == 0 and others[-1].stop == plan.steps
    conditions, noise = made._conditions(plan, 2), made._noise(3, range(2), plan.steps)
    hidden, latents = made._sample(plan, noise)
    assert latents.shape == noise.shape
    alone, _ = made.model.sample(conditions[: first.stop], noise[: first.stop])
    torch.testing.assert_close(hidden[: first.stop], alone)
    second = others[0]
    rows = [second.start, *second]
    again, _ = made.model.sample(conditions[rows], noise[rows], made.model.head(alone[-1:]))
    torch.testing.assert_close(hidden[second.start : second.stop], again[1:])
    assert float(conditions[second.start, 0, -1]) == 0.0


def test_what_goes_on_is_one_performance(engine) -> None:
    assert len(engine._plan([(engine._label("walk"), 2000)]).performances) == 1
    both = engine._plan([(engine._label("throw"), 20), (engine._label("wave left hand"), 20)])
    assert len(both.performances) == 1, "memory goes on from one action to another"


def test_the_middle_lies_between(engine) -> None:
    a, b = engine.latents("walk", 1, 20), engine.latents("walk", 2, 20)
    first, middle, last = (m.positions for m in engine.interpolate("walk", a, b, steps=3))
    whole = np.abs(first - last).mean()
    assert 0 < np.abs(first - middle).mean() < whole
    assert 0 < np.abs(last - middle).mean() < whole


def test_only_the_first_pose_is_walked_between(engine) -> None:
    a, b = engine.latents("walk", 1, 20), engine.latents("walk", 2, 20)
    made = engine.interpolate("walk", a, b, steps=3, whole=False)
    assert_close(made[0], engine.generate("walk", frames=20, seed=1))
    assert np.abs(made[0].rotations[0] - made[2].rotations[0]).max() > 1e-4
    assert len(engine.interpolate("walk", engine.latents("walk", 1, 1), engine.latents("walk", 2, 1), 2, False)) == 2


# ---- transition -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("fps", [10.0, 20.0])
def test_a_transition_switches_its_label_at_the_boundary(fps: float) -> None:
    made = tiny.engine(fps=fps)
    parts = [("walk", 20), ("wave left hand", 31), ("throw", 9)]
    motion = made.transition(parts, seed=6)
    assert len(motion) == 60
    assert [(s.start, s.end, s.value) for s in motion.labels] == [
        (0, 20, "walk"), (20, 51, "wave left hand"), (51, 60, "throw"),
    ]  # fmt: skip
    plan = made._plan([(made._label(name), frames) for name, frames in parts])
    names = [made.config.actions[i] for i in plan.labels]
    ratio = 20.0 / fps
    for step, name in enumerate(names):
        # the networks hear the label of the frame that they make, to half one of their frames
        near = {motion.label_at(min(59, max(0, round(step * ratio + shift)))) for shift in (-ratio / 2, 0, ratio / 2)}
        assert name in near
    starts = [i for i in range(1, len(names)) if names[i] != names[i - 1]]
    assert len(starts) == 2
    assert all(plan.progress[i] == 0 for i in starts), "each action begins at its beginning"


def test_a_transition_begins_as_its_first_action_does(engine) -> None:
    """The memory goes on and nothing of what comes is known before the switch."""
    alone = engine.generate("walk", frames=200, seed=6)
    parts = engine.transition([("walk", 200), ("throw", 40)], seed=6)
    # the spline through the model's frames hears the switch a few frames ahead
    assert_close(parts[:180], alone[:180])
    assert np.abs(parts.positions[-1] - alone.positions[-1]).max() > 1e-3
    assert_same(engine.transition([("walk", 30)], seed=2), engine.generate("walk", frames=30, seed=2))


# ---- outpaint -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("decoder", ["lie", "glmi-m", "glmi-r"])
@pytest.mark.parametrize(("keep", "frames"), [(1, 2), (1, 30), (2, 31), (20, 60), (21, 60), (40, 41)])
def test_outpainting_keeps_the_start_exactly(decoder: str, keep: int, frames: int) -> None:
    made, start = tiny.engine(decoder), tiny.movement(40, seed=3)
    results = made.outpaint(start, "throw", keep=keep, frames=frames, count=2, seed=5)
    for index, motion in enumerate(results):
        assert len(motion) == frames
        assert_same(motion[:keep], start[:keep])
        assert [(s.start, s.end, s.value) for s in motion.labels] == [(0, keep, "given"), (keep, frames, "throw")]
        assert (motion.provenance.index, motion.provenance.seed) == (index, 5)
    assert not np.allclose(results[0].rotations[keep:], results[1].rotations[keep:])
    again = made.outpaint(start, "throw", keep=keep, frames=frames, count=2, seed=5)
    assert_same(results[1], again[1])


def test_outpainting_takes_any_skeleton_and_rate(engine) -> None:
    other = engine.generate("walk", frames=50).resample(30.0).scale_bones({"*": 1.1})
    motion = engine.outpaint(other, "throw", keep=10, frames=30, count=1)[0]
    assert (motion.skeleton, motion.fps, len(motion)) == (SMPL22, 20.0, 30)
    with pytest.raises(OutOfRangeError, match="keep"):
        engine.outpaint(other, "throw", keep=99)
    with pytest.raises(OutOfRangeError, match="frames"):
        engine.outpaint(other, "throw", keep=10, frames=10)
    with pytest.raises(MotionloomError, match="glmi-m"):
        tiny.engine("plain").outpaint(other, "throw")


# ---- files ----------------------------------------------------------------------------------------------------


def test_trained_weights_load_and_generate(tmp_path: Path) -> None:
    """Trained, exported, loaded: one run in two parts ends where one in one part does."""
    settings = tiny.config(steps=4)
    whole = fit(settings, tmp_path / "whole", tiny.clips(1))

    answers = iter([False, True])
    with pytest.raises(Cancelled, match="after step 2"):
        fit(settings, tmp_path / "parts", tiny.clips(1), cancel=lambda: next(answers))
    parts = fit(settings, tmp_path / "parts", tiny.clips(1))
    assert (whole.step, parts.step) == (4, 4)
    for name, value in whole.averaged.items():
        assert torch.equal(value, parts.averaged[name]), name
    digest = export(whole, tmp_path / "mine.safetensors")
    made = engines.load("action2motion", checkpoint=tmp_path / "mine.safetensors")
    assert made.weights_hash == digest
    assert made.config.actions == tiny.ACTIONS
    assert_same(made.generate("walk", frames=9, seed=1), made.generate("walk", frames=9, seed=1))


def test_files_that_do_not_fit_are_refused(tmp_path: Path) -> None:
    with pytest.raises(UnknownLabelError, match="glmi-m"):
        load("glmi")
    with pytest.raises(CheckpointError, match=r"none\.safetensors"):
        load(checkpoint=tmp_path / "none.safetensors")
    path = tmp_path / "a.safetensors"
    path.write_bytes(b"not weights")
    path.with_suffix(".json").write_text(tiny.config().to_json())
    with pytest.raises(CheckpointError, match=r"a\.safetensors"):
        load(checkpoint=path)


# ---- the weights that ship --------------------------------------------------------------------------------------


def test_shipped_weights_fit_their_settings(shipped, tmp_path: Path) -> None:
    assert shipped.variant == "glmi-m"
    assert len(shipped.actions) == len(shipped.config.nominal_frames) >= 50
    assert "walk" in {action.name for action in shipped.actions}
    shutil.copy(WEIGHTS / "action2motion-glmi-m.safetensors", tmp_path / "copy.safetensors")
    shutil.copy(WEIGHTS / "action2motion-glmi-m.json", tmp_path / "copy.json")
    copy = engines.load("action2motion", checkpoint=tmp_path / "copy.safetensors")
    assert_same(copy.generate("walk", seed=3), shipped.generate("walk", seed=3))


def test_shipped_weights_move_like_a_body(shipped) -> None:
    for action in ("walk", "throw", "wave right hand"):
        motion = shipped.generate(action, frames=60, seed=1)
        height = motion.positions[:, SMPL22.index("head"), 1]
        assert (height > 0.8).all(), action
        speed = np.linalg.norm(np.diff(motion.positions, axis=0), axis=-1) * 20
        assert speed.max() < 20, action
        assert rotations.angle(motion.rotations).max() <= np.pi
    way = [np.linalg.norm(m.translation[-1, [0, 2]]) for m in shipped.generate_many("walk", count=4, frames=80)]
    assert np.median(way) > 1.0, "a walk of four seconds leads somewhere"
    turn = shipped.generate_many("turn left", count=4, frames=80)
    assert np.median([m.heading[-1] - m.heading[0] for m in turn]) > 0.3, "left is towards +X"


@pytest.mark.parametrize("keep", [10, 19, 20, 33])
def test_shipped_weights_go_on_without_a_jump(shipped, keep: int) -> None:
    start = shipped.generate("walk", frames=60, seed=1)
    own = np.linalg.norm(np.diff(start.positions, axis=0), axis=-1).max()
    for motion in shipped.outpaint(start, "walk", keep=keep, frames=80, count=3, seed=2):
        assert_same(motion[:keep], start[:keep])
        step = np.linalg.norm(np.diff(motion.positions[keep - 1 : keep + 2], axis=0), axis=-1)
        assert step.max() < 2 * own
        assert np.abs(np.diff(motion.heading[keep - 1 : keep + 2])).max() < 0.5
