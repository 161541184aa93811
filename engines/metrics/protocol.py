"""The papers' protocol: everything random is drawn again, N times, and given as a mean with its 95 % interval.

Each repeat has a generator of its own, the k-th the same however many there are, so a run that is cut short agrees
with a long one as far as it goes. A measure is a function of that generator; the ones below are the papers' tables:

    estimates = repeat(lambda rng: action_scores(real, made, labels, ACTION2MOTION, rng), ACTION2MOTION.repeats)
    str(estimates["fid"])        # 2.458 ± 0.079

The `real` row of a table is the same measure with other real motions in place of the generated.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from scipy import stats

from engines.errors import OutOfRangeError
from engines.metrics import checks, distribution, recognition, retrieval
from engines.metrics.recognition import Recognised

log = logging.getLogger(__name__)

CONFIDENCE = 0.95


@dataclass(frozen=True)
class Protocol:
    """How a paper measures: how often, and over how many pairs."""

    repeats: int
    """Times everything is measured."""
    diversity_pairs: int
    multimodality_pairs: int
    """Of each action, or of each sentence."""
    motions: int = 0
    """Generated in each repeat; 0 for one of each test item."""
    multimodality_prompts: int = 0
    """Sentences that get many motions each, for multimodality; 0 where it is over the actions."""
    motions_a_prompt: int = 0
    """How many each of these gets."""


ACTION2MOTION = Protocol(repeats=20, diversity_pairs=200, multimodality_pairs=20, motions=3000)
"""Action2Motion, section 4.2: real motions are drawn with replacement from the test set."""
TEXT2MOTION = Protocol(20, 300, 10, multimodality_prompts=100, motions_a_prompt=30)
"""Text2Motion, section 5; TM2T too."""
STYLIZATION = Protocol(repeats=30, diversity_pairs=300, multimodality_pairs=10, motions_a_prompt=30)
"""Generative stylization, section 5.3 of the thesis; `Div` there is the multimodality of one content's stylings."""
MULTIACT = Protocol(repeats=20, diversity_pairs=200, multimodality_pairs=20)
"""MultiAct, with FID to the training and to the test set, top-1 and top-5 accuracy."""


@dataclass(frozen=True)
class Metric:
    """A column of a table."""

    title: str
    better: Literal["higher", "lower", "like real"]
    """Which way is good."""
    unit: str = ""

    @property
    def arrow(self) -> str:
        """The papers' sign for it."""
        return {"higher": "↑", "lower": "↓", "like real": "→"}[self.better]


METRICS: Mapping[str, Metric] = {
    "r_precision_top1": Metric("R-precision top 1", "higher"),
    "r_precision_top2": Metric("R-precision top 2", "higher"),
    "r_precision_top3": Metric("R-precision top 3", "higher"),
    "transition_fid": Metric("Transition FID", "lower"),
    "fid": Metric("FID", "lower"),
    "accuracy_top1": Metric("Accuracy", "higher"),
    "accuracy_late": Metric("Accuracy, last quarter", "higher"),
    "accuracy_top5": Metric("Accuracy top 5", "higher"),
    "multimodal_distance": Metric("Multimodal distance", "lower"),
    "diversity": Metric("Diversity", "like real"),
    "multimodality": Metric("Multimodality", "like real"),
    "bleu1": Metric("BLEU@1", "higher"),
    "bleu4": Metric("BLEU@4", "higher"),
    "rouge_l": Metric("ROUGE-L", "higher"),
    "cider": Metric("CIDEr", "higher"),
    "f1": Metric("BERTScore-like F1", "higher"),
    "style_accuracy": Metric("Style accuracy", "higher"),
    "style_fid": Metric("Style FID", "lower"),
    "content_accuracy": Metric("Content accuracy", "higher"),
    "content_fid": Metric("Content FID", "lower"),
    "pose_distance": Metric("Geodesic distance", "lower", "rad"),
    "seam_jerk": Metric("Peak jerk at seams", "like real", "m/s³"),
    "foot_skate": Metric("Foot skate", "like real", "cm/s"),
    "contact_skate": Metric("Foot skating in contact", "like real", "cm/s"),
    "jitter": Metric("Jitter", "like real", "m/s³"),
    "ground_penetration": Metric("Ground penetration", "lower", "cm"),
    "floating": Metric("Floating", "like real", "cm"),
    "bone_length_drift": Metric("Bone-length drift", "lower", "mm"),
}
"""Every figure of this package by the name it has in score dictionaries, in the order of the papers' tables."""


@dataclass(frozen=True)
class Estimate:
    """A mean over repeats and the half width of its interval."""

    mean: float
    half_width: float
    values: tuple[float, ...] = ()
    """What the repeats gave."""

    def __str__(self) -> str:
        return f"{self.mean:.3f} ± {self.half_width:.3f}"


def estimate(values: Sequence[float] | np.ndarray) -> Estimate:
    """Mean and 95 % interval (Student's t, unbiased deviation) of what repeats gave; no width for a single one.

    The released text and action code has 1.96 and the biased deviation (`official_scores.interval`), 9 % narrower at
    20 repeats; MultiAct has Student's t.

    Raises:
        OutOfRangeError: no values, or one that is not finite.
    """
    array = np.asarray(values, dtype=np.float64)
    if array.ndim != 1 or len(array) == 0 or not np.isfinite(array).all():
        raise OutOfRangeError("values of the repeats", array.tolist(), "one or more finite numbers")
    half = 0.0
    if len(array) > 1:
        quantile = stats.t.ppf((1 + CONFIDENCE) / 2, len(array) - 1)
        half = float(quantile * array.std(ddof=1) / np.sqrt(len(array)))
    return Estimate(float(array.mean()), half, tuple(array.tolist()))


def repeat(
    measure: Callable[[np.random.Generator], Mapping[str, float]],
    repeats: int = 20,
    seed: int = 0,
    progress: Callable[[int, int], None] | None = None,
) -> dict[str, Estimate]:
    """Measures again and again, each time with a generator of its own.

    Args:
        measure: generator -> figures by name, the same names each time.
        repeats: how often.
        seed: of all generators.
        progress: called with (done, repeats) after each; may raise `Cancelled`.

    Raises:
        OutOfRangeError: no repeats; or the names of the figures change from one repeat to another.
    """
    if repeats < 1:
        raise OutOfRangeError("repeats", repeats, "1 or more")
    rows: list[dict[str, float]] = []
    for index, child in enumerate(np.random.SeedSequence(seed).spawn(repeats)):
        rows.append({name: float(value) for name, value in measure(np.random.default_rng(child)).items()})
        if rows[-1].keys() != rows[0].keys():
            raise OutOfRangeError(
                f"figures of repeat {index}", sorted(rows[-1]), f"those of the first, {sorted(rows[0])}"
            )
        log.debug("repeat %d of %d: %s", index + 1, repeats, rows[-1])
        if progress is not None:
            progress(index + 1, repeats)
    return {name: estimate([row[name] for row in rows]) for name in rows[0]}


# ---- the papers' tables -------------------------------------------------------------------------------------


def action_scores(
    real: Any, made: Recognised, labels: Any, protocol: Protocol, rng: np.random.Generator
) -> dict[str, float]:
    """FID, accuracy, diversity and multimodality of motions made for actions: Action2Motion's and MultiAct's columns.

    Args:
        real: (M, D) the evaluator's features of real motions.
        made: the evaluator's view of the N generated motions.
        labels: (N,) the actions asked for, as the evaluator's labels.
        protocol: numbers of pairs.
        rng: draws them.

    Raises:
        OutOfRangeError: shapes or labels that do not fit.
    """
    return {
        "fid": distribution.fid(real, made.features),
        **recognition.accuracies(made.logits, labels),
        "diversity": distribution.diversity(made.features, protocol.diversity_pairs, rng),
        "multimodality": distribution.multimodality(made.features, labels, protocol.multimodality_pairs, rng),
    }


@dataclass(frozen=True)
class TextFeatures:
    """A co-embedding evaluator's view of motions made for sentences."""

    texts: Any
    """(N, D) of the sentences."""
    motions: Any
    """(N, D) of the motion made for each."""
    repeats: Any = None
    """(prompts, motions a prompt, D) of many motions for a few sentences, optional: for multimodality."""
    identity: Any = None
    """(N,) whole numbers, optional: which sentences are the same."""


def text_scores(real: Any, made: TextFeatures, protocol: Protocol, rng: np.random.Generator) -> dict[str, float]:
    """R-precision, FID, multimodal distance, diversity and (with repeats) multimodality: Text2Motion's columns.

    Args:
        real: (M, D) the evaluator's features of real motions.
        made: its features of texts and of the motions generated for them.
        protocol: numbers of pairs.
        rng: draws pools and pairs.

    Raises:
        OutOfRangeError: shapes that do not fit.
    """
    precision = retrieval.r_precision(made.motions, made.texts, seed=rng, identity=made.identity)
    scores = {f"r_precision_top{place}": float(share) for place, share in enumerate(precision, start=1)}
    scores["fid"] = distribution.fid(real, made.motions)
    scores["multimodal_distance"] = retrieval.multimodal_distance(made.motions, made.texts)
    scores["diversity"] = distribution.diversity(made.motions, protocol.diversity_pairs, rng)
    if made.repeats is not None:
        pairs = protocol.multimodality_pairs
        scores["multimodality"] = distribution.multimodality_of_repeats(made.repeats, pairs, rng)
    return scores


def drawn(recognised: Recognised, count: int, rng: np.random.Generator) -> tuple[Recognised, np.ndarray]:
    """`count` items drawn with replacement, as Action2Motion draws real motions, and their indices (count,).

    Raises:
        OutOfRangeError: nothing to draw, or from nothing.
    """
    features, logits = checks.as_array(recognised.features), checks.as_array(recognised.logits)
    if count < 1 or len(features) == 0:
        raise OutOfRangeError("count", count, "1 or more, out of 1 or more items")
    chosen = rng.integers(len(features), size=count)
    return Recognised(features[chosen], logits[chosen]), chosen
