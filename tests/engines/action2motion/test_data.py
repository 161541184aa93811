"""Clips as training batches: windows, mirrored copies, short clips, balance, vocabulary."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from engines.action2motion.data import Sequences, conditions, vocabulary_of
from engines.action2motion.representation import encode
from engines.errors import MotionloomError
from tests.engines.action2motion.tiny import ACTIONS, clip, clips, config


@pytest.fixture(scope="module")
def sequences() -> Sequences:
    return Sequences(clips(), config())


def test_clips_come_mirrored_where_they_may(sequences: Sequences) -> None:
    labels = [ACTIONS[i] for i in sequences.labels]
    # two of each; a walk mirrored is a walk, a left turn a right one, a throw stays a throw and is not mirrored
    assert {name: labels.count(name) for name in ACTIONS} == {
        "walk": 4, "turn left": 4, "turn right": 4, "wave left hand": 4, "wave right hand": 4, "throw": 2,
    }  # fmt: skip
    assert len(sequences) == 22


def test_unknown_and_unlabelled_clips_are_passed_over() -> None:
    some = [clip("walk"), clip("kick"), clip("walk")]
    object.__setattr__(some[2], "action", None)
    assert len(Sequences(some, config())) == 2
    with pytest.raises(MotionloomError, match="prepare data"):
        Sequences(some[1:], config())


@pytest.mark.parametrize("decoder", ["glmi-m", "plain"])
def test_a_window_is_the_clips_stretch(decoder: str) -> None:
    settings = config(decoder, fps=10.0)
    sequences, motion = Sequences([clip("throw", 40, 3)], settings), clip("throw", 40, 3).motion
    features = encode(motion.resample(10.0))
    batch = sequences.windows(np.array([0]), np.array([5]))
    np.testing.assert_array_equal(batch.positions[:, 0].numpy(), features.positions[5:13])
    np.testing.assert_array_equal(batch.matrices[:, 0].numpy(), features.matrices[5:13])
    np.testing.assert_array_equal(batch.velocity[1:, 0].numpy(), features.velocity[6:13])
    np.testing.assert_array_equal(batch.velocity[0, 0].numpy(), 0)
    if decoder == "plain":
        expected = features.positions[5:13].reshape(8, -1)
    else:
        expected = np.concatenate([features.height, features.lie.reshape(20, -1)], axis=-1)[5:13]
    np.testing.assert_array_equal(batch.vectors[:, 0].numpy(), expected)
    hot = np.zeros(len(ACTIONS))
    hot[ACTIONS.index("throw")] = 1
    np.testing.assert_array_equal(batch.conditions[:, 0, :-1].numpy(), np.tile(hot, (8, 1)))
    np.testing.assert_allclose(batch.conditions[:, 0, -1].numpy(), np.arange(5, 13) / 19, atol=1e-6)
    assert batch.mask.min() == 1


def test_a_short_clip_holds_its_last_pose() -> None:
    sequences = Sequences([clip("throw", 10)], config(fps=20.0, window=16))
    batch = sequences.windows(np.array([0]), np.array([0]))
    assert batch.mask[:, 0].tolist() == [1.0] * 10 + [0.0] * 6
    assert torch.equal(batch.vectors[10:, 0], batch.vectors[9:10, 0].expand(6, -1))
    assert batch.velocity[10:].abs().max() == 0
    assert batch.velocity[1:10].abs().min() > 0
    assert batch.conditions[9:, 0, -1].tolist() == [1.0] * 7


def test_the_same_stream_draws_the_same_batch(sequences: Sequences) -> None:
    one, same, other = (sequences.draw(np.random.default_rng(seed)) for seed in (4, 4, 5))
    assert torch.equal(one.vectors, same.vectors)
    assert not torch.equal(one.vectors, other.vectors)
    assert one.vectors.shape == (8, 6, 67)
    assert sequences.draw(np.random.default_rng(0), size=3).mask.shape == (8, 3)


def test_rare_labels_are_drawn_more_often_than_they_come() -> None:
    many = [clip("walk", seed=i) for i in range(9)] + [clip("throw")]
    shares = []
    for balance in (1.0, 0.5, 0.0):
        sequences = Sequences(many, config(label_balance=balance))
        shares.append(float(sequences.probability[sequences.labels == ACTIONS.index("throw")].sum()))
    # 18 walks, mirrored ones included, and 1 throw
    assert shares == pytest.approx([1 / 19, 1 / (1 + 18**0.5), 1 / 2])


def test_statistics_scale_what_the_networks_see(sequences: Sequences) -> None:
    mean, spread, velocity = sequences.statistics()
    assert (mean.shape, spread.shape, velocity.shape) == ((67,), (67,), (3,))
    scaled = (sequences.vectors() - mean) / spread
    assert scaled.mean(0).abs().max() < 1e-3
    assert scaled.std(0).max() < 1 + 1e-4
    assert spread.min() > 0


def test_conditions_without_the_time_counter() -> None:
    progress = torch.rand(8, 2)
    labels = torch.tensor([3, 1])
    with_time, without = (conditions(labels, progress, config(time_counter=on)) for on in (True, False))
    assert with_time.shape == (8, 2, 7)
    assert torch.equal(with_time[..., :6], without)
    assert torch.equal(with_time[..., 6], progress)
    assert without.argmax(-1).tolist() == [[3, 1]] * 8


def test_vocabulary_is_what_occurs_mirrored_too() -> None:
    some = [clip("turn left", 40), clip("throw", 20), clip("throw", 30), clip("throw", 60)]
    assert vocabulary_of(some, 10.0) == (("turn left", "turn right", "throw"), (20, 20, 15))
