"""How close a caption is to what people wrote: BLEU, ROUGE-L, CIDEr-D, on plain tokens.

Every figure takes candidates (N sentences) and references (N lists of one or more sentences). Sentences are cut at
white space, nothing else is done to them: lower the case and drop punctuation and inflection before, in both alike, as
TM2T does. BLEU's n-grams are counted by sacrebleu; ROUGE-L and CIDEr-D are written from their papers, since the
packages that have them want Java or tokenise in their own way. How the released evaluation's scorers depart from
these is in `official_scores`. `bertscore` compares meanings.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

import numpy as np

from engines.errors import OutOfRangeError

CIDER_ORDER = 4
CIDER_SIGMA = 6.0
"""Words by which lengths may differ before CIDEr-D takes much off."""
ROUGE_BETA = 1.2
"""Weight of recall over precision, as in the caption evaluation of MS COCO."""


class NgramCounts(NamedTuple):
    """What BLEU is computed from."""

    matched: np.ndarray
    """(order,) n-grams of candidates that a reference has too, each at most as often as a reference has it."""
    total: np.ndarray
    """(order,) n-grams of candidates."""
    candidate_length: int
    """Words of all candidates."""
    reference_length: int
    """Words of the references nearest in length to each candidate, of two as near the shorter."""


def check(candidates: Sequence[str], references: Sequence[Sequence[str]]) -> None:
    """One or more candidates, and for each one or more references that are not empty.

    Raises:
        OutOfRangeError: else.
    """
    if isinstance(candidates, str) or any(isinstance(item, str) for item in references):
        raise OutOfRangeError("candidates or references", "one string", "a list of sentences; a list of them for each")
    if len(candidates) != len(references) or not candidates:
        raise OutOfRangeError(
            "number of references", len(references), f"{max(len(candidates), 1)}, a list for each candidate"
        )
    for index, sentences in enumerate(references):
        if not sentences or not all(sentence.split() for sentence in sentences):
            raise OutOfRangeError(f"references of item {index}", list(sentences), "one or more, none of them empty")


# ---- BLEU ---------------------------------------------------------------------------------------------------


def ngram_counts(candidates: Sequence[str], references: Sequence[Sequence[str]], order: int = 4) -> NgramCounts:
    """Counts of a corpus, up to n-grams of `order` words.

    Raises:
        OutOfRangeError: see `check`; or an order below 1.
    """
    from sacrebleu.metrics.bleu import BLEU

    check(candidates, references)
    if order < 1:
        raise OutOfRangeError("order", order, "1 or more")
    most = max(len(sentences) for sentences in references)
    # where an item has fewer references than others its first is given again, which changes no count
    streams = [[item[k] if k < len(item) else item[0] for item in references] for k in range(most)]
    counter = BLEU(tokenize="none", smooth_method="none", max_ngram_order=order, force=True)
    found = counter.corpus_score(list(candidates), streams)
    return NgramCounts(np.array(found.counts), np.array(found.totals), int(found.sys_len), int(found.ref_len))


def bleu(candidates: Sequence[str], references: Sequence[Sequence[str]], order: int = 4) -> float:
    """BLEU of a corpus, 0 to 1: geometric mean of 1- to `order`-gram precisions times the brevity penalty.

    Not smoothed: 0 where no n-gram of some length is matched. For one sentence, give lists of one.

    Source: Papineni et al. 2002, section 2.3.
    """
    counts = ngram_counts(candidates, references, order)
    if not counts.matched.all():
        return 0.0
    precision = math.exp(np.log(counts.matched / counts.total).mean())
    return precision * math.exp(min(0.0, 1.0 - counts.reference_length / counts.candidate_length))


# ---- ROUGE-L ------------------------------------------------------------------------------------------------


def common_subsequence(first: Sequence[str], second: Sequence[str]) -> int:
    """Length of the longest common subsequence of two lists of words.

    A row of the usual table is held in the bits of one integer (Hyyro 2004).
    """
    at: dict[str, int] = {}
    for index, word in enumerate(first):
        at[word] = at.get(word, 0) | 1 << index
    every = (1 << len(first)) - 1
    row = every
    for word in second:
        both = row & at.get(word, 0)
        row = ((row + both) | (row - both)) & every
    return len(first) - row.bit_count()


def rouge_l_items(candidates: Sequence[str], references: Sequence[Sequence[str]]) -> np.ndarray:
    """(N,) ROUGE-L F-measure of each candidate, 0 to 1: that with its best reference.

    Source: Lin 2004, section 3; recall weighs beta = 1.2 times as much as precision.
    """
    check(candidates, references)
    scores = []
    for candidate, sentences in zip(candidates, references, strict=True):
        words = candidate.split()
        scores.append(max(_rouge_l(words, sentence.split()) for sentence in sentences))
    return np.array(scores)


def rouge_l(candidates: Sequence[str], references: Sequence[Sequence[str]]) -> float:
    """Mean of `rouge_l_items`."""
    return float(rouge_l_items(candidates, references).mean())


def f_measure(precision: float, recall: float, beta: float = ROUGE_BETA) -> float:
    """Weighted harmonic mean; 0 where both are 0."""
    if precision + recall == 0:
        return 0.0
    return (1 + beta**2) * precision * recall / (recall + beta**2 * precision)


def _rouge_l(candidate: list[str], reference: list[str]) -> float:
    common = common_subsequence(candidate, reference)
    return f_measure(common / max(len(candidate), 1), common / len(reference))


# ---- CIDEr --------------------------------------------------------------------------------------------------


class _Weighted(NamedTuple):
    """A sentence as tf-idf vectors, one for each length of n-gram."""

    vectors: list[dict[tuple[str, ...], float]]
    norms: list[float]
    words: int


def cider_items(
    candidates: Sequence[str],
    references: Sequence[Sequence[str]],
    corpus: Sequence[Sequence[str]] | None = None,
) -> np.ndarray:
    """(N,) CIDEr-D of each candidate, 0 to 10.

    Cosines of tf-idf vectors of 1- to 4-grams, a candidate's entries clipped to the reference's, times a Gaussian of
    the difference in length; mean over n and references, times 10. A sentence of three words has no 4-grams and so
    reaches 7.5 at most.

    Source: Vedantam, Zitnick, Parikh 2015, sections 4 and 6 (CIDEr-D, sigma = 6).

    Args:
        candidates: N sentences.
        references: N lists of sentences.
        corpus: lists of sentences that say how rare n-grams are, the references by default. Where these are few, all
            is common, and for a single item every weight is 0.
    """
    check(candidates, references)
    rarity = corpus if corpus is not None else references
    documents = Counter(gram for item in rarity for gram in {g for sentence in item for g in _ngrams(sentence.split())})
    log_count = math.log(max(len(rarity), 1))
    weighed = cache(lambda sentence: _weigh(sentence, documents, log_count))  # the same sentence comes up often
    likeness = [
        np.mean([_cider(weighed(candidate), weighed(sentence)) for sentence in sentences])
        for candidate, sentences in zip(candidates, references, strict=True)
    ]
    return 10.0 * np.array(likeness)


def cider(
    candidates: Sequence[str],
    references: Sequence[Sequence[str]],
    corpus: Sequence[Sequence[str]] | None = None,
) -> float:
    """Mean of `cider_items`."""
    return float(cider_items(candidates, references, corpus).mean())


def _ngrams(words: list[str]) -> Counter[tuple[str, ...]]:
    """How often each 1- to 4-gram occurs."""
    lengths = range(1, CIDER_ORDER + 1)
    return Counter(tuple(words[i : i + n]) for n in lengths for i in range(len(words) - n + 1))


def _weigh(sentence: str, documents: Counter[tuple[str, ...]], log_count: float) -> _Weighted:
    words = sentence.split()
    vectors: list[dict[tuple[str, ...], float]] = [{} for _ in range(CIDER_ORDER)]
    for gram, count in _ngrams(words).items():
        vectors[len(gram) - 1][gram] = count * (log_count - math.log(max(documents[gram], 1)))
    norms = [math.sqrt(sum(value * value for value in vector.values())) for vector in vectors]
    return _Weighted(vectors, norms, len(words))


def _cider(made: _Weighted, real: _Weighted) -> float:
    """Likeness 0 to 1 of a candidate and a reference."""
    total = 0.0
    for n in range(CIDER_ORDER):
        scale = made.norms[n] * real.norms[n]
        if scale > 0:
            theirs = real.vectors[n]
            shared = (
                (min(value, theirs[gram]), theirs[gram]) for gram, value in made.vectors[n].items() if gram in theirs
            )
            total += sum(low * value for low, value in shared) / scale
    return total / CIDER_ORDER * math.exp(-((made.words - real.words) ** 2) / (2 * CIDER_SIGMA**2))


def scores(candidates: Sequence[str], references: Sequence[Sequence[str]]) -> dict[str, float]:
    """The papers' columns: BLEU@1, BLEU@4 and ROUGE-L from 0 to 1, CIDEr from 0 to 10."""
    return {
        "bleu1": bleu(candidates, references, 1),
        "bleu4": bleu(candidates, references, 4),
        "rouge_l": rouge_l(candidates, references),
        "cider": cider(candidates, references),
    }
