"""Sentences to motion tokens by an attentive GRU (thesis 6.2.3, equations 6.5 and 6.6).

Letters: B batch, N words, V motion tokens with their marks, C width.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor, nn
from torch.nn import functional as nnf
from torch.nn.utils.rnn import pack_padded_sequence, pad_packed_sequence


@dataclass(frozen=True)
class GRUSizes:
    """Of an attentive GRU."""

    text: int
    """Numbers of a word vector."""
    tokens: int
    """V."""
    text_hidden: int
    """Of each direction of the sentence encoder."""
    motion_hidden: int
    layers: int = 1
    """Of the decoder."""
    late: bool = False
    """Attend after the GRU rather than before it."""
    release: bool = False
    """As the release has it: the encoder's backward half is turned round in time, and attention sees padding."""


class Read(NamedTuple):
    """A sentence as the decoder sees it."""

    words: Float[Tensor, "B N C"]
    """w, a vector a word."""
    sentence: Float[Tensor, "B C"]
    """s."""
    there: Bool[Tensor, "B N"]


class SentenceEncoder(nn.Module):
    """A bidirectional GRU over word vectors."""

    def __init__(self, sizes: GRUSizes) -> None:
        super().__init__()
        self.release = sizes.release
        self.input = nn.Linear(sizes.text, sizes.text_hidden)
        self.start = nn.Parameter(torch.randn(2, 1, sizes.text_hidden))
        self.gru = nn.GRU(sizes.text_hidden, sizes.text_hidden, batch_first=True, bidirectional=True)

    def forward(self, words: Float[Tensor, "B N E"], lengths: Int[Tensor, " B"]) -> Read:
        """Word vectors of sentences of so many words; what is past them does not matter."""
        packed = pack_padded_sequence(self.input(words), lengths.cpu(), batch_first=True, enforce_sorted=False)
        made, last = self.gru(packed, self.start.expand(-1, len(words), -1).contiguous())
        made, _ = pad_packed_sequence(made, batch_first=True)
        there = torch.arange(made.shape[1], device=words.device) < lengths[:, None].to(words.device)
        if self.release:
            ahead, back = made.chunk(2, dim=-1)
            made = torch.cat([ahead, _turned(back, lengths)], dim=-1)
            there = torch.ones_like(there)
        return Read(made, last.transpose(0, 1).flatten(1), there)


class WordAttention(nn.Module):
    """One head over the words (equations 6.5, 6.6)."""

    def __init__(self, asking: int, words: int, size: int) -> None:
        super().__init__()
        self.query, self.value = nn.Linear(asking, size), nn.Linear(words, size)
        self.key = nn.Linear(words, size, bias=False)

    def forward(self, asking: Tensor, held: Held) -> tuple[Tensor, Tensor]:
        """What a hidden state (B, C) attends to (B, size), and how much to each word (B, N)."""
        scores = torch.einsum("bc,bnc->bn", self.query(asking), held.keys) / math.sqrt(held.values.shape[-1])
        weights = scores.masked_fill(~held.there, -torch.inf).softmax(-1)
        return torch.einsum("bn,bnc->bc", weights, held.values), weights


class Held(NamedTuple):
    """What of a sentence every step needs."""

    keys: Tensor
    """(B, N, size)."""
    values: Tensor
    there: Tensor


class AttentiveGRU(nn.Module):
    """Sentence encoder, attention, GRU decoder; the output layer is the token embedding."""

    def __init__(self, sizes: GRUSizes) -> None:
        super().__init__()
        self.sizes = sizes
        width = sizes.motion_hidden
        self.reader = SentenceEncoder(sizes)
        self.embed = nn.Embedding(sizes.tokens, width)
        nn.init.normal_(self.embed.weight, std=width**-0.5)
        self.first = nn.Linear(2 * sizes.text_hidden, sizes.layers * width)
        self.attention = WordAttention(width, 2 * sizes.text_hidden, width)
        mix: list[nn.Module] = [nn.Linear(2 * width, width), nn.LayerNorm(width), nn.LeakyReLU(0.2)]
        self.mix = nn.Sequential(*mix, *([nn.Linear(width, width)] if sizes.late else []))
        self.cells = nn.ModuleList(nn.GRUCell(width, width) for _ in range(sizes.layers))

    def read(self, words: Float[Tensor, "B N E"], lengths: Int[Tensor, " B"]) -> Read:
        """Sentences of word vectors."""
        return self.reader(words, lengths)

    def steps(self, read: Read) -> GRUSteps:
        """To decode token after token."""
        hidden = list(self.first(read.sentence).chunk(self.sizes.layers, dim=-1))
        return GRUSteps(
            self, hidden, Held(self.attention.key(read.words), self.attention.value(read.words), read.there)
        )


@dataclass
class GRUSteps:
    """Where decoding stands."""

    net: AttentiveGRU
    hidden: list[Tensor]
    """(B, C), a layer each."""
    held: Held
    weights: Tensor | None = None
    """(B, N) how much the last step attended to each word."""

    def step(self, tokens: Int[Tensor, " B"]) -> Float[Tensor, "B V"]:
        """Logits of what follows one more token."""
        return self.step_embedded(self.net.embed(tokens))

    def step_shares(self, shares: Float[Tensor, "B V"]) -> Float[Tensor, "B V"]:
        """Logits of what follows a (nearly) one-hot token, through which gradients pass."""
        return self.step_embedded(shares @ self.net.embed.weight)

    def step_embedded(self, x: Float[Tensor, "B C"]) -> Float[Tensor, "B V"]:
        """Logits of what follows an embedded token."""
        net = self.net
        if not net.sizes.late:
            x = self._mixed(x)
        for place, cell in enumerate(net.cells):
            self.hidden[place] = x = cell(x, self.hidden[place])
        if net.sizes.late:
            x = self._mixed(x)
        return nnf.linear(x, net.embed.weight)

    def choose(self, rows: Int[Tensor, " B"]) -> None:
        """Go on from these rows; each must be of the same sentence as the row it takes the place of."""
        self.hidden = [hidden[rows] for hidden in self.hidden]

    def _mixed(self, x: Tensor) -> Tensor:
        seen, self.weights = self.net.attention(self.hidden[-1], self.held)
        return self.net.mix(torch.cat([seen, x], dim=-1))


def unroll(net: AttentiveGRU, read: Read, tokens: Int[Tensor, "B S"], teacher: bool) -> Float[Tensor, "B S V"]:
    """Logits at every step, each fed with the real token before it, or with the likeliest of the step before.

    Args:
        net: the decoder.
        read: sentences.
        tokens: from [BOM] on.
        teacher: feed the real ones.
    """
    steps = net.steps(read)
    made, last = [], tokens[:, 0]
    for at in range(tokens.shape[1]):
        logits = steps.step(tokens[:, at] if teacher else last)
        made.append(logits)
        last = logits.argmax(-1)
    return torch.stack(made, 1)


def _turned(x: Tensor, lengths: Tensor) -> Tensor:
    """(B, N, C) each row's first `lengths` entries in reverse order."""
    at = torch.arange(x.shape[1], device=x.device)
    back = lengths[:, None].to(x.device) - 1 - at
    index = torch.where(back >= 0, back, at)
    return x.gather(1, index[..., None].expand_as(x))
