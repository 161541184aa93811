"""The engine: what is asked comes back, the same for the same seed; lengths; attention; what is refused."""

from __future__ import annotations

import json

import numpy as np
import pytest

from engines.errors import Cancelled, CheckpointError, MotionloomError, OutOfRangeError, UnknownLabelError
from engines.skeletons import SMPL22
from engines.text2motion.engine import Lengths, Text2MotionEngine, load
from tests.engines.text2motion.tiny import FakeEncoder, engine, model, movement

PROMPT, OTHER = "A person does throw.", "Someone does walk slowly, taking two steps."


@pytest.fixture(scope="module")
def made() -> Text2MotionEngine:
    return engine()


def test_the_same_seed_gives_the_same_motions(made: Text2MotionEngine) -> None:
    seen: list[tuple[int, int]] = []
    many = made.generate_many(prompt=PROMPT, count=3, seed=5, progress=lambda *now: seen.append(now))
    again = made.generate_many(prompt=PROMPT, count=3, seed=5)
    assert seen == [(3, 3)]
    for index, (motion, same) in enumerate(zip(many, again, strict=True)):
        np.testing.assert_array_equal(motion.rotations, same.rotations)
        assert (motion.skeleton, motion.fps) == (SMPL22, made.fps)
        assert made.config.shortest <= len(motion) <= made.max_frames
        origin = motion.provenance
        assert (origin.source, origin.weights, origin.prompt) == ("text2motion", made.weights_hash, PROMPT)
        assert (origin.seed, origin.index) == (5, index)
        json.dumps(dict(origin.parameters))
        assert motion.label_at(0, "text") == PROMPT
    assert len({motion.rotations.tobytes() for motion in many}) == 3


def test_a_motion_does_not_depend_on_those_beside_it(made: Text2MotionEngine) -> None:
    many = made.generate_many(prompt=PROMPT, count=70, seed=1)
    one = made.generate(PROMPT, seed=1)
    np.testing.assert_allclose(one.positions, many[0].positions, atol=1e-4)
    assert len({len(motion) for motion in many}) > 1  # of different lengths
    few = made.generate_many(prompt=PROMPT, count=66, seed=1)
    np.testing.assert_allclose(few[65].positions, many[65].positions, atol=1e-4)
    each = made.generate_each([PROMPT, OTHER, PROMPT], seed=1)
    np.testing.assert_allclose(each[0].positions, one.positions, atol=1e-4)
    np.testing.assert_allclose(each[2].positions, one.positions, atol=1e-4)
    np.testing.assert_allclose(each[1].positions, made.generate(OTHER, seed=1).positions, atol=1e-4)


@pytest.mark.parametrize("frames", [1, 7, 24, 40])
def test_a_length_that_is_told_is_kept(made: Text2MotionEngine, frames: int) -> None:
    assert len(made.generate_many(prompt=PROMPT, count=1, frames=frames)[0]) == frames
    assert len(made.generate(PROMPT, seconds=frames / 20)) == frames


def test_lengths_are_those_of_the_sentence(made: Text2MotionEngine) -> None:
    told = made.lengths(PROMPT)
    assert told.frames.tolist() == list(range(12, 41, 4))
    assert told.chances.sum() == pytest.approx(1)
    assert told.likeliest in told.frames
    drawn = [len(motion) for motion in made.generate_many(prompt=PROMPT, count=300, seed=2)]
    shares = np.array([drawn.count(frames) for frames in told.frames]) / 300
    np.testing.assert_allclose(shares, told.chances, atol=0.12)
    known = Lengths(np.array([4, 8, 12]), np.array([0.25, 0.5, 0.25]))
    assert [known.draw(uniform) for uniform in (0.0, 0.24, 0.25, 0.74, 0.75, 0.999999)] == [4, 4, 8, 8, 12, 12]
    assert (known.mean, known.likeliest) == (8.0, 8)


def test_without_text2length_lengths_must_be_said() -> None:
    alone = Text2MotionEngine(model(0, "autoencoder", "text2motion"), "0" * 64, FakeEncoder())
    assert "lengths" not in alone.capabilities
    assert len(alone.generate(PROMPT, seconds=1)) == 20
    for ask in (lambda: alone.generate(PROMPT), lambda: alone.lengths(PROMPT)):
        with pytest.raises(MotionloomError, match="say it"):
            ask()


def test_it_says_what_the_studio_asks(made: Text2MotionEngine) -> None:
    assert (made.name, made.variant, made.actions, made.max_frames) == ("text2motion", "small", (), 40)
    assert made.variant in made.variants
    assert made.capabilities == {"text", "lengths", "word_attention", "scale_bones", "variants"}
    assert "CC BY-NC" in made.licence


def test_an_action_is_a_sentence_too(made: Text2MotionEngine) -> None:
    assert made.generate_many("does throw", count=1)[0].provenance.prompt == "does throw"


def test_words_that_are_not_known_are_named(made: Text2MotionEngine) -> None:
    said = made.generate("A persn dances merrily.", seconds=1).provenance.parameters["unmet"]
    assert "'persn'" in said[0] and "'person'" in said[0]
    assert any("merrily" in one for one in said)
    assert "unmet" not in made.generate(PROMPT, frames=8).provenance.parameters


def test_temperature_scales_what_is_drawn(made: Text2MotionEngine) -> None:
    def spread(temperature: float) -> float:
        motions = made.generate_many(prompt=PROMPT, count=4, frames=20, temperature=temperature)
        return float(np.std([motion.positions for motion in motions], axis=0).mean())

    assert spread(0.0) < 1e-6 < spread(0.5) < spread(1.5)


def test_bones_can_be_longer(made: Text2MotionEngine) -> None:
    longer = made.generate(PROMPT, bone_scale={"*": 1.2})
    np.testing.assert_allclose(longer.skeleton.bone_lengths, 1.2 * SMPL22.bone_lengths)
    assert longer.provenance.parameters["bone_scale"] == {"*": 1.2}


@pytest.mark.parametrize(("wrong", "says"), [
    ({"count": 0}, "count"), ({"count": 1025}, "count"), ({"frames": 0}, "frames"), ({"frames": 41}, "frames"),
    ({"seed": -1}, "seed"), ({"temperature": -0.1}, "temperature"), ({"temperature": 2.1}, "temperature"),
    ({"frames": 2.5}, "frames"), ({"temperature": True}, "temperature"),
])  # fmt: skip
def test_numbers_out_of_range_are_refused(made: Text2MotionEngine, wrong: dict, says: str) -> None:
    with pytest.raises(OutOfRangeError, match=says):
        made.generate_many(prompt=PROMPT, **wrong)


@pytest.mark.parametrize(("prompt", "says"), [
    ("", "empty"), (" \n", "empty"), ("walk " * 2001, "length of the prompt"), ("走る", "cannot read"),
    ("🙂", "cannot read"), ("wal\x00k", "control character"), ("123!", "no word"),
])  # fmt: skip
def test_prompts_that_cannot_be_read_are_refused(made: Text2MotionEngine, prompt: str, says: str) -> None:
    for ask in (lambda: made.generate_many(prompt=prompt), lambda: made.lengths(prompt)):
        with pytest.raises(MotionloomError, match=says):
            ask()


def test_what_else_is_refused(made: Text2MotionEngine) -> None:
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


def test_words_a_motion_was_made_of(made: Text2MotionEngine) -> None:
    motion = made.generate_many(prompt=PROMPT, count=2, seed=3)[1]
    looked = made.attention(motion)
    assert looked.weights.shape == (len(motion) // 4, len(looked.words))
    assert looked.frames == 4
    np.testing.assert_allclose(looked.weights.sum(1), 1, atol=1e-5)
    assert looked.words == ("", "a", "person", "does", "throw", ".", "")
    cut = made.generate(PROMPT, frames=10)
    assert len(made.attention(cut).weights) == 3
    with pytest.raises(MotionloomError, match="this engine"):
        made.attention(movement(20))
    deaf = engine(attention=False)
    with pytest.raises(MotionloomError, match="without attention"):
        deaf.attention(deaf.generate(PROMPT))
