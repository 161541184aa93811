"""The networks of latent stylization: all of them convolutions over time, channels first (thesis, section 5.2)."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Literal, NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor, nn

_SLOPE = 0.2
"""Of leaky ReLUs."""


class Gaussian(NamedTuple):
    """A diagonal Gaussian."""

    mean: Tensor
    logvar: Tensor

    def sample(self, noise: Tensor) -> Tensor:
        """mean + deviation * noise."""
        return self.mean + torch.exp(0.5 * self.logvar) * noise


def convolution(inputs: int, outputs: int, stride: int = 1, mode: Literal["reflect", "zeros"] = "reflect") -> nn.Conv1d:
    """Three frames wide, as long as its input (or half of it)."""
    return nn.Conv1d(inputs, outputs, 3, stride, padding=1, padding_mode=mode)


def leaky(x: Tensor) -> Tensor:
    """Leaky ReLU."""
    return nn.functional.leaky_relu(x, _SLOPE)


def doubled(x: Tensor) -> Tensor:
    """Every frame twice."""
    return nn.functional.interpolate(x, scale_factor=2.0, mode="nearest")


class MotionEncoder(nn.Module):
    """E: features without contacts -> motion code at a quarter of the rate."""

    def __init__(self, channels: Sequence[int], latent: int, variational: bool) -> None:
        super().__init__()
        self.variational = variational
        self.down = nn.ModuleList(convolution(a, b, stride=2) for a, b in itertools.pairwise(channels))
        self.output = nn.Conv1d(channels[-1], latent * (2 if variational else 1), 1)

    def forward(self, motion: Float[Tensor, "B D T"]) -> Gaussian:
        """The motion code (B, Z, T / 4) as a Gaussian; a plain autoencoder's has no spread (logvar of -inf)."""
        x = motion
        for layer in self.down:
            x = nn.functional.dropout(leaky(layer(x)), 0.2, self.training)
        x = self.output(x)
        if self.variational:
            return Gaussian(*x.chunk(2, dim=1))
        return Gaussian(x, torch.full_like(x, -torch.inf))


class MotionDecoder(nn.Module):
    """D: motion code -> features, contacts among them."""

    def __init__(self, latent: int, channels: Sequence[int], output: int) -> None:
        super().__init__()
        self.first = convolution(latent, channels[0])
        self.up = nn.ModuleList(convolution(a, b, mode="zeros") for a, b in itertools.pairwise(channels))
        self.output = nn.Conv1d(channels[-1], output, 1)

    def forward(self, code: Float[Tensor, "B Z L"]) -> Float[Tensor, "B D T"]:
        """(B, Z, L) -> (B, D, 4 L)."""
        x = leaky(self.first(code))
        for layer in self.up:
            x = leaky(layer(doubled(x)))
        return self.output(x)


class SameCode(nn.Module):
    """No encoder: features without contacts are their own code."""

    def forward(self, motion: Float[Tensor, "B D T"]) -> Gaussian:
        """As they are, without spread."""
        return Gaussian(motion, torch.full_like(motion, -torch.inf))


class SameMotion(nn.Module):
    """No decoder: a code is its own features, contacts unknown."""

    def __init__(self, contacts: int) -> None:
        super().__init__()
        self.contacts = contacts

    def forward(self, code: Float[Tensor, "B Z L"]) -> Float[Tensor, "B D L"]:
        """As it is, contacts at their mean."""
        return nn.functional.pad(code, (0, 0, 0, self.contacts))


class ContentEncoder(nn.Module):
    """E_c: motion code -> content code; instance norms take away what is the same over the whole clip (the style)."""

    def __init__(self, mid: Sequence[int], channels: Sequence[int]) -> None:
        super().__init__()
        self.down = nn.ModuleList(convolution(a, b, stride=2) for a, b in itertools.pairwise(mid))
        sizes = [mid[-1], *channels]
        self.code = nn.ModuleList(nn.Conv1d(a, b, 1) for a, b in itertools.pairwise(sizes))

    def forward(self, code: Float[Tensor, "B Z L"]) -> Float[Tensor, "B C M"]:
        """(B, Z, L) -> (B, C, L / 2)."""
        x = code
        for layer in [*self.down, *self.code[:-1]]:
            x = leaky(nn.functional.instance_norm(layer(x)))
        return self.code[-1](x)


class StyleEncoder(nn.Module):
    """E_s: motion code, and its label in the supervised setting -> a Gaussian over styles."""

    def __init__(self, mid: Sequence[int], channels: Sequence[int], labels: int, size: int) -> None:
        super().__init__()
        self.down = nn.ModuleList(convolution(a, b, stride=2) for a, b in itertools.pairwise(mid))
        sizes = [mid[-1] + labels, *channels]
        self.code = nn.ModuleList(convolution(a, b, stride=2) for a, b in itertools.pairwise(sizes))
        self.output = nn.Conv1d(channels[-1], 2 * size, 1)

    def forward(self, code: Float[Tensor, "B Z L"], label: Float[Tensor, "B S"] | None) -> Gaussian:
        """Mean and log-variance (B, style)."""
        x = code
        for layer in self.down:
            x = leaky(layer(x))
        if label is not None:
            x = torch.cat([x, label[..., None].expand(-1, -1, x.shape[-1])], dim=1)
        for layer in self.code:
            x = leaky(layer(x))
        return Gaussian(*self.output(x.mean(-1, keepdim=True))[..., 0].chunk(2, dim=1))


class StyleCritic(nn.Module):
    """Motion code -> how much it is of each style; dropout keeps its view broad."""

    def __init__(self, latent: int, channels: Sequence[int], labels: int) -> None:
        super().__init__()
        self.down = nn.ModuleList(convolution(a, b, stride=2) for a, b in itertools.pairwise((latent, *channels)))
        self.output = nn.Linear(channels[-1], labels)

    def forward(self, code: Float[Tensor, "B Z L"]) -> Float[Tensor, "B S"]:
        """Logits."""
        x = nn.functional.dropout(code, 0.2, self.training)
        for layer in self.down:
            x = leaky(layer(x))
        return self.output(x.mean(-1))


class StyledLayer(nn.Module):
    """A convolution whose output gets mean and deviation from the style (adaptive instance normalisation)."""

    def __init__(self, inputs: int, outputs: int, style: int, up: bool = False) -> None:
        super().__init__()
        self.up = up
        self.convolution = convolution(inputs, outputs, mode="zeros")
        self.style = nn.Linear(style, 2 * outputs)
        nn.init.ones_(self.style.bias[:outputs])
        nn.init.zeros_(self.style.bias[outputs:])

    def forward(self, x: Float[Tensor, "B C L"], style: Float[Tensor, "B S"]) -> Float[Tensor, "B O M"]:
        """Content (B, C, L) in a style (B, S)."""
        x = leaky(self.convolution(doubled(x) if self.up else x))
        scale, shift = self.style(style)[..., None].chunk(2, dim=1)
        return scale * nn.functional.instance_norm(x) + shift


class Generator(nn.Module):
    """G: content code and style -> motion code."""

    def __init__(self, channels: Sequence[int], output: int, style: int, ups: int = 1) -> None:
        super().__init__()
        pairs = list(itertools.pairwise(channels))
        self.layers = nn.ModuleList(
            StyledLayer(a, b, style, up=i >= len(pairs) - ups) for i, (a, b) in enumerate(pairs)
        )
        self.output = nn.Conv1d(channels[-1], output, 1)

    def forward(self, content: Float[Tensor, "B C M"], style: Float[Tensor, "B S"]) -> Float[Tensor, "B Z L"]:
        """(B, C, M) and (B, S) -> (B, Z, 2 M)."""
        x = content
        for layer in self.layers:
            x = layer(x, style)
        return self.output(x)


class GlobalRegressor(nn.Module):
    """Local movement -> how the root travels (thesis, global motion prediction)."""

    def __init__(self, channels: Sequence[int]) -> None:
        super().__init__()
        self.layers = nn.ModuleList(convolution(a, b) for a, b in itertools.pairwise(channels))
        self.output = nn.Conv1d(channels[-1], 2, 1, bias=False)

    def forward(self, local: Float[Tensor, "B D T"]) -> Float[Tensor, "B 2 T"]:
        """Features but velocity and contacts (B, D, T) -> root velocity (B, 2, T)."""
        x = local
        for layer in self.layers:
            x = leaky(layer(x))
        return self.output(x)
