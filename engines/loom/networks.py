"""The transformer: noisy frames in patches, what is known beside them, what is wanted through the norms."""

from __future__ import annotations

import math
from typing import NamedTuple

import torch
from torch import Tensor, nn

from engines.loom.config import LoomConfig
from engines.loom.representation import KNOWN, LAYOUT
from engines.text import sides

SPANS = 5
"""Not told; a stretch from the middle; from the start; to the end; whole."""


class Wanted(NamedTuple):
    """What B motions are told to be; 0 in a label is "not told"."""

    action: Tensor
    """(B,) 1 + place in `config.actions`."""
    style: Tensor
    """(B,) 1 + place in `config.styles`."""
    text: Tensor
    """(B, `sides.SIZE`) sentences, zero where there is none."""
    span: Tensor
    """(B,) which part of a performance this is: one of `SPANS`."""
    frames: Tensor
    """(B,) how many frames the motion has."""

    def rows(self, index: slice | Tensor) -> Wanted:
        """Of some of the motions."""
        return Wanted(*(value[index] for value in self))

    def joined(self, other: Wanted) -> Wanted:
        """Of both, one after the other."""
        return Wanted(*(torch.cat(pair) for pair in zip(self, other, strict=True)))

    def told_nothing(self) -> Wanted:
        """The same lengths, nothing else said."""
        nothing = (torch.zeros_like(value) for value in self)
        return Wanted(*nothing)._replace(frames=self.frames)


class LoomNet(nn.Module):
    """x at noise level t -> the motion it comes from, all in normalised features."""

    def __init__(self, config: LoomConfig) -> None:
        super().__init__()
        self.config = config
        width, patch = config.width, config.patch
        self.frames = nn.Linear(patch * LAYOUT.size, width)
        self.known = nn.Linear(patch * KNOWN.size, width, bias=False)
        self.places = nn.Linear(4 * _WAVES, width)
        self.time = nn.Sequential(nn.Linear(2 * _WAVES, width), nn.SiLU(), nn.Linear(width, width))
        self.length = nn.Linear(2 * _WAVES, width)
        self.action = nn.Embedding(1 + len(config.actions), width)
        self.style = nn.Embedding(1 + len(config.styles), width)
        self.text = nn.Sequential(nn.Linear(sides.SIZE, width), nn.SiLU(), nn.Linear(width, width))
        self.span = nn.Embedding(SPANS, width)
        self.modulation = nn.Linear(width, 6 * width)
        self.blocks = nn.ModuleList(Block(config) for _ in range(config.depth))
        self.last = nn.Parameter(torch.zeros(2, width))
        self.back = nn.Linear(width, patch * config.frame_width)
        self.smooth = nn.Conv1d(config.frame_width, config.frame_width, 5, padding=2)
        self.output = nn.Conv1d(config.frame_width, LAYOUT.size, 3, padding=1)
        self._start()

    def _start(self) -> None:
        nn.init.zeros_(self.modulation.weight)
        nn.init.zeros_(self.modulation.bias)
        nn.init.zeros_(self.known.weight)
        for table in (self.action, self.style, self.span):
            nn.init.normal_(table.weight, std=0.5)

    def forward(self, x: Tensor, t: Tensor, wanted: Wanted, known: Tensor | None, mask: Tensor) -> Tensor:
        """Noisy frames (B, T, D), noise levels (B,), what is known (B, T, K) or nothing, frames there (B, T) bool.

        T is a multiple of the patch. Returns (B, T, D).
        """
        count, frames = x.shape[:2]
        patches = frames // self.config.patch
        there = mask.view(count, patches, -1).any(-1)
        hidden = self.frames((x * mask[..., None]).reshape(count, patches, -1))
        if known is not None:
            hidden = hidden + self.known(known.reshape(count, patches, -1))
        hidden = hidden + self.places(self._places(patches, wanted.frames))
        shift = self.modulation(nn.functional.silu(self.condition(t, wanted))).view(count, 6, 1, -1)
        turns = _turns(patches, self.config.width // self.config.heads, x.device)
        attended = there[:, None, None]
        for block in self.blocks:
            hidden = block(hidden, shift, turns, attended)
        hidden = nn.functional.layer_norm(hidden, hidden.shape[-1:]) * (1 + self.last[0]) + self.last[1]
        made = self.back(hidden).view(count, frames, -1) * mask[..., None]
        made = made.mT  # (B, T, W) -> (B, W, T)
        made = made + nn.functional.gelu(self.smooth(made))
        return self.output(made * mask[:, None]).mT

    def condition(self, t: Tensor, wanted: Wanted) -> Tensor:
        """All that is told, as one vector a motion (B, H)."""
        there = wanted.text.any(-1, keepdim=True)
        return (
            self.time(_waves(t * 100.0))
            + self.length(_waves(wanted.frames.float()))
            + self.action(wanted.action)
            + self.style(wanted.style)
            + self.span(wanted.span)
            + self.text(wanted.text * _TEXT_SCALE) * there
        )

    def _places(self, patches: int, frames: Tensor) -> Tensor:
        """(B, L, 4 W) how far a token is from the start and from the end."""
        at = torch.arange(patches, device=frames.device) * float(self.config.patch)
        start = _waves(at)[None].expand(len(frames), -1, -1)
        return torch.cat([start, _waves(frames[:, None].float() - at)], dim=-1)


class Block(nn.Module):
    """Attention and feed-forward, each scaled, shifted and gated by what is wanted (adaLN, one map for all blocks)."""

    def __init__(self, config: LoomConfig) -> None:
        super().__init__()
        self.heads = config.heads
        self.own = nn.Parameter(torch.randn(6, 1, config.width) / math.sqrt(config.width))
        self.attention = nn.Linear(config.width, 3 * config.width)
        self.merge = nn.Linear(config.width, config.width)
        self.inner = nn.Linear(config.width, config.inner)
        self.outer = nn.Linear(config.inner, config.width)

    def forward(self, x: Tensor, shift: Tensor, turns: tuple[Tensor, Tensor], there: Tensor | None) -> Tensor:
        """Tokens (B, L, H); modulation (B, 6, 1, H); rotary cosines and sines; tokens to attend to (B, 1, 1, L)."""
        scale_a, shift_a, gate_a, scale_b, shift_b, gate_b = (shift + self.own).unbind(1)
        seen = nn.functional.layer_norm(x, x.shape[-1:]) * (1 + scale_a) + shift_a
        parts = self.attention(seen).view(*x.shape[:2], 3, self.heads, -1).permute(2, 0, 3, 1, 4)
        query, key = (_turned(part, turns) for part in parts[:2])
        heard = nn.functional.scaled_dot_product_attention(query, key, parts[2], attn_mask=there)
        x = x + gate_a * self.merge(heard.transpose(1, 2).flatten(2))
        seen = nn.functional.layer_norm(x, x.shape[-1:]) * (1 + scale_b) + shift_b
        return x + gate_b * self.outer(nn.functional.gelu(self.inner(seen)))


_WAVES = 16
_TEXT_SCALE = 16.0
"""Sentence vectors have length one; this makes their numbers about as large as others'."""


def _waves(values: Tensor) -> Tensor:
    """Sines and cosines (..., 2 W) of numbers, periods from 6 to 2,500."""
    rates = torch.exp(-torch.arange(_WAVES, device=values.device) * (math.log(400.0) / (_WAVES - 1)))
    angles = values[..., None] * rates
    return torch.cat([angles.sin(), angles.cos()], dim=-1)


def _turns(length: int, size: int, device: torch.device) -> tuple[Tensor, Tensor]:
    """Cosines and sines (L, size / 2) of rotary position encoding (Su et al. 2021), slowest period 1,000 tokens."""
    rates = torch.exp(-torch.arange(size // 2, device=device) * (math.log(160.0) / (size // 2 - 1)))
    angles = torch.arange(length, device=device)[:, None] * rates
    return angles.cos(), angles.sin()


def _turned(x: Tensor, turns: tuple[Tensor, Tensor]) -> Tensor:
    """Halves of (B, heads, L, size) turned against each other by their place."""
    a, b = x.chunk(2, dim=-1)
    cos, sin = turns
    return torch.cat([a * cos - b * sin, a * sin + b * cos], dim=-1)
