"""A sequence made: what is asked again after a change, seams, labels, memory."""

from __future__ import annotations

import json
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

import engines
from engines.errors import Cancelled, MotionloomError
from studio import sequencing, tasks
from studio.library.motions import Cache
from studio.sequence import Block, Sequence
from studio.settings import GenerateSettings
from tests.studio.fakes import ConstrainedEngine, FakeEngine, sway


@pytest.fixture(autouse=True)
def nothing_at_hand(monkeypatch):
    monkeypatch.setattr(sequencing, "at_hand", Cache())


def asked(*blocks: Block, **more) -> GenerateSettings:
    return GenerateSettings(**{"engine": "fake", "action": "", "count": 1, "sequence": Sequence(blocks), **more})


THREE = (Block("walk", seconds=2.0), Block("run", seconds=1.5, transition=0.5), Block("jump", transition=0.0))


def test_one_motion_under_the_labels_of_its_blocks(engine):
    (made,) = tasks.generate(asked(*THREE))
    assert len(made) == 40 + 10 + 30 + 60
    assert [(s.start, s.end, s.kind, s.value) for s in made.labels] == [
        (0, 40, "action", "walk"), (40, 50, "transition", "walk > run"), (50, 80, "action", "run"),
        (80, 140, "action", "jump"),
    ]  # fmt: skip
    assert made.provenance.source == "fake"
    np.testing.assert_allclose(made.positions[0, 0, [0, 2]], 0, atol=1e-9)
    steps = np.linalg.norm(np.diff(made.positions[:, 0], axis=0), axis=-1) * made.fps
    assert steps.max() < 2.2, "nobody jumps over the floor at a seam"
    turned = np.degrees(np.abs(np.diff(np.unwrap(made.heading))))
    assert turned.max() < 10


def test_blocks_are_as_a_take_of_them_alone_would_be(engine):
    (alone,) = tasks.generate(GenerateSettings(engine="fake", action="run", frames=30, seed=7, count=1))
    (made,) = tasks.generate(asked(*THREE))
    np.testing.assert_allclose(made[50:80].rotations[:, 1:], alone.rotations[:, 1:], atol=1e-9)


def test_only_what_a_change_touches_is_made_again(engine):
    tasks.generate(asked(*THREE))
    assert [call["action"] for call in engine.calls] == ["walk", "run", "jump"]
    tasks.generate(asked(*THREE))
    changed = Sequence(THREE).changed("2", seed=11)
    tasks.generate(asked(*changed.blocks))
    tasks.generate(asked(*changed.moved("3", 0).blocks))
    assert [(call["action"], call["seed"]) for call in engine.calls[3:]] == [("run", 11)]


def test_draws_differ_but_for_what_is_locked(engine, monkeypatch):
    blocks = Sequence(THREE).changed("2", locked=True).blocks
    tasks.generate(asked(*blocks, count=3))
    assert sorted({(call["action"], call["seed"]) for call in engine.calls}) == [
        ("jump", 7), ("jump", 8), ("jump", 9), ("run", 7), ("walk", 7), ("walk", 8), ("walk", 9),
    ]  # fmt: skip
    monkeypatch.setattr(sequencing, "at_hand", Cache())
    engine.calls.clear()
    (third,) = tasks.generate(asked(*blocks, count=3, take=3))
    assert {call["seed"] for call in engine.calls} == {7, 9}
    assert third.provenance.index == 2


def test_a_clip_is_shown_as_it_is_turned_to_where_the_sequence_goes(engine):
    clip = sway(frames=30, seed=5).moved((9.0, 0.0, 4.0), 2.0)
    (made,) = tasks.generate(asked(THREE[0], Block.of(clip, "take 9")))
    np.testing.assert_allclose(made[52:].rotations[:, 1:], clip.rotations[:, 1:], atol=2e-6)
    assert made.label_at(60) == "take 9"
    assert made.positions[-1, 0, 2] > made.positions[40, 0, 2] > 1.0, "on along +Z"


def test_what_no_engine_can_make_is_said_with_the_block(engine):
    with pytest.raises(MotionloomError, match="block 2: unknown action 'wlak'; did you mean 'walk'"):
        tasks.generate(asked(Block("walk"), Block("wlak")))
    with pytest.raises(MotionloomError, match="block 1: fake takes no prompt"):
        tasks.generate(asked(Block("somebody waves", "prompt")))
    assert not engine.calls, "nothing is made before all is known to be possible"


def test_the_command_line_makes_a_settings_file(engine, run, tmp_path):
    blocks = [{"what": "walk", "seconds": 1}, {"what": "run", "seconds": 1, "transition": 0.5}]
    (tmp_path / "scene.json").write_text(json.dumps({"generate": {"engine": "fake", "sequence": {"blocks": blocks}}}))
    code, _, said = run("generate", "--settings", "scene.json", "-n", "1", "-o", "scene.npz")
    assert (code, said) == (0, "")
    made = engines.read(tmp_path / "scene.npz")
    assert (len(made), [label.value for label in made.labels]) == (50, ["walk", "walk > run", "run"])


def test_progress_and_cancel(engine):
    told: list[tuple[int, int | None]] = []
    tasks.generate(asked(*THREE), lambda done, total: told.append((done, total)))
    assert [done for done, _ in told] == [1, 1, 2, 3]
    assert {total for _, total in told} == {3}
    with pytest.raises(Cancelled):
        tasks.generate(asked(*THREE), cancel=lambda: True)


def test_ten_minutes_stream_in_the_memory_of_one(engine, monkeypatch):
    monkeypatch.setattr(sequencing, "at_hand", Cache(2**20))

    def peak(blocks: int) -> int:
        engine.calls.clear()
        many = asked(*(Block("walk", seconds=5.4, seed=i) for i in range(blocks)))
        tracemalloc.start()
        frames = sum(len(part) for part in sequencing.pieces(many))
        size = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert frames == blocks * 108 + (blocks - 1) * 12
        return size

    peak(3)  # what is loaded once
    short, long = peak(10), peak(100)
    assert long < 1.2 * short + 200_000


@pytest.mark.parametrize("name", ["", "multiact"])
def test_a_block_in_two_is_the_same_motion(following, name):
    clip = Block.of(sway(frames=50), "take 9")
    whole = Sequence((*THREE, clip), name)
    (made,) = tasks.generate(replace(asked(), sequence=whole))
    halves = whole.split("2", 0.7).split("4", 1.3).split("1", 1.0)
    (again,) = tasks.generate(replace(asked(), sequence=halves))
    np.testing.assert_allclose(again.positions, made.positions, atol=1e-5)
    done = [(label.start, label.end, label.value) for label in again.labels if label.kind == "action"]
    assert done[:4] == [(0, 20, "walk"), (20, 40, "walk"), (50, 64, "run"), (64, 80, "run")]
    (rest,) = tasks.generate(replace(asked(), sequence=halves.removed("1")))
    np.testing.assert_allclose(rest[:20].rotations[:, 1:], made[20:40].rotations[:, 1:], atol=1e-9)


class Follower(FakeEngine):
    """Goes on: the body stands as it is where it starts and sinks a centimetre a frame, a little more by the seed."""

    longest_transition = 2.0
    capabilities = frozenset({"actions", "sequences"})

    def continue_from(self, motion, action, seconds=0.0, seed=0, transition=0.0):
        self.calls.append({"action": action, "frames": round(seconds * 20), "seed": seed, "gap": transition})
        frames = round(seconds * 20)
        down = np.array([0, -0.01 - 1e-4 * (seed - 7), 0]) * np.arange(1, frames + 1)[:, None]
        on = motion[-1:].replaced(
            rotations=motion.rotations[-1:].repeat(frames, 0), translation=motion.translation[-1:] + down
        )
        return motion.concat(on)


@pytest.fixture
def following(monkeypatch) -> FakeEngine:
    """`multiact` is a fake that goes on, and every other engine one that does not; they share their calls."""
    words, on = ConstrainedEngine(), Follower()
    words.capabilities = words.capabilities - {"constraints"}
    on.calls = words.calls
    monkeypatch.setattr(tasks, "load_engine", lambda name, _variant="": on if name == "multiact" else words)
    return words


def on(*blocks: Block, **more) -> GenerateSettings:
    return asked(**more, sequence=Sequence(blocks, "multiact"))


def test_actions_go_on_from_what_stands_before(following):
    (made,) = tasks.generate(on(*THREE))
    told = [(call["action"], call["frames"], call.get("gap")) for call in following.calls]
    assert told == [("walk", 40, None), ("run", 40, 0.5), ("jump", 60, 0.05)]
    assert [(s.start, s.end, s.kind, s.value) for s in made.labels] == [
        (0, 40, "action", "walk"), (40, 50, "transition", "walk > run"), (50, 80, "action", "run"),
        (80, 140, "action", "jump"),
    ]  # fmt: skip
    np.testing.assert_allclose(np.diff(made.translation[39:], axis=0), [[0, -0.01, 0]] * 100, atol=1e-9)
    assert np.ptp(made.rotations[39:], axis=0).max() < 1e-9
    assert made.provenance.source == "fake"


def test_a_change_makes_again_what_goes_on_from_it(following):
    four = Sequence((*THREE, Block("hop")), "multiact")
    tasks.generate(replace(asked(), sequence=four))
    following.calls.clear()
    tasks.generate(replace(asked(), sequence=four.changed("3", seed=11)))
    assert [call["action"] for call in following.calls] == ["jump", "hop"]
    following.calls.clear()
    tasks.generate(replace(asked(), sequence=four.changed("3", seed=11)))
    assert not following.calls
    ids = [
        sequencing.depends(replace(asked(), sequence=s))
        for s in (four, four.changed("3", seed=11), four.split("2", 1.0))
    ]
    assert [a == b for a, b in zip(ids[0], ids[1], strict=True)] == [True, True, False, False]
    assert ids[2] == [*ids[0][:2], ids[0][1], *ids[0][2:]]


def test_words_styles_and_clips_stay_with_the_usual_engine(following):
    clip = Block.of(sway(frames=30), "take 9")
    (made,) = tasks.generate(
        on(
            Block("walk"),
            Block("somebody waves", "prompt"),
            Block("run", style="old"),
            clip,
            Block("hop"),
            guidance=5.0,
        )
    )
    assert [(call["action"], "gap" in call) for call in following.calls] == [
        ("walk", False), (None, False), ("run", False), ("hop", True),
    ]  # fmt: skip
    assert [call.get("guidance") for call in following.calls] == [None, 5.0, 5.0, None]
    assert len(made) == 60 + 12 + 60 + 12 + 60 + 12 + 30 + 12 + 60
    with pytest.raises(MotionloomError, match=r"block 2: transition is 3.0; accepted: 0 to 2 seconds into an action"):
        tasks.generate(on(Block("walk"), Block("run", transition=3.0)))


def test_the_command_line_says_who_makes_the_actions(following, run, tmp_path, monkeypatch):
    blocks = [{"what": "walk", "seconds": 1}, {"what": "run", "seconds": 1}]
    sequence = {"sequence": {"engine": "multiact", "blocks": blocks}}
    (tmp_path / "scene.json").write_text(json.dumps({"generate": {"engine": "fake", **sequence}}))

    def went_on(*options: str) -> list[bool]:
        following.calls.clear()
        monkeypatch.setattr(sequencing, "at_hand", Cache())
        code, _, said = run("generate", "--settings", "scene.json", "-n", "1", "-o", "scene.npz", *options)
        assert (code, said) == (0, "")
        return ["gap" in call for call in following.calls]

    assert went_on() == [False, True]
    assert went_on("--engine", "fake") == [False, False]
    assert went_on("--engine", "multiact") == [False, True]


def test_multiact_makes_a_scene_without_a_jump_or_a_turn():
    names = ("walk", "wave right hand", "walk", "bow", "run", "squat")
    (made,) = sequencing.make(on(*(Block(name, seconds=2.0) for name in names)))
    assert len(made) == 6 * 40 + 5 * 12
    assert made.provenance.source == "multiact"
    steps = np.linalg.norm(np.diff(made.positions, axis=0), axis=-1)
    seams = [label.start for label in made.labels if label.kind == "transition"]
    assert max(steps[seam - 2 : seam + 14].max() for seam in seams) < 0.3, "6 m/s, a hand that waves"
    turned = np.degrees(np.abs(np.diff(np.unwrap(made.heading))))
    assert turned.max() < 12


class Between(FakeEngine):
    """Makes what lies between: a body that stands still where it is asked to begin."""

    capabilities = FakeEngine.capabilities | {"constraints"}

    def generate_many(self, action, count=4, frames=60, seed=0, progress=None, cancel=None, **extra):  # noqa: PLR0917
        pinned = extra.get("constraints")
        if pinned is None:
            return super().generate_many(action, count, frames, seed, progress, cancel, **extra)
        self.calls.append(
            {"action": action, "frames": frames, "kept": [(keep.at, len(keep.motion)) for keep in pinned.kept]}
        )
        start = pinned.kept[0].motion
        return [
            start.replaced(
                rotations=start.rotations[:1].repeat(frames, 0), translation=start.translation[:1].repeat(frames, 0)
            )
        ]


def test_a_transition_is_asked_of_an_engine_that_is_told_both_ends(monkeypatch):
    fake = Between()
    monkeypatch.setattr(tasks, "load_engine", lambda _name, _variant="": fake)
    (made,) = tasks.generate(asked(*THREE[:2]))
    assert fake.calls[-1] == {"action": None, "frames": 50, "kept": [(0, 20), (30, 20)]}
    pose, ends = made.rotations, (39, 49)
    for a in ends:  # what the engine made of it does not begin or end where the blocks do; the seams are closed
        assert np.abs(pose[a + 1] - pose[a]).max() < 0.2
    tasks.generate(asked(*THREE[:2]))
    assert len(fake.calls) == 3, "the transition is kept as well"
