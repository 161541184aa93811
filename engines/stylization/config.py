"""Settings of latent stylization, saved as JSON beside its weights."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, get_args

from engines.config import Config
from engines.config import preset as named
from engines.errors import OutOfRangeError, UnknownLabelError

Latent = Literal["ae", "vae", "none"]
LATENTS: tuple[Latent, ...] = get_args(Latent)


@dataclass(frozen=True)
class StylizationConfig(Config):
    """Sizes, loss weights and vocabulary. The defaults are the preset `paper` (thesis section 5.3)."""

    latent: Latent = "ae"
    """The motion autoencoder: plain with L1 and smoothness on its codes, or variational with a light KL; or none, and
    features are stylised themselves (the thesis's ablation)."""
    supervised: bool = True
    """Whether style labels are told."""
    styles: tuple[str, ...] = ()
    """Labels, in one-hot order."""
    pace: tuple[tuple[float, float], ...] = ()
    """How fast each style moves beside a neutral one, (standing, travelling); measured on the clips of the training."""
    window: int = 160
    """Frames of a training window at 30 fps."""

    encoder: tuple[int, ...] = (384, 512)
    """Channels of E after each halving of the rate."""
    latent_size: int = 512
    """Z."""
    decoder: tuple[int, ...] = (512, 512, 384)
    """Channels of D, from the code on."""
    mid: tuple[int, ...] = (768,)
    """Of content and style encoder, after each halving of the rate."""
    content: tuple[int, ...] = (512, 512)
    style: tuple[int, ...] = (768, 512)
    style_size: int = 512
    generator: tuple[int, ...] = (768, 1024, 768)
    regressor: tuple[int, ...] = (512, 256, 128)
    """Of the global motion regressor; without any, the root travels as the content's does."""

    batch_size: int = 64
    """Of the autoencoder and the regressor; the style model has as many pairs."""
    learning_rate: float = 2e-4
    final_learning_rate: float = 2e-5
    l1_weight: float = 1e-3
    """On the size of codes (ae)."""
    smooth_weight: float = 1e-3
    """On the steps of codes in time (ae)."""
    latent_kl_weight: float = 1e-3
    """On codes against the standard normal (vae)."""
    hsa_weight: float = 1.0
    """lambda_hsa, homo-style alignment; 1 and 0.1 in the supervised and the unsupervised setting."""
    cycle_weight: float = 0.1
    """lambda_cyc; 0.1 and 1."""
    kl_weight: float = 0.1
    """lambda_kl; 0.1 and 0.01."""
    critic_weight: float = 0.0
    """Not the thesis's: on what a critic of styles, trained along, says of transferred codes (supervised setting)."""
    kept: float = 0.0
    """Not the thesis's: how much of what a content code cannot say of a motion stays in what is made of it."""
    autoencoder_steps: int = 60_000
    regressor_steps: int = 20_000
    steps: int = 60_000
    """Of the style model."""

    extra: Mapping[str, Any] = field(default_factory=dict)
    """Notes that travel with the weights."""

    @property
    def label_size(self) -> int:
        """How many numbers a label has in the networks: none in the unsupervised setting."""
        return len(self.styles) if self.supervised else 0

    @property
    def criticised(self) -> bool:
        """Whether there is a critic of styles."""
        return self.supervised and self.critic_weight > 0

    def checked(self) -> StylizationConfig:
        """Itself, once every number is in its range.

        Raises:
            OutOfRangeError: one is not.
            UnknownLabelError: no such latent space.
        """
        if self.latent not in LATENTS:
            raise UnknownLabelError("latent space", self.latent, LATENTS)
        if self.window < 16 or self.window % 4:
            raise OutOfRangeError("window", self.window, "a multiple of 4, 16 frames or more")
        for name in ("encoder", "decoder", "mid", "content", "style", "generator", "regressor"):
            sizes = getattr(self, name)
            if min(sizes, default=1) < 1 or not (sizes or name == "regressor"):
                raise OutOfRangeError(name, sizes, "one or more sizes, each 1 or more")
        if not 0 <= self.kept <= 1:
            raise OutOfRangeError("kept", self.kept, "0 to 1")
        if self.batch_size < 1:
            raise OutOfRangeError("batch_size", self.batch_size, "1 or more")
        return self


PAPER = StylizationConfig()
SMALL = StylizationConfig(
    encoder=(192, 192), latent_size=128, decoder=(192, 192, 192), mid=(192,), content=(128, 128), style=(192, 128),
    style_size=64, generator=(192, 256, 192), regressor=(128, 64, 32), batch_size=32, learning_rate=5e-4,
    critic_weight=0.1, kept=0.75, autoencoder_steps=8_000, regressor_steps=2_500, steps=6_000,
)  # fmt: skip
"""What ships: a fifth of the sizes."""
PRESETS = {"paper": PAPER, "small": SMALL}


def preset(name: str, supervised: bool = True) -> StylizationConfig:
    """A named preset, with the loss weights of the setting (thesis, implementation details).

    Raises:
        UnknownLabelError: no such preset.
    """
    found = named(name, PRESETS)
    return found if supervised else found.replaced(supervised=False, hsa_weight=0.1, cycle_weight=1.0, kl_weight=0.01)
