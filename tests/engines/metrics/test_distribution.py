"""FID, diversity and multimodality where the answer is known in closed form."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import sqrtm
from scipy.spatial.distance import pdist

from engines.errors import OutOfRangeError
from engines.metrics import distribution
from engines.metrics.distribution import FeatureStatistics, fid


def white(count: int, size: int, seed: int = 0) -> np.ndarray:
    """Features whose mean is exactly 0 and whose covariance is exactly the identity."""
    raw = np.random.default_rng(seed).normal(size=(count, size))
    raw -= raw.mean(axis=0)
    return raw @ np.linalg.inv(np.linalg.cholesky(np.cov(raw, rowvar=False))).T


def spd(size: int, seed: int) -> np.ndarray:
    root = np.random.default_rng(seed).normal(size=(size, size))
    return root @ root.T


# ---- FID ----------------------------------------------------------------------------------------------------


def test_fid_of_a_set_with_itself_is_zero() -> None:
    features = np.random.default_rng(1).normal(size=(50, 8)) @ spd(8, 1)
    assert fid(features, features) == pytest.approx(0, abs=1e-9 * np.trace(np.cov(features, rowvar=False)))


@given(seed=st.integers(0, 10**6), size=st.integers(1, 12))
@settings(max_examples=20, deadline=None)
def test_fid_of_a_shifted_set_is_the_square_of_the_shift(seed: int, size: int) -> None:
    rng = np.random.default_rng(seed)
    features, shift = rng.normal(size=(40, size)) * rng.uniform(0.1, 3, size), rng.normal(size=size) * 3
    assert fid(features, features + shift) == pytest.approx(shift @ shift, rel=1e-9)


@pytest.mark.parametrize("scale", [0.0, 0.5, 2.0, 10.0])
def test_fid_of_a_scaled_set(scale: float) -> None:
    assert fid(white(60, 5), scale * white(60, 5, 3)) == pytest.approx(5 * (1 - scale) ** 2, rel=1e-9, abs=1e-9)


def test_fid_of_covariances_with_the_same_axes() -> None:
    axes = np.linalg.qr(np.random.default_rng(4).normal(size=(6, 6)))[0]
    one, other = np.array([1, 2, 3, 4, 5, 0.5]), np.array([2, 2, 1, 0.1, 7, 3])
    found = fid((white(80, 6) * one) @ axes, (white(90, 6, 5) * other) @ axes)
    assert found == pytest.approx(np.square(one - other).sum(), rel=1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_fid_agrees_with_the_root_of_the_product(seed: int) -> None:
    rng = np.random.default_rng(seed)
    real, made = rng.normal(size=(100, 7)) @ spd(7, seed), rng.normal(size=(70, 7)) @ spd(7, seed + 9) + 2
    one, other = np.cov(real, rowvar=False), np.cov(made, rowvar=False)
    shift = real.mean(axis=0) - made.mean(axis=0)
    expected = shift @ shift + np.trace(one + other - 2 * np.real(sqrtm(one @ other)))
    assert fid(real, made) == pytest.approx(expected, rel=1e-8)


def test_fid_is_symmetric_and_knows_no_order_and_no_axes() -> None:
    rng = np.random.default_rng(2)
    real, made = rng.normal(size=(90, 6)), rng.normal(size=(70, 6)) @ spd(6, 2)
    turn = np.linalg.qr(rng.normal(size=(6, 6)))[0]
    expected = pytest.approx(fid(real, made), rel=1e-9)
    assert fid(made, real) == expected
    assert fid(rng.permutation(real), rng.permutation(made)) == expected
    assert fid(real @ turn + 4, made @ turn + 4) == expected


def test_fid_of_singular_covariances_is_exact() -> None:
    """Two sets in planes across each other share nothing: all their spread counts."""
    plane = white(30, 2)
    real, made = np.zeros((30, 6)), np.zeros((30, 6))
    real[:, :2], made[:, 3:5] = 3 * plane, 2 * plane
    assert fid(real, made) == pytest.approx(2 * 9 + 2 * 4, rel=1e-6)
    assert fid(real, 2 * real) == pytest.approx(2 * 9, rel=1e-6)


def test_fid_takes_torch_and_half_precision() -> None:
    features = torch.arange(24, dtype=torch.float16).reshape(8, 3).requires_grad_(True)
    assert fid(features, features.detach().numpy() + np.float16(1)) == pytest.approx(3)


def test_fid_keeps_its_digits_far_from_the_origin() -> None:
    features = white(50, 4) + 1e6
    assert fid(features, features + 0.5) == pytest.approx(4 * 0.25, rel=1e-5)


# ---- batches ------------------------------------------------------------------------------------------------


@given(cuts=st.lists(st.integers(0, 60), max_size=4), seed=st.integers(0, 1000))
@settings(max_examples=30, deadline=None)
def test_batches_and_merging_change_nothing(cuts: list[int], seed: int) -> None:
    features = np.random.default_rng(seed).normal(size=(60, 5)) + 100
    batches = [batch for batch in np.split(features, sorted(cuts)) if len(batch)]
    added, merged = FeatureStatistics(), FeatureStatistics()
    for batch in batches:
        added.add(batch)
        merged.merge(FeatureStatistics(batch))
    for statistics in (added, merged):
        assert statistics.count == 60
        np.testing.assert_allclose(statistics.mean, features.mean(axis=0))
        np.testing.assert_allclose(statistics.covariance, np.cov(features, rowvar=False), atol=1e-10)


def test_merging_nothing_changes_nothing() -> None:
    statistics = FeatureStatistics(white(10, 3))
    assert statistics.merge(FeatureStatistics()).count == 10


# ---- diversity and multimodality ----------------------------------------------------------------------------


def test_two_points_are_as_diverse_as_they_are_apart() -> None:
    """No pair is a motion beside itself, which would pull the mean down."""
    points = [[0.0, 0.0], [3.0, 4.0]]
    for seed in range(10):
        assert distribution.diversity(points, 7, seed) == pytest.approx(5)
    assert distribution.diversity(points, None) == pytest.approx(5)


def test_alike_is_not_diverse() -> None:
    assert distribution.diversity(np.ones((40, 3)), None) == 0
    assert distribution.multimodality(np.ones((40, 3)), np.arange(40) // 4) == 0


@pytest.mark.parametrize("count", [2, 3, 63, 64, 65, 200])
def test_all_pairs_without_a_draw(count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(distribution, "CHUNK", 64)
    features = np.random.default_rng(count).normal(size=(count, 3))
    found = distribution.diversity(features, None)
    assert found == pytest.approx(pdist(features).mean())
    assert distribution.diversity(features[::-1], None) == pytest.approx(found)


def test_drawn_pairs_have_the_mean_of_all_pairs() -> None:
    features = np.random.default_rng(6).normal(size=(9, 4))
    exact = distribution.diversity(features, None)
    spread = pdist(features).std() / np.sqrt(20000)
    assert distribution.diversity(features, 20000) == pytest.approx(exact, abs=5 * spread)
    first, second = distribution.distinct_pairs(9, 20000, np.random.default_rng(0))
    assert (first != second).all()
    counts = np.bincount(first * 9 + second, minlength=81).reshape(9, 9)
    assert counts[~np.eye(9, dtype=bool)].min() > 0.7 * 20000 / 72


def test_the_draw_follows_its_seed() -> None:
    features = np.random.default_rng(7).normal(size=(50, 4))
    assert distribution.diversity(features, 20, 3) == distribution.diversity(features, 20, 3)
    assert distribution.diversity(features, 20, 3) != distribution.diversity(features, 20, 4)


@pytest.mark.parametrize("pairs", [None, 5])
def test_labels_count_alike_in_multimodality(pairs: int | None) -> None:
    features = np.array([[0.0], [2.0], [10.0], [16.0]])
    assert distribution.multimodality(features, [0, 0, 5, 5], pairs) == pytest.approx((2 + 6) / 2)
    many = np.concatenate([features, np.full((30, 1), 50.0)])
    assert distribution.multimodality(many, [0, 0, 5, 5, *[9] * 30], pairs) == pytest.approx((2 + 6 + 0) / 3)


def test_multimodality_knows_no_order() -> None:
    rng = np.random.default_rng(8)
    features, labels = rng.normal(size=(60, 3)), rng.integers(4, size=60)
    order = rng.permutation(60)
    expected = distribution.multimodality(features, labels, None)
    assert distribution.multimodality(features[order], labels[order], None) == pytest.approx(expected)
    apart = [pdist(features[labels == label]).mean() for label in range(4)]
    assert expected == pytest.approx(np.mean(apart))


def test_multimodality_of_repeats_is_that_of_prompts_as_labels() -> None:
    features = np.random.default_rng(9).normal(size=(4, 6, 3))
    labels = np.repeat(np.arange(4), 6)
    for pairs in (None, 10):
        assert distribution.multimodality_of_repeats(features, pairs) == pytest.approx(
            distribution.multimodality(features.reshape(24, 3), labels, pairs)
        )


# ---- wrong input --------------------------------------------------------------------------------------------

GOOD = white(10, 3)


@pytest.mark.parametrize(
    ("work", "words"),
    [
        (lambda: fid(GOOD, GOOD[:1]), "number of features is 1; accepted: 2 or more"),
        (lambda: fid(GOOD, GOOD[:, :2]), "size of the second features is 2; accepted: 3"),
        (lambda: fid(GOOD, GOOD[0]), r"shape of features is \(3,\)"),
        (lambda: fid(GOOD, GOOD.astype(complex)), "real numbers"),
        (lambda: fid(GOOD, np.where(GOOD[4:5, 1:2] == GOOD, np.nan, GOOD)), r"in row 4 of features is nan.*\(1 such"),
        (lambda: FeatureStatistics(GOOD).add(GOOD[:, :1]), "size of the new features is 1"),
        (lambda: distribution.diversity(GOOD[:1]), "number of features is 1"),
        (lambda: distribution.diversity(GOOD, 0), "pairs is 0"),
        (lambda: distribution.multimodality(GOOD, [0] * 9 + [7]), r"labels with a single item is \[7\]"),
        (lambda: distribution.multimodality(GOOD, [0] * 9), r"shape of labels is \(9,\)"),
        (lambda: distribution.multimodality(GOOD, [0.5] * 10), "whole numbers"),
        (lambda: distribution.multimodality(GOOD, [-1] * 10), "0 or more"),
        (lambda: distribution.multimodality_of_repeats(GOOD), "2 or more repeats"),
        (lambda: distribution.distinct_pairs(1, 3, np.random.default_rng(0)), "number of items is 1"),
    ],
)
def test_wrong_input_is_told(work, words: str) -> None:
    with pytest.raises(OutOfRangeError, match=words):
        work()
