"""Latent stylization: motion codes, their content and their style, put together anew (thesis, section 5.2)."""

from __future__ import annotations

import torch
from jaxtyping import Float
from torch import Tensor, nn

from engines.features.style import layout
from engines.stylization.config import StylizationConfig
from engines.stylization.networks import (
    ContentEncoder,
    Gaussian,
    Generator,
    GlobalRegressor,
    MotionDecoder,
    MotionEncoder,
    StyleCritic,
    StyleEncoder,
)

LAYOUT = layout()
D = LAYOUT.size
SEEN = LAYOUT.size - LAYOUT.part("contacts").size
"""What the encoder is shown: all but the contacts, which come last."""
LOCAL = slice(LAYOUT["root_height"].start, SEEN)
"""What says nothing of where the root goes."""


class Stylizer(nn.Module):
    """All networks, and the scale of the features."""

    mean: Tensor
    std: Tensor

    def __init__(self, config: StylizationConfig) -> None:
        super().__init__()
        self.config = config
        self.encoder = MotionEncoder((SEEN, *config.encoder), config.latent_size, config.latent == "vae")
        self.decoder = MotionDecoder(config.latent_size, config.decoder, D)
        self.content = ContentEncoder((config.latent_size, *config.mid), config.content)
        self.style = StyleEncoder((config.latent_size, *config.mid), config.style, config.label_size, config.style_size)
        self.generator = Generator(
            (config.content[-1], *config.generator), config.latent_size, config.style_size + config.label_size
        )
        self.critic = (
            StyleCritic(config.latent_size, (*config.mid, *config.style), config.label_size)
            if config.criticised
            else None
        )
        self.regressor = GlobalRegressor((1 + LOCAL.stop - LOCAL.start, *config.regressor))
        self.register_buffer("mean", torch.zeros(D))
        self.register_buffer("std", torch.ones(D))

    def encode(self, motion: Float[Tensor, "B T D"], noise: Tensor | None = None) -> Float[Tensor, "B Z L"]:
        """Motion codes of normalised features; noise (B, Z, L) draws from the variational one, none takes its mean."""
        code = self.encoder(motion.mT[:, :SEEN])
        return code.mean if noise is None or not self.encoder.variational else code.sample(noise)

    def decode(self, code: Float[Tensor, "B Z L"]) -> Float[Tensor, "B T D"]:
        """Normalised features of motion codes."""
        return self.decoder(code).mT

    def style_of(self, code: Float[Tensor, "B Z L"], label: Float[Tensor, "B S"] | None) -> Gaussian:
        """Where in the style space a motion code lies; labels in the supervised setting only."""
        return self.style(code, label if self.config.supervised else None)

    def generate(
        self, content: Float[Tensor, "B C M"], style: Float[Tensor, "B K"], label: Float[Tensor, "B S"] | None
    ) -> Float[Tensor, "B Z L"]:
        """A motion code of a content in a style."""
        told = torch.cat([style, label], dim=1) if self.config.supervised and label is not None else style
        return self.generator(content, told)

    def travel(self, motion: Float[Tensor, "B T D"], turning: Float[Tensor, "B T 1"]) -> Float[Tensor, "B T 2"]:
        """Root velocity that fits local movement (normalised features) and a yaw velocity."""
        return self.regressor(torch.cat([turning, motion[..., LOCAL]], dim=-1).mT).mT

    def assembled(self, content: Float[Tensor, "B T D"], code: Float[Tensor, "B Z L"]) -> Float[Tensor, "B T D"]:
        """Features of a stylised code: local movement of the code, turning of the content, travel that fits both."""
        made = self.decode(code)
        turning = content[:, : made.shape[1], LAYOUT["yaw_velocity"]]
        return torch.cat([turning, self.travel(made, turning), made[..., LAYOUT["root_height"].start :]], dim=-1)
