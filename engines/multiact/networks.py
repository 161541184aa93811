"""The networks of MACVAE: encoder, PrevNet and CurrNet, decoder, postprocessor (section "Architecture")."""

from __future__ import annotations

import math

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor, nn

from engines.text2motion.networks import Gaussian

SEEN = 4
"""Frames of the previous motion that PrevNet sees."""
_WIDE = 5
"""Frames that convolutions over time look at."""
_NARROWEST, _WIDEST = -9.0, 3.0
"""Log-variances a prior may have: a pose nobody has seen must not blow it up."""
_AT_FIRST = -2.0
"""... and has before it is trained."""


def sinusoids(at: Float[Tensor, "*batch"], width: int) -> Float[Tensor, "*batch C"]:
    """Positional encoding of frames, which may be negative (Vaswani et al. 2017)."""
    rates = torch.exp(torch.arange(0, width, 2, device=at.device) * (-math.log(10_000.0) / width))
    angles = at[..., None] * rates
    return torch.cat([angles.sin(), angles.cos()], dim=-1)


class Convolution(nn.Conv1d):
    """Over time, channels last; beyond both ends lie the first and the last frame."""

    def __init__(self, inputs: int, outputs: int) -> None:
        super().__init__(inputs, outputs, _WIDE, padding=_WIDE // 2, padding_mode="replicate")

    def forward(self, x: Float[Tensor, "B T C"]) -> Float[Tensor, "B T E"]:
        """(B, T, C) -> (B, T, E)."""
        return super().forward(x.mT).mT


def held(x: Float[Tensor, "B T C"], frames: Int[Tensor, " B"]) -> Float[Tensor, "B T C"]:
    """What lies past the end of each sequence becomes its last frame, as if nothing had been padded."""
    at = torch.arange(x.shape[1], device=x.device).minimum(frames[:, None] - 1)
    return x.gather(1, at[..., None].expand_as(x))


def around(prior: Gaussian, away: Gaussian) -> Gaussian:
    """The posterior that lies so many of the prior's deviations away from it (Vahdat and Kautz 2020, section 3.2).

    What the prior knows for certain, how the previous motion ends, the decoder so gets as certain as that, and it
    costs no divergence; the encoder has only to tell what nobody could foresee.
    """
    return Gaussian(prior.mean + torch.exp(0.5 * prior.logvar) * away.mean, prior.logvar + away.logvar)


class Encoder(nn.Module):
    """Previous motion, transition and current action, with their labels -> where z_p and z_c lie around their priors.

    It begins by telling nothing, so that posteriors are priors.
    """

    def __init__(self, features: int, actions: int, width: int, layer: nn.TransformerEncoderLayer, layers: int) -> None:
        super().__init__()
        self.pose = nn.Linear(features, width // 2)
        self.action = nn.Embedding(actions + 1, width // 2)
        self.layers = nn.TransformerEncoder(layer, layers, nn.LayerNorm(width), enable_nested_tensor=False)
        self.convolution = Convolution(width, width)
        self.heads = nn.ModuleList(nn.Linear(width, width) for _ in range(4))
        for head in self.heads.parameters():
            nn.init.zeros_(head)

    def forward(
        self, x: Float[Tensor, "B T D"], labels: Int[Tensor, "B T"], frames: Int[Tensor, " B"]
    ) -> tuple[Gaussian, Gaussian]:
        """Of z_p and z_c, for `around`.

        Args:
            x: normalised features.
            labels: of each frame: 0 in the transition, else 1 + action.
            frames: that are there.
        """
        at = torch.arange(x.shape[1], device=x.device)
        there = at < frames[:, None]
        seen = torch.cat([self.pose(x), self.action(labels)], dim=-1)
        seen = seen + sinusoids(at.to(x), seen.shape[-1])
        coded = self.convolution(held(self.layers(seen, src_key_padding_mask=_hidden(there)), frames))
        mean = (coded * there[..., None]).sum(1) / frames[:, None]
        mu_p, logvar_p, mu_c, logvar_c = (head(mean) for head in self.heads)
        return Gaussian(mu_p, logvar_p), Gaussian(mu_c, logvar_c)


class PrevNet(nn.Module):
    """The last four frames of the previous motion -> prior of z_p: one linear layer, and the token of "transition"."""

    def __init__(self, features: int, width: int) -> None:
        super().__init__()
        self.mean, self.logvar = nn.Linear(SEEN * features, width), nn.Linear(SEEN * features, width)
        nn.init.constant_(self.logvar.bias, _AT_FIRST)

    def forward(self, last: Float[Tensor, "B seen D"]) -> Gaussian:
        """The biases of the layers are the token."""
        seen = last.flatten(1)
        return Gaussian(self.mean(seen), self.logvar(seen).clamp(_NARROWEST, _WIDEST))


class CurrNet(nn.Module):
    """The current action -> prior of z_c: a learned token for each parameter of each action."""

    def __init__(self, actions: int, width: int) -> None:
        super().__init__()
        self.mean, self.logvar = nn.Embedding(actions, width), nn.Embedding(actions, width)
        nn.init.constant_(self.logvar.weight, _AT_FIRST)

    def forward(self, actions: Int[Tensor, " B"]) -> Gaussian:
        """Actions count from 0."""
        return Gaussian(self.mean(actions), self.logvar(actions).clamp(_NARROWEST, _WIDEST))


class TransitionLength(nn.Module):
    """How long it takes to get from how the previous motion ends into an action."""

    def __init__(self, features: int, actions: int, width: int) -> None:
        super().__init__()
        self.seen, self.action = nn.Linear(SEEN * features, width), nn.Embedding(actions, width)
        self.output = nn.Linear(width, 1)

    def forward(self, last: Float[Tensor, "B seen D"], actions: Int[Tensor, " B"]) -> Float[Tensor, " B"]:
        """The logarithm of a number of frames."""
        return self.output(nn.functional.silu(self.seen(last.flatten(1)) + self.action(actions)))[:, 0]


class Decoder(nn.Module):
    """Latents and two lengths -> poses.

    Keys and values are z_p as often as the transition has frames, then z_c; queries are positions, half of their
    channels counted from the action's first frame, so that the decoder knows where it begins.
    """

    def __init__(self, width: int, features: int, layer: nn.TransformerDecoderLayer, layers: int) -> None:
        super().__init__()
        self.layers = nn.TransformerDecoder(layer, layers, nn.LayerNorm(width))
        self.convolution = Convolution(width, width)
        self.output = nn.Linear(width, features)

    def forward(
        self, z_p: Float[Tensor, "B H"], z_c: Float[Tensor, "B H"], frames: Int[Tensor, "B 2"]
    ) -> Float[Tensor, "B T D"]:
        """As many frames as the longest of (B, 2) transition and action together."""
        total = frames.sum(1)
        at = torch.arange(int(total.max()), device=z_p.device)
        transition = (at < frames[:, :1])[..., None]
        memory = torch.where(transition, z_p[:, None], z_c[:, None])
        half = z_p.shape[1] // 2
        start = sinusoids(at.to(z_p), half).expand(len(frames), -1, -1)
        begun = sinusoids((at - frames[:, :1]).to(z_p), half)
        hidden = _hidden(at < total[:, None])
        made = self.layers(
            torch.cat([start, begun], dim=-1), memory, tgt_key_padding_mask=hidden, memory_key_padding_mask=hidden
        )
        return self.output(self.convolution(held(made, total)))


class Postprocessor(nn.Module):
    """One convolution over time, all features together, across the seam; it begins as no change at all."""

    def __init__(self, features: int) -> None:
        super().__init__()
        self.convolution = Convolution(features, features)
        nn.init.dirac_(self.convolution.weight)
        nn.init.zeros_(self.convolution.bias)  # type: ignore[arg-type]  # it has one

    def forward(
        self, last: Float[Tensor, "B seen D"], made: Float[Tensor, "B T D"], frames: Int[Tensor, " B"]
    ) -> Float[Tensor, "B T D"]:
        """What was made (frames of it there), after the previous motion's last frames, which are then discarded."""
        whole = torch.cat([last, held(made, frames)], dim=1)
        return self.convolution(whole)[:, last.shape[1] :]


def _hidden(there: Bool[Tensor, "B T"]) -> Bool[Tensor, "B T"] | None:
    """A padding mask, or none where nothing is padded."""
    return None if bool(there.all()) else ~there
