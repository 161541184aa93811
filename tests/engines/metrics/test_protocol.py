"""Repeats, intervals and the papers' tables over made-up evaluators."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from engines.errors import Cancelled, OutOfRangeError
from engines.metrics import language, physical, protocol, style
from engines.metrics.protocol import ACTION2MOTION, METRICS, TEXT2MOTION, TextFeatures
from engines.metrics.recognition import Recognised
from engines.motion import Motion
from engines.skeletons import SMPL22


def test_the_interval_is_student_s() -> None:
    values = np.random.default_rng(0).normal(5, 2, size=20)
    found = protocol.estimate(values)
    low, high = stats.ttest_1samp(values, 0).confidence_interval(0.95)
    assert found.mean == pytest.approx(values.mean())
    assert (found.mean - found.half_width, found.mean + found.half_width) == pytest.approx((low, high))
    assert found.values == tuple(values)


def test_nineteen_of_twenty_intervals_hold_the_truth() -> None:
    draws = np.random.default_rng(1).normal(3, 1, size=(1000, 20))
    held = [abs(e.mean - 3) <= e.half_width for e in map(protocol.estimate, draws)]
    assert np.mean(held) == pytest.approx(0.95, abs=0.02)


def test_estimates_are_written_as_in_the_papers() -> None:
    assert str(protocol.Estimate(2.4582, 0.0789)) == "2.458 ± 0.079"
    assert protocol.estimate([1.5]) == protocol.Estimate(1.5, 0.0, (1.5,))


def test_repeats_are_the_same_however_many() -> None:
    def draw(rng: np.random.Generator) -> dict[str, float]:
        return {"a": rng.normal(), "b": 2.0}

    few, many, other = protocol.repeat(draw, 3), protocol.repeat(draw, 20), protocol.repeat(draw, 3, seed=1)
    assert many["a"].values[:3] == few["a"].values != other["a"].values
    assert len(set(many["a"].values)) == 20
    assert many["b"].half_width == 0


def test_progress_is_told_and_can_stop() -> None:
    told = []
    protocol.repeat(lambda rng: {"a": 0.0}, 3, progress=lambda done, of: told.append((done, of)))
    assert told == [(1, 3), (2, 3), (3, 3)]

    def stop(done: int, of: int) -> None:
        raise Cancelled("stopped")

    with pytest.raises(Cancelled):
        protocol.repeat(lambda rng: {"a": 0.0}, 3, progress=stop)


# ---- the papers' tables -------------------------------------------------------------------------------------

CENTRES = 5 * np.random.default_rng(2).normal(size=(6, 8))
LABELS = np.arange(300) % 6


def motions(noise: float, seed: int) -> Recognised:
    """Features around one centre an action, scored by nearness to the centres."""
    features = CENTRES[LABELS] + noise * np.random.default_rng(seed).normal(size=(300, 8))
    return Recognised(features, -np.linalg.norm(features[:, None] - CENTRES, axis=-1))


def test_a_worse_engine_has_a_worse_row() -> None:
    real = motions(1, 3)

    def row(noise: float) -> dict[str, protocol.Estimate]:
        made = motions(noise, 4)
        return protocol.repeat(
            lambda rng: protocol.action_scores(real.features, made, LABELS, ACTION2MOTION, rng), repeats=4
        )

    good, bad, collapsed = row(1), row(6), row(0)
    assert good["fid"].mean < bad["fid"].mean / 20
    assert good["accuracy_top1"].mean > 0.99
    assert bad["accuracy_top1"].mean < 0.8
    assert bad["multimodality"].mean > 2 * good["multimodality"].mean
    assert collapsed["multimodality"].mean == pytest.approx(0, abs=1e-12)
    assert good["fid"].half_width == 0, "nothing drawn here changes the features"
    assert good["diversity"].half_width > 0


def test_real_motions_are_drawn_with_replacement() -> None:
    real = motions(1, 3)
    some, chosen = protocol.drawn(real, 3000, np.random.default_rng(0))
    np.testing.assert_array_equal(some.features, real.features[chosen])
    np.testing.assert_array_equal(some.logits, real.logits[chosen])
    assert len(chosen) == 3000
    assert set(chosen.tolist()) == set(range(300))
    with pytest.raises(OutOfRangeError, match="count is 0"):
        protocol.drawn(real, 0, np.random.default_rng(0))


def test_a_text_row() -> None:
    rng = np.random.default_rng(5)
    texts = rng.normal(size=(120, 4))
    shift = np.array([0.03, 0.04, 0, 0])
    repeats = np.tile(texts[:3, None], (1, 6, 1))
    made = TextFeatures(texts, texts + shift, repeats, np.arange(120))
    found = protocol.repeat(lambda g: protocol.text_scores(texts, made, TEXT2MOTION, g), repeats=3)
    assert found["r_precision_top3"].mean > 0.99
    assert found["multimodal_distance"].mean == pytest.approx(0.05)
    assert found["fid"].mean == pytest.approx(0.0025)
    assert found["multimodality"].mean == 0
    assert "multimodality" not in protocol.text_scores(texts, TextFeatures(texts, texts), TEXT2MOTION, rng)


def test_every_figure_has_a_title_and_a_direction() -> None:
    real, rng = motions(1, 3), np.random.default_rng(0)
    texts = TextFeatures(real.features, real.features, real.features.reshape(30, 10, 8))
    still = Motion(SMPL22, np.tile([1.0, 0, 0, 0], (5, 22, 1)), np.zeros((5, 3)), 20.0)
    figures = {
        **protocol.action_scores(real.features, real, LABELS, ACTION2MOTION, rng),
        **protocol.text_scores(real.features, texts, TEXT2MOTION, rng),
        **language.scores(["a b"], [["a b"]]),
        **style.style_scores(real, LABELS, real.features),
        **style.content_scores(real, LABELS, real.features),
        **physical.table(still, still.positions),
    }
    assert figures.keys() - METRICS.keys() == set()
    elsewhere = {"f1", "pose_distance", "accuracy_late", "transition_fid", "seam_jerk"}
    assert METRICS.keys() - figures.keys() == elsewhere
    assert METRICS["fid"].arrow + METRICS["cider"].arrow + METRICS["diversity"].arrow == "↓↑→"


@pytest.mark.parametrize(
    ("work", "words"),
    [
        (lambda: protocol.estimate([]), r"values of the repeats is \[\]"),
        (lambda: protocol.estimate([1, np.nan]), "one or more finite numbers"),
        (lambda: protocol.repeat(lambda rng: {"a": 1.0}, 0), "repeats is 0"),
        (lambda: protocol.repeat(lambda rng: {str(rng.random()): 1.0}, 2), "figures of repeat 1"),
    ],
)
def test_wrong_input_is_told(work, words: str) -> None:
    with pytest.raises(OutOfRangeError, match=words):
        work()
