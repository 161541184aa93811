"""The networks against what they are said to be: naive forms of the same, one motion beside many."""

from __future__ import annotations

import math

import pytest
import torch

from engines.text2motion.losses import divergence
from engines.text2motion.model import Sizes, TemporalVAE, generate, unroll
from engines.text2motion.networks import Gaussian, SnippetDecoder, SnippetEncoder, WordReader, time_to_arrival
from engines.text2motion.packed import PackedVAE
from tests.engines.text2motion.tiny import model

SIZES = Sizes(word=6, tags=3, text_hidden=5, attention=8, latent=4, latent_hidden=10, motion_hidden=12, code=7)


def vae(**changes) -> TemporalVAE:
    torch.manual_seed(1)
    return TemporalVAE(Sizes(**{**vars(SIZES), **changes})).eval().requires_grad_(False)


def sentences(lengths: list[int], seed: int = 0) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    generator = torch.Generator().manual_seed(seed)
    size = (len(lengths), max(lengths))
    return torch.randn(*size, 6, generator=generator), torch.rand(*size, 3, generator=generator), torch.tensor(lengths)


def test_a_code_sees_ten_frames_and_makes_four() -> None:
    encoder, decoder = SnippetEncoder(5, 9, 7).eval(), SnippetDecoder(7, 9, 6)
    features = torch.randn(1, 40, 5, requires_grad=True)
    codes = encoder(features)
    assert codes.shape == (1, 10, 7)
    codes[0, 4].sum().backward()
    assert features.grad is not None
    seen = features.grad[0].abs().sum(-1).nonzero().flatten().tolist()
    assert seen == list(range(13, 23))
    assert decoder(codes).shape == (1, 40, 6)


def test_a_row_is_encoded_and_decoded_as_if_it_were_alone() -> None:
    encoder, decoder = SnippetEncoder(5, 9, 7).eval(), SnippetDecoder(7, 9, 6)
    features, count = torch.randn(3, 24, 5), torch.tensor([6, 2, 4])
    codes = encoder(features, count)
    made = decoder(codes, count)
    for row, n in enumerate(count.tolist()):
        alone = encoder(features[row : row + 1, : 4 * n])
        torch.testing.assert_close(codes[row, :n], alone[0])
        torch.testing.assert_close(made[row, : 4 * n], decoder(alone)[0])


def test_sentences_are_read_in_both_directions() -> None:
    torch.manual_seed(0)
    reader = WordReader(6, 3, 5).eval()
    vectors, tags, lengths = sentences([4, 2])
    read = reader(vectors, tags, lengths)
    told = reader.input(vectors + reader.tag(tags))
    for row, n in enumerate(lengths.tolist()):
        for direction, order in ((0, range(n)), (1, range(n - 1, -1, -1))):
            cell = torch.nn.GRUCell(5, 5)
            ending = "_reverse" * direction
            cell.load_state_dict({
                f"{kind}_{side}": getattr(reader.gru, f"{kind}_{side}_l0{ending}")
                for kind in ("weight", "bias") for side in ("ih", "hh")
            })  # fmt: skip
            state = reader.start[direction]
            for at in order:
                state = cell(told[row : row + 1, at], state)
                torch.testing.assert_close(read.words[row, at, 5 * direction :][:5], state[0])
            torch.testing.assert_close(read.sentence[row, 5 * direction :][:5], state[0])
    assert read.there.tolist() == [[True] * 4, [True, True, False, False]]


def test_time_to_arrival_is_equation_5() -> None:
    made = time_to_arrival(torch.tensor([3, 50]), 8)
    for row, left in zip(made, (3, 50), strict=True):
        for i in range(4):
            angle = left / 10_000 ** (2 * i / 8)
            assert row[2 * i].item() == pytest.approx(math.sin(angle), abs=1e-6)
            assert row[2 * i + 1].item() == pytest.approx(math.cos(angle), abs=1e-6)


def test_divergence_is_that_of_torch() -> None:
    first, second = (Gaussian(torch.randn(3, 4), torch.randn(3, 4)) for _ in range(2))
    normal = [torch.distributions.Normal(one.mean, (0.5 * one.logvar).exp()) for one in (first, second)]
    expected = torch.distributions.kl_divergence(*normal).sum(-1)
    torch.testing.assert_close(divergence(first, second), expected)
    assert divergence(first, first).abs().max() < 1e-6


@pytest.mark.parametrize("changes", [{}, {"attention": 0}, {"position": False}, {"tags": 0}])
def test_packed_steps_say_the_same(changes: dict) -> None:
    net = vae(**changes)
    lengths = torch.tensor([5, 3, 4])
    read = net.reader(*sentences([4, 7, 2]))
    noise, start = torch.randn(3, 5, 4), torch.randn(3, 7)
    heat: list[torch.Tensor] = []
    packed_heat: list[torch.Tensor] = []
    plain = generate(net.steps(read, lengths), start, noise, heat)
    packed = generate(PackedVAE(net).steps(read, lengths, 5), start, noise, packed_heat)
    torch.testing.assert_close(packed, plain, atol=1e-5, rtol=1e-5)
    assert len(heat) == len(packed_heat) == (0 if "attention" in changes else 5)
    for one, other in zip(heat, packed_heat, strict=True):
        torch.testing.assert_close(one, other, atol=1e-5, rtol=1e-5)


def test_a_motion_does_not_depend_on_those_beside_it() -> None:
    net = vae()
    words, tags, counts = sentences([4, 7, 2])
    lengths, noise, start = torch.tensor([5, 3, 4]), torch.randn(3, 5, 4), torch.randn(3, 7)
    many = generate(net.steps(net.reader(words, tags, counts), lengths), start, noise)
    for row in range(3):
        one = slice(row, row + 1)
        read = net.reader(words[one, : counts[row]], tags[one, : counts[row]], counts[one])
        alone = generate(net.steps(read, lengths[one]), start[one], noise[one, : lengths[row]])
        torch.testing.assert_close(alone[0], many[row, : lengths[row]], atol=1e-5, rtol=1e-5)


def test_what_is_fed_and_what_is_drawn() -> None:
    net = vae()
    read, lengths = net.reader(*sentences([4, 4])), torch.tensor([5, 5])
    real, start, noise = torch.randn(2, 5, 7), torch.randn(2, 7), torch.randn(2, 5, 4)
    coins = torch.tensor([True, False])
    both = unroll(net, read, real, lengths, start, noise, coins)
    for row, coin in enumerate(coins.tolist()):
        alone = unroll(net, read, real, lengths, start, noise, torch.full((2,), coin))
        torch.testing.assert_close(both.codes[row], alone.codes[row])
    assert (both.codes[0, 1:] - unroll(net, read, real, lengths, start, noise, ~coins).codes[0, 1:]).abs().max() > 1e-4
    # fed with its own codes and drawn from the prior, it is generation
    free = unroll(net, read, real, lengths, start, noise, torch.zeros(2, dtype=torch.bool), from_prior=True)
    torch.testing.assert_close(free.codes, generate(net.steps(read, lengths), start, noise))


def test_attention_is_told_which_words_are_there() -> None:
    net = vae()
    assert net.attention is not None
    read = net.reader(*sentences([4, 2]))
    _, weights = net.attention(torch.randn(2, 12), net.attention.hold(read))
    torch.testing.assert_close(weights.sum(-1), torch.ones(2))
    assert (weights[1, 2:] == 0).all()


def test_the_start_is_the_mean_pose() -> None:
    net = model()
    still = net.mean.expand(1, 4, -1)
    torch.testing.assert_close(net.start(1), net.encode(net.normalised(still))[:, 0])
    frames = model(snippet_codes=False)
    assert frames.autoencoder is None
    torch.testing.assert_close(frames.denormalised(frames.start(1))[0], frames.mean)
