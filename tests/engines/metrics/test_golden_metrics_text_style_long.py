"""The same for topic `metrics_text_style_long`: captions, stylisation, MultiAct."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import torch

from engines.geometry import rotations
from engines.metrics import distribution, language, official_scores, recognition, retrieval, style
from engines.metrics.official import OfficialClassifier, centred_on_first_root
from tests.engines.metrics.golden import arrays, cases, weights

TOPIC = "metrics_text_style_long"
CLOSE = 1e-5
FID_CLOSE = 1e-4

pytestmark = pytest.mark.golden

numeric = pytest.mark.parametrize("file", cases(TOPIC, "*_stylization_and_t2m_numeric.npz"))
multiact = pytest.mark.parametrize("file", cases(TOPIC, "*_multiact.npz"))
captions = pytest.mark.parametrize("file", cases(TOPIC, "*_nlp.json"))


@numeric
def test_golden_style_features(file: Path) -> None:
    golden = arrays(file)
    real, made = golden["feat_gt"], golden["feat_fake"]
    for fid in (distribution.fid, official_scores.fid):
        assert fid(real, made) == pytest.approx(float(golden["fid"]), rel=FID_CLOSE)
    seen = recognition.Recognised(made, golden["style_logits"])
    ours = style.style_scores(seen, golden["style_labels"], real)
    assert ours["style_accuracy"] == pytest.approx(float(golden["style_accuracy"]), rel=CLOSE)
    assert ours["style_fid"] == pytest.approx(float(golden["fid"]), rel=FID_CLOSE)
    within = official_scores.shared_multimodality(golden["mm_feat"], golden["mm_first"], golden["mm_second"])
    assert within == pytest.approx(float(golden["multimodality"]), rel=CLOSE)


@numeric
def test_golden_style_diversity(file: Path) -> None:
    golden = arrays(file)
    first, second = golden["div_first"], golden["div_second"]
    found = distribution.pair_distance(golden["feat_gt"], first, second)
    assert found == pytest.approx(float(golden["diversity"]), rel=CLOSE)


@numeric
def test_golden_geodesic_distance(file: Path) -> None:
    golden = arrays(file)
    source, target = (rotations.rot6d_to_matrix(golden[f"rot6d_{name}"]) for name in ("source", "target"))
    np.testing.assert_allclose(source, golden["rotmat_source"], atol=2e-6)
    np.testing.assert_allclose(target, golden["rotmat_target"], atol=2e-6)
    near_zero = 1e-4
    for measure in (style.geodesic_distance, official_scores.geodesic_distance):
        angles = measure(source, target)
        np.testing.assert_allclose(angles, golden["geo_per_joint"], rtol=CLOSE, atol=near_zero)
        np.testing.assert_allclose(angles.mean(axis=(-2, -1)), golden["geo_per_item"], rtol=CLOSE, atol=near_zero)
        assert angles.mean() == pytest.approx(float(golden["geo_mean"]), rel=1e-4)
    same = official_scores.geodesic_distance(golden["rotmat_source"], golden["rotmat_source"])
    assert same.min() == pytest.approx(float(golden["geo_identical_min"]), abs=near_zero)
    assert style.geodesic_distance(source, source).max() < 1e-7


@numeric
def test_golden_batch_of_pairs(file: Path) -> None:
    golden = arrays(file)
    texts, motions = golden["R_precision_emb1"], golden["R_precision_emb2"]
    pool = len(golden["euclid_matrix"])
    block = official_scores.distances(texts[:pool], motions[:pool])
    np.testing.assert_allclose(block, golden["euclid_matrix"], rtol=1e-4, atol=1e-5)
    hits = official_scores.r_precision_hits(texts[:pool], motions[:pool], pool)
    assert hits.tolist() == golden["R_precision_top3_sum"].tolist()
    total = retrieval.multimodal_distance(texts, motions) * len(texts)
    assert total == pytest.approx(float(golden["matching_score_sum"]), rel=CLOSE)


@multiact
def test_golden_multiact_classifier(file: Path) -> None:
    golden = arrays(file)
    classifier = OfficialClassifier.load(weights(file, "weights_multiact_classifier.safetensors"))
    for name in ("gt", "gen"):
        motions = centred_on_first_root(torch.from_numpy(golden[f"{name}_joint"]))
        logits = classifier(motions, torch.from_numpy(golden[f"gru_h0_for_{name}_logits"])).logits
        features = classifier(motions, torch.from_numpy(golden[f"gru_h0_for_{name}_feat"])).features
        np.testing.assert_allclose(logits, golden[f"{name}_logits"], rtol=CLOSE, atol=1e-6)
        np.testing.assert_allclose(features, golden[f"{name}_feat"], rtol=CLOSE, atol=1e-6)


@multiact
def test_golden_multiact_scores(file: Path) -> None:
    golden = arrays(file)
    logits, labels, accepted = golden["acc_logits"], golden["gen_label"], golden["confusion_accept_matrix_rows_gt"]

    def count(**options) -> int:
        return round(recognition.accuracy(logits, labels, **options) * len(labels))

    assert count() == int(golden["acc_plain_correct_count"])
    assert count(accepted=accepted) == int(golden["acc_correct_count_with_confusion"])
    assert count(k=5, accepted=accepted) == int(golden["acc_top5_correct_count_with_confusion"])
    made = golden["gen_feat"]
    for fid in (distribution.fid, official_scores.fid):
        assert fid(golden["gt_feat"], made) == pytest.approx(float(golden["fid"]), rel=FID_CLOSE)
    apart = distribution.pair_distance(made, golden["div_first_idx"], golden["div_second_idx"])
    assert apart == pytest.approx(float(golden["div"]), rel=CLOSE)


@multiact
def test_golden_multiact_multimodality(file: Path) -> None:
    golden = arrays(file)
    stream = iter(golden["multimod_randint_stream"].tolist())
    quota = 20
    pairs = official_scores.action_pairs(golden["gen_label"], quota, stream.__next__)
    assert len(pairs) == quota * int(golden["multimod_unique_labels"])
    assert next(stream, None) is None, "every draw was used"
    classes = int(golden["multimod_num_labels"])
    within = official_scores.class_multimodality(golden["gen_feat"], pairs, quota, classes)
    assert within == pytest.approx(float(golden["multimod"]), rel=CLOSE)


@captions
def test_golden_captions(file: Path) -> None:
    golden = json.loads(file.read_text(encoding="utf-8"))
    made, real = golden["hyps"], golden["refs"]
    for order, expected in enumerate(golden["Bleu"], start=1):
        assert official_scores.bleu(made, real, order) == pytest.approx(expected, rel=CLOSE)
        assert language.bleu(made, real, order) == pytest.approx(expected, rel=CLOSE)
    for order, expected in enumerate(golden["Bleu_per_item"], start=1):
        np.testing.assert_allclose(official_scores.bleu_items(made, real, order), expected, rtol=CLOSE)
    rouge = official_scores.rouge_l_items(made, real)
    np.testing.assert_allclose(rouge, golden["ROUGE_L_per_item"], rtol=CLOSE)
    assert rouge.mean() == pytest.approx(golden["ROUGE_L"], rel=CLOSE)
    np.testing.assert_allclose(language.cider_items(made, real), golden["CIDEr_per_item"], rtol=CLOSE, atol=1e-9)
    assert language.cider(made, real) == pytest.approx(golden["CIDEr"], rel=CLOSE)


@captions
def test_golden_our_rouge_is_at_most_the_released(file: Path) -> None:
    golden = json.loads(file.read_text(encoding="utf-8"))
    ours = language.rouge_l_items(golden["hyps"], golden["refs"])
    assert (ours <= np.array(golden["ROUGE_L_per_item"]) + 1e-12).all()
    assert ours.mean() == pytest.approx(golden["ROUGE_L"], abs=0.02)
