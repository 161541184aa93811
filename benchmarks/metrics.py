"""What the metrics cost at the papers' sizes, beside the plainest code that gives the same number.

Run: OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python benchmarks/metrics.py. Milliseconds of processor time, which a busy
machine changes less than a clock, the best of several runs; both columns of a row are taken one after the other. The
last column is how far the two results differ, relative.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from engines.metrics import distribution, language, official_scores, protocol, recognition, retrieval
from engines.metrics.bertscore import SpellingEncoder, bert_score

REPEATS = 3
RNG = np.random.default_rng(0)
Work = Callable[[], float]


def best(work: Work) -> tuple[float, float]:
    """Processor milliseconds of the fastest of several runs, and the result."""
    taken, result = [], 0.0
    for _ in range(REPEATS):
        began = time.process_time()
        result = work()
        taken.append(time.process_time() - began)
    return min(taken) * 1e3, result


def row(name: str, ours: Work, plain: Work | None = None, how: str = "") -> None:
    quick, found = best(ours)
    if plain is None:
        print(f"{name:<48}{quick:>10.1f}")
        return
    slow, expected = best(plain)
    apart = abs(found - expected) / max(abs(expected), 1e-12)
    print(f"{name:<48}{quick:>10.1f}{slow:>12.1f}{slow / quick:>9.1f}{apart:>12.1e}   {how}")


def fid_by_sqrtm(real: np.ndarray, made: np.ndarray) -> Work:
    return lambda: official_scores.fid(real, made)


def loop_of_pairs(features: np.ndarray) -> float:
    """Mean distance of all pairs, one after the other."""
    gaps = [np.linalg.norm(one - other) for i, one in enumerate(features) for other in features[:i]]
    return float(np.mean(gaps))


def loop_of_pools(queries: np.ndarray, candidates: np.ndarray, others: np.ndarray) -> float:
    """Top-1 R-precision, candidate by candidate."""
    right = 0
    for index, query in enumerate(queries):
        gaps = [np.linalg.norm(query - candidates[other]) for other in (index, *others[index])]
        right += int(np.argmin(gaps) == 0)
    return right / len(queries)


def loop_of_places(logits: np.ndarray, labels: np.ndarray) -> float:
    """Top-5 accuracy, item by item."""
    return sum(label in np.argsort(-row)[:5] for row, label in zip(logits, labels, strict=True)) / len(labels)


def table_of_words(candidates: list[str], references: list[list[str]]) -> float:
    """ROUGE-L by the usual table."""

    def common(first: list[str], second: list[str]) -> int:
        last = [0] * (len(second) + 1)
        for one in first:
            row = [0]
            for j, other in enumerate(second):
                row.append(last[j] + 1 if one == other else max(last[j + 1], row[j]))
            last = row
        return last[-1]

    def score(words: list[str], other: list[str]) -> float:
        shared = common(words, other)
        return language.f_measure(shared / len(words), shared / len(other))

    best_of = [max(score(c.split(), s.split()) for s in item) for c, item in zip(candidates, references, strict=True)]
    return float(np.mean(best_of))


def sentences(count: int) -> list[str]:
    """Sentences of 6 to 14 words out of 300, frequent ones more often."""
    words = np.array([f"word{i}" for i in range(300)])
    share = 1 / np.arange(1, 301)
    return [" ".join(RNG.choice(words, RNG.integers(6, 15), p=share / share.sum())) for _ in range(count)]


def main() -> None:
    print(f"{'':<48}{'ours, ms':>10}{'plain, ms':>12}{'ratio':>9}{'apart':>12}")
    for count, size in ((3000, 30), (2000, 512)):
        real, made = RNG.normal(size=(2, count, size)) * RNG.uniform(0.2, 2, size)
        row(f"FID, {count} x {size}", lambda r=real, m=made: distribution.fid(r, m), fid_by_sqrtm(real, made), "sqrtm")
    features = RNG.normal(size=(1000, 512))
    row("diversity, all pairs of 1000 x 512", lambda: distribution.diversity(features, None),
        lambda: loop_of_pairs(features), "a pair at a time")  # fmt: skip
    texts = RNG.normal(size=(2000, 512))
    motions = texts + 1.2 * RNG.normal(size=texts.shape)
    others = retrieval._others(2000, 31, np.random.default_rng(0), None)
    row("R-precision, 2000 pools of 32 x 512", lambda: float(retrieval.r_precision(motions, texts)[0]),
        lambda: loop_of_pools(motions, texts, others), "a candidate at a time")  # fmt: skip
    logits, labels = RNG.normal(size=(3000, 53)), RNG.integers(53, size=3000)
    row("top-5 accuracy, 3000 x 53", lambda: recognition.accuracy(logits, labels, 5),
        lambda: loop_of_places(logits, labels), "an item at a time")  # fmt: skip
    captions, real_captions = sentences(1000), [sentences(3) for _ in range(1000)]
    row("ROUGE-L, 1000 captions x 3", lambda: language.rouge_l(captions, real_captions),
        lambda: table_of_words(captions, real_captions), "the table of the definition")  # fmt: skip
    row("BLEU@4, 1000 captions x 3", lambda: language.bleu(captions, real_captions))
    row("CIDEr-D, 1000 captions x 3", lambda: language.cider(captions, real_captions))
    encoder = SpellingEncoder()
    row("BERTScore-like, 1000 captions x 3", lambda: bert_score(captions, real_captions, encoder)["f1"])
    view = recognition.Recognised(RNG.normal(size=(3000, 30)), RNG.normal(size=(3000, 12)))
    real = RNG.normal(size=(3000, 30))
    actions, settings = np.arange(3000) % 12, protocol.ACTION2MOTION

    def whole() -> float:
        measure = lambda rng: protocol.action_scores(real, view, actions, settings, rng)  # noqa: E731
        return protocol.repeat(measure, settings.repeats)["fid"].mean

    row("Action2Motion's four figures, 20 repeats", whole)


if __name__ == "__main__":
    main()
