"""The released text2motion against its own numbers (golden/tm2t_text2motion): logits, draws, inverse alignment."""

from __future__ import annotations

import re

import numpy as np
import pytest
import torch
from safetensors.torch import load_file
from torch import Tensor

from engines.tm2t import official
from engines.tm2t.official_weights import gru_of, our_name, translator_of
from engines.tm2t.sampling import gumbel_sample, sample
from engines.tm2t.vocabulary import MotionTokens
from tests.engines.action2motion.golden import cases, close, tensors

pytestmark = pytest.mark.golden

TOPIC = "tm2t_text2motion"
LOGITS, LOSS, NORM, MARGIN = 1e-4, 1e-5, 1e-4, 1e-5


def arrays(path) -> dict[str, Tensor]:
    return {name: value.long() if value.dtype == torch.int32 else value for name, value in tensors(path).items()}


def weights(path, name: str) -> dict[str, Tensor]:
    return load_file(path.with_name(f"{path.stem.partition('_')[0]}_weights_{name}.safetensors"))


def gru(path):
    kind = "late" if "late" in path.stem else "early"
    return gru_of(weights(path, f"seq2seq_{kind}")).eval()


def vocabulary(size: int) -> MotionTokens:
    return MotionTokens(size - 3)


@pytest.mark.parametrize("path", cases(TOPIC, "*_seq2seq_*.npz"))
def test_golden_attentive_gru(path) -> None:
    a, net = arrays(path), gru(path)
    pad = vocabulary(net.sizes.tokens).pad
    read = net.read(a["word_emb"], a["cap_lens"])
    close(read.words, a["text_hidden_seq"], LOGITS)
    close(read.sentence, a["text_hidden_last"], LOGITS)
    for layer, hidden in enumerate(net.steps(read).hidden):
        close(hidden, a[f"init_hidden_{layer}"], LOGITS)
    before, gold = a["m_tokens"][:, :-1], a["m_tokens"][:, 1:]
    made = {name: official.forced(net, a["word_emb"], a["cap_lens"], before, name == "tf") for name in ("tf", "free")}
    close(made["tf"][:, :8], a["logits_teacher_forced_first8"], LOGITS)
    close(made["tf"][:, -1], a["logits_teacher_forced_last"], LOGITS)
    close(made["tf"].gather(-1, gold[..., None])[..., 0], a["logits_teacher_forced_gold"], LOGITS)
    close(made["tf"].logsumexp(-1), a["logsumexp_teacher_forced"], LOGITS)
    best = made["free"].topk(2, dim=-1)
    assert torch.equal(best.indices[..., 0], a["greedy_feedback_argmax"])
    close(best.values[..., 0], a["greedy_feedback_top1_logit"], LOGITS)
    close(best.values[..., 0] - best.values[..., 1], a["greedy_feedback_margin"], LOGITS)
    for name, logits in made.items():
        for kind, smoothing in (("plain", 0.0), ("smooth", 0.1)):
            loss = official.text_loss(logits, gold, pad, smoothing)
            torch.testing.assert_close(loss, a[f"loss_{name}_{kind}_sum"], rtol=LOSS, atol=0)
        right = official.correct(logits, gold, pad)
        assert right == (int(a[f"n_correct_{name}"]), int(a[f"n_word_{name}"]))
    alone = official.forced(net, a["word_emb"][3:], a["cap_lens"][3:], before[3:], True)
    close(alone.logsumexp(-1), a["item3_alone_logsumexp"], LOGITS)
    close(alone.gather(-1, gold[3:, :, None])[..., 0], a["item3_alone_logits_gold"], LOGITS)


@pytest.mark.parametrize("path", cases(TOPIC, "*_seq2seq_*.npz"))
def test_golden_drawn_motions(path) -> None:
    a, net = arrays(path), gru(path)
    tokens = vocabulary(net.sizes.tokens)
    for kind in ("all", "100", "5"):
        most = 20 if kind == "5" else official.MAX_STEPS
        uniform = a[f"sample_top{kind}_uniform"]
        spare = torch.zeros(len(uniform), most - uniform.shape[1], dtype=uniform.dtype)
        steps = net.steps(net.read(a["word_emb"], a["cap_lens"]))
        drawn = sample(steps, tokens, torch.cat([uniform, spare], 1), 0 if kind == "all" else int(kind))
        expected, lengths = a[f"sample_top{kind}_tokens"][:, 1:], a[f"sample_top{kind}_len_map"][:, 0]
        sure = a[f"sample_top{kind}_cdf_margin_min"] > MARGIN
        compared = 0
        for row, length in enumerate(lengths.tolist()):
            # once a draw was too close to call, whatever follows may differ
            until = int(sure[row].int().cumprod(0).sum())
            upto = min(until, length)
            np.testing.assert_array_equal(drawn.tokens[row, :upto], expected[row, :upto])
            compared += upto
            if until == sure.shape[1] or until > length:
                assert drawn.lengths[row] == length, (kind, row)
        assert compared > 0


@pytest.mark.parametrize("path", cases(TOPIC, "*_seq2seq_*.npz"))
def test_golden_gumbel_draws(path) -> None:
    """The first two captions, the longest among them, as far as their noise is written down."""
    a, net = arrays(path), gru(path)
    noise = a["gumbel_topall_noise_first20steps_item01"]
    steps = net.steps(net.read(a["word_emb"][:2], a["cap_lens"][:2]))
    made = gumbel_sample(steps, vocabulary(net.sizes.tokens), noise, release=True)
    drawn = made.shares.argmax(-1)
    assert drawn.shape[1] > 0
    assert torch.equal(drawn, a["gumbel_topall_tokens"][:2, 1 : drawn.shape[1] + 1])
    for length, expected in zip(made.lengths.tolist(), a["gumbel_topall_len_map"][:2, 0].tolist(), strict=True):
        assert length == min(expected, noise.shape[1])


@pytest.mark.parametrize("path", cases(TOPIC, "*_cycle_*.npz"))
def test_golden_inverse_alignment(path) -> None:
    a, net = arrays(path), gru(path)
    back = translator_of(weights(path, "m2t_for_cycle"), heads=2).eval()
    pad_word = back.sizes.target - 1
    before, gold = a["word_ids"][:, :-1], a["word_ids"][:, 1:]
    noise = a["gumbel_noise_f16"].float()
    made = official.cycle(net, back, a["word_emb"], a["cap_lens"], before, noise, pad_word)
    assert torch.equal(made.tokens, a["gumbel_tokens"])
    assert made.lengths.tolist() == a["len_map_before_plus1"][:, 0].tolist()
    close(made.logits, a["txt_pred_logits"], LOGITS)
    loss = official.text_loss(made.logits, gold, pad_word)
    torch.testing.assert_close(loss, a["m2t_loss_sum"], rtol=LOSS, atol=0)
    assert official.correct(made.logits, gold, pad_word) == (int(a["txt_n_correct"]), int(a["txt_n_word"]))
    loss.backward()
    ours = dict(net.named_parameters())
    stated = [name for name in a if name.startswith("gradnorm.")]
    assert len(stated) > 20
    for name in stated:
        gradient = ours[our_name(name.removeprefix("gradnorm."))].grad
        assert gradient is not None
        torch.testing.assert_close(gradient.norm(), a[name], rtol=NORM, atol=1e-6, msg=name)
    size = float(a["grad.motion_decoder_step.z2init.weight"].abs().max())
    assert net.first.weight.grad is not None
    close(net.first.weight.grad, a["grad.motion_decoder_step.z2init.weight"], NORM * size)
    source = back.encoder.embed.weight.grad
    assert source is not None
    torch.testing.assert_close(source.norm(), a["m2t_src_emb_gradnorm"], rtol=NORM, atol=0)
    tokens = a["m_tokens"]
    logits = official.forced(net, a["word_emb"], a["cap_lens"], tokens[:, :-1], True)
    pad = vocabulary(net.sizes.tokens).pad
    loss = official.text_loss(logits, tokens[:, 1:], pad)
    torch.testing.assert_close(loss, a["t2m_loss_sum_tf1"], rtol=LOSS, atol=0)
    assert official.correct(logits, tokens[:, 1:], pad) == (int(a["mot_n_correct"]), int(a["mot_n_word"]))


@pytest.mark.parametrize("path", cases(TOPIC, "*_transformer_variants.npz"))
@pytest.mark.parametrize("kind", ["V1", "V2"])
def test_golden_transformers(path, kind: str) -> None:
    a, net = arrays(path), translator_of(weights(path, f"transformer{kind}"), heads=4).eval()
    assert net.sizes.tied == (kind == "V1")
    tokens = vocabulary(net.sizes.target)
    source = read_text(net, a)
    before, gold = a["m_tokens"][:, :-1], a["m_tokens"][:, 1:]
    logits = net(source, before, before != tokens.pad)
    close(logits, a[f"{kind}_logits"], LOGITS)
    torch.testing.assert_close(official.text_loss(logits, gold, tokens.pad), a[f"{kind}_loss_sum"], rtol=LOSS, atol=0)
    if f"{kind}_loss_smooth_sum" in a:
        smooth = official.text_loss(logits, gold, tokens.pad, 0.1)
        torch.testing.assert_close(smooth, a[f"{kind}_loss_smooth_sum"], rtol=LOSS, atol=0)
    with torch.no_grad():
        steps, rows = net.steps(source), [before[:, 0]]
        for _ in range(30):
            rows.append(steps.step(rows[-1]).argmax(-1))
    greedy = torch.stack(rows, 1)
    lengths = a[f"{kind}_greedy_len_map"][:, 0].tolist()
    for row, length in enumerate(lengths):
        np.testing.assert_array_equal(greedy[row, : length + 1], a[f"{kind}_greedy_tokens"][row, : length + 1])
    drawn = sample(net.steps(source), tokens, a[f"{kind}_sample_top10_uniform"], 10)
    expected, lengths = a[f"{kind}_sample_top10_tokens"][:, 1:], a[f"{kind}_sample_top10_len_map"][:, 0].tolist()
    assert drawn.lengths.tolist() == lengths
    for row, length in enumerate(lengths):
        np.testing.assert_array_equal(drawn.tokens[row, :length], expected[row, :length])


@pytest.mark.parametrize("path", cases(TOPIC, "*_transformer_variants.npz"))
def test_golden_joint_transformer(path) -> None:
    a, net = arrays(path), translator_of(weights(path, "transformerV1"), heads=4).eval()
    back = translator_of(weights(path, "m2t_for_joint_transformer"), heads=4).eval()
    tokens, pad_word = vocabulary(net.sizes.target), back.sizes.target - 1
    before, gold = a["m_tokens"][:, :-1], a["m_tokens"][:, 1:]
    logits = net(read_text(net, a), before, before != tokens.pad)
    shares = official.joint_shares(logits, a["joint_gumbel"])
    words = a["word_ids"]
    there = words[:, :-1] != pad_word
    text = back(back.read_shares(shares, a["m_tokens"] != tokens.pad), words[:, :-1], there)
    close(text, a["joint_txt_logits"], LOGITS)
    terms = {}
    for name, made, right, pad in (("t2m", logits, gold, tokens.pad), ("m2t", text, words[:, 1:], pad_word)):
        terms[name] = official.text_loss(made, right, pad)
        hits, count = official.correct(made, right, pad)
        torch.testing.assert_close(terms[name] / count, a[f"joint_{name}_loss"], rtol=LOSS, atol=0)
        assert hits / count == pytest.approx(float(a[f"joint_{name}_accuracy"]))
    total = terms["t2m"] + terms["m2t"]
    torch.testing.assert_close(total, a["joint_loss_total_sum"], rtol=LOSS, atol=0)
    total.backward()
    ours = dict(net.named_parameters())
    for name in [name for name in a if name.startswith("joint_gradnorm.") and "w_ks.bias" not in name]:
        gradient = ours[our_name(re.sub("^joint_gradnorm.", "", name))].grad
        assert gradient is not None
        torch.testing.assert_close(gradient.norm(), a[name], rtol=NORM, atol=1e-4, msg=name)


def read_text(net, a: dict[str, Tensor]):
    there = torch.arange(a["word_emb"].shape[1]) < a["cap_lens"][:, None]
    return net.read(a["word_emb"] if net.sizes.source_vectors else a["word_ids"], there)
