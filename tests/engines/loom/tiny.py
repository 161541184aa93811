"""A few short clips and a network small enough to train in a test."""

from __future__ import annotations

from typing import Any

import numpy as np
import torch

from engines.loom.config import LoomConfig
from engines.loom.data import vocabulary_of
from engines.loom.engine import LoomEngine
from engines.loom.model import Loom
from engines.loom.representation import LAYOUT
from engines.skeletons import SMPL22
from tests.engines.action2motion.tiny import clips

SIZES = {"width": 32, "depth": 2, "heads": 2, "inner": 48, "frame_width": 16, "batch_size": 4}


def config(**changes: Any) -> LoomConfig:
    """Settings with the vocabulary of the tiny clips."""
    actions, _, usual = vocabulary_of(clips())
    return LoomConfig(**{**SIZES, "actions": actions, "styles": ("old", "proud"), "usual_frames": usual, **changes})


def model(**changes: Any) -> Loom:
    """Random weights, none of them zero; features on a human scale."""
    torch.manual_seed(0)
    made = Loom(config(**changes))
    with torch.no_grad():
        for parameter in made.parameters():
            if not parameter.any():
                torch.nn.init.normal_(parameter, std=0.02)
        made.std.fill_(0.1)
        made.mean[LAYOUT["height"]] = 0.93
        made.mean[LAYOUT["turns"]] = torch.from_numpy(np.tile([1.0, 0, 0, 0, 1.0, 0], len(SMPL22))).float()
        made.mean[LAYOUT["facing"]] = torch.tensor([1.0, 0.0])
    return made


def engine(**changes: Any) -> LoomEngine:
    """An engine that makes nonsense, but makes it as the trained one does."""
    return LoomEngine(model(**changes), "0" * 64)
