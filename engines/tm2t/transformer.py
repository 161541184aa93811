"""A transformer that translates one sequence of tokens into another (Vaswani et al. 2017), one step at a time if asked.

Layers normalise after adding; embeddings are scaled by the root of the width; places are sines and cosines. While
decoding, keys and values of what is there already are kept, so that a step costs one token.
Letters: B batch, S source tokens, N target tokens, V target vocabulary, H heads.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, cast

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor, nn
from torch.nn import functional as nnf

_EPSILON = 1e-6


@dataclass(frozen=True)
class Sizes:
    """Of a translator."""

    source: int
    """Its vocabulary; with `source_vectors` the numbers of a source vector."""
    target: int
    """V."""
    width: int
    inner: int
    layers: int
    heads: int
    head_size: int
    source_places: int = 256
    """Longest source."""
    target_places: int = 256
    """Longest target."""
    dropout: float = 0.1
    source_vectors: bool = False
    """The source comes as vectors of words, not as indices."""
    target_vectors: int = 0
    """The target comes as vectors of so many numbers; 0: as indices."""
    tied: bool = True
    """The output layer is the target's embedding."""


class KeysValues(NamedTuple):
    """(B, H, S, size) each."""

    keys: Tensor
    values: Tensor


class Attention(nn.Module):
    """Attention of many heads, added to what asks, then normalised."""

    def __init__(self, sizes: Sizes) -> None:
        super().__init__()
        self.heads, self.chance = sizes.heads, sizes.dropout
        inner = sizes.heads * sizes.head_size
        self.query, self.key, self.value = (nn.Linear(sizes.width, inner) for _ in range(3))
        self.out = nn.Linear(inner, sizes.width)
        self.norm = nn.LayerNorm(sizes.width, eps=_EPSILON)
        self.dropout = nn.Dropout(sizes.dropout)

    def remember(self, source: Float[Tensor, "B S C"]) -> KeysValues:
        """Keys and values of what can be attended to."""
        return KeysValues(self._split(self.key(source)), self._split(self.value(source)))

    def forward(self, x: Float[Tensor, "B N C"], held: KeysValues, mask: Tensor | None) -> Float[Tensor, "B N C"]:
        """x with what it attends to; mask (B, 1, N or 1, S) true where it may."""
        chance = self.chance if self.training else 0.0
        seen = nnf.scaled_dot_product_attention(self._split(self.query(x)), *held, attn_mask=mask, dropout_p=chance)
        return self.norm(x + self.dropout(self.out(seen.transpose(1, 2).flatten(2))))

    def _split(self, x: Tensor) -> Tensor:
        return x.unflatten(-1, (self.heads, -1)).transpose(1, 2)


class FeedForward(nn.Module):
    """Two layers on every token by itself, added to it, then normalised."""

    def __init__(self, sizes: Sizes) -> None:
        super().__init__()
        self.inner, self.outer = nn.Linear(sizes.width, sizes.inner), nn.Linear(sizes.inner, sizes.width)
        self.norm = nn.LayerNorm(sizes.width, eps=_EPSILON)
        self.dropout = nn.Dropout(sizes.dropout)

    def forward(self, x: Tensor) -> Tensor:
        """(..., width) -> the same shape."""
        return self.norm(x + self.dropout(self.outer(torch.relu(self.inner(x)))))


class EncoderLayer(nn.Module):
    """The source looks at itself."""

    def __init__(self, sizes: Sizes) -> None:
        super().__init__()
        self.attention, self.feed = Attention(sizes), FeedForward(sizes)

    def forward(self, x: Tensor, mask: Tensor) -> Tensor:
        """(B, S, width) -> the same shape."""
        return self.feed(self.attention(x, self.attention.remember(x), mask))


class DecoderLayer(nn.Module):
    """The target looks at itself, then at the source."""

    def __init__(self, sizes: Sizes) -> None:
        super().__init__()
        self.attention, self.cross, self.feed = Attention(sizes), Attention(sizes), FeedForward(sizes)

    def forward(self, x: Tensor, own: KeysValues, mask: Tensor | None, source: KeysValues, there: Tensor) -> Tensor:
        """(B, N, width) -> the same shape."""
        return self.feed(self.cross(self.attention(x, own, mask), source, there))


class Source(NamedTuple):
    """An encoded source."""

    encoded: Float[Tensor, "B S C"]
    there: Bool[Tensor, "B S"]

    def repeated(self, count: int) -> Source:
        """Every row so many times, one after another."""
        return Source(self.encoded.repeat_interleave(count, 0), self.there.repeat_interleave(count, 0))


class Encoder(nn.Module):
    """Embedding, places and layers of the source."""

    def __init__(self, sizes: Sizes) -> None:
        super().__init__()
        kind = nn.Linear(sizes.source, sizes.width, bias=False) if sizes.source_vectors else None
        self.embed = kind or nn.Embedding(sizes.source, sizes.width)
        self.layers = nn.ModuleList(EncoderLayer(sizes) for _ in range(sizes.layers))
        self.register_buffer("places", places(sizes.source_places, sizes.width), persistent=False)

    def forward(self, embedded: Tensor, there: Tensor) -> Tensor:
        """Embedded source (B, S, width) and which of it is there (B, S) -> (B, S, width)."""
        x = embedded * math.sqrt(embedded.shape[-1]) + self.places[: embedded.shape[1]]  # type: ignore[index]
        mask = there[:, None, None]
        for layer in self.layers:
            x = layer(x, mask)
        return x


class Decoder(nn.Module):
    """Embedding, places and layers of the target."""

    def __init__(self, sizes: Sizes) -> None:
        super().__init__()
        kind = nn.Linear(sizes.target_vectors, sizes.width, bias=False) if sizes.target_vectors else None
        self.embed = kind or nn.Embedding(sizes.target, sizes.width)
        self.layers = cast(Sequence[DecoderLayer], nn.ModuleList(DecoderLayer(sizes) for _ in range(sizes.layers)))
        self.register_buffer("places", places(sizes.target_places, sizes.width), persistent=False)

    def forward(self, targets: Tensor, source: Source, mask: Tensor) -> Tensor:
        """All of a target at once: indices (B, N) or vectors, mask (B, 1, N, N) -> (B, N, width)."""
        x = self.begin(targets, 0)
        for layer in self.layers:
            held = layer.attention.remember(x)
            x = layer(x, held, mask, layer.cross.remember(source.encoded), source.there[:, None, None])
        return x

    def begin(self, targets: Tensor, first: int) -> Tensor:
        """Embedded targets (B, N, width) of which the first is at place `first`."""
        x = self.embed(targets)
        return x * math.sqrt(x.shape[-1]) + self.places[first : first + x.shape[1]]  # type: ignore[index]


class Translator(nn.Module):
    """Encoder, decoder and output layer."""

    def __init__(self, sizes: Sizes) -> None:
        super().__init__()
        self.sizes = sizes
        self.encoder, self.decoder = Encoder(sizes), Decoder(sizes)
        self.head = None if sizes.tied else nn.Linear(sizes.width, sizes.target, bias=False)
        for parameter in self.parameters():
            if parameter.ndim > 1:
                nn.init.xavier_uniform_(parameter)

    def read(self, source: Tensor, there: Bool[Tensor, "B S"]) -> Source:
        """A source of indices (B, S), or of word vectors (B, S, size), and which of it is there."""
        return Source(self.encoder(self.encoder.embed(source), there), there)

    def read_shares(self, shares: Float[Tensor, "B S K"], there: Bool[Tensor, "B S"]) -> Source:
        """A source of (nearly) one-hot shares, through which gradients pass."""
        embedded = (shares * there[..., None]) @ self.encoder.embed.weight
        return Source(self.encoder(embedded, there), there)

    def forward(self, source: Source, targets: Tensor, there: Bool[Tensor, "B N"]) -> Float[Tensor, "B N V"]:
        """Logits of what follows each token of the targets, which see what is before them.

        Args:
            source: of `read`.
            targets: indices (B, N), or vectors (B, N, size), from the start mark on.
            there: which of them are.
        """
        count = there.shape[1]
        causal = torch.ones(count, count, dtype=torch.bool, device=there.device).tril()
        return self.logits(self.decoder(targets, source, (there[:, None] & causal)[:, None]))

    def logits(self, x: Float[Tensor, "*B C"]) -> Float[Tensor, "*B V"]:
        """Of decoder outputs."""
        return self.head(x) if self.head is not None else nnf.linear(x, self.decoder.embed.weight)

    def steps(self, source: Source) -> TranslatorSteps:
        """To decode token after token."""
        memory = [layer.cross.remember(source.encoded) for layer in self.decoder.layers]
        return TranslatorSteps(self, memory, source.there[:, None, None])


@dataclass
class TranslatorSteps:
    """A target as far as it is known, and the next logits."""

    net: Translator
    memory: list[KeysValues]
    """Of the source, a layer each."""
    there: Tensor
    """(B, 1, 1, S)."""
    own: list[KeysValues] = field(default_factory=list)
    """Of the target so far, a layer each."""

    def step(self, tokens: Int[Tensor, " B"]) -> Float[Tensor, "B V"]:
        """Logits of what follows one more token."""
        decoder = self.net.decoder
        done = self.own[0].keys.shape[2] if self.own else 0
        x = decoder.begin(tokens[:, None], done)
        kept = []
        for place, layer in enumerate(decoder.layers):
            new = layer.attention.remember(x)
            if self.own:
                new = KeysValues(*(torch.cat(pair, 2) for pair in zip(self.own[place], new, strict=True)))
            kept.append(new)
            x = layer(x, new, None, self.memory[place], self.there)
        self.own = kept
        return self.net.logits(x[:, 0])

    def choose(self, rows: Int[Tensor, " B"]) -> None:
        """Go on from these rows; each must be of the same source as the row it takes the place of."""
        self.own = [KeysValues(*(part[rows] for part in held)) for held in self.own]


def places(count: int, width: int) -> Float[Tensor, "N C"]:
    """(count, width) sines in even columns and cosines in odd ones, wavelengths from 2 pi to 20,000 pi."""
    rate = 10_000.0 ** (-(torch.arange(width, dtype=torch.float64) // 2) * 2 / width)
    angle = torch.arange(count, dtype=torch.float64)[:, None] * rate
    table = torch.where(torch.arange(width) % 2 == 0, angle.sin(), angle.cos())
    return table.float()
