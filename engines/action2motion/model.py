"""Action2Motion: a conditional temporal VAE with a learned prior (Guo et al. 2020; thesis section 3.2.1).

At each frame a latent is drawn, in training from the posterior, which sees the pose to come, in use from the prior,
which sees only what has been; the generator turns [previous pose, action, time counter, latent] into the next pose.
Four ways to decode a pose (thesis figure 3.4):

- `plain`: joint positions and root velocity straight from the hidden vector;
- `lie`: so(3) parameters, then forward kinematics; the root velocity straight from the hidden vector;
- `glmi-m`: as lie, but the velocity is inferred by an MLP from this local pose, the one before and h° (eq. 3.9);
- `glmi-r`: the same with a GRU in the MLP's place.

Only the generator has to run frame by frame, and only where it feeds itself: posterior, prior and teacher-forced rows
run in one fused call, forward kinematics and GLMI once over all frames.

Letters: T frames, B batch, J joints, D pose features, C conditions, Z latent, H hidden.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
from torch import Tensor, nn

from engines.action2motion.config import Action2MotionConfig
from engines.action2motion.networks import GaussianGRU, GeneratorGRU, rollout, sample_latent
from engines.action2motion.representation import VELOCITY_SIZE, local_positions


@dataclass(frozen=True)
class Poses:
    """Decoded frames of a batch."""

    vectors: Tensor
    """(T, B, D) pose as the networks are fed it."""
    positions: Tensor
    """(T, B, J, 3) joints in the heading frame, metres."""
    matrices: Tensor | None
    """(T, B, J, 3, 3) local rotations; None for the plain decoder, which has none."""
    velocity: Tensor
    """(T, B, 3) root velocity a frame."""


class PoseHead(nn.Module):
    """Hidden vector -> pose vector; Lie parameters are bounded by pi through two tanh, as in the released model."""

    def __init__(self, hidden_size: int, joints: int, lie: bool) -> None:
        super().__init__()
        self.lie = lie
        self.output = nn.Linear(hidden_size, 3 * joints + lie)
        self.output_lie = nn.Linear(3 * joints, 3 * joints) if lie else None

    def forward(self, hidden: Tensor) -> Tensor:
        """(..., H) -> (..., D): [height, so(3) of every joint], or positions."""
        raw = self.output(hidden)
        if self.output_lie is None:
            return raw
        angles = torch.tanh(self.output_lie(torch.tanh(raw[..., 1:]))) * math.pi
        return torch.cat([raw[..., :1], angles], dim=-1)


class DirectVelocity(nn.Module):
    """Root velocity straight from the generator, beside the pose (figure 3.4 a and b)."""

    def __init__(self, hidden_size: int) -> None:
        super().__init__()
        self.output = nn.Linear(hidden_size, VELOCITY_SIZE)

    def forward(self, hidden: Tensor, positions: Tensor, before: Tensor) -> Tensor:
        """Hidden (T, B, H) -> velocity (T, B, 3); the poses are not looked at."""
        return self.output(hidden)


class GLMI(nn.Module):
    """Global and local movement integration (eq. 3.9): velocity = f(this local pose, the one before, h°)."""

    def __init__(self, hidden_size: int, joints: int, movement_size: int, recurrent: bool) -> None:
        super().__init__()
        self.upstream = nn.Linear(hidden_size, movement_size)
        inputs, width = 6 * joints + movement_size, 128
        self.mix = nn.GRU(inputs, width) if recurrent else nn.Sequential(nn.Linear(inputs, width), nn.LeakyReLU(0.2))
        self.output = nn.Linear(width, VELOCITY_SIZE)

    def forward(self, hidden: Tensor, positions: Tensor, before: Tensor) -> Tensor:
        """Hidden (T, B, H), positions and those a frame before (T, B, J, 3) -> velocity (T, B, 3)."""
        joined = torch.cat([positions.flatten(-2), before.flatten(-2), self.upstream(hidden)], dim=-1)
        mixed = self.mix(joined)
        return self.output(mixed[0] if isinstance(mixed, tuple) else mixed)


class Action2Motion(nn.Module):
    """The whole model; see the module's docstring."""

    pose_mean: Tensor
    pose_std: Tensor
    velocity_std: Tensor

    def __init__(self, config: Action2MotionConfig) -> None:
        super().__init__()
        self.config = config
        pose, condition, latent = config.pose_size, config.condition_size, config.latent_size
        size, wide = config.embed_size, config.generator_size
        self.prior = GaussianGRU(pose + condition, latent, size, config.prior_layers)
        self.posterior = GaussianGRU(pose + condition, latent, size, config.posterior_layers)
        self.generator = GeneratorGRU(pose + condition + latent, wide, config.generator_layers)
        self.head = PoseHead(wide, config.joints, lie=config.decoder != "plain")
        if config.decoder.startswith("glmi"):
            self.velocity = GLMI(wide, config.joints, config.movement_size, recurrent=config.decoder == "glmi-r")
        else:
            self.velocity = DirectVelocity(wide)
        self.register_buffer("pose_mean", torch.zeros(pose))
        self.register_buffer("pose_std", torch.ones(pose))
        self.register_buffer("velocity_std", torch.ones(VELOCITY_SIZE))

    def scaled(self, vectors: Tensor) -> Tensor:
        """Pose vectors (..., D) as the networks take them in."""
        return (vectors - self.pose_mean) / self.pose_std

    def feed(self, hidden: Tensor) -> Tensor:
        """Hidden (B, H) -> the next frame's previous pose, scaled (B, D)."""
        return self.scaled(self.head(hidden))

    def decode(self, hidden: Tensor, real_before: Tensor | None = None, given: Tensor | None = None) -> Poses:
        """All frames at once: hidden (T, B, H) -> poses and velocity.

        Args:
            hidden: of the generator.
            real_before: (T, B', J, 3) real positions a frame before, for the first B' rows (teacher forcing).
            given: (K, B, D) first poses that stand as they are (outpainting).
        """
        vectors = self.head(hidden)
        if given is not None:
            vectors = torch.cat([given, vectors[len(given) :]])
        if self.config.decoder == "plain":
            positions, matrices = vectors.unflatten(-1, (self.config.joints, 3)), None
        else:
            lie = vectors[..., 1:].unflatten(-1, (self.config.joints, 3))
            positions, matrices = local_positions(vectors[..., :1], lie)
        before = torch.cat([positions[:1], positions[:-1]])
        if real_before is not None:
            before = torch.cat([real_before, before[:, real_before.shape[1] :]], dim=1)
        return Poses(vectors, positions, matrices, self.velocity(hidden, positions, before) * self.velocity_std)

    def reconstruct(  # noqa: PLR0913, PLR0917 - what is shown, and how the rows are led
        self, vectors: Tensor, conditions: Tensor, real_positions: Tensor, forced: int, noise: Tensor, closed: int = 0
    ) -> tuple[Poses, tuple[Tensor, Tensor, Tensor, Tensor]]:
        """One pass of training.

        Args:
            vectors: (T, B, D) real poses, unscaled.
            conditions: (T, B, C).
            real_positions: (T, B, J, 3), for the velocity of teacher-forced rows.
            forced: the first so many rows are teacher-forced.
            noise: (T, B, Z) of the draws.
            closed: the last so many rows run as in use: shown their first `config.lead` poses, they go on alone with
                latents of the prior. The rows between feed themselves with latents of the posterior.

        Returns:
            Poses (T, B, ...), and the Gaussians (mu_q, logvar_q, mu_p, logvar_p), each (T, B - closed, Z).
        """
        shown = torch.cat([real_positions[:1], real_positions[:-1]])[:, :forced]
        if not closed:
            hidden, gaussians = self._with_posterior(vectors, conditions, forced, noise)
            return self.decode(hidden, shown), gaussians
        led = vectors.shape[1] - closed
        hidden, gaussians = self._with_posterior(vectors[:, :led], conditions[:, :led], forced, noise[:, :led])
        alone, _ = self.sample(conditions[:, led:], noise[:, led:], vectors[: self.config.lead, led:])
        return self.decode(torch.cat([hidden, alone], dim=1), shown), gaussians

    def _with_posterior(
        self, vectors: Tensor, conditions: Tensor, forced: int, noise: Tensor
    ) -> tuple[Tensor, tuple[Tensor, Tensor, Tensor, Tensor]]:
        """Hidden (T, B, H) of rows whose latents the posterior draws, teacher-forced or self-fed, and the Gaussians."""
        real = self.scaled(vectors)
        mu_q, logvar_q, _, _ = self.posterior(torch.cat([real, conditions], dim=-1))
        known = torch.cat([conditions, sample_latent(mu_q, logvar_q, noise)], dim=-1)
        before = torch.cat([torch.zeros_like(real[:1]), real[:-1]])
        if self.config.detached_feed:
            with torch.no_grad():
                own = self.generator.unroll(known[:, forced:], torch.zeros_like(real[0, forced:]), self.feed)[1]
            before = torch.cat([before[:, :forced], torch.cat([torch.zeros_like(own[:1]), own[:-1]])], dim=1)
            hidden = self.generator(torch.cat([before, known], dim=-1))[0]
        else:
            rows = torch.cat([before[:, :forced], known[:, :forced]], dim=-1)
            led = self.generator(rows)[0]
            free, own, _ = self.generator.unroll(known[:, forced:], torch.zeros_like(real[0, forced:]), self.feed)
            before = torch.cat([before[:, :forced], torch.cat([torch.zeros_like(own[:1]), own[:-1]])], dim=1)
            hidden = torch.cat([led, free], dim=1)
        mu_p, logvar_p, _, _ = self.prior(torch.cat([before, conditions], dim=-1))
        return hidden, (mu_q, logvar_q, mu_p, logvar_p)

    def sample(self, conditions: Tensor, noise: Tensor, given: Tensor | None = None) -> tuple[Tensor, Tensor]:
        """Draw from the prior, frame after frame.

        Args:
            conditions: (T, B, C).
            noise: (T, B, Z).
            given: (K, B, D) unscaled first poses that are kept as they are (outpainting); K < T. Their latents are
                the posterior's means, so that the state after them knows what was seen.

        Returns:
            hidden (T, B, H) of the generator and the latents (T, B, Z) that were drawn.
        """
        if given is None:
            first = torch.zeros_like(self.pose_mean).expand(conditions.shape[1], -1)
            drawn = rollout(self.prior, self.generator, self.feed, conditions, noise, first)
            return drawn.hidden, drawn.z
        kept, real = len(given), self.scaled(given)
        seen = conditions[:kept]
        latent = self.posterior(torch.cat([real, seen], dim=-1))[0]
        before = torch.cat([torch.zeros_like(real[:1]), real[:-1]])
        prior_state = self.prior(torch.cat([before, seen], dim=-1))[3]
        hidden, generator_state = self.generator(torch.cat([before, seen, latent], dim=-1))
        drawn = rollout(
            self.prior,
            self.generator,
            self.feed,
            conditions[kept:],
            noise[kept:],
            real[-1],
            prior_state,
            generator_state,
        )
        return torch.cat([hidden, drawn.hidden]), torch.cat([latent, drawn.z])

    def replay(self, conditions: Tensor, latents: Tensor) -> Tensor:
        """Hidden (T, B, H) of the generator for latents (T, B, Z) chosen beforehand (interpolation)."""
        first = torch.zeros_like(self.pose_mean).expand(conditions.shape[1], -1)
        return self.generator.unroll(torch.cat([conditions, latents], dim=-1), first, self.feed)[0]
