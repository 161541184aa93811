"""The model's parts and ways: shapes, gradients, fused against frame by frame, sampling from a given start."""

from __future__ import annotations

import math

import pytest
import torch
from torch import Tensor

from engines.action2motion.config import DECODERS, PAPER, SMALL, Action2MotionConfig, preset
from engines.action2motion.model import GLMI, Action2Motion, DirectVelocity, Draws
from engines.action2motion.networks import sample_latent
from engines.action2motion.representation import local_positions
from engines.errors import CheckpointError, UnknownLabelError
from tests.engines.action2motion.tiny import config, model

T, B, J = 7, 4, 22
every_decoder = pytest.mark.parametrize("decoder", DECODERS)


def inputs(made: Action2Motion, frames: int = T, batch: int = B) -> tuple[Tensor, Tensor, Tensor, Tensor]:
    """Pose vectors, conditions, positions and noise, all at random."""
    generator = torch.Generator().manual_seed(5)
    sizes = made.config.pose_size, made.config.condition_size, made.config.latent_size
    vectors, conditions, noise = (0.5 * torch.randn(frames, batch, size, generator=generator) for size in sizes)
    return vectors, conditions, torch.randn(frames, batch, J, 3, generator=generator), noise


def stepped(made: Action2Motion, row: int, forced: bool) -> tuple[Tensor, Tensor, Tensor, Tensor]:
    """One sequence of the training pass, frame by frame: hidden, pose vectors, mu and logvar of the prior."""
    vectors, conditions, _, noise = (x[:, row : row + 1] for x in inputs(made))
    real = made.scaled(vectors)
    pose, states, frames = torch.zeros_like(real[0]), [None, None, None], []
    for now, known, eps in zip(real, conditions, noise, strict=True):
        mu_p, logvar_p, states[0] = made.prior.step(torch.cat([pose, known], dim=-1), states[0])
        mu_q, logvar_q, states[1] = made.posterior.step(torch.cat([now, known], dim=-1), states[1])
        z = sample_latent(mu_q, logvar_q, eps)
        hidden, states[2] = made.generator.step(torch.cat([pose, known, z], dim=-1), states[2])
        pose = now if forced else made.feed(hidden)
        frames.append((hidden, made.head(hidden), mu_p, logvar_p))
    hidden, poses, mu, logvar = (torch.stack(part) for part in zip(*frames, strict=True))
    return hidden, poses, mu, logvar


@every_decoder
def test_the_training_pass_equals_the_loop(decoder: str) -> None:
    made, forced = model(decoder), 2
    vectors, conditions, positions, noise = inputs(made)
    poses, (_, _, mu_p, logvar_p) = made.reconstruct(vectors, conditions, positions, Draws(noise, forced))
    for row in range(B):
        _, expected, mu, logvar = stepped(made, row, forced=row < forced)
        torch.testing.assert_close(poses.vectors[:, row : row + 1], expected, atol=1e-5, rtol=1e-4)
        torch.testing.assert_close(mu_p[:, row : row + 1], mu, atol=1e-5, rtol=1e-4)
        torch.testing.assert_close(logvar_p[:, row : row + 1], logvar, atol=1e-5, rtol=1e-4)


def partly(made: Action2Motion, noise: Tensor, own: Tensor, pose: float = 0.0) -> Draws:
    generator = torch.Generator().manual_seed(9)
    shifts = pose * torch.randn(T, B, made.config.pose_size, generator=generator)
    return Draws(noise, own=own, pose=shifts, prior=torch.randn(noise.shape, generator=generator)[:, : B // 2])


@every_decoder
@pytest.mark.parametrize("rounds", [1, 2])
def test_poses_fed_in_rounds(decoder: str, rounds: int) -> None:
    """n rounds make the first n + 1 frames those of the loop, where latents are the posterior's."""
    made = model(decoder, feed_rounds=rounds)
    vectors, conditions, positions, noise = inputs(made)
    all_own = torch.ones(T, B, dtype=torch.bool)
    by_rounds, _ = made.reconstruct(vectors, conditions, positions, partly(made, noise, all_own))
    by_loop, _ = made.reconstruct(vectors, conditions, positions, Draws(noise, forced=0))
    half = B // 2
    frames = rounds + 1  # each round makes one more frame of the chain its own
    torch.testing.assert_close(by_rounds.vectors[:frames, half:], by_loop.vectors[:frames, half:], atol=1e-5, rtol=1e-4)
    assert (by_rounds.vectors[frames:, half:] - by_loop.vectors[frames:, half:]).abs().max() > 1e-4
    assert (by_rounds.vectors[1:, :half] - by_loop.vectors[1:, :half]).abs().max() > 1e-4, "latents of the prior"


@every_decoder
def test_nothing_of_its_own_and_no_noise_is_teacher_forcing(decoder: str) -> None:
    made = model(decoder, feed_rounds=1)
    vectors, conditions, positions, noise = inputs(made)
    none_own = torch.zeros(T, B, dtype=torch.bool)
    partly_fed, gaussians = made.reconstruct(vectors, conditions, positions, partly(made, noise, none_own))
    forced, expected = made.reconstruct(vectors, conditions, positions, Draws(noise, forced=B))
    torch.testing.assert_close(partly_fed.vectors, forced.vectors)
    for ours, theirs in zip(gaussians, expected, strict=True):
        torch.testing.assert_close(ours, theirs)
    noisy, _ = made.reconstruct(vectors, conditions, positions, partly(made, noise, none_own, pose=0.3))
    torch.testing.assert_close(noisy.vectors[0], forced.vectors[0])
    assert (noisy.vectors[1:] - forced.vectors[1:]).abs().max() > 1e-3


@every_decoder
@pytest.mark.parametrize("rounds", [0, 1])
def test_gradients_reach_every_parameter(decoder: str, rounds: int) -> None:
    made = model(decoder, feed_rounds=rounds)
    vectors, conditions, positions, noise = inputs(made)
    mixed = torch.rand(T, B, generator=torch.Generator().manual_seed(1)) < 0.5
    given = partly(made, noise, mixed, pose=0.1) if rounds else Draws(noise, forced=2)
    poses, gaussians = made.reconstruct(vectors, conditions, positions, given)
    assert poses.positions.shape == (T, B, J, 3)
    assert poses.velocity.shape == (T, B, 3)
    assert poses.vectors.shape == (T, B, made.config.pose_size)
    assert (poses.matrices is None) == (decoder == "plain")
    assert all(part.shape == (T, B, made.config.latent_size) for part in gaussians)
    total = poses.positions.square().sum() + poses.velocity.square().sum() + sum(g.square().sum() for g in gaussians)
    total.backward()
    for name, parameter in made.named_parameters():
        assert parameter.grad is not None, name
        assert parameter.grad.abs().max() > 0, name


@pytest.mark.parametrize("decoder", ["glmi-m", "glmi-r"])
def test_glmi_sees_both_poses_and_what_comes_from_upstream(decoder: str) -> None:
    made = model(decoder).velocity
    assert isinstance(made, GLMI)
    hidden, now, before = torch.randn(T, B, 16), torch.randn(T, B, J, 3), torch.randn(T, B, J, 3)
    for part in (hidden, now, before):
        part.requires_grad_()
    velocity = made(hidden, now, before)
    assert velocity.shape == (T, B, 3)
    gradients = torch.autograd.grad(velocity[3].sum(), (hidden, now, before))
    for gradient in gradients:
        assert gradient[3].abs().max() > 0
        assert gradient[4:].abs().max() == 0
        assert (gradient[:3].abs().max() > 0) == (decoder == "glmi-r"), "the GRU remembers, the MLP does not"


def test_glmi_as_written_in_the_equation() -> None:
    """V_t = f(p_t, p_(t-1), h°), h° a linear view of the generator's hidden vector, f one hidden layer."""
    glmi = model("glmi-m").velocity
    hidden, now, before = torch.randn(T, B, 16), torch.randn(T, B, J, 3), torch.randn(T, B, J, 3)
    inner, _ = glmi.mix
    joined = torch.cat([now.reshape(T, B, -1), before.reshape(T, B, -1), glmi.upstream(hidden)], dim=-1)
    value = joined @ inner.weight.T + inner.bias
    expected = torch.where(value > 0, value, 0.2 * value) @ glmi.output.weight.T + glmi.output.bias
    torch.testing.assert_close(glmi(hidden, now, before), expected)


@pytest.mark.parametrize("decoder", ["plain", "lie"])
def test_the_direct_velocity_looks_at_no_pose(decoder: str) -> None:
    made = model(decoder)
    assert isinstance(made.velocity, DirectVelocity)
    hidden = torch.randn(T, B, 16)
    one, other = (made.velocity(hidden, torch.randn(T, B, J, 3), torch.randn(T, B, J, 3)) for _ in range(2))
    assert torch.equal(one, other)


def test_decode_takes_the_real_pose_before_for_forced_rows() -> None:
    made, hidden = model("glmi-m"), torch.randn(T, B, 16)
    real = torch.randn(T, 2, J, 3)
    free, led = made.decode(hidden), made.decode(hidden, real)
    assert torch.equal(free.velocity[:, 2:], led.velocity[:, 2:])
    before = torch.cat([real, torch.cat([free.positions[:1], free.positions[:-1]])[:, 2:]], dim=1)
    expected = made.velocity(hidden, free.positions, before) * made.velocity_std
    torch.testing.assert_close(led.velocity, expected)
    assert (led.velocity[:, :2] - free.velocity[:, :2]).abs().max() > 1e-4


@every_decoder
def test_lie_parameters_are_bounded(decoder: str) -> None:
    made = model(decoder)
    vectors = made.head(100 * torch.randn(T, B, 16))
    if decoder == "plain":
        assert vectors.abs().max() > math.pi
    else:
        assert vectors[..., 1:].abs().max() <= math.pi
        lie = vectors[..., 1:].unflatten(-1, (J, 3))
        torch.testing.assert_close(
            made.decode(torch.zeros(1, 1, 16)).positions[0, 0, 0, 1], made.head(torch.zeros(16))[0]
        )
        torch.testing.assert_close(local_positions(vectors[..., :1], lie)[0][..., 0, 1], vectors[..., 0])


@every_decoder
def test_a_sample_replays_from_its_latents(decoder: str) -> None:
    made = model(decoder)
    _, conditions, _, noise = inputs(made)
    with torch.inference_mode():
        hidden, latents = made.sample(conditions, noise)
        torch.testing.assert_close(made.replay(conditions, latents), hidden, atol=1e-5, rtol=1e-4)
        one, _ = made.sample(conditions[:, :1], noise[:, :1])
        torch.testing.assert_close(one, hidden[:, :1], atol=1e-5, rtol=1e-4)
        shown = made.head(hidden[:2])
        led, drawn = made.sample(conditions, noise, shown)
        torch.testing.assert_close(made.replay(conditions, drawn, shown), led, atol=1e-5, rtol=1e-4)
    assert latents.shape == noise.shape


@every_decoder
@pytest.mark.parametrize("kept", [1, 3, T - 1])
def test_a_given_start_is_what_teacher_forcing_sees(decoder: str, kept: int) -> None:
    """The start's hidden vectors are those of a fused pass over the real poses with the posterior's means."""
    made = model(decoder)
    vectors, conditions, positions, noise = inputs(made)
    with torch.inference_mode():
        hidden, latents = made.sample(conditions, noise, vectors[:kept])
        silent = torch.zeros_like(noise[:kept])
        led, (mu_q, *_) = made.reconstruct(vectors[:kept], conditions[:kept], positions[:kept], Draws(silent, forced=B))
        torch.testing.assert_close(made.head(hidden[:kept]), led.vectors, atol=1e-5, rtol=1e-4)
        torch.testing.assert_close(latents[:kept], mu_q, atol=1e-5, rtol=1e-4)
        poses = made.decode(hidden, given=vectors[:kept])
    assert torch.equal(poses.vectors[:kept], vectors[:kept])
    assert hidden.shape == (T, B, 16)


def test_presets_and_their_json() -> None:
    assert preset("paper") is PAPER
    assert preset("small") is SMALL
    assert (PAPER.embed_size, PAPER.latent_size, PAPER.generator_layers, PAPER.window) == (128, 30, 2, 60)
    with pytest.raises(UnknownLabelError, match="small"):
        preset("smal")
    for made in (PAPER, SMALL, config("glmi-r", extra={"step": 3})):
        assert Action2MotionConfig.from_json(made.to_json()) == made
    with pytest.raises(CheckpointError, match="colour"):
        Action2MotionConfig.from_json('{"colour": "red"}')
