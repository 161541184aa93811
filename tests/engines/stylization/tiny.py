"""Networks small enough for tests, and styled clips made by formula."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import torch

from engines.datasets import Clip
from engines.stylization.config import StylizationConfig
from engines.stylization.engine import StylizationEngine
from engines.stylization.model import Stylizer
from tests.engines.action2motion.tiny import clip

STYLES = ("old", "proud")


SIZES: dict[str, Any] = {
    "styles": STYLES, "window": 32, "encoder": (12, 12), "latent_size": 8, "decoder": (12, 12, 12), "mid": (12,),
    "content": (8, 8), "style": (12, 8), "style_size": 4, "generator": (12, 12, 12), "regressor": (8, 8, 8),
    "batch_size": 4, "autoencoder_steps": 4, "regressor_steps": 4, "steps": 4,
}  # fmt: skip


def config(**changes: Any) -> StylizationConfig:
    return StylizationConfig(**{**SIZES, **changes})


def clips(count: int = 2) -> list[Clip]:
    """Long and short ones of two styles, and one without any."""
    styled = [
        replace(clip("walk", 16 + 20 * i, 7 * i + k), style=style)
        for i, style in enumerate(STYLES)
        for k in range(count)
    ]
    return [*styled, clip("throw", 30, 99)]


def model(**changes: Any) -> Stylizer:
    torch.manual_seed(0)
    return Stylizer(config(**changes)).eval()


def engine(**changes: Any) -> StylizationEngine:
    return StylizationEngine(model(**changes), "0" * 64)
