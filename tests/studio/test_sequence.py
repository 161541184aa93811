"""Blocks of a sequence: what is accepted, what becomes of them, how they are written."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from engines.errors import MotionloomError, OutOfRangeError
from studio.sequence import EMPTY, MOST_BLOCKS, Block, Sequence
from studio.settings import GenerateSettings, Settings, parse_settings
from tests.studio.fakes import sway


@pytest.fixture
def three() -> Sequence:
    return Sequence((Block("walk"), Block("Bow  ", seconds=2.0), Block("a person Waves", "prompt", transition=1.0)))


def names(sequence: Sequence) -> list[str]:
    return [block.what for block in sequence.blocks]


def test_blocks_have_ids_of_their_own_and_a_length(three):
    assert [block.id for block in three.blocks] == ["1", "2", "3"]
    assert names(three) == ["walk", "bow", "a person Waves"], "actions are written small"
    assert three.seconds == pytest.approx(3 + 0.6 + 2 + 1 + 3)
    assert three.frames(20) == 60 + 12 + 40 + 20 + 60
    assert three.subject == "walk, then bow, then a person Waves"
    assert not EMPTY
    assert EMPTY.seconds == 0


def test_insert_move_duplicate_remove(three):
    four = three.inserted(Block("run"), 1)
    assert names(four) == ["walk", "run", "bow", "a person Waves"]
    assert four.block("4").what == "run"
    assert names(four.moved("4", 3)) == [*names(three), "run"]
    assert names(four.moved("4", 99)) == [*names(three), "run"]
    assert four.removed("4") == three
    twice = three.duplicated("2")
    assert names(twice) == ["walk", "bow", "bow", "a person Waves"]
    assert len({block.id for block in twice.blocks}) == 4


def test_change_and_split_keep_the_length(three):
    assert three.changed("1", seconds=1.5, style="proud").blocks[0].seconds == 1.5
    halves = three.split("1", 1.26)
    assert halves.seconds == pytest.approx(three.seconds)
    assert [(b.begins, b.seconds, b.whole) for b in halves.blocks[:2]] == [(0, 1.25, 3), (1.25, 1.75, 3)], (
        "to the frame"
    )
    with pytest.raises(OutOfRangeError, match="into the block"):
        three.split("1", 3.0)


def test_parts_stay_one_draw_until_one_becomes_another(three):
    halves = three.split("1", 1.0).split("4", 1.0)
    assert [block.id for block in halves.blocks] == ["1", "4", "5", "2", "3"]

    def together(sequence: Sequence) -> list[bool]:
        return [b.continues(a) for a, b in pairwise(sequence.blocks)]

    assert together(halves) == [True, True, False, False]
    assert together(halves.reseeded(lambda block: int(block.id))) == [True, True, False, False]
    assert halves.reseeded(lambda block: int(block.id)).blocks[2].seed == 1
    assert together(halves.changed("4", transition=0.3)) == [False, True, False, False]
    assert together(halves.changed("4", seconds=0.5)) == [True, False, False, False]
    other = halves.changed("5", what="run")
    assert together(other) == [True, False, False, False]
    assert (other.blocks[2].begins, other.blocks[2].whole, other.blocks[2].transition) == (0, 0, 0.6)
    longer = halves.changed("5", seconds=1.5).blocks[2]
    assert (longer.begins, longer.whole) == (2, 3.5), "past the end of its draw, it is of a longer one"


def test_a_locked_block_stays_as_it_is(three):
    held = three.changed("2", locked=True)
    for change in (
        lambda: held.changed("2", seconds=1.0), lambda: held.split("2", 1.0), lambda: held.removed("2"),
    ):  # fmt: skip
        with pytest.raises(MotionloomError, match=r"block 2 \(bow\) is locked; unlock it first"):
            change()
    assert held.changed("2", transition=0.2).blocks[1].transition == 0.2
    assert [block.seed for block in held.reseeded(lambda _: 3).blocks] == [3, 7, 3]
    assert held.changed("2", locked=False) == three


def test_a_clip_is_cut_and_never_longer_than_it_is():
    motion = sway(frames=50).moved((30.0, 0.0, 20.0), 1.0)
    clip = Block.of(motion, "take 2")
    assert (clip.kind, clip.seconds, clip.frames(20)) == ("clip", 2.5, 50)
    one = Sequence((clip,))
    assert one.changed("1", seconds=1.0).seconds == 1.0
    assert one.changed("1", seconds=9.0).seconds == 2.5
    a, b = one.split("1", 1.0).blocks
    assert (a.seconds, b.seconds, b.transition) == (1.0, 1.5, 0.0)
    assert a.clip is not None
    assert b.clip is not None
    whole = np.concatenate([a.clip.motion.rotations, b.clip.motion.rotations])
    np.testing.assert_allclose(whole, motion.face_front().rotations, atol=2e-6)
    with pytest.raises(OutOfRangeError, match="up to 30 s in a clip"):
        Block.of(sway(frames=700), "take 3")


def test_the_settings_file_holds_it(three):
    sequence = three.inserted(Block.of(sway(frames=20), "take 1")).changed("2", locked=True, engine="loom")
    text = Settings(GenerateSettings(engine="loom", action="", sequence=sequence)).to_json()
    assert parse_settings(text).generate.sequence == sequence
    assert json.loads(text)["generate"]["sequence"]["blocks"][0] == {"what": "walk", "id": "1"}
    named = Settings(GenerateSettings(sequence=replace(three.split("1", 1.0), engine="multiact"))).to_json()
    assert parse_settings(named).generate.sequence == replace(three.split("1", 1.0), engine="multiact")
    with pytest.raises(MotionloomError, match="engine of sequence is 3; accepted: a name"):
        parse_settings('{"generate": {"sequence": {"blocks": [{"what": "walk"}], "engine": 3}}}')
    plain = parse_settings('{"generate": {"sequence": {"blocks": [{"what": "walk"}, {"what": "run"}]}}}').generate
    assert [block.id for block in plain.sequence.blocks] == ["1", "2"]
    assert plain.subject == "walk, then run"


@pytest.mark.parametrize(
    ("blocks", "said"),
    [
        ([{"what": "walk", "seconds": 0}], r"block 1: seconds is 0; accepted: 0\.2 to 600"),
        ([{"what": "walk"}, {"what": "walk", "seconds": -1}], "block 2: seconds is -1"),
        ([{"what": "walk", "transition": -0.5}], "block 1: transition is -0.5; accepted: 0 to 5 seconds"),
        ([{"what": "walk", "seed": 1.5}], "seed of block 1 is 1.5"),
        ([{"what": "walk", "seed": True}], "seed of block 1 is True"),
        ([{"what": "walk", "kind": "promt"}], "unknown kind of block 'promt'; did you mean 'prompt'"),
        ([{"what": " "}], "what a block shows"),
        ([{"seconds": 2}], "what block 1 shows"),
        ([{"what": "walk", "secs": 2}], "unknown key of block 1 'secs'; did you mean 'seconds'"),
        ([{"what": "take 2", "kind": "clip"}], "and no other, holds a clip"),
        ([{"what": "walk"}] * 1000, f"number of blocks is 1000; accepted: 1 to {MOST_BLOCKS}"),
        ([], f"number of blocks is 0; accepted: 1 to {MOST_BLOCKS}"),
        ([{"what": "walk", "seconds": 400}] * 2, r"length of the sequence is '800\.6 s'; accepted: up to 600 s"),
        ("walk", "a list of"),
        (
            [{"what": "walk", "seconds": 2, "begins": 1.5, "whole": 3}],
            "block 1: begins is 1.5; accepted: 0 to 1: a part",
        ),
        ([{"what": "walk", "whole": 700}], "block 1: whole is 700; accepted: 0 to 600 seconds"),
    ],
)
def test_what_is_wrong_is_said_with_its_place(blocks, said):
    with pytest.raises(MotionloomError, match=said):
        parse_settings(json.dumps({"generate": {"sequence": {"blocks": blocks}}}))


def test_a_sequence_goes_with_nothing_that_says_the_same(three):
    with pytest.raises(MotionloomError, match="do not go with it"):
        GenerateSettings(sequence=three, then=(("run", 20),))
    with pytest.raises(MotionloomError, match="unknown block '9'"):
        three.moved("9", 0)
