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
    SameCode,
    SameMotion,
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
        if config.latent == "none":
            size = SEEN
            self.encoder, self.decoder = SameCode(), SameMotion(D - SEEN)
        else:
            size = config.latent_size
            self.encoder = MotionEncoder((SEEN, *config.encoder), size, config.latent == "vae")
            self.decoder = MotionDecoder(size, config.decoder, D)
        self.content = ContentEncoder((size, *config.mid), config.content)
        self.style = StyleEncoder((size, *config.mid), config.style, config.label_size, config.style_size)
        self.generator = Generator((config.content[-1], *config.generator), size, config.style_size + config.label_size)
        looks = (*config.mid, *config.style)
        self.critic = StyleCritic(size, looks, config.label_size) if config.criticised else None
        local = (1 + LOCAL.stop - LOCAL.start, *config.regressor)
        self.regressor = GlobalRegressor(local) if config.regressor else None
        self.register_buffer("mean", torch.zeros(D))
        self.register_buffer("std", torch.ones(D))

    def encode(self, motion: Float[Tensor, "B T D"], noise: Tensor | None = None) -> Float[Tensor, "B Z L"]:
        """Motion codes of normalised features; noise (B, Z, L) draws from the variational one, none takes its mean."""
        code = self.encoder(motion.mT[:, :SEEN])
        return code.mean if noise is None or self.config.latent != "vae" else code.sample(noise)

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

    def travel(self, motion: Float[Tensor, "B T D"], content: Float[Tensor, "B T D"]) -> Float[Tensor, "B T 2"]:
        """Root velocity that fits local movement and the content's turning; without a regressor the content's own."""
        if self.regressor is None:
            return content[..., LAYOUT["root_velocity"]]
        return self.regressor(torch.cat([content[..., LAYOUT["yaw_velocity"]], motion[..., LOCAL]], dim=-1).mT).mT

    def assembled(self, content: Float[Tensor, "B T D"], code: Float[Tensor, "B Z L"]) -> Float[Tensor, "B T D"]:
        """Features of a stylised code: local movement of the code, turning of the content, travel that fits both."""
        made = self.decode(code)
        content = content[:, : made.shape[1]]
        rest = made[..., LAYOUT["root_height"].start :]
        return torch.cat([content[..., LAYOUT["yaw_velocity"]], self.travel(made, content), rest], dim=-1)
