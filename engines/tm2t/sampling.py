"""Token after token: drawing motions, and drawing them so that gradients pass (thesis 6.2.3).

A decoder is anything that has `step(tokens (B,)) -> logits (B, V)`. Letters: B batch, S steps, V tokens with marks.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np
import torch
from jaxtyping import Float, Int
from torch import Tensor

from engines.tm2t.vocabulary import MotionTokens


class Steps(Protocol):
    """A decoder that goes on by one token at a time."""

    def step(self, tokens: Tensor) -> Tensor:
        """Tokens (B,) -> logits (B, V) of what follows."""
        ...


class SoftSteps(Steps, Protocol):
    """... and one that can be fed with shares of tokens."""

    def step_shares(self, shares: Tensor) -> Tensor:
        """Shares (B, V) -> logits (B, V) of what follows."""
        ...


class Drawn(NamedTuple):
    """Motions as tokens."""

    tokens: Int[Tensor, "B S"]
    """Without [BOM]; what comes after a row's length means nothing."""
    lengths: Int[Tensor, " B"]
    """How many of them are codes; S where [EOM] did not come."""


def top_k(logits: Float[Tensor, "B V"], count: int) -> Float[Tensor, "B V"]:
    """Logits with all but the likeliest `count` ruled out; ties with the last of them stay."""
    if count < 1 or count >= logits.shape[-1]:
        return logits
    least = logits.topk(count, dim=-1).values[:, -1:]
    return logits.masked_fill(logits < least, -torch.inf)


def pick(chances: Float[Tensor, "B V"], uniform: Float[Tensor, " B"]) -> Int[Tensor, " B"]:
    """One entry of each row, by the inverse of the summed chances: how many sums are at or below the draw."""
    sums = chances.double().cumsum(-1)
    sums = sums / sums[:, -1:]
    likely = (chances > 0) * torch.arange(1, chances.shape[-1] + 1, device=chances.device)
    return torch.minimum((sums <= uniform.double()[:, None]).sum(-1), likely.amax(-1) - 1)


@torch.no_grad()
def sample(  # noqa: PLR0913, PLR0917 - what a draw depends on
    steps: Steps,
    tokens: MotionTokens,
    uniform: Float[Tensor, "B S"],
    among: int = 0,
    temperature: float = 1.0,
    exactly: int | None = None,
    least: int = 0,
    heat: list[Tensor] | None = None,
) -> Drawn:
    """Draw motions until [EOM] is the likeliest token.

    Args:
        steps: fresh.
        tokens: the vocabulary.
        uniform: draws in [0, 1), one a step; S steps at most.
        among: draw among so many of the likeliest; 0: among all.
        temperature: above 1 more even, below 1 more often the likeliest.
        exactly: so many codes, wherever [EOM] would have come.
        least: codes before [EOM] is heard.
        heat: gets what the decoder attended to (B, N) at each step.
    """
    count = uniform.shape[1] if exactly is None else exactly
    last = torch.full((len(uniform),), tokens.begin, device=uniform.device)
    lengths = torch.full_like(last, count)
    made = []
    for at in range(count):
        logits = top_k(steps.step(last).float(), among)
        if heat is not None:
            heat.append(steps.weights)  # type: ignore[attr-defined]
        ends = (logits.argmax(-1) == tokens.end) & (at >= least)
        chances = (logits / temperature).softmax(-1)
        chances[:, tokens.codes :] = 0.0
        # where the marks had it all, any code will do
        chances = torch.where(chances.sum(-1, keepdim=True) > 0, chances, _codes_only(chances, tokens))
        last = pick(chances, uniform[:, at])
        if exactly is None:
            last = torch.where(ends, tokens.end, last)
            lengths = torch.where(ends & (lengths == count), at, lengths)
        made.append(last)
        if (lengths < count).all():
            break
    return Drawn(torch.stack(made, 1), lengths)


def _codes_only(chances: Tensor, tokens: MotionTokens) -> Tensor:
    even = torch.zeros_like(chances)
    even[:, : tokens.codes] = 1.0
    return even


class SoftDrawn(NamedTuple):
    """Motions as nearly one-hot shares, through which gradients pass."""

    shares: Float[Tensor, "B S V"]
    lengths: Int[Tensor, " B"]
    """How many of them come before [EOM] was the likeliest; S where it never was."""


def straight_through(logits: Float[Tensor, "*B V"], noise: Float[Tensor, "*B V"], temperature: float) -> Tensor:
    """Gumbel-softmax: one-hot forward, soft backward (Jang et al. 2017; thesis 6.2.3).

    Args:
        logits: (..., V).
        noise: (..., V) standard Gumbel draws.
        temperature: tau.
    """
    soft = ((logits + noise) / temperature).softmax(-1)
    hard = torch.zeros_like(soft).scatter_(-1, soft.argmax(-1, keepdim=True), 1.0)
    return hard - soft.detach() + soft


def gumbel_sample(  # noqa: PLR0913, PLR0917 - what a draw depends on
    steps: SoftSteps,
    tokens: MotionTokens,
    noise: Float[Tensor, "B S V"],
    temperature: float = 1.0,
    among: int = 0,
    release: bool = False,
) -> SoftDrawn:
    """Draw motions by Gumbel-softmax, each token fed to the next step, its gradient too.

    Args:
        steps: fresh.
        tokens: the vocabulary.
        noise: standard Gumbel draws; S steps at most.
        temperature: tau.
        among: draw among so many of the likeliest; 0: among all.
        release: as the release has it: padding may be drawn, and no gradient passes through what is fed back.
    """
    batch, count, size = noise.shape
    ruled_out = torch.zeros(size, dtype=torch.bool, device=noise.device)
    ruled_out[[tokens.begin, tokens.end] + [tokens.pad] * (not release)] = True
    lengths = torch.full((batch,), count, device=noise.device)
    made: list[Tensor] = []
    for at in range(count):
        if not made:
            logits = steps.step(torch.full((batch,), tokens.begin, device=noise.device))
        elif release:
            logits = steps.step(made[-1].argmax(-1))
        else:
            logits = steps.step_shares(made[-1])
        logits = top_k(logits, among)
        ends = logits.argmax(-1) == tokens.end
        lengths = torch.where(ends & (lengths == count), at, lengths)
        made.append(straight_through(logits.masked_fill(ruled_out, -torch.inf), noise[:, at], temperature))
        if (lengths < count).all():
            break
    return SoftDrawn(torch.stack(made, 1), lengths)


def gumbel_noise(shape: tuple[int, ...], generator: torch.Generator) -> Tensor:
    """Standard Gumbel draws."""
    return -torch.log(-torch.log(torch.rand(shape, generator=generator).clamp(1e-9, 1 - 1e-7)))


def uniforms(seed: int, indices: range | list[int], steps: int) -> Tensor:
    """(B, steps) draws in [0, 1): a stream for each motion of a seed, whatever else is drawn beside it."""
    streams = [np.random.default_rng(np.random.SeedSequence([seed, index])) for index in indices]
    return torch.from_numpy(np.stack([stream.random(steps) for stream in streams]))
