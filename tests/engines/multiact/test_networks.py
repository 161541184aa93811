"""MACVAE's networks: padding changes nothing, the seam is seen, lengths are kept."""

from __future__ import annotations

import torch

from engines.multiact.networks import SEEN, Convolution, Postprocessor, around, held, sinusoids
from engines.multiact.representation import D
from engines.text2motion.losses import divergence
from engines.text2motion.networks import Gaussian
from tests.engines.multiact.tiny import model


def test_a_motion_is_the_same_in_any_batch() -> None:
    net = model()
    generator = torch.Generator().manual_seed(0)
    last = torch.randn(3, SEEN, D, generator=generator) * 0.05 + net.mean
    actions, frames = torch.tensor([0, 3, 1]), torch.tensor([[4, 30], [9, 12], [2, 20]])
    noise = torch.randn(3, 2, net.config.width, generator=generator)
    together = net.generate(last, actions, frames, noise)
    assert together.shape == (3, 34, D)
    for i in range(3):
        alone = net.generate(last[i : i + 1], actions[i : i + 1], frames[i : i + 1], noise[i : i + 1])
        torch.testing.assert_close(together[i, : alone.shape[1]], alone[0], atol=1e-5, rtol=1e-5)


def test_padding_does_not_reach_the_posterior() -> None:
    net = model()
    for head in net.encoder.heads.parameters():
        torch.nn.init.normal_(head)
    x = torch.randn(2, 40, D)
    labels = torch.randint(0, 3, (2, 40))
    frames = torch.tensor([40, 25])
    whole = net.encoder(x, labels, frames)
    alone = net.encoder(x[1:, :25], labels[1:, :25], frames[1:])
    assert whole[0].mean.abs().min() > 0
    for one, other in zip(whole, alone, strict=True):
        torch.testing.assert_close(one.mean[1:], other.mean, atol=1e-5, rtol=1e-4)


def test_latents_come_from_what_they_are_for() -> None:
    net = model()
    last = net.normalise(torch.randn(2, SEEN, D))
    here, there = net.prior(last, torch.tensor([0, 0])), net.prior(last, torch.tensor([3, 3]))
    assert torch.equal(here[0].mean, there[0].mean) and not torch.equal(here[1].mean, there[1].mean)
    assert torch.equal(here[1].mean[0], here[1].mean[1]) and not torch.equal(here[0].mean[0], here[0].mean[1])


def test_the_postprocessor_begins_as_no_change_and_then_looks_across_the_seam() -> None:
    net = Postprocessor(D)
    last, made, frames = torch.randn(1, SEEN, D), torch.randn(1, 9, D), torch.tensor([9])
    torch.testing.assert_close(net(last, made, frames), made)
    torch.nn.init.normal_(net.convolution.weight)
    other = net(last + 1, made, frames) - net(last, made, frames)
    assert other[0, :2].abs().min() > 0 and other[0, 2:].abs().max() == 0


def test_what_is_past_the_end_is_the_last_frame() -> None:
    x = torch.arange(10.0).view(1, 5, 2)
    assert torch.equal(held(x, torch.tensor([3]))[0, 2:], x[0, 2].expand(3, -1))
    layer = Convolution(2, 2)
    torch.testing.assert_close(layer(held(x, torch.tensor([3])))[:, :3], layer(x[:, :3]))


def test_positions_before_the_action_are_told_from_those_in_it() -> None:
    coded = sinusoids(torch.tensor([-2.0, 0.0, 2.0]), 8)
    assert coded.shape == (3, 8)
    assert not torch.allclose(coded[0], coded[2])
    torch.testing.assert_close(coded[1], torch.tensor([0.0] * 4 + [1.0] * 4))


def test_a_posterior_that_knows_nothing_is_the_prior_and_costs_nothing() -> None:
    prior = Gaussian(torch.randn(3, 8), torch.randn(3, 8))
    nothing = Gaussian(torch.zeros(3, 8), torch.zeros(3, 8))
    assert divergence(around(prior, nothing), prior).abs().max() < 1e-6
    away = Gaussian(torch.ones(3, 8), torch.zeros(3, 8))  # a deviation in each of eight directions
    torch.testing.assert_close(divergence(around(prior, away), prior), torch.full((3,), 4.0))
