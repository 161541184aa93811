"""The engine: what is asked comes back, the same for the same seed; captions; tokens; what is refused."""

from __future__ import annotations

import json

import numpy as np
import pytest

from engines.errors import Cancelled, CheckpointError, MotionloomError, OutOfRangeError, UnknownLabelError
from engines.skeletons import SMPL22
from engines.tm2t.engine import TM2TEngine, load
from tests.engines.tm2t.tiny import engine, movement

PROMPT = "A person does throw."


@pytest.fixture(scope="module")
def made() -> TM2TEngine:
    return engine()


def test_the_same_seed_gives_the_same_motions(made: TM2TEngine) -> None:
    seen: list[tuple[int, int]] = []
    many = made.generate_many(prompt=PROMPT, count=3, seed=5, progress=lambda *now: seen.append(now))
    again = made.generate_many(prompt=PROMPT, count=3, seed=5)
    assert seen == [(3, 3)]
    for index, (motion, same) in enumerate(zip(many, again, strict=True)):
        np.testing.assert_array_equal(motion.rotations, same.rotations)
        assert (motion.skeleton, motion.fps) == (SMPL22, made.fps)
        assert 20 <= len(motion) <= made.max_frames
        assert len(motion) % 4 == 0
        origin = motion.provenance
        assert (origin.source, origin.weights, origin.prompt) == ("tm2t", made.weights_hash, PROMPT)
        assert (origin.seed, origin.index) == (5, index)
        json.dumps(dict(origin.parameters))
        assert motion.label_at(0, "text") == PROMPT
    assert len({motion.rotations.tobytes() for motion in many}) == 3


def test_a_motion_does_not_depend_on_those_beside_it(made: TM2TEngine) -> None:
    many = made.generate_many(prompt=PROMPT, count=4, seed=1)
    one = made.generate(PROMPT, seed=1)
    np.testing.assert_array_equal(made.tokens(one), made.tokens(many[0]))
    assert len(one) == len(many[0])
    each = made.generate_each([PROMPT, "Someone does walk slowly, taking two steps.", PROMPT], seed=1)
    np.testing.assert_allclose(each[0].positions, one.positions, atol=1e-4)
    np.testing.assert_allclose(each[2].positions, one.positions, atol=1e-4)
    assert each[1].provenance.prompt != PROMPT


@pytest.mark.parametrize("frames", [1, 7, 24, 40])
def test_a_length_that_is_told_is_kept(made: TM2TEngine, frames: int) -> None:
    assert len(made.generate_many(prompt=PROMPT, count=1, frames=frames)[0]) == frames
    assert len(made.generate(PROMPT, seconds=frames / 20)) == frames


def test_an_action_is_a_sentence_too(made: TM2TEngine) -> None:
    assert made.generate_many("does throw", count=1)[0].provenance.prompt == "does throw"


def test_words_that_are_not_known_are_named(made: TM2TEngine) -> None:
    motion = made.generate("A persn dances merrily.")
    (said, *more) = motion.provenance.parameters["unmet"]
    assert "'persn'" in said
    assert "'person'" in said
    assert any("merrily" in one for one in more)
    assert "unmet" not in made.generate(PROMPT, frames=8).provenance.parameters


def test_bones_can_be_longer(made: TM2TEngine) -> None:
    longer = made.generate(PROMPT, bone_scale={"*": 1.2})
    np.testing.assert_allclose(longer.skeleton.bone_lengths, 1.2 * SMPL22.bone_lengths)


@pytest.mark.parametrize(("wrong", "says"), [
    ({"count": 0}, "count"), ({"count": 1025}, "count"), ({"frames": 0}, "frames"), ({"frames": 41}, "frames"),
    ({"seed": -1}, "seed"), ({"top_k": 0}, "top_k"), ({"temperature": 0.0}, "temperature"), ({"frames": 2.5}, "frames"),
])  # fmt: skip
def test_numbers_out_of_range_are_refused(made: TM2TEngine, wrong: dict, says: str) -> None:
    with pytest.raises(OutOfRangeError, match=says):
        made.generate_many(prompt=PROMPT, **wrong)


def test_what_else_is_refused(made: TM2TEngine) -> None:
    with pytest.raises(OutOfRangeError, match="seconds"):
        made.generate(PROMPT, seconds=11)
    with pytest.raises(MotionloomError, match="empty"):
        made.generate_many()
    with pytest.raises(Cancelled):
        made.generate_many(prompt=PROMPT, cancel=lambda: True)
    with pytest.raises(UnknownLabelError, match="variant"):
        load("large")
    with pytest.raises(CheckpointError, match="no such weights"):
        load(checkpoint="nowhere.safetensors")


def test_captions_are_sentences_the_likeliest_first(made: TM2TEngine) -> None:
    motion = movement(30)
    told = made.caption(motion, beams=2, count=3)
    assert 1 <= len(told) <= 3
    assert [one.score for one in told] == sorted((one.score for one in told), reverse=True)
    assert len({one.sentence for one in told}) == len(told)
    assert all(one.sentence[0] == one.sentence[0].upper() for one in told)
    assert made.caption(motion, beams=3, count=1) == told[:1]
    short, long = movement(2), movement(300, fps=60.0)
    many = made.caption_many([motion, short, long])
    assert [one.sentence for one in many[0]] == [one.sentence for one in told]
    np.testing.assert_allclose([one.score for one in many[0]], [one.score for one in told], atol=1e-4)
    for wrong in ({"beams": 0}, {"count": 17}):
        with pytest.raises(OutOfRangeError):
            made.caption(motion, **wrong)


def test_tokens_there_and_back(made: TM2TEngine) -> None:
    codes = [3, 3, 5, 1, 0, 2]
    motion = made.from_tokens(codes)
    assert len(motion) == 24
    assert len(made.tokens(motion)) == 6
    for wrong in ([], [12], [-1]):
        with pytest.raises(OutOfRangeError, match="codes"):
            made.from_tokens(wrong)


def test_every_token_is_a_figure(made: TM2TEngine) -> None:
    gallery = made.gallery()
    assert gallery.positions.shape == (12, 4, len(SMPL22), 3)
    assert np.isfinite(gallery.positions).all()
    np.testing.assert_allclose(gallery.positions[..., 1].min(axis=(1, 2)), 0, atol=1e-5)
    some = made.gallery([5, 2])
    np.testing.assert_allclose(some.positions, gallery.positions[[5, 2]], atol=1e-5)
    # the same four frames as a motion of that token alone
    alone = made.from_tokens([5]).positions
    np.testing.assert_allclose(np.diff(some.positions[0], axis=0), np.diff(alone, axis=0), atol=1e-4)
    with pytest.raises(OutOfRangeError):
        made.gallery([12])


def test_words_a_motion_was_made_of(made: TM2TEngine) -> None:
    motion = made.generate_many(prompt=PROMPT, count=2, seed=3)[1]
    looked = made.attention(motion)
    assert looked.weights.shape == (len(motion) // 4, len(looked.words))
    np.testing.assert_allclose(looked.weights.sum(1), 1, atol=1e-5)
    assert looked.words[1:-1] == ("a", "person", "does", "throw", ".")
    redrawn = made.from_tokens(looked.codes.tolist())
    np.testing.assert_allclose(redrawn.positions, motion.positions, atol=1e-6)
    with pytest.raises(MotionloomError, match="this engine"):
        made.attention(movement(20))


def test_a_transformer_makes_motions_too() -> None:
    other = engine(backbone="transformer")
    assert len(other.generate(PROMPT, frames=12)) == 12
    with pytest.raises(MotionloomError, match="transformer"):
        other.attention(other.generate(PROMPT))
