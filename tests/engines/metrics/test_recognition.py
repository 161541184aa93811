"""Top-k accuracy and confusion of classifiers whose answers are known."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engines.errors import OutOfRangeError
from engines.metrics import recognition

LABELS = np.arange(12) % 6


def test_always_right_and_always_wrong() -> None:
    right = np.eye(6)[LABELS]
    assert recognition.accuracies(right, LABELS) == {"accuracy_top1": 1.0, "accuracy_top5": 1.0}
    assert recognition.accuracies(-right, LABELS) == {"accuracy_top1": 0.0, "accuracy_top5": 0.0}


def test_no_top5_of_five_classes() -> None:
    assert recognition.accuracies(np.eye(5), np.arange(5)) == {"accuracy_top1": 1.0}


@given(places=st.lists(st.integers(0, 5), min_size=1, max_size=20), k=st.integers(1, 6))
def test_a_hit_is_a_label_among_the_first_k(places: list[int], k: int) -> None:
    rng = np.random.default_rng(len(places))
    scores, labels = np.zeros((len(places), 6)), rng.integers(6, size=len(places))
    for row, (place, label) in enumerate(zip(places, labels, strict=True)):
        others = rng.permutation([c for c in range(6) if c != label])
        order = [*others[:place], label, *others[place:]]
        scores[row, order] = -np.arange(6)
    expected = [place < k for place in places]
    assert recognition.hits(scores, labels, k).tolist() == expected
    assert recognition.hits(scores, labels, k, np.zeros((6, 6))).tolist() == expected


@pytest.mark.parametrize("label", [0, 3])
def test_a_classifier_without_an_opinion_has_its_chance(label: int) -> None:
    """Not everything right because the first of equal scores happens to be the label."""
    scores, labels = np.zeros((7, 4)), np.full(7, label)
    assert [recognition.accuracy(scores, labels, k) for k in (1, 2, 4)] == pytest.approx([0.25, 0.5, 1.0])
    scores[:, 1] = 1
    assert recognition.accuracy(scores, labels, 2) == pytest.approx(1 / 3)


def test_synonyms_count_for_the_label_they_stand_under() -> None:
    scores = np.array([[0.0, 1, 2], [0, 2, 1], [2, 1, 0]])
    table = np.zeros((3, 3))
    table[0, 2] = 1  # for label 0, the answer 2 counts too
    assert recognition.hits(scores, [0, 0, 2], 1, table).tolist() == [1, 0, 0]
    assert recognition.hits(scores, [0, 0, 2], 2, table).tolist() == [1, 1, 0]


def test_items_in_any_order() -> None:
    rng = np.random.default_rng(0)
    scores, labels, order = rng.normal(size=(40, 6)), rng.integers(6, size=40), rng.permutation(40)
    assert recognition.accuracy(scores, labels, 2) == recognition.accuracy(scores[order], labels[order], 2)
    np.testing.assert_array_equal(
        recognition.confusion(scores, labels), recognition.confusion(scores[order], labels[order])
    )


def test_confusion_has_labels_in_rows() -> None:
    scores = np.array([[1.0, 0, 0], [0, 1, 0], [0, 1, 0], [0, 0, 1]])
    counts = recognition.confusion(scores, [0, 0, 1, 1])
    assert counts.tolist() == [[1, 1, 0], [0, 1, 1], [0, 0, 0]]
    share = recognition.class_accuracy(counts)
    assert share[:2].tolist() == [0.5, 0.5]
    assert np.isnan(share[2])


@pytest.mark.parametrize(
    ("work", "words"),
    [
        (lambda: recognition.accuracy(np.eye(3), [0, 1]), r"shape of labels is \(2,\)"),
        (lambda: recognition.accuracy(np.eye(3), [0, 1, 3]), "labels is .*accepted: 0 to 2"),
        (lambda: recognition.accuracy(np.eye(3), [0, 1, 2], 4), "k is 4; accepted: 1 to 3"),
        (lambda: recognition.accuracy(np.eye(3), [0, 1, 2], 1, np.eye(2)), r"accepted is \(2, 2\)"),
        (lambda: recognition.accuracy(np.ones((3, 1)), [0, 0, 0]), "number of classes is 1"),
        (lambda: recognition.accuracy(np.full((3, 3), np.inf), [0, 1, 2]), "accepted: finite ones"),
        (lambda: recognition.class_accuracy(np.ones((2, 3))), "shape of confusion"),
    ],
)
def test_wrong_input_is_told(work, words: str) -> None:
    with pytest.raises(OutOfRangeError, match=words):
        work()
