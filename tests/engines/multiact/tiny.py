"""A small MACVAE with random weights, and clips made by formula."""

from __future__ import annotations

from typing import Any

import torch

from engines.datasets import Clip
from engines.multiact.config import SMALL, MultiActConfig
from engines.multiact.model import MACVAE
from engines.multiact.representation import LAYOUT
from tests.engines.action2motion.tiny import clip

ACTIONS = ("walk", "turn left", "turn right", "throw", "sit down")
SIZES: dict[str, Any] = {
    "width": 16, "heads": 2, "inner": 24, "encoder_layers": 1, "decoder_layers": 1, "batch_size": 4, "pairs": 24,
    "steps": 4,
}  # fmt: skip


def config(**changes: Any) -> MultiActConfig:
    usual = ((40, 60, 90), (30, 60, 90), (30, 60, 90), (20, 30, 40), (20, 30, 40))
    return SMALL.replaced(**{**SIZES, "actions": ACTIONS, "usual_frames": usual, **changes})


def model(seed: int = 0, **changes: Any) -> MACVAE:
    """Random weights; its poses are near a standing body's, which steps ahead."""
    torch.manual_seed(seed)
    made = MACVAE(config(**changes))
    with torch.no_grad():
        made.mean[LAYOUT["rotations"]] = torch.tensor([1.0, 0, 0, 0, 1, 0]).repeat(22)
        made.mean[LAYOUT["height"]] = 0.95
        made.mean[LAYOUT["step"]] = torch.tensor([0.0, 0.05])
        made.std.fill_(0.05)
    return made.eval()


def clips(count: int = 2) -> list[Clip]:
    """Some of each action; the walks turn by formula, the turns too."""
    return [clip(action, 60 + 6 * i, 10 * i + k) for i, action in enumerate(ACTIONS) for k in range(count)]
