"""The frame-by-frame ways compute what the fused calls compute, gradients included."""

from __future__ import annotations

import pytest
import torch
from torch import Tensor, nn

from engines.action2motion.networks import (
    GaussianGRU,
    GeneratorGRU,
    LieHead,
    PlainHead,
    Rollout,
    rollout,
    sample_latent,
)

FRAMES, BATCH, CONDITION, LATENT, HIDDEN, JOINTS = 7, 3, 5, 4, 16, 6
POSE = 3 * JOINTS


@pytest.fixture(params=[1, 3], ids=["one layer", "three layers"])
def networks(request) -> tuple[GaussianGRU, GeneratorGRU, LieHead]:
    torch.manual_seed(request.param)
    prior = GaussianGRU(POSE + CONDITION, LATENT, HIDDEN, request.param).double()
    generator = GeneratorGRU(POSE + CONDITION + LATENT, HIDDEN, request.param).double()
    return prior, generator, LieHead(HIDDEN, JOINTS).double()


def draw(*shape: int) -> Tensor:
    return torch.randn(*shape, dtype=torch.float64)


def gradients(value: Tensor, modules: nn.Module) -> tuple[Tensor, ...]:
    return torch.autograd.grad(value.square().mean(), list(modules.parameters()), retain_graph=True)


def test_gaussian_steps_equal_the_fused_call(networks) -> None:
    prior, x = networks[0], draw(FRAMES, BATCH, POSE + CONDITION)
    mu, logvar, hidden, last = prior(x)
    state, steps = None, []
    for frame in x:
        *gaussian, state = prior.step(frame, state)
        steps.append((*gaussian, state[-1]))
    assert mu.shape == (FRAMES, BATCH, LATENT)
    for fused, parts in zip((mu, logvar, hidden), zip(*steps, strict=True), strict=True):
        torch.testing.assert_close(torch.stack(parts), fused)
        torch.testing.assert_close(gradients(torch.stack(parts), prior.gru), gradients(fused, prior.gru))
    torch.testing.assert_close(torch.stack(state), torch.stack(last))


def test_a_sequence_goes_on_from_its_state(networks) -> None:
    prior, generator, _ = networks
    for network in (prior, generator):
        x = draw(FRAMES, BATCH, network.input_size)
        whole = network.hidden_sequence(x)[0]
        first, state = network.hidden_sequence(x[:4])
        torch.testing.assert_close(torch.cat([first, network.hidden_sequence(x[4:], state)[0]]), whole)


def test_unroll_feeds_each_frame_with_the_one_before(networks) -> None:
    _, generator, head = networks
    known, first = draw(FRAMES, BATCH, CONDITION + LATENT), draw(BATCH, POSE)
    hidden, poses, last = generator.unroll(known, first, head)
    # given the same previous poses, the fused call must agree
    fed = torch.cat([first[None], poses[:-1]])
    again, state = generator(torch.cat([fed, known], dim=-1))
    torch.testing.assert_close(again, hidden)
    torch.testing.assert_close(head(hidden), poses)
    torch.testing.assert_close(torch.stack(state), torch.stack(last))


def test_unroll_carries_gradients_through_what_is_fed_back(networks) -> None:
    _, generator, head = networks
    known, first = draw(FRAMES, BATCH, CONDITION + LATENT), draw(BATCH, POSE)
    pose, state, steps = first, None, []
    for frame in known:
        hidden, state = generator.step(torch.cat([pose, frame], dim=-1), state)
        pose = head(hidden)
        steps.append(pose)
    poses = generator.unroll(known, first, head)[1]
    torch.testing.assert_close(poses, torch.stack(steps))
    torch.testing.assert_close(gradients(poses, generator), gradients(torch.stack(steps), generator))


def test_rollout_equals_single_steps(networks) -> None:
    prior, generator, head = networks
    condition, noise, first = draw(FRAMES, BATCH, CONDITION), draw(FRAMES, BATCH, LATENT), draw(BATCH, POSE)
    pose, upper, lower, steps = first, None, None, []
    for frame, eps in zip(condition, noise, strict=True):
        mu, logvar, upper = prior.step(torch.cat([pose, frame], dim=-1), upper)
        z = sample_latent(mu, logvar, eps)
        hidden, lower = generator.step(torch.cat([pose, frame, z], dim=-1), lower)
        pose = head(hidden)
        steps.append((pose, hidden, z, mu, logvar))
    made = rollout(prior, generator, head, condition, noise, first)
    names = ("poses", "hidden", "z", "mu", "logvar")
    for name, parts in zip(names, zip(*steps, strict=True), strict=True):
        torch.testing.assert_close(getattr(made, name), torch.stack(parts), msg=name)


def test_rollout_in_two_parts_equals_one(networks) -> None:
    condition, noise, first = draw(FRAMES, BATCH, CONDITION), draw(FRAMES, BATCH, LATENT), draw(BATCH, POSE)
    whole = rollout(*networks, condition, noise, first)
    start: Rollout = rollout(*networks, condition[:3], noise[:3], first)
    rest = rollout(*networks, condition[3:], noise[3:], start.poses[-1], start.prior_state, start.generator_state)
    torch.testing.assert_close(torch.cat([start.poses, rest.poses]), whole.poses)


def test_lie_head_bounds_the_angles_and_not_the_translation() -> None:
    head = LieHead(HIDDEN, JOINTS).double()
    out = head(draw(50, HIDDEN) * 1e4)
    assert out.shape == (50, POSE)
    assert out[:, 3:].abs().max() <= torch.pi
    assert out[:, :3].abs().max() > 10 * torch.pi
    assert PlainHead(HIDDEN, POSE)(torch.zeros(2, HIDDEN)).shape == (2, POSE)
