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
from engines.action2motion.networks import GaussianGRU, GeneratorGRU, State, rollout, sample_latent
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


@dataclass(frozen=True)
class Draws:
    """Everything random in one pass of training."""

    latent: Tensor
    """(T, B, Z) standard normal, for the posterior's latents."""
    forced: int = 0
    """The first so many sequences are teacher-forced."""
    own: Tensor | None = None
    """(T, B) where the model is fed its own pose; None: whole sequences, those that are not `forced`."""
    pose: Tensor | None = None
    """With `own`: (T, B, D) added to the fed poses."""
    prior: Tensor | None = None
    """With `own`: (T, B', Z) standard normal, for the prior's latents, which the first B' sequences take."""


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

    def joints(self, vectors: Tensor) -> tuple[Tensor, Tensor | None]:
        """Pose vectors (..., D) -> joints (..., J, 3) in the heading frame and local rotations (..., J, 3, 3)."""
        if self.config.decoder == "plain":
            return vectors.unflatten(-1, (self.config.joints, 3)), None
        return local_positions(vectors[..., :1], vectors[..., 1:].unflatten(-1, (self.config.joints, 3)))

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
        positions, matrices = self.joints(vectors)
        before = torch.cat([positions[:1], positions[:-1]])
        if real_before is not None:
            before = torch.cat([real_before, before[:, real_before.shape[1] :]], dim=1)
        return Poses(vectors, positions, matrices, self.velocity(hidden, positions, before) * self.velocity_std)

    def reconstruct(
        self, vectors: Tensor, conditions: Tensor, real_positions: Tensor, draws: Draws
    ) -> tuple[Poses, tuple[Tensor, Tensor, Tensor, Tensor]]:
        """One pass of training, with latents of the posterior.

        Args:
            vectors: (T, B, D) real poses, unscaled.
            conditions: (T, B, C).
            real_positions: (T, B, J, 3), for the velocity of teacher-forced sequences.
            draws: everything random.

        Returns:
            Poses (T, B, ...), and the Gaussians (mu_q, logvar_q, mu_p, logvar_p), each (T, B, Z).
        """
        real = self.scaled(vectors)
        mu_q, logvar_q, _, _ = self.posterior(torch.cat([real, conditions], dim=-1))
        known = torch.cat([conditions, sample_latent(mu_q, logvar_q, draws.latent)], dim=-1)
        if draws.own is None:
            before, hidden = self._self_fed(real, known, draws.forced)
            shown = _a_frame_later(real_positions)[:, : draws.forced]
        else:
            before = self._partly_own(real, known, draws)
            hidden, shown = self.generator(torch.cat([before, known], dim=-1))[0], None
        mu_p, logvar_p, _, _ = self.prior(torch.cat([before, conditions], dim=-1))
        with torch.autocast(hidden.device.type, enabled=False):  # angles in bfloat16 would be most of a degree off
            poses = self.decode(hidden.float(), shown)
        return poses, (mu_q.float(), logvar_q.float(), mu_p.float(), logvar_p.float())

    def _self_fed(self, real: Tensor, known: Tensor, forced: int) -> tuple[Tensor, Tensor]:
        """Fed poses (T, B, D) and hidden (T, B, H): the first rows teacher-forced, the others fed with their own."""
        before = _a_frame_later(real)[:, :forced]
        led = self.generator(torch.cat([before, known[:, :forced]], dim=-1))[0]
        free, own, _ = self.generator.unroll(known[:, forced:], torch.zeros_like(real[0, forced:]), self.feed)
        return torch.cat([before, _a_frame_later(own)], dim=1), torch.cat([led, free], dim=1)

    @torch.no_grad()
    def _partly_own(self, real: Tensor, known: Tensor, draws: Draws) -> Tensor:
        """Fed poses (T, B, D): real ones with noise on them and, where `draws.own`, what the model makes of such.

        The first sequences take the latents for that from the prior, as in use: what the model makes there strays
        from the real motion, and the loss teaches it the way back. (Parallel scheduled sampling, Duckworth et al.
        2019, "Parallel Scheduled Sampling"; latents of the prior and noise are ours.)
        """
        assert draws.own is not None and draws.pose is not None and draws.prior is not None
        start = _a_frame_later(real)
        start[1:] += draws.pose[1:]
        conditions = known[..., : self.config.condition_size]
        mu, logvar, _, _ = self.prior(torch.cat([start, conditions], dim=-1))
        half = draws.prior.shape[1]
        drawn = sample_latent(mu[:, :half], logvar[:, :half], draws.prior)
        latent = torch.cat([drawn, known[:, half:, self.config.condition_size :]], dim=1)
        before = start
        for _ in range(self.config.feed_rounds):
            made = self.feed(self.generator(torch.cat([before, conditions, latent], dim=-1))[0])
            before = torch.where(draws.own[..., None], _a_frame_later(made), start)
        return before

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
        led = self._led(given, conditions)
        rest = len(given)
        drawn = rollout(
            self.prior,
            self.generator,
            self.feed,
            conditions[rest:],
            noise[rest:],
            self.scaled(given[-1]),
            led.prior_state,
            led.generator_state,
        )
        return torch.cat([led.hidden, drawn.hidden]), torch.cat([led.latent, drawn.z])

    def replay(self, conditions: Tensor, latents: Tensor, given: Tensor | None = None) -> Tensor:
        """Hidden (T, B, H) of the generator for latents (T, B, Z) chosen beforehand (interpolation).

        `given` is as in `sample`; the latents of its frames are not looked at.
        """
        known = torch.cat([conditions, latents], dim=-1)
        if given is None:
            first = torch.zeros_like(self.pose_mean).expand(conditions.shape[1], -1)
            return self.generator.unroll(known, first, self.feed)[0]
        led = self._led(given, conditions)
        rest = known[len(given) :]
        after = self.generator.unroll(rest, self.scaled(given[-1]), self.feed, led.generator_state)[0]
        return torch.cat([led.hidden, after])

    def _led(self, given: Tensor, conditions: Tensor) -> _Led:
        """The networks after they were shown poses (K, B, D)."""
        real, seen = self.scaled(given), conditions[: len(given)]
        latent = self.posterior(torch.cat([real, seen], dim=-1))[0]
        before = _a_frame_later(real)
        prior_state = self.prior(torch.cat([before, seen], dim=-1))[3]
        hidden, generator_state = self.generator(torch.cat([before, seen, latent], dim=-1))
        return _Led(hidden, latent, prior_state, generator_state)


@dataclass(frozen=True)
class _Led:
    """The networks after they were shown poses: hidden (K, B, H), latents (K, B, Z) and their states."""

    hidden: Tensor
    latent: Tensor
    prior_state: State
    generator_state: State


def _a_frame_later(values: Tensor) -> Tensor:
    """(T, ...) shifted by one frame, zeros first: what was there a frame before."""
    return torch.cat([torch.zeros_like(values[:1]), values[:-1]])
