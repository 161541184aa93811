"""A few short clips, captions of them, and networks small enough to train in a test."""

from __future__ import annotations

from typing import Any

import numpy as np
import torch

from engines.features.humanml3d import HUMANML3D
from engines.text.words import Words
from engines.text2motion.config import SMALL, STAGES, Text2MotionConfig
from engines.text2motion.engine import Text2MotionEngine
from engines.text2motion.model import LAYOUT, Text2Motion
from engines.text2motion.train import Material
from tests.engines.tm2t.tiny import FakeEncoder, Said, clip, clips, movement

__all__ = ["SIZES", "FakeEncoder", "Said", "clip", "clips", "config", "engine", "material", "model", "movement"]

SIZES: dict[str, Any] = {
    "text_size": 6, "code_size": 8, "autoencoder_hidden": 10, "text_hidden": 6, "length_hidden": 5,
    "attention_size": 8, "latent_size": 4, "latent_hidden": 10, "motion_hidden": 12, "window": 16, "shortest": 12,
    "longest": 40, "batch_size": 4, "autoencoder_batch": 4, "curriculum_first": 3, "curriculum_steps": 3,
    "teacher_forcing_steps": 2, "kl_ramp": 2,
}  # fmt: skip


def material() -> Material:
    return Material(Said(), FakeEncoder())


def config(*parts: str, **changes: Any) -> Text2MotionConfig:
    """Settings of a few units each, with all parts if none is named."""
    words = Words.of(Said().sentences).known
    return SMALL.replaced(**{**SIZES, "words": words, "parts": parts or STAGES, **changes})


def model(seed: int = 0, *parts: str, **changes: Any) -> Text2Motion:
    """Random weights; features on a human scale."""
    torch.manual_seed(seed)
    made = Text2Motion(config(*parts, **changes))
    with torch.no_grad():
        features = np.concatenate([HUMANML3D.encode(one.motion) for one in clips(1)])
        made.mean.copy_(torch.from_numpy(features.mean(0)))
        for part in LAYOUT:
            made.std[LAYOUT[part.name]] = max(float(features[:, LAYOUT[part.name]].std()), 0.1) / part.emphasis
    return made.eval()


def engine(**changes: Any) -> Text2MotionEngine:
    """An engine that makes nonsense, but makes it as a trained one does."""
    return Text2MotionEngine(model(**changes), "0" * 64, FakeEncoder())
