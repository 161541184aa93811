"""BERTScore's arithmetic with encoders whose cosines are known, and the encoder that comes along."""

from __future__ import annotations

import math
import os
import subprocess
import sys

import numpy as np
import pytest

from engines.errors import OutOfRangeError
from engines.metrics.bertscore import (
    EncodedSentence,
    LanguageEncoder,
    SpellingEncoder,
    bert_score,
    mismatched_baseline,
)

VOCABULARY = ["a", "person", "walks", "jumps", "left", "right", "dog"]


def one_hot(sentence: str) -> EncodedSentence:
    """Words are alike or not at all; their lengths must not matter."""
    tokens = sentence.split()
    return EncodedSentence(tokens, np.array([3.0 * np.eye(7)[VOCABULARY.index(t)] for t in tokens]).reshape(-1, 7))


def test_the_same_and_nothing_in_common() -> None:
    for encoder in (one_hot, SpellingEncoder()):
        same = bert_score(["a person walks"], [["a person walks"]], encoder)
        assert same == pytest.approx({"precision": 1, "recall": 1, "f1": 1})
    assert set(bert_score(["dog"], [["a person"]], one_hot).values()) == {0.0}
    assert set(bert_score([""], [["a person"]], one_hot).values()) == {0.0}


def test_precision_and_recall_of_words() -> None:
    found = bert_score(["a person jumps left"], [["a person walks"]], one_hot, idf=False)
    assert found == pytest.approx({"precision": 2 / 4, "recall": 2 / 3, "f1": 2 * 0.5 / (0.5 + 2 / 3) * 2 / 3})


def test_words_that_all_references_have_count_less() -> None:
    real = [["a walks"], ["a jumps"], ["a dog"]]
    found = bert_score(["a walks", "a left", "a dog"], real, one_hot)
    weights = {"a": math.log(4 / 4), "left": math.log(4 / 1)}
    assert weights["a"] == 0, "so the second candidate is judged by its wrong word alone"
    assert found["precision"] == pytest.approx((1 + 0 + 1) / 3)
    assert bert_score(["a walks", "a left", "a dog"], real, one_hot, idf=False)["precision"] == pytest.approx(2.5 / 3)


def test_the_best_reference_counts() -> None:
    found = bert_score(["a dog"], [["left right", "a dog"]], one_hot)
    assert found["f1"] == pytest.approx(1)


def test_rescaling_puts_strangers_at_zero() -> None:
    found = bert_score(
        ["a dog"], [["a person"]], one_hot, idf=False, baseline=dict.fromkeys(("precision", "recall", "f1"), 0.5)
    )
    assert found == pytest.approx({"precision": 0, "recall": 0, "f1": 0}, abs=1e-12)
    encoder = SpellingEncoder()
    sentences = ["a person walks left", "the dog jumps", "someone throws far", "he kicks twice", "she waves slowly"]
    baseline = mismatched_baseline(sentences, encoder, pairs=200)
    assert 0 < baseline["f1"] < 0.6
    means = [
        bert_score([one], [[other]], encoder, idf=False, baseline=baseline)["f1"]
        for one in sentences
        for other in sentences
        if one != other
    ]
    assert np.mean(means) == pytest.approx(0, abs=0.05)
    with pytest.raises(OutOfRangeError, match="number of items is 1"):
        mismatched_baseline(["a dog", "a dog"], one_hot)


def cosine(one: str, other: str) -> float:
    encoder = SpellingEncoder()
    return bert_score([one], [[other]], encoder, idf=False)["f1"]


def test_spelling_knows_inflection_and_order_but_no_meaning() -> None:
    assert cosine("walks", "walk") > 0.3
    assert cosine("walks", "walking") > 0.2
    assert cosine("walks", "Walks") == pytest.approx(1)
    assert abs(cosine("fast", "quick")) < 0.2
    assert cosine("left hand right foot", "right hand left foot") < 0.99
    plain = SpellingEncoder(context=0)
    assert bert_score(["left hand"], [["hand left"]], plain)["f1"] == pytest.approx(1)


def test_spelling_is_the_same_in_every_run() -> None:
    code = "from engines.metrics.bertscore import SpellingEncoder as S; print(S()('walk left').vectors.sum())"
    found = {
        subprocess.run(
            [sys.executable, "-c", code],
            capture_output=True, text=True, check=True, env={**os.environ, "PYTHONHASHSEED": seed},
        ).stdout
        for seed in ("1", "2")
    }  # fmt: skip
    assert len(found) == 1


def test_an_encoder_that_loses_tokens_is_told() -> None:
    with pytest.raises(OutOfRangeError, match="shape of an encoder's vectors"):
        bert_score(["a"], [["a"]], lambda sentence: EncodedSentence(["a"], np.zeros((2, 3))))


@pytest.fixture(scope="module")
def language() -> LanguageEncoder:
    return LanguageEncoder()


def test_a_language_model_knows_meanings_and_sides(language: LanguageEncoder) -> None:
    said = "A person walks forward quickly."

    def f1(other: str) -> float:
        return bert_score([other], [[said]], language, idf=False)["f1"]

    assert f1(said) == pytest.approx(1, abs=1e-6)
    assert f1("Someone strides ahead fast.") > f1("Somebody bows to the audience.") + 0.1
    turns = [f"A person turns to the {side}." for side in ("left", "right")]
    assert bert_score([turns[0]], [[turns[1]]], language)["f1"] < 0.99
    # spelling does not know that the first of these is nearer
    spelt = [bert_score([t], [[said]], SpellingEncoder(), idf=False)["f1"]
             for t in ("Someone strides ahead fast.", "A person talks forwards quietly.")]  # fmt: skip
    assert spelt[0] < spelt[1]


def test_a_language_model_gives_a_vector_a_piece(language: LanguageEncoder) -> None:
    sentences = ["Somebody cartwheels.", "", "A person walks."]
    many = language.many(sentences)
    assert [made.tokens for made in many] == [
        ["somebody", "cart", "##wheel", "##s", "."],
        [],
        ["a", "person", "walks", "."],
    ]
    for sentence, made in zip(sentences, many, strict=True):
        assert made.vectors.shape == (len(made.tokens), 384)
        np.testing.assert_allclose(language(sentence).vectors, made.vectors, atol=1e-4)


def test_sentences_are_encoded_once_and_together() -> None:
    asked = []

    class Counting:
        def __call__(self, sentence: str) -> EncodedSentence:
            return one_hot(sentence)

        def many(self, sentences) -> list[EncodedSentence]:
            asked.append(list(sentences))
            return [one_hot(sentence) for sentence in sentences]

    real = [["a person walks", "a dog"], ["a dog"]]
    made = ["a dog", "a dog walks"]
    assert bert_score(made, real, Counting()) == bert_score(made, real, one_hot)
    assert asked == [["a dog", "a dog walks", "a person walks"]]


def test_unrelated_captions_are_put_at_zero(language: LanguageEncoder) -> None:
    sentences = ["A person walks.", "Somebody throws a ball.", "A figure bows deeply.", "Someone climbs a ladder."]
    baseline = mismatched_baseline(sentences, language, pairs=60)
    assert 0.2 < baseline["f1"] < 0.9
    assert (
        bert_score(["A person walks."], [["A person is walking."]], language, idf=False, baseline=baseline)["f1"] > 0.5
    )
