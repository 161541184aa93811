"""The space of motions and sentences: its sides, how they are trained together and stored, and the shipped one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch

from engines import datasets, text
from engines.datasets import Clip
from engines.datasets.captions import captions, encoded
from engines.errors import Cancelled, CheckpointError, OutOfRangeError, UnknownLabelError
from engines.geometry.mirror import mirror_words
from engines.metrics.evaluators import co_embedding, train_co_embedding
from engines.metrics.evaluators.co_embedding import CoEmbedding, CoEmbeddingConfig, CoEmbeddingNet
from tests.engines.action2motion.tiny import movement

SMALL = CoEmbeddingConfig(width=16, hidden=24, size=12, steps=5, batch_size=8, learning_rate=3e-3)


def clips(count: int = 3) -> list[Clip]:
    """Bodies that turn, or hardly, and what is said of them follows from that."""
    made = []
    for i in range(count):
        for action, turning in (("walk", 0.2), ("turn left", 3.0)):
            motion = movement(50 + i, seed=i, turning=turning)
            made.append(Clip("cmu", f"{action}-{i}", action, None, None, None, "train", motion))
    return made


@pytest.fixture(scope="module")
def told() -> encoded.EncodedCaptions:
    return encoded.make(clips(), text.load(), count=12)


def net() -> CoEmbeddingNet:
    torch.manual_seed(0)
    return CoEmbeddingNet(SMALL)


def test_similarity_is_the_cosine_of_each_pair() -> None:
    judge, motions = CoEmbedding(net()), [clip.motion for clip in clips(1)]
    said = ["a person walks", "a person turns left"]
    cosines = judge.texts(said) @ judge.motions(motions).T
    np.testing.assert_allclose(judge.similarity(said, motions), np.diag(cosines))
    assert abs(judge.similarity(said[:1], motions[1:])[0] - cosines[0, 1]) < 1e-6
    assert np.abs(cosines).max() <= 1.0 + 1e-6


def test_both_sides_give_unit_vectors_of_one_space() -> None:
    made = CoEmbedding(net())
    points = made.motions([movement(length) for length in (20, 35)])
    words = made.texts(["A person walks.", "A person bows.", ""])
    assert points.shape == (2, 12) and words.shape == (3, 12)
    assert points.dtype == words.dtype == np.float64
    for rows in (points, words):
        np.testing.assert_allclose(np.linalg.norm(rows, axis=1), 1.0, atol=1e-5)
    assert made.motions([]).shape == made.texts([]).shape == (0, 12)


def test_a_motion_is_seen_alike_among_others_and_how_long_it_lasts_counts() -> None:
    made = CoEmbedding(net())
    motions = [movement(length, seed=length) for length in (20, 41, 33)]
    together = made.motions(motions)
    for motion, point in zip(motions, together, strict=True):
        np.testing.assert_allclose(made.motions([motion])[0], point, atol=1e-5)
    still = movement(40)[:1]
    short, long = (still.concat(*[still] * (length - 1)) for length in (20, 60))
    assert np.abs(made.motions([short]) - made.motions([long])).max() > 1e-3


def test_words_that_a_mirror_exchanges() -> None:
    assert train_co_embedding.sides_of("The Left hand, then right.") == "left right"
    assert train_co_embedding.sides_of("A person walks.") == ""


def test_what_is_true_of_several_motions_is_not_held_against_them(told) -> None:
    pairs = train_co_embedding.Pairs(clips(), told, 100)
    names = [name for clip in clips() for name in (clip.name, clip.mirror().name)]
    picks = np.array([names.index(name) for name in ("walk-0", "walk-1", "turn left-0", "Mturn left-0", "turn left-1")])

    def row(pick: int, sides: str) -> int:
        return next(r for r in pairs.said[pick] if train_co_embedding.sides_of(told.sentences[r]) == sides)

    said = np.array([row(picks[0], ""), row(picks[1], ""), *(row(picks[i], s) for i, s in ((2, "left"), (3, "right"))),
                     row(picks[4], "left")])  # fmt: skip
    also = pairs._also(picks, said)
    assert not also.diagonal().any()
    assert also[0, 1] and also[1, 0], "both walk, and nothing is said of sides"
    assert also[2, 4] and also[4, 2], "both turn left"
    assert not also[2, 3] and not also[3, 2], "one turns left, the other right"
    assert not also[0, 2] and not also[2, 0]


def test_every_second_motion_of_a_batch_is_the_mirror_image_of_the_one_before_it(told) -> None:
    pairs = train_co_embedding.Pairs(clips(), told, 100)
    batch = pairs.draw(np.random.default_rng(0), 6)
    assert batch.motions.count == 6 and batch.also.shape == (6, 6)
    assert batch.sentences.dtype == torch.float32
    found = [int((pairs.told.vectors == row.numpy().astype(np.float16)).all(1).argmax()) for row in batch.sentences]
    for one, other in zip(found[::2], found[1::2], strict=True):
        assert mirror_words(told.sentences[one]) == told.sentences[other]


def test_training_brings_motions_to_their_sentences(told) -> None:
    def similarity(made: CoEmbedding) -> float:
        """How much nearer a motion is to its own kind's sentences than to the other's."""
        points = made.motions([clip.motion for clip in clips()])
        words = made.texts([told.sentences[told.of(clip)[0]] for clip in clips()])
        own = np.arange(len(points))[:, None] % 2 == np.arange(len(points)) % 2
        cosines = points @ words.T
        return float(cosines[own].mean() - cosines[~own].mean())

    quick = replace(SMALL, steps=150, learning_rate=2e-2, dropout=0.0)
    trained = train_co_embedding.fit(quick, clips(), told)
    assert similarity(trained) > 0.5 > similarity(CoEmbedding(net()))


def test_resuming_is_exact(told, tmp_path) -> None:
    whole = train_co_embedding.fit(SMALL, clips(), told)
    asked = iter([False, False, True])
    with pytest.raises(Cancelled):
        train_co_embedding.fit(SMALL, clips(), told, tmp_path / "run.pt", cancel=lambda: next(asked))
    resumed = train_co_embedding.fit(SMALL, clips(), told, tmp_path / "run.pt")
    for name, value in whole.net.state_dict().items():
        assert torch.equal(value, resumed.net.state_dict()[name]), name


def test_what_was_stored_is_loaded(tmp_path) -> None:
    made = CoEmbedding(net())
    train_co_embedding.export(made, tmp_path / "mine.safetensors", step=5)
    again = co_embedding.load(tmp_path / "mine.safetensors")
    assert again.config == replace(SMALL, extra={"step": 5})
    np.testing.assert_allclose(again.motions([movement(30)]), made.motions([movement(30)]), atol=5e-3)
    np.testing.assert_allclose(again.texts(["A bow."]), made.texts(["A bow."]), atol=5e-3)
    with pytest.raises(CheckpointError, match="motionloom train evaluator --task text"):
        co_embedding.load(tmp_path / "none.safetensors")


def test_data_that_does_not_fit(told) -> None:
    with pytest.raises(OutOfRangeError, match="number of clips to train on is 0"):
        train_co_embedding.fit(SMALL, [], told)
    with pytest.raises(UnknownLabelError, match="clip with captions"):
        train_co_embedding.fit(SMALL, [replace(clips()[0], name="other")], told)
    with pytest.raises(OutOfRangeError, match="size of the captions' vectors is 384"):
        train_co_embedding.fit(replace(SMALL, encoder_size=300), clips(), told)


class Oracle:
    """Knows whose sentence is whose by asking the captions; `wrong` takes left for right."""

    def __init__(self, known: list[Clip], wrong: bool = False) -> None:
        both = [seen for clip in known for seen in (clip, clip.mirror())]
        self.place = {seen.motion.rotations.tobytes(): i for i, seen in enumerate(both)}
        self.points = np.eye(len(both))
        self.wrong, self.said = wrong, {}
        for i, seen in enumerate(both):
            for sentence in captions(seen, encoded.HELD_OUT_SEED):
                self.said[sentence] = self.said.get(sentence, 0.0) + self.points[i]

    def motions(self, motions) -> np.ndarray:
        return np.stack([self.points[self.place[motion.rotations.tobytes()]] for motion in motions])

    def texts(self, sentences) -> np.ndarray:
        rows = [self.said.get(mirror_words(s) if self.wrong else s, -self.points.sum(0)) for s in sentences]
        return np.stack([row / np.linalg.norm(row) for row in rows])


def test_measures_of_who_knows_all_and_of_who_knows_nothing() -> None:
    known = [replace(clip, name=f"{i}", split="test") for i, clip in enumerate(clips(18))]
    oracle, wrong = Oracle(known), Oracle(known, wrong=True)
    found = train_co_embedding.measure(oracle, known, repeats=3)  # pyright: ignore[reportArgumentType]
    blind = train_co_embedding.measure(CoEmbedding(net()), known, repeats=3)
    assert found.figures["r_precision_different_top1"].mean > 0.6
    assert blind.figures["r_precision_top1"].mean < 0.4
    assert found.figures["motion_r_precision_top3"].mean > 0.6
    assert found.sides == 1.0 and found.sided > 50
    assert 0.2 < blind.sides < 0.8
    assert train_co_embedding.measure(wrong, known, repeats=1).sides == 0.0  # pyright: ignore[reportArgumentType]


@pytest.fixture
def held_out() -> list[Clip]:
    if not (datasets.cache_folder() / f"house-v{datasets.VERSION}.npz").is_file():
        pytest.skip("no prepared data: motionloom data prepare")
    return datasets.load("test")


@pytest.mark.data
def test_the_shipped_one_on_held_out_clips(held_out) -> None:
    found = train_co_embedding.measure(co_embedding.load(), held_out[::4], repeats=5)
    assert found.figures["r_precision_top1"].mean > 0.72
    assert found.figures["r_precision_top3"].mean > 0.95
    assert found.figures["motion_r_precision_top1"].mean > 0.70
    assert found.sides > 0.97


@pytest.mark.data
@pytest.mark.parametrize(("action", "sentence"), [
    ("raise left hand", "the left arm goes up in the air"), ("raise right hand", "the right arm goes up in the air"),
    ("wave left hand", "he waves hello using his left hand"), ("turn right", "walks, then makes a right turn"),
])  # fmt: skip
def test_the_shipped_one_tells_sides_in_words_of_its_own(held_out, action, sentence) -> None:
    judge = co_embedding.load()
    points = judge.motions([clip.motion for clip in held_out if clip.action == action])
    here, there = judge.texts([sentence, mirror_words(sentence)])
    assert (points @ here > points @ there).mean() > 0.9
