"""Captions compared word by word in a vector space: BERTScore's arithmetic over any encoder.

How it differs from the BERTScore of the papers: that one takes its vectors from RoBERTa-large (24 layers, 1.4 GB,
downloaded), from the layer that agrees best with people's judgements of translations. Here the encoder is a parameter,
and two come along:

- `LanguageEncoder`: the sentence encoder of `engines.text`, MiniLM (6 layers), read at its last layer. It knows what
  words mean and where they stand. It was tuned so that whole sentences compare, which makes its tokens alike within a
  sentence: unrelated captions score higher than with RoBERTa, hence `mismatched_baseline`. Its pieces of words are
  BERT's, lower case; RoBERTa's keep capitals.
- `SpellingEncoder`: needs no file and knows no meanings: words are alike as far as their letters are ("walk", "walks",
  "walking"), and "quickly" and "fast" are strangers.

Precision, recall, F1, idf weights and rescaling are BERTScore's own. Figures compare only within one encoder, and must
not stand beside published ones.

Source: Zhang et al. 2020, "BERTScore: evaluating text generation with BERT", section 3.
"""

from __future__ import annotations

import hashlib
import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np

from engines.errors import OutOfRangeError
from engines.metrics import checks, language


class EncodedSentence(NamedTuple):
    """A sentence as an encoder sees it."""

    tokens: Sequence[str]
    """Its words or pieces of words, without start and end marks."""
    vectors: np.ndarray
    """(tokens, D), of any length; their directions are compared."""


Encoder = Callable[[str], EncodedSentence]
"""Sentence -> one vector a token."""


@runtime_checkable
class ManyEncoder(Protocol):
    """An encoder that is faster with many sentences at once."""

    def many(self, sentences: Sequence[str]) -> list[EncodedSentence]:
        """Each as the encoder gives it alone, but for rounding."""
        ...


class LanguageEncoder:
    """Tokens in their context, as a language model sees them.

    Args:
        name: an encoder of `engines.text`.

    Raises:
        UnknownLabelError: no such encoder.
        CheckpointError: its weights are not installed.
    """

    def __init__(self, name: str = "minilm") -> None:
        from engines import text  # with torch, which the rest of this module does without

        self._encoder = text.load(name)

    def __call__(self, sentence: str) -> EncodedSentence:
        """Pieces of words and a vector for each; start and end marks are left out."""
        return self.many([sentence])[0]

    def many(self, sentences: Sequence[str]) -> list[EncodedSentence]:
        """Several at once."""
        found = self._encoder.encode(sentences)
        vectors, counts = found.tokens.double().numpy(), found.mask.sum(1).tolist()
        return [
            EncodedSentence(pieces, row[1 : count - 1])
            for pieces, row, count in zip(self._encoder.pieces(sentences), vectors, counts, strict=True)
        ]


class SpellingEncoder:
    """Words as sums of fixed random vectors of their letter n-grams, with a little of their neighbours.

    Deterministic, nothing to download or train. Source of the subword sums: Bojanowski et al. 2017.

    Args:
        size: D.
        context: weight of the words beside a word, so that "left hand right foot" is not "right hand left foot".
    """

    def __init__(self, size: int = 128, context: float = 0.2) -> None:
        self.size, self.context = size, context
        self._known: dict[str, np.ndarray] = {}

    def __call__(self, sentence: str) -> EncodedSentence:
        """One unit vector a word before its neighbours are mixed in; letter case does not matter."""
        tokens = sentence.lower().split()
        if not tokens:
            return EncodedSentence([], np.zeros((0, self.size)))
        words = np.stack([self._word(token) for token in tokens])
        mixed = words.copy()
        mixed[1:] += self.context * words[:-1]
        mixed[:-1] += self.context * words[1:]
        return EncodedSentence(tokens, mixed)

    def _word(self, word: str) -> np.ndarray:
        if word not in self._known:
            marked = f"<{word}>"
            pieces = [marked] + [marked[i : i + n] for n in (3, 4, 5) for i in range(len(marked) - n + 1)]
            total = np.sum([self._piece(piece) for piece in pieces], axis=0)
            self._known[word] = total / np.linalg.norm(total)
        return self._known[word]

    def _piece(self, piece: str) -> np.ndarray:
        # a digest, not hash(): that one changes from run to run
        seed = int.from_bytes(hashlib.blake2b(piece.encode(), digest_size=8).digest(), "little")
        return np.random.default_rng(seed).standard_normal(self.size)


class _Matched(NamedTuple):
    """Tokens of a candidate and of one of its references, each with its largest cosine in the other."""

    made: Sequence[str]
    made_best: np.ndarray
    real: Sequence[str]
    real_best: np.ndarray


def idf_weights(sentences: Sequence[Sequence[str]]) -> Callable[[str], float]:
    """How much a token counts: log((M + 1) / (m + 1)) where m of M sentences, given as their tokens, have it."""
    documents = Counter(token for sentence in sentences for token in set(sentence))
    count = len(sentences)
    return lambda token: math.log((count + 1) / (documents[token] + 1))


def bert_score(
    candidates: Sequence[str],
    references: Sequence[Sequence[str]],
    encoder: Encoder,
    *,
    idf: bool = True,
    baseline: Mapping[str, float] | None = None,
) -> dict[str, float]:
    """Mean {"precision", "recall", "f1"}, each candidate with the reference that gives it the best F1.

    A token's score is its largest cosine with the other sentence's tokens.

    Args:
        candidates: N sentences; an empty one scores 0.
        references: N lists of sentences.
        encoder: sentence -> tokens and vectors.
        idf: tokens that many references have count less.
        baseline: of `mismatched_baseline`: scores b are given as (x - b) / (1 - b), so that 0 means unrelated.

    Raises:
        OutOfRangeError: no candidates, or references missing; or vectors that do not fit their tokens.
    """
    language.check(candidates, references)
    seen = _encoded([*candidates, *(sentence for sentences in references for sentence in sentences)], encoder)
    rows = [
        [_match(seen[candidate], seen[sentence]) for sentence in sentences]
        for candidate, sentences in zip(candidates, references, strict=True)
    ]
    weight = idf_weights([pair.real for row in rows for pair in row]) if idf else lambda token: 1.0
    best = [max((_score(pair, weight) for pair in row), key=lambda score: score[2]) for row in rows]
    means = dict(zip(("precision", "recall", "f1"), np.mean(best, axis=0).tolist(), strict=True))
    return {name: _rescaled(value, baseline, name) for name, value in means.items()}


def mismatched_baseline(
    sentences: Sequence[str], encoder: Encoder, pairs: int = 1000, seed: int = 0
) -> dict[str, float]:
    """Scores of sentences that have nothing to do with each other: the zero of a rescaled `bert_score`.

    Args:
        sentences: two or more different ones, of the language to be scored.
        encoder: as in `bert_score`.
        pairs: random pairs of different sentences to average.
        seed: of the draw.

    Raises:
        OutOfRangeError: fewer than two different sentences.
    """
    from engines.metrics.distribution import distinct_pairs

    different = sorted(set(sentences))
    first, second = distinct_pairs(len(different), pairs, np.random.default_rng(seed))
    return bert_score([different[i] for i in first], [[different[i]] for i in second], encoder, idf=False)


def _encoded(sentences: Sequence[str], encoder: Encoder) -> dict[str, EncodedSentence]:
    """Each different sentence once, with unit vectors."""
    different = list(dict.fromkeys(sentences))
    found = encoder.many(different) if isinstance(encoder, ManyEncoder) else map(encoder, different)
    return {sentence: _unit(made) for sentence, made in zip(different, found, strict=True)}


def _unit(sentence: EncodedSentence) -> EncodedSentence:
    vectors = checks.as_array(sentence.vectors).astype(np.float64)
    if vectors.ndim != 2 or len(vectors) != len(sentence.tokens):
        raise OutOfRangeError("shape of an encoder's vectors", vectors.shape, f"({len(sentence.tokens)}, size)")
    norms = np.linalg.norm(vectors, axis=1, keepdims=True)
    return EncodedSentence(sentence.tokens, vectors / np.where(norms > 0, norms, 1.0))


def _match(made: EncodedSentence, real: EncodedSentence) -> _Matched:
    if not made.tokens or not real.tokens:
        return _Matched(made.tokens, np.zeros(len(made.tokens)), real.tokens, np.zeros(len(real.tokens)))
    cosines = made.vectors @ real.vectors.T
    return _Matched(made.tokens, cosines.max(axis=1), real.tokens, cosines.max(axis=0))


def _score(pair: _Matched, weight: Callable[[str], float]) -> tuple[float, float, float]:
    """Precision, recall and F1 of one candidate with one reference."""
    if not pair.made or not pair.real:
        return 0.0, 0.0, 0.0
    precision = _weighted(pair.made_best, [weight(token) for token in pair.made])
    recall = _weighted(pair.real_best, [weight(token) for token in pair.real])
    total = precision + recall
    return precision, recall, 2 * precision * recall / total if total > 0 else 0.0


def _weighted(values: np.ndarray, weights: Sequence[float]) -> float:
    """Weighted mean; the plain one where all weights are 0 (one reference: every token is in all of them)."""
    return float(np.average(values, weights=weights) if sum(weights) > 0 else values.mean())


def _rescaled(value: float, baseline: Mapping[str, float] | None, name: str) -> float:
    return value if baseline is None else (value - baseline[name]) / (1.0 - baseline[name])
