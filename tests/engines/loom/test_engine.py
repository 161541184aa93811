"""Loom as people ask it, on random weights: what is promised holds whatever the network has learned."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from engines.errors import Cancelled, MotionloomError, OutOfRangeError, UnknownLabelError
from engines.loom import output
from engines.loom.constraints import Constraints, Keep, Path, Pin
from engines.loom.engine import LoomEngine
from engines.loom.passes import LOOP
from engines.loom.plan import natural_length
from engines.loom.reach import Reach
from engines.loom.representation import KNOWN, LAYOUT, kinematics
from engines.motion import Motion
from engines.skeletons import SMPL22
from engines.text import reader
from tests.engines.action2motion.tiny import movement
from tests.engines.loom.tiny import engine as tiny_engine
from tests.engines.loom.tiny import model as tiny_model


@pytest.fixture(scope="module")
def engine() -> LoomEngine:
    return tiny_engine()


def same(a: Motion, b: Motion, atol: float = 1e-4) -> bool:
    return a.rotations.shape == b.rotations.shape and bool(np.abs(a.positions - b.positions).max() < atol)


@pytest.mark.parametrize("frames", [1, 2, 7, 60, 200, 201, 450])
def test_any_length(engine: LoomEngine, frames: int) -> None:
    motion = engine.generate("walk", frames=frames, seed=2)
    assert len(motion) == frames
    assert motion.label_at(frames - 1) == "walk"
    assert np.isfinite(motion.positions).all()


def test_the_same_seed_gives_the_same_motions_however_many(engine: LoomEngine) -> None:
    few, many = engine.generate_many("throw", 2, 40, seed=5), engine.generate_many("throw", 3, 40, seed=5)
    assert all(same(a, b) for a, b in zip(few, many, strict=False))
    assert not same(many[0], many[1], 1e-2)
    assert not same(many[0], engine.generate("throw", 40, seed=6), 1e-2)
    again = engine.generate_many("throw", 2, 40, seed=5)
    assert all(np.array_equal(a.rotations, b.rotations) for a, b in zip(few, again, strict=True))


def test_all_that_is_told_changes_the_motion(engine: LoomEngine) -> None:
    plain = engine.generate("walk", 30, seed=1)
    for told in ({"style": "proud"}, {"prompt": "a person strolls"}, {"guidance": 5.0}, {"steps": 12}):
        assert not same(plain, engine.generate("walk", 30, seed=1, **told), 1e-6), told
    assert not same(plain, engine.generate("throw", 30, seed=1), 1e-6)
    only_words = engine.generate(prompt="Bake a cake.", frames=30)
    assert only_words.label_at(0, "text") == "Bake a cake." and only_words.label_at(0) is None


def test_actions_and_styles_are_read_out_of_prompts(engine: LoomEngine) -> None:
    prompt = "someone walks proudly"
    read = engine.generate(prompt=prompt, frames=30, seed=1)
    assert (read.label_at(0), read.label_at(0, "style"), read.label_at(0, "text")) == ("walk", "proud", prompt)
    assert same(read, engine.generate("walk", 30, seed=1, style="proud", prompt=prompt), 1e-6)
    told = engine.generate("throw", 30, seed=1, style="old", prompt=prompt)
    assert (told.label_at(0), told.label_at(0, "style")) == ("throw", "old"), "what is told goes before what is read"
    assert engine.understood(prompt) == "Understood as: walk, proud."
    assert "goes by the words alone" in engine.understood("bake a cake")
    assert engine.understood(" ") == ""


def test_a_prompt_may_ask_for_several_actions_in_turn(engine: LoomEngine) -> None:
    prompt = "a proud man walks ahead, then throws a ball."
    both = engine.generate(prompt=prompt, frames=90, seed=3)
    at = next(part.start for part in both.labels if part.kind == "action" and part.value == "throw")
    assert (len(both), both.label_at(0), both.label_at(at - 1), both.label_at(89)) == (90, "walk", "walk", "throw")
    assert both.label_at(0, "style") == both.label_at(89, "style") == "proud"
    assert (both.label_at(0, "text"), both.label_at(89, "text")) == ("a proud man walks ahead", "throws a ball")
    assert engine.understood(prompt) == "Understood as: walk, proud, then throw, proud."
    short = engine.generate(prompt=prompt, frames=20)
    assert short.label_at(0) == short.label_at(19), "too short for two"
    assert engine.generate("walk", prompt=prompt, frames=90).label_at(89) == "walk"
    assert len(reader.clauses("Walk; then run. After that, sit down and finally wave")) == 4
    assert reader.clauses("walks and waves") == ["walks and waves"]


def test_provenance_makes_it_again(engine: LoomEngine) -> None:
    made = engine.generate_many("walk", 3, 40, seed=4, style="old", guidance=1.5, bone_scale={"left_knee": 1.1})[2]
    told = dict(made.provenance.parameters)
    again = engine.generate_many(
        "walk", 3, told["frames"], made.provenance.seed or 0, style=told["style"], guidance=told["guidance"],
        bone_scale=told["bone_scale"],
    )[made.provenance.index]  # fmt: skip
    assert np.array_equal(made.positions, again.positions)


@pytest.mark.parametrize("keep", [1, 13, 30])
def test_going_on_keeps_what_was_there_to_the_last_bit(engine: LoomEngine, keep: int) -> None:
    before = movement(30)
    made = engine.outpaint(before, "walk", keep=keep, frames=90, count=2, seed=1)
    for motion in made:
        assert len(motion) == 90
        assert np.array_equal(motion.rotations[:keep], before.rotations[:keep])
        assert np.array_equal(motion.translation[:keep], before.translation[:keep])
        assert (motion.labels[0].end, motion.labels[1].value) == (keep, "walk")
    assert not same(made[0], made[1], 1e-2)


def test_transition_has_its_segments(engine: LoomEngine) -> None:
    motion = engine.transition([("walk", 50), ("throw", 30), ("turn left", 120)], seed=3)
    assert [(s.start, s.end, s.value) for s in motion.labels] == [
        (0, 50, "walk"), (50, 80, "throw"), (80, 200, "turn left"),
    ]  # fmt: skip


def test_an_action_done_once_is_done_again_when_asked_for_longer(engine: LoomEngine) -> None:
    from engines.loom.plan import AGAIN, WHOLE, windows

    passes = windows(engine.config, [("throw", 150)])
    assert sum(window.frames for window in passes) == 150 and len(passes) > 2
    assert [window.shown for window in passes] == [0] + [AGAIN] * (len(passes) - 1)
    assert {window.span for window in passes} == {WHOLE}


def test_how_long_is_found_where_nobody_says_it(engine: LoomEngine) -> None:
    usual = dict(zip(engine.config.actions, (middle for _, middle, _ in engine.config.usual_frames), strict=True))
    thrown = engine.generate(prompt="someone throws a ball", frames=None)
    assert len(thrown) == engine.expected_frames("throw") == usual["throw"]
    assert thrown.provenance.parameters["frames"] == usual["throw"]
    walked, both = engine.expected_frames("walk"), engine.expected_frames(prompt="a man walks, then throws a ball")
    assert both == walked + usual["throw"]
    assert len(engine.generate(None, frames=None, constraints=Constraints(loop=True))) == 80
    slow = engine.config.replaced(usual_frames=((300, 400, 500),) * len(usual))
    assert natural_length(slow, "throw") == slow.longest, "one window"
    assert natural_length(slow, "walk") == natural_length(slow, None) + 20 == 100, "goes on as long as one likes"
    with pytest.raises(UnknownLabelError):
        engine.generate_many("thrwo", frames=None)


def test_interpolation_ends_are_the_draws(engine: LoomEngine) -> None:
    a, b = engine.latents("walk", seed=1, frames=40), engine.latents("walk", seed=2, frames=40)
    made = engine.interpolate("walk", a, b, steps=4)
    assert same(made[0], engine.generate("walk", 40, seed=1)) and same(made[-1], engine.generate("walk", 40, seed=2))
    assert not same(made[1], made[2], 1e-3)


def test_kept_frames_and_key_poses_are_in_the_motion(engine: LoomEngine) -> None:
    first, key = movement(10), movement(1, seed=9)
    motion = engine.generate("walk", 60, constraints=Constraints(kept=(Keep(first), Keep(key, 40))))
    assert np.array_equal(motion.rotations[:10], first.rotations)
    np.testing.assert_allclose(motion.positions[40], key.positions[0], atol=1e-9)


def test_a_path_is_followed(engine: LoomEngine) -> None:
    points = np.array([[1.0, 1.0], [1.0, 3.0], [3.0, 3.0]])
    motion = engine.generate("walk", 80, constraints=Constraints(path=Path(points)))
    root = motion.positions[:, 0, [0, 2]]
    assert np.abs(root[[0, -1]] - points[[0, -1]]).max() < 0.02
    assert np.linalg.norm(root - points[1], axis=1).min() < 0.1
    assert "unmet" not in motion.provenance.parameters, motion.provenance


def test_a_pin_that_is_missed_is_said(engine: LoomEngine) -> None:
    motion = engine.generate("walk", 40, constraints=Constraints(pins=(Pin("left_wrist", 20, (9.0, 1.0, 9.0)),)))
    gap = np.linalg.norm(motion.positions[20, SMPL22.index("left_wrist")] - [9, 1, 9])
    assert f"The left wrist at frame 20 is {100 * gap:.0f} cm" in motion.provenance.parameters["unmet"][0]


def test_a_loop_closes(engine: LoomEngine) -> None:
    motion = engine.generate("walk", 60, constraints=Constraints(loop=True))
    place = motion.in_place().moved(yaw=0.0)
    turns = np.abs((place.rotations[0, 1:] * place.rotations[-1, 1:]).sum(-1))
    usual = np.abs((place.rotations[1:, 1:] * place.rotations[:-1, 1:]).sum(-1)).min(0)
    assert (turns > usual - 0.02).all()  # the seam is no larger a step than others
    with pytest.raises(OutOfRangeError, match=str(200 - LOOP)):
        engine.generate("walk", 190, constraints=Constraints(loop=True))


def test_parts_made_anew_leave_the_others(engine: LoomEngine) -> None:
    before = movement(40)
    made = engine.regenerate(before, ["left arm"], "walk", count=2, seed=1)
    legs = [SMPL22.index(f"left_{name}") for name in ("hip", "knee", "ankle")]
    for motion in made:
        np.testing.assert_allclose(np.abs((motion.rotations * before.rotations).sum(-1))[:, legs], 1, atol=1e-5)
        assert np.abs(motion.rotations[:, SMPL22.index("left_elbow")] - before.rotations[:, 18]).max() > 1e-3


def test_another_manner_begins_further_away_with_more_strength(monkeypatch: pytest.MonkeyPatch) -> None:
    engine, before = tiny_engine(), movement(48)
    # a network that takes whatever it sees for the motion: what comes out is what sampling began from
    monkeypatch.setattr(engine.model, "forward", lambda x, *_: x)
    weak, strong = (engine.stylise(before, "old", strength=s, keep_path=False, seed=1)[0] for s in (0.01, 0.5))

    def gap(motion: Motion) -> float:
        return float(np.abs(np.abs((motion.rotations * before.rotations).sum(-1)) - 1)[:, 1:].mean())

    assert gap(weak) < 1e-4 < gap(strong)
    assert len(weak) == 48 and weak.label_at(0, "style") == "old"


def test_the_best_of_several_is_one_of_them(engine: LoomEngine) -> None:
    from engines.metrics import physical

    drawn = engine.generate_many("walk", 6, 30, seed=3)
    kept = engine.generate_many("walk", 2, 30, seed=3, best_of=3)
    for i, motion in enumerate(kept):
        group = drawn[3 * i : 3 * i + 3]
        assert any(same(motion, other) for other in group)
        measures = ("foot_skate", "jitter", "ground_penetration")
        kept_one, *others = ([physical.summary(m)[name] for name in measures] for m in (motion, *group))
        assert not any(all(a < b for a, b in zip(other, kept_one, strict=True)) for other in others), "none is better"


def test_the_smooth_one_is_the_best() -> None:
    smooth, shaken = movement(30), movement(30)
    path = shaken.translation + 0.05 * np.random.default_rng(0).normal(size=(30, 3))
    shaken = shaken.replaced(translation=path)
    best = output.best([shaken, smooth, smooth, shaken], 2)
    assert [m is smooth for m in best] == [True, True]


@pytest.mark.parametrize(
    ("asked", "error", "said"),
    [
        ({"action": "wlak"}, UnknownLabelError, "walk"),
        ({"action": "walk", "style": "prowd"}, UnknownLabelError, "proud"),
        ({"action": "walk", "frames": 0}, OutOfRangeError, "1 to 12,000"),
        ({"action": "walk", "frames": 100_000}, OutOfRangeError, "12,000"),
        ({"action": "walk", "guidance": 11.0}, OutOfRangeError, "0 to 10"),
        ({"action": "walk", "seed": -1}, OutOfRangeError, "2\\^63"),
        ({"action": "walk", "best_of": 17}, OutOfRangeError, "1 to 16"),
        ({"prompt": "x" * 1001}, OutOfRangeError, "1,000 characters"),
        ({"action": "walk", "frames": 300, "constraints": Constraints(loop=True)}, OutOfRangeError, "pinned"),
    ],
)
def test_requests_out_of_range(engine: LoomEngine, asked: dict, error: type, said: str) -> None:
    with pytest.raises(error, match=said):
        engine.generate(**asked)


def test_cancel_and_progress(engine: LoomEngine) -> None:
    heard: list[tuple[int, int]] = []
    engine.generate_many("walk", 3, 20, progress=lambda done, total: heard.append((done, total)))
    assert heard == [(3, 3)]
    with pytest.raises(Cancelled):
        engine.generate_many("walk", 3, 20, cancel=lambda: True)


def test_nothing_left_to_keep_is_an_error(engine: LoomEngine) -> None:
    with pytest.raises(MotionloomError, match="left to keep"):
        engine.regenerate(movement(20), ["upper body", "lower body"])


def test_a_pinned_joint_that_can_be_reached_is(engine: LoomEngine) -> None:
    free = engine.generate("walk", 40, seed=1)
    wrist = SMPL22.index("left_wrist")
    towards = free.positions[20, SMPL22.index("head")] - free.positions[20, wrist]
    place = free.positions[20, wrist] + 0.15 * towards / np.linalg.norm(towards)
    pinned = engine.generate("walk", 40, seed=1, constraints=Constraints(pins=(Pin("left_wrist", 20, tuple(place)),)))
    assert np.linalg.norm(pinned.positions[20, wrist] - place) < 0.03
    assert np.linalg.norm(free.positions[20, wrist] - place) > 0.1
    step = np.linalg.norm(np.diff(pinned.positions[:, wrist], axis=0), axis=-1)
    usual = np.linalg.norm(np.diff(free.positions[:, wrist], axis=0), axis=-1)
    assert step.max() < usual.max() + 0.1  # no jump where it is pinned


def test_the_arm_reaches_before_the_back_bends() -> None:
    made, wrist = tiny_model(), SMPL22.index("left_wrist")
    x = torch.zeros(1, 40, LAYOUT.size)
    resting = made.mean[LAYOUT["turns"]].view(1, -1)
    place = kinematics(resting, made.mean[LAYOUT["height"]].view(1, 1))[0, wrist]
    known = torch.zeros(1, 40, KNOWN.size)
    KNOWN.read(known, "joints_known")[:, 20, wrist - 1] = 1.0
    KNOWN.read(known, "joints")[:, 20, wrist - 1] = place + torch.tensor([-0.1, 0.25, 0.25])
    change = (Reach(made, known, np.zeros((40, 2)))(x, 0.5) - x)[0, 20]
    moved = dict(zip(SMPL22.joints, LAYOUT.read(change, "turns").view(22, 6).norm(dim=-1).tolist(), strict=True))
    assert moved["left_shoulder"] > 0.1
    assert max(moved[name] for name in ("pelvis", "spine1", "spine2", "spine3")) < 0.3 * moved["left_shoulder"]


def test_a_pin_may_lie_where_an_action_is_usually_over(engine: LoomEngine) -> None:
    pins = (Pin("left_wrist", 150, (0.3, 1.0, 0.3)),)
    motion = engine.generate("throw", 160, constraints=Constraints(pins=pins))
    assert (len(motion), motion.label_at(159)) == (160, "throw")


def test_what_a_motion_goes_on_from_keeps_its_name(engine: LoomEngine) -> None:
    walk = engine.generate("walk", 40, seed=1)
    on = engine.generate("throw", 60, seed=2, constraints=Constraints(kept=(Keep(walk[:20]),)))
    assert [(part.start, part.end, part.value) for part in on.labels] == [(0, 20, "walk"), (20, 60, "throw")]
