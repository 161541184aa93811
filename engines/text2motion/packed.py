"""Text2Motion for generation: what does not change from step to step is multiplied out before.

Reading weights is what a step of one motion costs. Keys and values enter every step through matrices that never change,
so these are multiplied with them once a sentence; the code before is multiplied once for prior and generator together;
means and deviations of the prior are one product. The posterior is not there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
from jaxtyping import Float, Int
from torch import Tensor
from torch.nn import functional as nnf

from engines.text2motion.model import TemporalVAE
from engines.text2motion.networks import Gaussian, Read, Recurrent, time_to_arrival


class PackedVAE:
    """Gives steps that say what `TemporalVAE.steps` says of generation, up to rounding.

    Args:
        net: frozen, of one layer.
    """

    def __init__(self, net: TemporalVAE) -> None:
        self.net = net
        code, seen = net.sizes.code, net.sizes.attention
        with torch.no_grad():
            prior, generator = (_input(part) for part in (net.prior, net.generator))
            of_code = torch.cat([prior.weight[:, :code], generator.weight[:, :code]])
            self.of_code = of_code, torch.cat([prior.bias, generator.bias])
            self.of_seen = torch.cat([prior.weight[:, code:], generator.weight[:, code : code + seen]])
            self.of_latent = generator.weight[:, code + seen :].contiguous()
            told = (net.prior.mean, net.prior.logvar)
            self.latent = torch.cat([part.weight for part in told]), torch.cat([part.bias for part in told])

    def steps(self, read: Read, lengths: Int[Tensor, " B"], most: int) -> PackedSteps:
        """To generate motions of so many codes of sentences.

        Args:
            read: sentences.
            lengths: codes of each motion.
            most: steps that are made.
        """
        net = self.net
        prior, generator = (part.begin(read.sentence)[0] for part in (net.prior, net.generator))
        asked = bias = mixed = None
        if net.attention is not None:
            held = net.attention.hold(read)
            query, scale = net.attention.query, 1 / math.sqrt(held.values.shape[-1])
            # (W h + b) . k = h . (W' k) + b . k
            asked = (nnf.linear(held.keys, query.weight.T) * scale).transpose(1, 2).contiguous()
            bias = torch.where(held.there, held.keys @ query.bias * scale, -torch.inf)[:, None]
            mixed = nnf.linear(held.values, self.of_seen)
        arrivals = None
        if net.sizes.position:
            left = (lengths[:, None] - torch.arange(most)).clamp_min(0).T
            arrivals = [time_to_arrival(left, size) for size in (net.sizes.latent_hidden, net.sizes.motion_hidden)]
        return PackedSteps(self, prior, generator, asked, bias, mixed, arrivals)


@dataclass
class PackedSteps:
    """Where generation stands."""

    packed: PackedVAE
    prior: Tensor
    """(B, H)."""
    generator: Tensor
    keys: Tensor | None
    """(B, H, N) as memories ask."""
    bias: Tensor | None
    """(B, 1, N)."""
    mixed: Tensor | None
    """(B, N, H + H) what the values add to the inputs of prior and generator."""
    arrivals: list[Tensor] | None
    """(S, B, H) each."""
    done: int = 0
    weights: Tensor | None = None
    """(B, N) how much each word was attended to for the last code."""

    def step(self, last: Float[Tensor, "B C"], noise: Float[Tensor, "B Z"]) -> tuple[Tensor, Gaussian]:
        """As `model.Steps.step`."""
        packed, net = self.packed, self.packed.net
        given = nnf.linear(last, *packed.of_code)
        if self.keys is not None and self.bias is not None and self.mixed is not None:
            weights = torch.softmax(self.generator[:, None] @ self.keys + self.bias, -1)
            given = given + (weights @ self.mixed)[:, 0]
            self.weights = weights[:, 0]
        for_prior, for_generator = given.split([net.sizes.latent_hidden, net.sizes.motion_hidden], -1)
        self.prior = _follow(net.prior, for_prior, self._arrival(0), self.prior)
        prior = Gaussian(*nnf.linear(self.prior, *packed.latent).chunk(2, -1))
        for_generator = for_generator + nnf.linear(prior.sample(noise), packed.of_latent)
        self.generator = _follow(net.generator, for_generator, self._arrival(1), self.generator)
        self.done += 1
        return net.generator.head(self.generator), prior

    def _arrival(self, which: int) -> Tensor | None:
        return None if self.arrivals is None else self.arrivals[which][self.done]


def _follow(part: Recurrent, given: Tensor, arrival: Tensor | None, memory: Tensor) -> Tensor:
    """The memory (B, H) after one more input, which has been through the first linear layer."""
    x = part.embed[2](part.embed[1](given))
    return part.cells[0](x if arrival is None else x + arrival, memory)


def _input(part: Recurrent) -> torch.nn.Linear:
    linear = part.embed[0]
    assert isinstance(linear, torch.nn.Linear)
    return linear
