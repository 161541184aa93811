"""The released classifier and way of counting: loading, and what departs from ours."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch
from safetensors.torch import save_file

from engines.errors import CheckpointError, OutOfRangeError
from engines.metrics import distribution, official_scores, retrieval
from engines.metrics.official import OfficialClassifier, centred_on_first_root


@pytest.fixture
def classifier() -> OfficialClassifier:
    torch.manual_seed(0)
    return OfficialClassifier(pose_size=9, hidden_size=8, layers=2, feature_size=5, classes=4).eval()


def test_sizes_come_from_the_weights(classifier: OfficialClassifier, tmp_path: Path) -> None:
    save_file(classifier.state_dict(), tmp_path / "a.safetensors")
    torch.save({"epoch": 3, "model": classifier.state_dict()}, tmp_path / "a.tar")
    motions = torch.randn(3, 7, 9)
    expected = classifier(motions).logits
    for name in ("a.safetensors", "a.tar"):
        torch.testing.assert_close(OfficialClassifier.load(tmp_path / name)(motions).logits, expected)


def test_the_start_matters_and_is_zeros_by_default(classifier: OfficialClassifier) -> None:
    motions = torch.randn(3, 2, 9)
    generator = torch.Generator().manual_seed(1)
    start = classifier.random_state(3, generator)
    again = classifier.random_state(3, torch.Generator().manual_seed(1))
    torch.testing.assert_close(start, again)
    assert start.shape == (2, 3, 8)
    plain = classifier(motions)
    torch.testing.assert_close(classifier(motions, torch.zeros(2, 3, 8)).logits, plain.logits)
    assert (classifier(motions, start).features - plain.features).abs().max() > 1e-3
    assert plain.features.abs().max() < 1


def test_pads_become_minus_the_first_root() -> None:
    motions = torch.arange(12.0).reshape(1, 2, 6) + 1
    motions[:, 1] = 0
    assert centred_on_first_root(motions).tolist() == [[[0, 0, 0, 3, 3, 3], [-1, -2, -3, -1, -2, -3]]]


def test_bad_checkpoints_are_told(classifier: OfficialClassifier, tmp_path: Path) -> None:
    cut = {name: value for name, value in classifier.state_dict().items() if name != "linear2.weight"}
    save_file(cut, tmp_path / "cut.safetensors")
    save_file({"weight": torch.zeros(2)}, tmp_path / "other.safetensors")
    (tmp_path / "bad.safetensors").write_bytes(b"nonsense")
    (tmp_path / "bad.tar").write_bytes(b"nonsense")
    torch.save([1, 2], tmp_path / "list.tar")
    for name, words in {
        "cut.safetensors": "not a released action classifier",
        "other.safetensors": "has no recurrent.weight_ih_l0",
        "list.tar": "has no recurrent.weight_ih_l0",
        "bad.safetensors": "cannot be read",
        "bad.tar": "cannot be read",
        "absent.tar": "cannot be read",
    }.items():
        with pytest.raises(CheckpointError, match=words):
            OfficialClassifier.load(tmp_path / name)


def test_bad_motions_are_told(classifier: OfficialClassifier) -> None:
    with pytest.raises(OutOfRangeError, match="shape of motions"):
        classifier(torch.zeros(3, 7, 8))
    with pytest.raises(OutOfRangeError, match="shape of the state"):
        classifier(torch.zeros(3, 7, 9), torch.zeros(2, 2, 8))
    with pytest.raises(OutOfRangeError, match="3 times joints"):
        centred_on_first_root(torch.zeros(1, 2, 7))


# ---- counting -----------------------------------------------------------------------------------------------

RNG = np.random.default_rng(0)


def test_fid_agrees_with_ours_where_nothing_is_singular() -> None:
    real, made = RNG.normal(size=(90, 6)).astype(np.float32), RNG.normal(size=(80, 6)).astype(np.float32) * 2
    assert official_scores.fid(real, made) == pytest.approx(distribution.fid(real, made), rel=1e-5)
    with pytest.raises(OutOfRangeError, match="size of made features is 5"):
        official_scores.fid(real, made[:, :5])


def test_distances_may_be_undefined_where_rounding_undercuts_zero() -> None:
    same = np.random.default_rng(3).normal(size=(200, 32)).astype(np.float32) * 100
    found = np.diag(official_scores.distances(same, same))
    assert np.isnan(found).any()
    assert np.nanmax(found) > 0
    assert retrieval.multimodal_distance(same, same) == 0


def test_pools_are_blocks_and_the_rest_is_left_out() -> None:
    texts = RNG.normal(size=(70, 5)).astype(np.float32)
    assert official_scores.r_precision_hits(texts, texts + 1e-3).tolist() == [64, 64, 64]
    apart = official_scores.matching_score(texts, texts + np.float32(1))
    assert apart == pytest.approx(64 * np.sqrt(5), rel=1e-5)
    with pytest.raises(OutOfRangeError, match="number of texts is 31"):
        official_scores.r_precision_hits(texts[:31], texts[:31])


def test_subsets_do_not_repeat_but_may_meet_themselves() -> None:
    draws = [official_scores.subset_pairs(10, 10, np.random.default_rng(seed)) for seed in range(5)]
    for first, second in draws:
        assert sorted(first.tolist()) == sorted(second.tolist()) == list(range(10))
    assert any((first == second).any() for first, second in draws)
    with pytest.raises(OutOfRangeError, match="pairs is 11"):
        official_scores.subset_pairs(10, 11, np.random.default_rng(0))


def test_action_pairs_keep_to_their_quota() -> None:
    rng = np.random.default_rng(0)
    labels = np.array([0, 0, 0, 0, 0, 3, 3, 5])
    pairs = official_scores.action_pairs(labels, 6, lambda: int(rng.integers(len(labels))))
    assert (labels[pairs[:, 0]] == labels[pairs[:, 1]]).all()
    assert np.bincount(labels[pairs[:, 0]]).tolist() == [6, 0, 0, 6, 0, 6]
    assert [7, 7] in pairs.tolist(), "a lone motion is compared with itself"
    with pytest.raises(OutOfRangeError, match="quota is 0"):
        official_scores.action_pairs(labels, 0, lambda: 0)


def test_absent_classes_divide_too() -> None:
    pairs = np.array([[0, 1], [1, 0]])
    features = np.array([[0.0, 0.0], [3.0, 4.0]])
    assert official_scores.class_multimodality(features, pairs, 2, 1) == pytest.approx(5)
    assert official_scores.class_multimodality(features, pairs, 2, 10) == pytest.approx(0.5)


def test_equal_rotations_are_not_quite_equal() -> None:
    assert 1e-4 < official_scores.geodesic_distance(np.eye(3), np.eye(3)) < 1e-3
    half = np.diag([1.0, -1.0, -1.0])
    assert 1e-4 < np.pi - official_scores.geodesic_distance(np.eye(3), half) < 1e-3
