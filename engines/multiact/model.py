"""MACVAE: a transition and an action, from how the previous motion ends and an action's label (Lee et al. 2023)."""

from __future__ import annotations

from typing import NamedTuple

import torch
from jaxtyping import Float, Int
from torch import Tensor, nn

from engines.multiact.config import MultiActConfig
from engines.multiact.networks import (
    SEEN,
    CurrNet,
    Decoder,
    Encoder,
    Postprocessor,
    PrevNet,
    TransitionLength,
    around,
)
from engines.multiact.representation import D
from engines.text2motion.networks import Gaussian

LONGEST_TRANSITION = 40
"""Frames, two seconds."""


class Pass(NamedTuple):
    """What a training pass makes."""

    made: Tensor
    """(B, T, D) features, not normalised."""
    posterior: tuple[Gaussian, Gaussian]
    """Of z_p and z_c."""
    prior: tuple[Gaussian, Gaussian]
    length: Tensor
    """(B,) logarithm of the transition's frames, as foreseen."""


class MACVAE(nn.Module):
    """All networks, and the scale of the features."""

    mean: Tensor
    std: Tensor

    def __init__(self, config: MultiActConfig) -> None:
        super().__init__()
        self.config = config
        width, actions = config.width, len(config.actions)
        sizes = (width, config.heads, config.inner, config.dropout, "gelu")
        encoder_layer = nn.TransformerEncoderLayer(*sizes, batch_first=True, norm_first=True)
        decoder_layer = nn.TransformerDecoderLayer(*sizes, batch_first=True, norm_first=True)
        self.encoder = Encoder(D, actions, width, encoder_layer, config.encoder_layers)
        self.prevnet, self.currnet = PrevNet(D, width), CurrNet(actions, width)
        self.transition_length = TransitionLength(D, actions, max(16, width // 4))
        self.decoder = Decoder(width, D, decoder_layer, config.decoder_layers)
        self.postprocessor = Postprocessor(D)
        self.register_buffer("mean", torch.zeros(D))
        self.register_buffer("std", torch.ones(D))

    def normalise(self, features: Float[Tensor, "*batch D"]) -> Float[Tensor, "*batch D"]:
        """Features as the networks have them."""
        return (features - self.mean) / self.std

    def prior(self, last: Float[Tensor, "B seen D"], actions: Int[Tensor, " B"]) -> tuple[Gaussian, Gaussian]:
        """Of z_p and z_c.

        Args:
            last: normalised last frames of the previous motion.
            actions: to come.
        """
        return self.prevnet(last), self.currnet(actions)

    def decode(
        self, z_p: Float[Tensor, "B H"], z_c: Float[Tensor, "B H"], frames: Int[Tensor, "B 2"], last: Tensor
    ) -> Float[Tensor, "B T D"]:
        """Features, not normalised, of transition and action (B, 2) frames, after the last (B, seen, D) normalised."""
        made = self.postprocessor(last, self.decoder(z_p, z_c, frames), frames.sum(1))
        return made * self.std + self.mean

    def forward(self, x: Tensor, labels: Tensor, frames: Tensor, noise: Tensor, blur: Tensor) -> Pass:
        """A training pass.

        Args:
            x: (B, P + T, D) features: the previous motion's last frames, transition, current action.
            labels: (B, 2) previous and current action, from 0; -1 for a previous one without a name.
            frames: (B, 2) of transition and current action.
            noise: (B, 2, H) of both latents.
            blur: (B, P, D) standard normal noise of the previous motion.
        """
        before = blur.shape[1]
        x = self.normalise(x)
        x = torch.cat([x[:, :before] + self.config.noise * blur, x[:, before:]], dim=1)
        last = x[:, before - SEEN : before]
        prior = self.prior(last, labels[:, 1])
        away = self.encoder(x, _labels(x.shape[1], before, labels, frames), before + frames.sum(1))
        posterior = around(prior[0], away[0]), around(prior[1], away[1])
        made = self.decode(posterior[0].sample(noise[:, 0]), posterior[1].sample(noise[:, 1]), frames, last)
        return Pass(made, posterior, prior, self.transition_length(last, labels[:, 1]))

    @torch.inference_mode()
    def generate(self, last: Tensor, actions: Tensor, frames: Tensor, noise: Tensor) -> Float[Tensor, "B T D"]:
        """Features of transition and action, drawn from the prior.

        Args:
            last: (B, seen, D) last frames of the previous motion, not normalised.
            actions: (B,).
            frames: (B, 2) of transition and action.
            noise: (B, 2, H).
        """
        seen = self.normalise(last)
        z_p, z_c = (found.sample(noise[:, i]) for i, found in enumerate(self.prior(seen, actions)))
        return self.decode(z_p, z_c, frames, seen)

    @torch.inference_mode()
    def transition_frames(self, last: Tensor, actions: Tensor) -> list[int]:
        """How many frames the transitions into actions (B,) take, after frames as for `generate`."""
        frames = self.transition_length(self.normalise(last), actions).exp().round()
        return frames.clamp(1, LONGEST_TRANSITION).int().tolist()


def _labels(total: int, before: int, labels: Tensor, frames: Tensor) -> Tensor:
    """(B, T) of each frame: 0 in the transition and where the previous action has no name, else 1 + action."""
    at = torch.arange(total, device=frames.device)
    current = at >= before + frames[:, :1]
    return torch.where(current, 1 + labels[:, 1:], torch.where(at < before, 1 + labels[:, :1], 0))
