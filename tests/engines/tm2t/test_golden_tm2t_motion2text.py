"""The released motion2text against its own numbers (golden/tm2t_motion2text): logits, losses, gradients, search."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from safetensors.torch import load_file
from torch import Tensor

from engines.tm2t.official import beam_search, correct, text_loss
from engines.tm2t.official_weights import our_name, translator_of
from engines.tm2t.sampling import top_k
from engines.tm2t.transformer import Source, Translator, places
from tests.engines.action2motion.golden import cases, close, tensors

pytestmark = pytest.mark.golden

LOGITS, LOSS, HEADS = 1e-4, 1e-5, 4
CASES = cases("tm2t_motion2text", "*_m2t.npz")


def opened(path, weights: str = "V2") -> tuple[dict[str, Tensor], Translator]:
    kind = path.stem.partition("_")[0]
    state = load_file(path.with_name(f"{kind}_weights_{weights}.safetensors"))
    return {name: _long(value) for name, value in tensors(path).items()}, translator_of(state, HEADS).eval()


def _long(value: Tensor) -> Tensor:
    return value.long() if value.dtype == torch.int32 else value


def marks(net: Translator) -> tuple[int, int, int]:
    """Start, end and padding of the text."""
    return net.sizes.target - 3, net.sizes.target - 2, net.sizes.target - 1


def read(net: Translator, tokens: Tensor) -> Source:
    return net.read(tokens, tokens != net.sizes.source - 1)


@pytest.mark.parametrize("path", CASES)
def test_golden_logits_and_losses(path) -> None:
    a, net = opened(path)
    begin, _, pad = marks(net)
    tokens, words = a["m_tokens"], a["word_ids"]
    assert net.sizes.tied
    assert (words[:, 0] == begin).all()
    close(places(100, net.sizes.width), a["positional_encoding"], 1e-5)
    source = read(net, tokens)
    assert torch.equal(source.there[:, None], a["src_mask"].bool())
    close(source.encoded, a["enc_output"], LOGITS)
    before, gold = words[:, :-1], words[:, 1:]
    logits = net(source, before, before != pad)
    close(logits, a["logits"], LOGITS)
    for name, smoothing in (("plain", 0.0), ("smooth", 0.1)):
        found = text_loss(logits, gold, pad, smoothing)
        torch.testing.assert_close(found, a[f"loss_{name}_sum"], rtol=LOSS, atol=0)
    right, count = correct(logits, gold, pad)
    assert (right, count) == (int(a["n_correct"]), int(a["n_word"]))
    shares = torch.nn.functional.one_hot(tokens, net.sizes.source).float()
    by_length = torch.arange(tokens.shape[1]) < (a["m_lens"] + 2)[:, None]
    for name, there in (("srcmask", source.there), ("srclens", by_length)):
        soft = net(net.read_shares(shares, there), before, before != pad)
        close(soft, a[f"logits_onehot_input_{name}"], LOGITS)


@pytest.mark.parametrize("path", CASES)
def test_golden_gradients(path) -> None:
    a, net = opened(path)
    pad = marks(net)[2]
    before, gold = a["word_ids"][:, :-1], a["word_ids"][:, 1:]
    text_loss(net(read(net, a["m_tokens"]), before, before != pad), gold, pad).backward()
    ours = dict(net.named_parameters())
    stated = [name for name in a if name.startswith("gradnorm.") and "w_ks.bias" not in name]
    assert len(stated) > 50
    for name in stated:
        gradient = ours[our_name(name.removeprefix("gradnorm."))].grad
        assert gradient is not None
        torch.testing.assert_close(gradient.norm(), a[name], rtol=1e-4, atol=1e-5, msg=name)
    for name, parameter in (("trg_word_emb", net.decoder.embed.weight), ("src_word_emb", net.encoder.embed.weight)):
        assert parameter.grad is not None
        close(parameter.grad, a[f"grad_{name}"], 1e-4 * float(a[f"grad_{name}"].abs().max()), name)


@pytest.mark.parametrize("path", CASES)
def test_golden_decoder_of_vectors(path) -> None:
    a, net = opened(path, "V3")
    there = torch.arange(a["V3_word_emb"].shape[1] - 1) < a["V3_trg_lens"][:, None]
    logits = net(read(net, a["m_tokens"]), a["V3_word_emb"][:, :-1], there)
    close(logits, a["V3_logits"], LOGITS)


@pytest.mark.parametrize("path", CASES)
def test_golden_beam_search(path) -> None:
    a, net = opened(path)
    names = [name.removesuffix("_result") for name in a if name.endswith("_result")]
    assert len(names) >= 10
    for name in names:
        beams, item = int(name[4]), int(name.rpartition("item")[2])
        found = beam_search(net.steps(read(net, a["m_tokens"][[item]]).repeated(beams)), *marks(net), beams, 30)
        assert found.result == a[f"{name}_result"].tolist(), name
        assert torch.equal(found.beams, a[f"{name}_final_beams"]), name
        close(torch.stack(found.scores), a[f"{name}_scores_per_step"], LOGITS, name)


@pytest.mark.parametrize("path", CASES)
def test_golden_greedy_and_drawn_words(path) -> None:
    a, net = opened(path)
    for name in [name for name in a if name.startswith("greedy_item")]:
        tokens, _ = drawn(net, a["m_tokens"][[int(name[-1])]], None)
        expected = a[name]
        assert torch.equal(tokens[:, : expected.shape[1]], expected), name
    tokens, lengths = drawn(net, a["m_tokens"], a["sample_batch_top8_uniform"])
    assert lengths.tolist() == a["sample_batch_top8_len_map"][:, 0].tolist()
    expected = a["sample_batch_top8_tokens"]
    for row, length in enumerate(lengths.tolist()):
        np.testing.assert_array_equal(tokens[row, : length + 1], expected[row, : length + 1])


@torch.no_grad()
def drawn(net: Translator, motion: Tensor, uniform: Tensor | None) -> tuple[Tensor, Tensor]:
    """As `sampling.sample`, for words: ends where the end is the likeliest."""
    from engines.tm2t.sampling import pick

    begin, end, pad = marks(net)
    steps = net.steps(read(net, motion))
    rows = [torch.full((len(motion),), begin)]
    lengths = torch.full((len(motion),), 30)
    for at in range(30):
        logits = top_k(steps.step(rows[-1]), 8)
        ends = logits.argmax(-1) == end
        lengths = torch.where(ends & (lengths == 30), at, lengths)
        chances = logits.softmax(-1)
        chances[:, [begin, end, pad]] = 0
        last = chances.argmax(-1) if uniform is None else pick(chances, uniform[:, at])
        rows.append(torch.where(ends, end, last))
    return torch.stack(rows, 1), lengths
