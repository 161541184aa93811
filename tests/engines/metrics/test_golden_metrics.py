"""Our metrics and the compatibility path beside numbers of the released evaluation code, topic `metrics`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch

from engines.metrics import distribution, official_scores, protocol, recognition, retrieval, style
from engines.metrics.official import OfficialClassifier
from tests.engines.metrics.golden import arrays, cases, weights

TOPIC = "metrics"
CLOSE = 1e-5
"""Relative, the topic's own."""

pytestmark = pytest.mark.golden

text = pytest.mark.parametrize("file", cases(TOPIC, "*_t2m.npz"))
action = pytest.mark.parametrize("file", cases(TOPIC, "*_a2m.npz"))
shipped = pytest.mark.parametrize("file", cases(TOPIC, "*_humanact12_shipped_classifier.npz"))


@text
def test_golden_fid(file: Path) -> None:
    golden = arrays(file)
    names = sorted(name[4:-2] for name in golden if name.startswith("fid_") and name.endswith("_x"))
    assert names
    for name in names:
        real, made = golden[f"fid_{name}_x"], golden[f"fid_{name}_y"]
        near = {"rankdef": 1e-2, "f64": 1e-7}.get(name, CLOSE)
        expected = pytest.approx(float(golden[f"fid_{name}"]), rel=near, abs=1e-7)
        assert distribution.fid(real, made) == expected, name
        assert official_scores.fid(real, made) == expected, name
        ours = distribution.FeatureStatistics(real)
        np.testing.assert_allclose(ours.mean, golden[f"fid_{name}_mu1"], rtol=CLOSE, atol=1e-6)
        np.testing.assert_allclose(ours.covariance, golden[f"fid_{name}_cov1"], rtol=CLOSE, atol=1e-6)


@text
def test_golden_texts_and_motions(file: Path) -> None:
    golden = arrays(file)
    texts, motions, pool = golden["match_text"], golden["match_motion"], int(golden["match_pool"])
    score = official_scores.matching_score(texts, motions, pool) / len(texts)
    assert score == pytest.approx(float(golden["matching_score"]), rel=CLOSE)
    assert retrieval.multimodal_distance(texts, motions) == pytest.approx(float(golden["matching_score"]), rel=CLOSE)
    hits = official_scores.r_precision_hits(texts, motions, pool)
    assert (hits / len(texts)).tolist() == golden["R_precision_top123"].tolist()
    block = official_scores.distances(texts[:pool], motions[:pool])
    np.testing.assert_allclose(block, golden["dist_mat_pool0"], rtol=CLOSE)
    each = [official_scores.distances(a[None], b[None])[0, 0] for a, b in zip(texts, motions, strict=True)]
    np.testing.assert_allclose(each, golden["matching_score_per_item"], rtol=CLOSE)
    expected = golden["R_top5_sum_single_pool_of_160"]
    found = official_scores.r_precision_hits(texts, motions, len(texts), len(expected))
    assert found.tolist() == expected.tolist()


@text
def test_golden_our_r_precision_of_all_as_one_pool(file: Path) -> None:
    """With everything in the pool nothing is drawn: ours must count what the release counts."""
    golden = arrays(file)
    texts, motions = golden["match_text"], golden["match_motion"]
    ours = retrieval.r_precision(texts, motions, pool=len(texts)) * len(texts)
    np.testing.assert_allclose(ours, golden["R_top5_sum_single_pool_of_160"][:3])


@text
def test_golden_diversity_and_multimodality(file: Path) -> None:
    golden = arrays(file)
    apart = distribution.pair_distance(golden["diversity_emb"], golden["diversity_first"], golden["diversity_second"])
    assert apart == pytest.approx(float(golden["diversity"]), rel=CLOSE)
    within = official_scores.shared_multimodality(golden["mm_emb"], golden["mm_first"], golden["mm_second"])
    assert within == pytest.approx(float(golden["multimodality"]), rel=CLOSE)


@text
def test_golden_mean_and_interval(file: Path) -> None:
    golden = arrays(file)
    ours = protocol.estimate(golden["stat_values"])
    assert ours.mean == pytest.approx(float(golden["stat_mean"]), rel=CLOSE)
    expected = float(golden["stat_conf_interval"])
    assert official_scores.interval(golden["stat_values"]) == pytest.approx(expected, rel=CLOSE)
    if len(golden["stat_values"]) == 20:  # Student's t and the unbiased deviation are wider
        assert ours.half_width / expected == pytest.approx(2.093024 / 1.96 * np.sqrt(20 / 19), rel=CLOSE)


@action
def test_golden_action_features(file: Path) -> None:
    golden = arrays(file)
    made, labels = golden["act_x"], golden["labels_x"]
    for fid in (distribution.fid, official_scores.fid):
        assert fid(made, golden["act_y"]) == pytest.approx(float(golden["fid"]), rel=CLOSE)
    apart = distribution.pair_distance(made, golden["div_first"], golden["div_second"])
    assert apart == pytest.approx(float(golden["diversity"]), rel=CLOSE)
    classes = len(np.unique(labels))
    quota = len(golden["mm_pairs"]) // classes
    stream = iter(golden["mm_raw_draws"].tolist())
    pairs = official_scores.action_pairs(labels, quota, stream.__next__)
    assert pairs.tolist() == golden["mm_pairs"].tolist()
    assert next(stream, None) is None, "every draw was used"
    within = official_scores.class_multimodality(made, pairs, quota, classes)
    assert within == pytest.approx(float(golden["multimodality"]), rel=CLOSE)


@action
def test_golden_small_classifier(file: Path) -> None:
    golden = arrays(file)
    motions, start = torch.from_numpy(golden["cls_motions"]), torch.from_numpy(golden["cls_h0"])
    seen = OfficialClassifier.load(weights(file, "a2m_small_classifier.safetensors"))(motions, start)
    np.testing.assert_allclose(seen.features, golden["cls_features"], rtol=CLOSE, atol=1e-6)
    np.testing.assert_allclose(seen.logits, golden["cls_logits"], rtol=CLOSE, atol=1e-6)
    labels = golden["cls_labels"]
    assert recognition.confusion(seen.logits, labels).tolist() == golden["cls_confusion"].tolist()
    assert recognition.accuracy(seen.logits, labels) == pytest.approx(float(golden["cls_accuracy"]))


@shipped
def test_golden_shipped_classifier(file: Path) -> None:
    golden = arrays(file)
    classifier = OfficialClassifier.load(weights(file, "humanact12_shipped_classifier.safetensors"))
    motions, start = torch.from_numpy(golden["motions"]), torch.from_numpy(golden["h0"])
    seen = classifier(motions, start)
    np.testing.assert_allclose(seen.features, golden["features"], rtol=CLOSE, atol=2e-6)
    np.testing.assert_allclose(seen.logits, golden["logits"], rtol=CLOSE, atol=1e-5)
    np.testing.assert_allclose(classifier(motions).logits, golden["logits_h0_zero"], rtol=CLOSE, atol=1e-5)


def test_golden_angles_by_two_formulas() -> None:
    """The released arc cosine agrees with ours away from 0 and pi, and has its floor at 0."""
    turn = np.linspace(0.1, 3.0, 30)
    made = np.stack([[[np.cos(a), 0, np.sin(a)], [0, 1, 0], [-np.sin(a), 0, np.cos(a)]] for a in turn])
    still = np.broadcast_to(np.eye(3), made.shape)
    np.testing.assert_allclose(style.geodesic_distance(made, still), turn, atol=1e-12)
    np.testing.assert_allclose(official_scores.geodesic_distance(made, still), turn, atol=2e-5)
