"""The networks of Text2Motion (Guo et al. 2022, section 3; thesis 4.2).

Letters: B batch, T frames, S codes, N words, D features, C numbers of a code, E of a word vector, K tags, Z latent,
H hidden. `release` stands for what the released networks do otherwise (`official`).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor, nn
from torch.nn.utils.rnn import pack_padded_sequence, pad_packed_sequence

SLOPE = 0.2
"""Of the leaky rectifiers."""
UNIT = 4
"""Frames of a snippet code: two convolutions of stride 2."""


class SnippetEncoder(nn.Module):
    """Features -> snippet codes, one for four frames, each of which sees ten; the paper counts eight (equation 4.1).

    Args:
        features: how many it is shown.
        hidden: channels after the first convolution.
        code: C.
        dropout: after each convolution, in training.
    """

    def __init__(self, features: int, hidden: int, code: int, dropout: float = 0.2) -> None:
        super().__init__()
        self.first = nn.Conv1d(features, hidden, 4, 2, 1)
        self.second = nn.Conv1d(hidden, code, 4, 2, 1)
        self.dropout, self.rectify = nn.Dropout(dropout), nn.LeakyReLU(SLOPE)
        self.out = nn.Linear(code, code)

    def forward(self, features: Float[Tensor, "B T D"], codes: Int[Tensor, " B"] | None = None) -> Tensor:
        """(B, T, D) -> (B, S, C); T is a multiple of 4.

        Args:
            features: normalised.
            codes: how many of each row; beyond them is nothing, as if each row were encoded alone. All if none.
        """
        x = _kept(features.transpose(1, 2), codes, UNIT)
        x = _kept(self.rectify(self.dropout(self.first(x))), codes, UNIT // 2)
        x = self.rectify(self.dropout(self.second(x)))
        return self.out(x.transpose(1, 2))


class SnippetDecoder(nn.Module):
    """Snippet codes -> features, contacts among them."""

    def __init__(self, code: int, hidden: int, features: int) -> None:
        super().__init__()
        self.first = nn.ConvTranspose1d(code, hidden, 4, 2, 1)
        self.second = nn.ConvTranspose1d(hidden, features, 4, 2, 1)
        self.rectify = nn.LeakyReLU(SLOPE)
        self.out = nn.Linear(features, features)

    def forward(self, codes: Float[Tensor, "B S C"], count: Int[Tensor, " B"] | None = None) -> Tensor:
        """(B, S, C) -> (B, 4 S, D); `count` codes of each row are there, what lies beyond means nothing."""
        x = _kept(codes.transpose(1, 2), count, 1)
        x = _kept(self.rectify(self.first(x)), count, UNIT // 2)
        return self.out(self.rectify(self.second(x)).transpose(1, 2))


class Read(NamedTuple):
    """Sentences as the rest sees them."""

    words: Float[Tensor, "B N H2"]
    """w, a vector a word."""
    sentence: Float[Tensor, "B H2"]
    """s."""
    there: Bool[Tensor, "B N"]
    """Which words attention may look at."""


class WordReader(nn.Module):
    """Text encoder: tags are embedded and added to word vectors, then a bidirectional GRU.

    Args:
        word: E.
        tags: K; 0: no tags are told.
        hidden: of each direction.
        release: the backward half is turned round in time, and attention sees padding.
    """

    def __init__(self, word: int, tags: int, hidden: int, release: bool = False) -> None:
        super().__init__()
        self.release = release
        self.tag = nn.Linear(tags, word) if tags else None
        self.input = nn.Linear(word, hidden)
        self.start = nn.Parameter(torch.randn(2, 1, hidden))
        self.gru = nn.GRU(hidden, hidden, batch_first=True, bidirectional=True)

    def forward(self, vectors: Float[Tensor, "B N E"], tags: Float[Tensor, "B N K"], lengths: Tensor) -> Read:
        """Words of sentences of `lengths` (B,) words; what is past them does not matter."""
        told = vectors if self.tag is None else vectors + self.tag(tags)
        packed = pack_padded_sequence(self.input(told), lengths.cpu(), batch_first=True, enforce_sorted=False)
        made, last = self.gru(packed, self.start.expand(-1, len(vectors), -1).contiguous())
        made, _ = pad_packed_sequence(made, batch_first=True)
        there = torch.arange(made.shape[1], device=vectors.device) < lengths[:, None].to(vectors.device)
        if self.release:
            ahead, back = made.chunk(2, dim=-1)
            made, there = torch.cat([ahead, _turned(back, lengths)], dim=-1), torch.ones_like(there)
        return Read(made, last.transpose(0, 1).flatten(1), there)


class Held(NamedTuple):
    """What of a sentence every step of attention needs."""

    keys: Float[Tensor, "B N A"]
    values: Float[Tensor, "B N A"]
    there: Bool[Tensor, "B N"]


class WordAttention(nn.Module):
    """Local word attention: one head, asked by the generator's memory (equation 4.4)."""

    def __init__(self, asking: int, words: int, size: int) -> None:
        super().__init__()
        self.query, self.value = nn.Linear(asking, size), nn.Linear(words, size)
        self.key = nn.Linear(words, size, bias=False)

    def hold(self, read: Read) -> Held:
        """Keys and values of sentences."""
        return Held(self.key(read.words), self.value(read.words), read.there)

    def forward(self, memory: Float[Tensor, "B H"], held: Held) -> tuple[Tensor, Tensor]:
        """What memories attend to (B, A), and how much to each word (B, N)."""
        scores = torch.einsum("ba,bna->bn", self.query(memory), held.keys) / math.sqrt(held.values.shape[-1])
        weights = scores.masked_fill(~held.there, -torch.inf).softmax(-1)
        return torch.einsum("bn,bna->ba", weights, held.values), weights


def time_to_arrival(count: Tensor, size: int) -> Tensor:
    """(..., size) sines and cosines of how many codes are still to come, the one at hand included (equation 4.5).

    Args:
        count: (...) 1 for the last code.
        size: even.
    """
    exponents = torch.arange(0, size, 2, device=count.device) / size
    angles = count[..., None].float() / 10_000.0**exponents
    return torch.stack([angles.sin(), angles.cos()], dim=-1).flatten(-2)


class Gaussian(NamedTuple):
    """Diagonal normal distributions."""

    mean: Tensor
    logvar: Tensor

    def sample(self, noise: Tensor) -> Tensor:
        """A draw, by standard normal noise of the same shape."""
        return self.mean + noise * (0.5 * self.logvar).exp()


class Recurrent(nn.Module):
    """What prior, posterior and generator share: an embedded input, time to arrival, GRU layers.

    Args:
        given: numbers of the input.
        hidden: H.
        sentence: numbers of s, from which the first memory is made.
        layers: of the GRU.
        stacked: each layer hears the one below; if not, as in the release, every layer hears the input.
    """

    def __init__(self, given: int, hidden: int, sentence: int, layers: int = 1, stacked: bool = True) -> None:
        super().__init__()
        self.stacked, self.layers = stacked, layers
        self.embed = nn.Sequential(nn.Linear(given, hidden), nn.LayerNorm(hidden), nn.LeakyReLU(SLOPE))
        self.first = nn.Linear(sentence, layers * hidden)
        self.cells = nn.ModuleList(nn.GRUCell(hidden, hidden) for _ in range(layers))

    @property
    def size(self) -> int:
        """H."""
        return self.embed[0].out_features  # type: ignore[return-value]

    def begin(self, sentence: Float[Tensor, "B H2"]) -> list[Tensor]:
        """The first memory, (B, H) a layer."""
        return list(self.first(sentence).chunk(self.layers, dim=-1))

    def follow(self, given: Tensor, arrival: Tensor | None, memory: list[Tensor]) -> list[Tensor]:
        """The memory after one more input (B, given); the last layer's is what is heard of it.

        Args:
            given: the input.
            arrival: (B, H) `time_to_arrival`; not told if none.
            memory: before.
        """
        x = inner = self.embed(given) if arrival is None else self.embed(given) + arrival
        after = []
        for cell, before in zip(self.cells, memory, strict=True):
            after.append(cell(inner, before))
            inner = after[-1] if self.stacked else x
        return after


class LatentNet(Recurrent):
    """Prior or posterior: what the latent of a code may be."""

    def __init__(  # noqa: PLR0913, PLR0917 - sizes
        self, given: int, hidden: int, sentence: int, latent: int, layers: int = 1, stacked: bool = True
    ) -> None:
        super().__init__(given, hidden, sentence, layers, stacked)
        self.mean, self.logvar = nn.Linear(hidden, latent), nn.Linear(hidden, latent)

    def forward(self, given: Tensor, arrival: Tensor | None, memory: list[Tensor]) -> tuple[Gaussian, list[Tensor]]:
        """Distributions (B, Z) after one more input, and the memory after it."""
        after = self.follow(given, arrival, memory)
        return Gaussian(self.mean(after[-1]), self.logvar(after[-1])), after


class Generator(Recurrent):
    """Tells the next code."""

    def __init__(self, given: int, hidden: int, sentence: int, code: int, layers: int = 1) -> None:
        super().__init__(given, hidden, sentence, layers)
        self.head = nn.Sequential(
            nn.Linear(hidden, hidden), nn.LayerNorm(hidden), nn.LeakyReLU(SLOPE), nn.Linear(hidden, code)
        )

    def forward(self, given: Tensor, arrival: Tensor | None, memory: list[Tensor]) -> tuple[Tensor, list[Tensor]]:
        """A code (B, C) after one more input, and the memory after it."""
        after = self.follow(given, arrival, memory)
        return self.head(after[-1]), after


class LengthEstimator(nn.Module):
    """Text2length: a text encoder of its own and an MLP (section 3.2; thesis 4.2.2).

    Args:
        word: E.
        tags: K; 0: none.
        hidden: of each direction of the text encoder.
        classes: how many lengths.
    """

    widths = (512, 256, 128)

    def __init__(self, word: int, tags: int, hidden: int, classes: int) -> None:
        super().__init__()
        self.reader = WordReader(word, tags, hidden)
        layers: list[nn.Module] = []
        before = 2 * hidden
        for width in self.widths:
            layers += [nn.Linear(before, width), nn.LayerNorm(width), nn.LeakyReLU(SLOPE)]
            before = width
        self.head = nn.Sequential(*layers, nn.Linear(before, classes))

    def forward(self, vectors: Float[Tensor, "B N E"], tags: Float[Tensor, "B N K"], lengths: Tensor) -> Tensor:
        """(B, classes) logits of sentences of `lengths` (B,) words."""
        return self.head(self.reader(vectors, tags, lengths).sentence)


def _kept(x: Tensor, codes: Tensor | None, each: int) -> Tensor:
    """(B, C, T) with zeros past `each` frames a code of each row."""
    if codes is None:
        return x
    there = torch.arange(x.shape[-1], device=x.device) < each * codes[:, None].to(x.device)
    return x * there[:, None]


def _turned(x: Tensor, lengths: Tensor) -> Tensor:
    """(B, N, C) each row's first `lengths` entries in reverse order."""
    at = torch.arange(x.shape[1], device=x.device)
    back = lengths[:, None].to(x.device) - 1 - at
    index = torch.where(back >= 0, back, at)
    return x.gather(1, index[..., None].expand_as(x))
