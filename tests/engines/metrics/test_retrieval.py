"""R-precision and multimodal distance of texts and motions that surely do or do not belong together."""

from __future__ import annotations

import numpy as np
import pytest

from engines.errors import OutOfRangeError
from engines.metrics import retrieval
from engines.metrics.retrieval import r_precision

RNG = np.random.default_rng(0)
TEXTS = RNG.normal(size=(200, 6))


def test_a_perfect_match_is_found_first() -> None:
    assert r_precision(TEXTS, TEXTS).tolist() == [1, 1, 1]
    assert r_precision(TEXTS, TEXTS + 0.001 * RNG.normal(size=TEXTS.shape)).tolist() == [1, 1, 1]


def test_the_farthest_is_never_found() -> None:
    directions = TEXTS / np.linalg.norm(TEXTS, axis=1, keepdims=True)
    assert r_precision(directions, -directions).tolist() == [0, 0, 0]


@pytest.mark.parametrize("pool", [3, 10, 32])
def test_all_the_same_is_no_better_than_chance(pool: int) -> None:
    """A network that always makes one motion must not be right every time."""
    same = np.ones((60, 4))
    np.testing.assert_allclose(r_precision(TEXTS[:60, :4], same, pool=pool), np.arange(1, 4) / pool)


def test_strangers_are_at_chance() -> None:
    found = r_precision(RNG.normal(size=(3000, 5)), RNG.normal(size=(3000, 5)))
    np.testing.assert_allclose(found, np.arange(1, 4) / 32, atol=4 * np.sqrt(3 / 32 / 3000))


def test_places_are_counted_against_the_whole_set() -> None:
    """With everything in the pool nothing is drawn, so the plain count must come out, in any order of the rows."""
    motions = TEXTS + RNG.normal(size=TEXTS.shape)
    gaps = np.linalg.norm(motions[:, None] - TEXTS, axis=-1)
    places = (gaps < np.diag(gaps)[:, None]).sum(axis=1)
    expected = [(places < k).mean() for k in (1, 2, 3)]
    assert 0 < expected[0] < 1
    np.testing.assert_allclose(r_precision(motions, TEXTS, pool=200), expected)
    order = RNG.permutation(200)
    np.testing.assert_allclose(r_precision(motions[order], TEXTS[order], pool=200, seed=5), expected)


def test_pools_hold_others_and_none_twice() -> None:
    others = retrieval._others(40, 31, np.random.default_rng(1), None)
    assert all(len(set(row)) == 31 and index not in row for index, row in enumerate(others.tolist()))
    assert set(others.ravel().tolist()) == set(range(40))
    assert len({tuple(sorted(row)) for row in others.tolist()}) > 30


def test_the_same_sentence_is_no_rival() -> None:
    texts = np.repeat(TEXTS[:50], 2, axis=0)
    which = np.repeat(np.arange(50), 2)
    assert r_precision(texts, texts, pool=50)[0] < 0.9
    assert r_precision(texts, texts, pool=50, identity=which)[0] == 1
    others = retrieval._others(100, 49, np.random.default_rng(1), which)
    assert (which[others] != which[:, None]).all()


def test_the_draw_follows_its_seed() -> None:
    motions = TEXTS + RNG.normal(size=TEXTS.shape)
    one, again, other = (r_precision(motions, TEXTS, seed=seed).tolist() for seed in (1, 1, 2))
    assert one == again
    assert one != other


def test_multimodal_distance_is_the_mean_distance_of_the_pairs() -> None:
    assert retrieval.multimodal_distance(TEXTS, TEXTS) == 0
    shift = np.zeros(6)
    shift[:2] = 3, 4
    assert retrieval.multimodal_distance(TEXTS, TEXTS + shift) == pytest.approx(5)
    order = RNG.permutation(200)
    motions = RNG.normal(size=TEXTS.shape)
    expected = retrieval.multimodal_distance(TEXTS, motions)
    assert retrieval.multimodal_distance(TEXTS[order], motions[order]) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("work", "words"),
    [
        (lambda: r_precision(TEXTS[:31], TEXTS[:31]), "number of candidates is 31; accepted: 32 or more"),
        (lambda: r_precision(TEXTS, TEXTS[:50]), "number of candidates is 50; accepted: 200"),
        (lambda: r_precision(TEXTS, TEXTS[:, :3]), "size of candidates is 3"),
        (lambda: r_precision(TEXTS, TEXTS, pool=2), "pool is 2; accepted: 3 or more"),
        (lambda: r_precision(TEXTS, TEXTS, identity=[0] * 190 + [1] * 10), "unlike the most frequent one is 10"),
        (lambda: retrieval.multimodal_distance(TEXTS, TEXTS * np.nan), "accepted: finite ones"),
    ],
)
def test_wrong_input_is_told(work, words: str) -> None:
    with pytest.raises(OutOfRangeError, match=words):
        work()
