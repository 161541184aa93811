"""Transformer and attentive GRU: step by step as all at once, and padding that nobody hears."""

from __future__ import annotations

import pytest
import torch

from engines.tm2t.attentive import AttentiveGRU, GRUSizes, unroll
from engines.tm2t.packed import PackedGRU
from engines.tm2t.transformer import Sizes, Translator

SIZES = Sizes(source=9, target=7, width=16, inner=24, layers=2, heads=2, head_size=8)


def translator(**changes) -> Translator:
    torch.manual_seed(0)
    return Translator(Sizes(**{**vars(SIZES), **changes})).eval()


def gru(**changes) -> AttentiveGRU:
    torch.manual_seed(0)
    return AttentiveGRU(GRUSizes(**{"text": 5, "tokens": 7, "text_hidden": 4, "motion_hidden": 6, **changes})).eval()


@pytest.mark.parametrize("changes", [{}, {"tied": False}, {"source_vectors": True}])
def test_steps_with_what_is_kept_are_the_whole(changes) -> None:
    net = translator(**changes)
    torch.manual_seed(1)
    source = torch.randn(3, 5, 9) if net.sizes.source_vectors else torch.randint(9, (3, 5))
    targets = torch.randint(7, (3, 6))
    read = net.read(source, torch.arange(5) < torch.tensor([[5], [2], [4]]))
    whole = net(read, targets, torch.ones(3, 6, dtype=torch.bool))
    steps = net.steps(read)
    for at in range(6):
        torch.testing.assert_close(steps.step(targets[:, at]), whole[:, at], atol=1e-5, rtol=1e-4)


def test_rows_can_be_exchanged_while_decoding() -> None:
    net = translator()
    read = net.read(torch.tensor([[1, 2, 3]]), torch.ones(1, 3, dtype=torch.bool)).repeated(2)
    steps = net.steps(read)
    steps.step(torch.tensor([0, 1]))
    steps.choose(torch.tensor([1, 1]))
    after = steps.step(torch.tensor([4, 5]))
    whole = net(read, torch.tensor([[1, 4], [1, 5]]), torch.ones(2, 2, dtype=torch.bool))
    torch.testing.assert_close(after, whole[:, 1], atol=1e-5, rtol=1e-4)


def test_padding_of_the_source_is_not_heard() -> None:
    net = translator()
    short, there = torch.tensor([[1, 2]]), torch.tensor([[True, True]])
    long, some = torch.tensor([[1, 2, 8, 8]]), torch.tensor([[True, True, False, False]])
    targets, all_there = torch.tensor([[0, 3]]), torch.ones(1, 2, dtype=torch.bool)
    torch.testing.assert_close(
        net(net.read(short, there), targets, all_there), net(net.read(long, some), targets, all_there)
    )


def test_the_future_is_not_seen() -> None:
    net = translator()
    read = net.read(torch.tensor([[1, 2]]), torch.ones(1, 2, dtype=torch.bool))
    targets, there = torch.tensor([[0, 3, 4]]), torch.ones(1, 3, dtype=torch.bool)
    other = torch.tensor([[0, 3, 6]])
    assert torch.equal(net(read, targets, there)[:, :2], net(read, other, there)[:, :2])


def test_one_hot_shares_are_indices() -> None:
    net = translator()
    source, there = torch.tensor([[1, 2, 8]]), torch.tensor([[True, True, False]])
    shares = torch.nn.functional.one_hot(source, 9).float()
    targets, all_there = torch.tensor([[0, 3]]), torch.ones(1, 2, dtype=torch.bool)
    torch.testing.assert_close(
        net(net.read(source, there), targets, all_there), net(net.read_shares(shares, there), targets, all_there)
    )


@pytest.mark.parametrize("changes", [{}, {"late": True}, {"layers": 2}])
def test_a_sentence_alone_is_the_sentence_among_others(changes) -> None:
    net = gru(**changes)
    torch.manual_seed(2)
    words, lengths = torch.randn(3, 6, 5), torch.tensor([3, 6, 4])
    tokens = torch.randint(7, (3, 4))
    whole = unroll(net, net.read(words, lengths), tokens, True)
    for row, length in enumerate(lengths.tolist()):
        alone = unroll(net, net.read(words[[row], :length], lengths[[row]]), tokens[[row]], True)
        torch.testing.assert_close(alone[0], whole[row], atol=1e-5, rtol=1e-4)


def test_attention_looks_at_words_that_are_there() -> None:
    net = gru()
    steps = net.steps(net.read(torch.randn(2, 5, 5), torch.tensor([5, 2])))
    steps.step(torch.tensor([0, 0]))
    assert steps.weights is not None
    torch.testing.assert_close(steps.weights.sum(1), torch.ones(2))
    assert (steps.weights[1, 2:] == 0).all()
    assert (steps.weights[1, :2] > 0).all()


def test_fed_with_itself_it_hears_its_likeliest_token() -> None:
    net = gru()
    read, tokens = net.read(torch.randn(1, 3, 5), torch.tensor([3])), torch.tensor([[5, 0, 0]])
    free = unroll(net, read, tokens, False)
    own = torch.cat([tokens[:, :1], free.argmax(-1)[:, :-1]], 1)
    torch.testing.assert_close(unroll(net, read, own, True), free)


def test_a_share_of_a_token_is_the_token() -> None:
    net = gru()
    read = net.read(torch.randn(2, 3, 5), torch.tensor([3, 2]))
    tokens = torch.tensor([4, 1])
    shares = torch.nn.functional.one_hot(tokens, 7).float()
    torch.testing.assert_close(net.steps(read).step_shares(shares), net.steps(read).step(tokens))


@pytest.mark.parametrize("layers", [1, 2])
def test_packed_says_the_same(layers: int) -> None:
    net = gru(layers=layers).requires_grad_(False)
    read = net.read(torch.randn(3, 5, 5), torch.tensor([5, 2, 4]))
    plain, packed = net.steps(read), PackedGRU(net).steps(read)
    half = PackedGRU(net, torch.bfloat16).steps(read)
    for tokens in torch.randint(7, (5, 3)):
        expected = plain.step(tokens)
        torch.testing.assert_close(packed.step(tokens), expected, atol=1e-5, rtol=1e-4)
        torch.testing.assert_close(packed.weights, plain.weights, atol=1e-5, rtol=1e-4)
        torch.testing.assert_close(half.step(tokens), expected, atol=3e-2, rtol=3e-2)
