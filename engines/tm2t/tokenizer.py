"""Motion tokens: an autoencoder whose latents are entries of a codebook (thesis 6.2.1, equations 6.1 to 6.3).

The encoder is not shown the foot contacts; the decoder has to tell them (thesis 6.3.3). Four frames make one token.
Letters: B batch, T frames, t tokens, D features, d numbers of a codebook entry, K entries.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import NamedTuple

import torch
from jaxtyping import Float, Int
from torch import Tensor, nn
from torch.nn import functional as nnf

SLOPE = 0.2
"""Of the leaky rectifiers."""


class Coded(NamedTuple):
    """Latents and the codebook's answer."""

    latents: Float[Tensor, "B t d"]
    """What the encoder says."""
    codes: Int[Tensor, "B t"]
    """The nearest entries."""
    entries: Float[Tensor, "B t d"]
    """... themselves; gradients reach the codebook."""
    passed: Float[Tensor, "B t d"]
    """... with the gradients of the latents: the straight-through estimator."""


class Residual(nn.Module):
    """Two convolutions, added to what they are given."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.layers = nn.Sequential(
            nn.Conv1d(width, width, 3, 1, 1), nn.LeakyReLU(SLOPE), nn.Conv1d(width, width, 3, 1, 1)
        )

    def forward(self, x: Tensor) -> Tensor:
        """(B, width, t) -> the same shape."""
        return x + self.layers(x)


class MotionEncoder(nn.Module):
    """Features -> latents, half as many for every entry of `channels`."""

    def __init__(self, features: int, channels: Sequence[int]) -> None:
        super().__init__()
        sizes = [features, *channels]
        layers: list[nn.Module] = []
        for before, after in itertools.pairwise(sizes):
            layers += [nn.Conv1d(before, after, 4, 2, 1), nn.LeakyReLU(SLOPE), Residual(after)]
        self.layers = nn.Sequential(*layers)

    def forward(self, features: Float[Tensor, "B T D"]) -> Float[Tensor, "B t d"]:
        """Latents of windows of 4 frames or more; frames past a multiple of 4 are not looked at."""
        return self.layers(features.transpose(1, 2)).transpose(1, 2)


class MotionDecoder(nn.Module):
    """Latents -> features, twice as many for every entry of `channels` but the first.

    Args:
        latent_size: d.
        channels: widths; the last is D.
        blocks: residual blocks at the start.
    """

    def __init__(self, latent_size: int, channels: Sequence[int], blocks: int) -> None:
        super().__init__()
        layers: list[nn.Module] = []
        if latent_size != channels[0]:
            layers.append(nn.Conv1d(latent_size, channels[0], 3, 1, 1))
        layers += [Residual(channels[0]) for _ in range(blocks)]
        for before, after in itertools.pairwise(channels):
            layers += [nn.Upsample(scale_factor=2), nn.Conv1d(before, after, 3, 1, 1), nn.LeakyReLU(SLOPE)]
        layers.append(nn.Conv1d(channels[-1], channels[-1], 3, 1, 1))
        self.layers = nn.Sequential(*layers)

    def forward(self, latents: Float[Tensor, "B t d"]) -> Float[Tensor, "B T D"]:
        """Features, contacts among them."""
        return self.layers(latents.transpose(1, 2)).transpose(1, 2)


class Codebook(nn.Module):
    """K entries of d numbers that learn by gradients (equation 6.3)."""

    def __init__(self, codes: int, size: int) -> None:
        super().__init__()
        self.weight = nn.Parameter(torch.empty(codes, size).uniform_(-1 / codes, 1 / codes))

    def nearest(self, latents: Float[Tensor, "B t d"]) -> Int[Tensor, "B t"]:
        """The entries with the least squared distance (equation 6.1)."""
        # |z|^2 is the same for all entries; half precision would mistake neighbours for each other
        with torch.autocast(latents.device.type, enabled=False):
            return (self.weight.square().sum(1) - 2 * latents.float() @ self.weight.T).argmin(-1)

    def forward(self, latents: Float[Tensor, "B t d"]) -> Coded:
        """Latents -> entries."""
        codes = self.nearest(latents)
        entries = nnf.embedding(codes, self.weight)
        return Coded(latents, codes, entries, latents + (entries - latents).detach())


class AveragedCodebook(Codebook):
    """Entries that are moving averages of the latents they stand for (van den Oord et al. 2017, appendix A.1).

    Args:
        codes: K.
        size: d.
        decay: of the averages.
        least: entries used less than this often a batch begin again at a latent of the batch; 0: never.
        epsilon: keeps the counts above zero.
        release: as the released class has it, where new latents never reach the averages, so that entries only fade.
    """

    uses: Tensor
    sums: Tensor

    def __init__(  # noqa: PLR0913, PLR0917 - sizes, and three small numbers
        self, codes: int, size: int, decay: float = 0.99, least: float = 0.0, epsilon: float = 1e-5,
        release: bool = False,
    ) -> None:  # fmt: skip
        super().__init__(codes, size)
        self.weight.requires_grad_(False)
        self.decay, self.least, self.epsilon, self.release = decay, least, epsilon, release
        self.register_buffer("uses", torch.zeros(codes))
        self.register_buffer("sums", self.weight.detach().clone())

    def forward(self, latents: Float[Tensor, "B t d"]) -> Coded:
        """Latents -> entries; in training the entries move afterwards."""
        coded = super().forward(latents)
        if self.training:
            self._follow(latents.detach().flatten(0, -2).float(), coded.codes.flatten())
        return coded

    @torch.no_grad()
    def _follow(self, latents: Tensor, codes: Tensor) -> None:
        counts = torch.bincount(codes, minlength=len(self.uses)).to(self.uses)
        self.uses.mul_(self.decay).add_(counts, alpha=1 - self.decay)
        self.sums.mul_(self.decay)
        if not self.release:
            self.sums.index_add_(0, codes, latents, alpha=1 - self.decay)
        total = self.uses.sum()
        smooth = (self.uses + self.epsilon) / (total + len(self.uses) * self.epsilon) * total
        self.weight.copy_(self.sums / smooth[:, None])
        unused = (self.uses < self.least).nonzero().flatten()
        if len(unused):
            chosen = latents[torch.randint(len(latents), (len(unused),)).to(latents.device)]
            self.weight[unused] = chosen
            # as if used twice as often as it takes, so that it has time to find its own
            self.uses[unused] = 2 * self.least
            self.sums[unused] = 2 * self.least * chosen


class MotionTokenizer(nn.Module):
    """Encoder, codebook and decoder.

    Args:
        features: D.
        hidden_features: how many at the end of D the encoder is not shown.
        channels: of the encoder; the last is d.
        widths: of the decoder; the last is D.
        blocks: of the decoder.
        codebook: of entries of d numbers.
    """

    def __init__(  # noqa: PLR0913, PLR0917 - the sizes of three networks
        self, features: int, hidden_features: int, channels: Sequence[int], widths: Sequence[int], blocks: int,
        codebook: Codebook,
    ) -> None:  # fmt: skip
        super().__init__()
        self.shown = features - hidden_features
        self.encoder = MotionEncoder(self.shown, channels)
        self.codebook = codebook
        self.decoder = MotionDecoder(channels[-1], widths, blocks)

    def latents(self, features: Float[Tensor, "B T D"]) -> Float[Tensor, "B t d"]:
        """What the encoder makes of normalised features."""
        return self.encoder(features[..., : self.shown])

    def encode(self, features: Float[Tensor, "B T D"]) -> Int[Tensor, "B t"]:
        """Motion tokens of normalised features; T // 4 of them."""
        return self.codebook.nearest(self.latents(features))

    def decode(self, codes: Int[Tensor, "B t"]) -> Float[Tensor, "B T D"]:
        """Normalised features of motion tokens, four frames each."""
        return self.decoder(nnf.embedding(codes, self.codebook.weight))

    def forward(self, features: Float[Tensor, "B T D"]) -> tuple[Float[Tensor, "B T D"], Coded]:
        """There and back, with what happened between."""
        coded = self.codebook(self.latents(features))
        return self.decoder(coded.passed), coded


def perplexity(codes: Tensor, count: int) -> Tensor:
    """How many entries are used, as if all of them alike: exp of the entropy of their shares.

    Args:
        codes: any shape.
        count: K.
    """
    shares = torch.bincount(codes.flatten(), minlength=count).float() / codes.numel()
    return torch.exp(-(shares * torch.log(shares + 1e-10)).sum())
