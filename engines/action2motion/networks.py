"""The recurrent networks of Action2Motion: Gaussian prior and posterior, generator, and the heads behind it.

Source: Guo et al. 2020, "Action2Motion", appendix table 3; thesis section 3.2.1, equations 3.7 and 3.8. Each network
is a linear embedding, a stack of GRU layers and linear outputs. The weights live in `nn.GRU`: whole sequences whose
inputs are all known (posterior, prior in training, teacher forcing) run in one fused call; where a frame needs the
frame before it, `step` and `unroll` use the very same parameters one frame at a time.

Letters: T frames, B batch, D input size, H hidden size, Z latent size, L layers.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import torch
from jaxtyping import Float
from torch import Tensor, nn

State = tuple[Float[Tensor, "B _H"], ...]
"""Hidden state of a GRU stack: one (B, H) tensor a layer (each network has its own H). `None` stands for zeros."""


class EmbeddedGRU(nn.Module):
    """Linear embedding and a stack of GRU layers, no nonlinearity between them.

    Args:
        input_size: D, features of one frame.
        hidden_size: H, of the embedding and of every layer.
        layers: L, number of stacked GRU layers.
    """

    def __init__(self, input_size: int, hidden_size: int, layers: int) -> None:
        super().__init__()
        self.input_size, self.hidden_size, self.layers = input_size, hidden_size, layers
        self.embed = nn.Linear(input_size, hidden_size)
        self.gru = nn.GRU(hidden_size, hidden_size, layers)

    def initial_state(self, batch: int) -> State:
        """Zeros for `batch` sequences: L tensors (B, H)."""
        return (self.embed.weight.new_zeros(batch, self.hidden_size),) * self.layers

    def hidden_sequence(
        self, x: Float[Tensor, "T B D"], state: State | None = None
    ) -> tuple[Float[Tensor, "T B H"], State]:
        """All frames (T, B, D) in one fused call -> top-layer hidden (T, B, H) and the state after the last."""
        start = None if state is None else torch.stack(state)  # L of (B, H) -> (L, B, H)
        hidden, last = self.gru(self.embed(x), start)
        return hidden, last.unbind(0)

    def folded_weights(self) -> list[Sequence[Tensor]]:
        """`nn.GRU.all_weights` with the embedding multiplied into the first layer, which then takes raw frames (B, D).

        Spares the larger part of a product a frame; differentiable. Worth it for a loop over several frames.
        """
        first, *others = self.gru.all_weights
        weight_ih, weight_hh, bias_ih, bias_hh = first
        bias = torch.addmv(bias_ih, weight_ih, self.embed.bias)
        return [(weight_ih @ self.embed.weight, weight_hh, bias, bias_hh), *others]

    def hidden_step(self, x: Float[Tensor, "B D"], state: State | None = None) -> State:
        """One frame (B, D) -> the new state; its last entry is the top-layer hidden (B, H)."""
        state = self.initial_state(len(x)) if state is None else state
        return stack_step(self.embed(x), state, self.gru.all_weights)


def stack_step(value: Float[Tensor, "B D"], state: State, weights: Sequence[Sequence[Tensor]]) -> State:
    """One frame through a stack of GRU layers -> the new state.

    `torch.gru_cell` on the parameters of `nn.GRU` is within a few per cent of the best that eager torch does at any
    batch size, backward included (`benchmarks/gru_step.py`). Loops take the weights once: asking for them costs as
    much as a product at batch 1.

    Args:
        value: (B, H) embedded frame for `nn.GRU.all_weights`, (B, D) raw frame for `folded_weights`.
        state: of the frame before.
        weights: (weight_ih, weight_hh, bias_ih, bias_hh) of each layer.
    """
    new = []
    for layer, before in zip(weights, state, strict=True):
        value = torch.gru_cell(value, before, *layer)
        new.append(value)
    return tuple(new)


class GaussianGRU(EmbeddedGRU):
    """Prior or posterior network: a Gaussian over the latent of each frame (thesis equations 3.7, 3.8).

    Args:
        input_size: D, [pose, condition, (time)].
        latent_size: Z.
        hidden_size: H.
        layers: L.
    """

    def __init__(self, input_size: int, latent_size: int, hidden_size: int, layers: int) -> None:
        super().__init__(input_size, hidden_size, layers)
        self.latent_size = latent_size
        self.mu_net = nn.Linear(hidden_size, latent_size)
        self.logvar_net = nn.Linear(hidden_size, latent_size)

    def forward(
        self, x: Float[Tensor, "T B D"], state: State | None = None
    ) -> tuple[Float[Tensor, "T B Z"], Float[Tensor, "T B Z"], Float[Tensor, "T B H"], State]:
        """All frames at once.

        Args:
            x: (T, B, D).
            state: of the frame before, zeros if None.

        Returns:
            mu (T, B, Z), logvar (T, B, Z), hidden (T, B, H) of the top layer, and the state after the last frame.
        """
        hidden, last = self.hidden_sequence(x, state)
        return self.mu_net(hidden), self.logvar_net(hidden), hidden, last

    def step(
        self, x: Float[Tensor, "B D"], state: State | None = None
    ) -> tuple[Float[Tensor, "B Z"], Float[Tensor, "B Z"], State]:
        """One frame (B, D) -> mu (B, Z), logvar (B, Z), new state."""
        state = self.hidden_step(x, state)
        return self.mu_net(state[-1]), self.logvar_net(state[-1]), state


class GeneratorGRU(EmbeddedGRU):
    """Generator up to its hidden vector; a head (`PlainHead`, `LieHead`, ...) turns that into a pose.

    The input is laid out [previous pose, condition, (time), z].

    Args:
        input_size: D.
        hidden_size: H.
        layers: L.
    """

    def forward(self, x: Float[Tensor, "T B D"], state: State | None = None) -> tuple[Float[Tensor, "T B H"], State]:
        """All frames (T, B, D) at once -> hidden (T, B, H) and the state after the last frame."""
        return self.hidden_sequence(x, state)

    def step(self, x: Float[Tensor, "B D"], state: State | None = None) -> tuple[Float[Tensor, "B H"], State]:
        """One frame (B, D) -> hidden (B, H), new state."""
        state = self.hidden_step(x, state)
        return state[-1], state

    def unroll(
        self,
        known: Float[Tensor, "T B Dk"],
        first: Float[Tensor, "B Dp"],
        feed: Callable[[Tensor], Tensor],
        state: State | None = None,
    ) -> tuple[Float[Tensor, "T B H"], Float[Tensor, "T B Dp"], State]:
        """Frames one after another, each fed with what `feed` made of the frame before it.

        Args:
            known: (T, B, Dk) the inputs known beforehand, [condition, (time), z]; Dk = D - Dp.
            first: (B, Dp) the pose before the first frame (zeros at the start of a motion).
            feed: hidden (B, H) -> the pose (B, Dp) the next frame is fed with; usually a head.
            state: of the frame before, zeros if None.

        Returns:
            hidden (T, B, H), fed poses (T, B, Dp) where entry t came out of frame t, and the last state.
        """
        weights = self.folded_weights()
        state = self.initial_state(len(first)) if state is None else state
        pose, hidden, poses = first, [], []
        for known_part in known.unbind(0):
            state = stack_step(torch.cat([pose, known_part], dim=1), state, weights)
            pose = feed(state[-1])
            hidden.append(state[-1])
            poses.append(pose)
        return torch.stack(hidden), torch.stack(poses), state


class PlainHead(nn.Module):
    """Hidden (..., H) -> joint positions (..., out), linear (thesis figure 3.4 a)."""

    def __init__(self, hidden_size: int, out: int) -> None:
        super().__init__()
        self.output = nn.Linear(hidden_size, out)

    def forward(self, hidden: Float[Tensor, "*batch H"]) -> Float[Tensor, "*batch out"]:
        """(..., H) -> (..., out)."""
        return self.output(hidden)


class LieHead(nn.Module):
    """Hidden (..., H) -> [root translation, axis-angle of every other joint] (..., 3 J), thesis figure 3.4 b.

    The first three outputs are linear; the 3 J - 3 others go through tanh, a linear layer, tanh, and are times pi.

    Args:
        hidden_size: H.
        joints: J, the root included.
    """

    ANGLE_LIMIT = math.pi
    """Largest size of one axis-angle component, radians."""

    def __init__(self, hidden_size: int, joints: int) -> None:
        super().__init__()
        self.joints = joints
        self.output = nn.Linear(hidden_size, 3 * joints)
        self.output_lie = nn.Linear(3 * joints - 3, 3 * joints - 3)

    def forward(self, hidden: Float[Tensor, "*batch H"]) -> Float[Tensor, "*batch out"]:
        """(..., H) -> (..., 3 J): metres for the first 3, radians for the rest."""
        raw = self.output(hidden)
        angles = torch.tanh(self.output_lie(torch.tanh(raw[..., 3:]))) * self.ANGLE_LIMIT
        return torch.cat([raw[..., :3], angles], dim=-1)


def sample_latent(
    mu: Float[Tensor, "*batch Z"], logvar: Float[Tensor, "*batch Z"], noise: Float[Tensor, "*batch Z"]
) -> Float[Tensor, "*batch Z"]:
    """The reparameterisation z = mu + exp(logvar / 2) * noise; all of one shape."""
    return torch.addcmul(mu, torch.exp(0.5 * logvar), noise)


@dataclass
class Rollout:
    """What `rollout` computed, frame by frame, and the states to go on from."""

    poses: Float[Tensor, "T B Dp"]
    """(T, B, Dp) what `feed` made of each frame, which is what the next frame was fed with."""
    hidden: Float[Tensor, "T B H"]
    """(T, B, H) top-layer hidden of the generator."""
    z: Float[Tensor, "T B Z"]
    """(T, B, Z) latent drawn from the prior."""
    mu: Float[Tensor, "T B Z"]
    """(T, B, Z) mean of the prior."""
    logvar: Float[Tensor, "T B Z"]
    """(T, B, Z) logarithm of its variance."""
    prior_state: State
    """Of the prior after the last frame."""
    generator_state: State
    """Of the generator after the last frame."""


def rollout(  # noqa: PLR0913, PLR0917 - two networks, their inputs and their states
    prior: GaussianGRU,
    generator: GeneratorGRU,
    feed: Callable[[Tensor], Tensor],
    condition: Float[Tensor, "T B Dc"],
    noise: Float[Tensor, "T B Z"],
    first: Float[Tensor, "B Dp"],
    prior_state: State | None = None,
    generator_state: State | None = None,
) -> Rollout:
    """Generation: z from the learned prior, pose from the generator, both fed with the pose before.

    Equals `prior.step`, `sample_latent`, `generator.step` and `feed` for each frame.

    Args:
        prior: its input is [previous pose, condition].
        generator: its input is [previous pose, condition, z].
        feed: generator hidden (B, H) -> pose (B, Dp), usually a head.
        condition: (T, B, Dc) condition of each frame, time counter included where there is one.
        noise: (T, B, Z) standard normal draws; zeros give the most likely latents.
        first: (B, Dp) the pose before the first frame (zeros at the start of a motion).
        prior_state: of the frame before, zeros if None.
        generator_state: of the frame before, zeros if None.
    """
    heads = torch.cat([prior.mu_net.weight, prior.logvar_net.weight]).t()
    heads_bias = torch.cat([prior.mu_net.bias, prior.logvar_net.bias])
    prior_weights, weights = prior.folded_weights(), generator.folded_weights()
    upper = prior.initial_state(len(first)) if prior_state is None else prior_state
    lower = generator.initial_state(len(first)) if generator_state is None else generator_state
    pose, made = first, []
    for known, eps in zip(condition.unbind(0), noise.unbind(0), strict=True):
        seen = torch.cat([pose, known], dim=1)
        upper = stack_step(seen, upper, prior_weights)
        mu, logvar = torch.addmm(heads_bias, upper[-1], heads).chunk(2, dim=1)
        z = sample_latent(mu, logvar, eps)
        lower = stack_step(torch.cat([seen, z], dim=1), lower, weights)
        pose = feed(lower[-1])
        made.append((pose, lower[-1], z, mu, logvar))
    poses, hidden, drawn, mean, spread = (torch.stack(parts) for parts in zip(*made, strict=True))
    return Rollout(poses, hidden, drawn, mean, spread, upper, lower)
