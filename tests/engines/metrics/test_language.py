"""BLEU, ROUGE-L and CIDEr-D where the papers or a few lines of arithmetic say what must come out."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engines.errors import OutOfRangeError
from engines.metrics import language, official_scores

WORDS = st.lists(st.sampled_from(["a", "b", "c", "d", "e"]), max_size=9)
SENTENCES = WORDS.filter(len).map(" ".join)

REAL = [
    ["a person walks forward and turns left", "someone walks ahead then turns to the left"],
    ["a figure jumps twice", "the person is jumping two times"],
    ["a man throws a ball with the right hand"],
]


def test_the_same_sentence_is_perfect() -> None:
    made = [item[0] for item in REAL]
    found = language.scores(made, [[sentence] for sentence in made])
    assert found == pytest.approx({"bleu1": 1, "bleu4": 1, "rouge_l": 1, "cider": 10})


def test_other_words_are_worth_nothing() -> None:
    made = ["x y z u v", "x y z u v", "x y z u v"]
    assert set(language.scores(made, REAL).values()) == {0.0}
    assert language.scores(["", "", ""], REAL) == {"bleu1": 0, "bleu4": 0, "rouge_l": 0, "cider": 0}


def test_items_in_any_order() -> None:
    made = ["a person turns left", "a figure jumps twice", "the man throws a ball"]
    found = language.scores(made, REAL)
    assert language.scores(made[::-1], REAL[::-1]) == pytest.approx(found)
    assert language.scores(made, [item[::-1] for item in REAL]) == pytest.approx(found)


# ---- BLEU ---------------------------------------------------------------------------------------------------


def test_papineni_s_example() -> None:
    """Seven times "the" matches as often as one reference has it: 2 of 7 (section 2.1)."""
    real = ["the cat is on the mat", "there is a cat on the mat"]
    counts = language.ngram_counts(["the the the the the the the"], [real], 1)
    assert (counts.matched.tolist(), counts.total.tolist()) == ([2], [7])
    assert language.bleu(["the the the the the the the"], [real], 1) == pytest.approx(2 / 7)


def test_short_candidates_pay() -> None:
    assert language.bleu(["a b"], [["a b c d"]], 1) == pytest.approx(math.exp(1 - 4 / 2))
    assert language.bleu(["a b c d e"], [["a b c d"]], 1) == pytest.approx(4 / 5)


def test_bleu_is_of_the_corpus_not_the_mean() -> None:
    made, real = ["a b c d", "x"], [["a b c d"], ["y"]]
    assert language.bleu(made, real, 1) == pytest.approx(4 / 5)


def naive_counts(made: list[str], real: list[list[str]], n: int) -> tuple[int, int, int]:
    """Matched, all, and reference length, as the paper says it."""

    def grams(words: list[str]) -> Counter:
        return Counter(tuple(words[i : i + n]) for i in range(len(words) - n + 1))

    matched = total = length = 0
    for one, item in zip(made, real, strict=True):
        words = one.split()
        most = Counter()
        for sentence in item:
            most |= grams(sentence.split())
        matched += (grams(words) & most).total()
        total += grams(words).total()
        length += min((abs(len(s.split()) - len(words)), len(s.split())) for s in item)[1]
    return matched, total, length


@given(
    items=st.lists(st.tuples(WORDS.map(" ".join), st.lists(SENTENCES, min_size=1, max_size=3)), min_size=1, max_size=4)
)
@settings(max_examples=60, deadline=None)
def test_counts_as_the_paper_says_them(items: list[tuple[str, list[str]]]) -> None:
    """Also where items have different numbers of references, and where candidates are empty."""
    made, real = [one for one, _ in items], [item for _, item in items]
    counts = language.ngram_counts(made, real, 4)
    for n in range(1, 5):
        matched, total, length = naive_counts(made, real, n)
        assert (counts.matched[n - 1], counts.total[n - 1], counts.reference_length) == (matched, total, length)


# ---- ROUGE-L ------------------------------------------------------------------------------------------------


@given(first=WORDS, second=WORDS)
@settings(max_examples=100, deadline=None)
def test_common_subsequence_by_the_table(first: list[str], second: list[str]) -> None:
    table = np.zeros((len(first) + 1, len(second) + 1), dtype=int)
    for i, one in enumerate(first):
        for j, other in enumerate(second):
            table[i + 1, j + 1] = table[i, j] + 1 if one == other else max(table[i, j + 1], table[i + 1, j])
    assert language.common_subsequence(first, second) == table[-1, -1]


def test_lin_s_example() -> None:
    """Section 3.1: order matters, where bigrams see no difference."""
    real = [["police killed the gunman"]]
    assert language.rouge_l(["police kill the gunman"], real) == pytest.approx(3 / 4)
    assert language.rouge_l(["the gunman kill police"], real) == pytest.approx(2 / 4)


def test_the_best_reference_counts() -> None:
    real = ["a b c d e f g h", "a x"]
    expected = language.f_measure(1 / 2, 1 / 2)
    assert language.rouge_l(["a b"], [real]) == pytest.approx(max(language.f_measure(1, 2 / 8), expected))
    # the released scorer takes precision from one and recall from the other
    assert official_scores.rouge_l_items(["a b"], [real])[0] == pytest.approx(language.f_measure(1, 1 / 2))


# ---- CIDEr --------------------------------------------------------------------------------------------------


def test_cider_by_hand() -> None:
    """Two items: "a" is in both and weighs log(2/2) = 0, all else log 2; so of "a b" only b and "a b" count."""
    found = language.cider_items(["a b", "a d"], [["a b"], ["a c"]])
    assert found == pytest.approx([10 * 2 / 4, 0])
    longer = language.cider_items(["a b b", "a c"], [["a b"], ["a c"]])[0]
    unigrams = min(2, 1) * 1 / 2  # counts clipped to the reference, norms 2 and 1
    bigrams = 1 / math.sqrt(2)  # "a b" and "b b" against "a b"
    assert longer == pytest.approx(10 * (unigrams + bigrams) / 4 * math.exp(-1 / 72))


def test_rare_words_weigh_more() -> None:
    real = [["a person kicks"], ["a person waves"], ["a person hops"]]
    common, rare = language.cider_items(["a person spins", "dog bird kicks", "x"], [real[0], real[0], real[2]], real)[
        :2
    ]
    assert rare > common


def test_a_larger_corpus_can_say_what_is_rare() -> None:
    alone = language.cider(["a b c d"], [["a b c d"]])
    assert alone == 0
    assert language.cider(["a b c d"], [["a b c d"]], [["a b c d"], ["x y"], ["z"]]) == pytest.approx(10)


def test_the_released_bleu_is_never_quite_zero() -> None:
    made, real = ["a b c"], [["a x c y"]]
    assert language.bleu(made, real, 4) == 0
    assert 0 < official_scores.bleu(made, real, 4) < 1e-3


@pytest.mark.parametrize(
    ("made", "real", "words"),
    [
        ([], [], "number of references is 0"),
        (["a"], [["a"], ["b"]], "number of references is 2; accepted: 1"),
        (["a"], [[]], "references of item 0"),
        (["a", "b"], [["a"], ["b", " "]], "references of item 1"),
        ("a b", [["a"], ["b"], ["c"]], "one string"),
        (["a"], ["a b"], "one string"),
    ],
)
def test_wrong_input_is_told(made, real, words: str) -> None:
    for metric in (language.bleu, language.rouge_l, language.cider, official_scores.bleu_items):
        with pytest.raises(OutOfRangeError, match=words):
            metric(made, real)


def test_an_order_below_one_is_told() -> None:
    with pytest.raises(OutOfRangeError, match="order is 0"):
        language.bleu(["a"], [["a"]], 0)
