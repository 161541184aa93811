"""The attentive GRU for generation: what does not change from step to step is multiplied out before.

Reading weights is what a step of one motion costs. Keys and values enter every step through matrices that never change,
so these are multiplied with them once a sentence, and with all tokens' embeddings once and for all; of the weights only
the GRU's own and the output layer are left to be read at each step, in half precision if that is asked for.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
from jaxtyping import Float, Int
from torch import Tensor
from torch.nn import functional as nnf

from engines.tm2t.attentive import AttentiveGRU, Read


class PackedGRU:
    """Gives steps that say what `AttentiveGRU.steps` says, up to rounding.

    Args:
        net: frozen, with early attention.
        dtype: of the weights read at every step.
    """

    def __init__(self, net: AttentiveGRU, dtype: torch.dtype = torch.float32) -> None:
        self.net, self.dtype = net, dtype
        linear = net.mix[0]
        assert isinstance(linear, torch.nn.Linear)
        width = net.sizes.motion_hidden
        with torch.no_grad():
            self.of_values, of_tokens = linear.weight[:, :width], linear.weight[:, width:]
            self.tokens = nnf.linear(net.embed.weight, of_tokens, linear.bias)
            self.output = net.embed.weight.to(dtype)
            names = ("weight_ih", "bias_ih", "weight_hh", "bias_hh")
            self.cells = [[getattr(cell, name).to(dtype) for name in names] for cell in net.cells]

    def steps(self, read: Read) -> PackedSteps:
        """To draw motions of sentences."""
        attention = self.net.attention
        keys, values = attention.key(read.words), attention.value(read.words)
        scale = 1 / math.sqrt(values.shape[-1])
        # (W h + b) . k = h . (W' k) + b . k
        asked = nnf.linear(keys, attention.query.weight.T) * scale
        bias = torch.where(read.there, keys @ attention.query.bias * scale, -torch.inf)
        hidden = list(self.net.first(read.sentence).chunk(self.net.sizes.layers, dim=-1))
        return PackedSteps(self, hidden, asked.transpose(1, 2), bias, nnf.linear(values, self.of_values))


@dataclass
class PackedSteps:
    """Where decoding stands."""

    packed: PackedGRU
    hidden: list[Tensor]
    """(B, C), a layer each, float32."""
    keys: Tensor
    """(B, C, N)."""
    bias: Tensor
    """(B, N)."""
    values: Tensor
    """(B, N, C)."""
    weights: Tensor | None = None
    """(B, N) how much the last step attended to each word."""

    def step(self, tokens: Int[Tensor, " B"]) -> Float[Tensor, "B V"]:
        """Logits of what follows one more token."""
        packed = self.packed
        self.weights = torch.softmax((self.hidden[-1][:, None] @ self.keys)[:, 0] + self.bias, -1)
        mixed = (self.weights[:, None] @ self.values)[:, 0] + packed.tokens[tokens]
        x = packed.net.mix[2](packed.net.mix[1](mixed))
        for place, weights in enumerate(packed.cells):
            self.hidden[place] = x = _cell(x, self.hidden[place], weights)
        return nnf.linear(x.to(packed.dtype), packed.output).float()


def _cell(x: Tensor, hidden: Tensor, weights: list[Tensor]) -> Tensor:
    """A GRU's step; the state stays in full precision."""
    weight_in, bias_in, weight_own, bias_own = weights
    given = nnf.linear(x.to(weight_in.dtype), weight_in, bias_in).float().chunk(3, -1)
    own = nnf.linear(hidden.to(weight_own.dtype), weight_own, bias_own).float().chunk(3, -1)
    reset, update = torch.sigmoid(given[0] + own[0]), torch.sigmoid(given[1] + own[1])
    new = torch.tanh(given[2] + reset * own[2])
    return new + update * (hidden - new)
