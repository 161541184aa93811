"""A few short clips, captions of them, and networks small enough to train in a test."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from typing import Any

import numpy as np
import torch

from engines.datasets import Clip
from engines.features.humanml3d import HUMANML3D
from engines.text import EncodedText
from engines.text.words import Words
from engines.tm2t.config import PARTS, SMALL, TM2TConfig
from engines.tm2t.engine import TM2TEngine
from engines.tm2t.model import LAYOUT, TM2T
from engines.tm2t.train import Material
from tests.engines.action2motion.tiny import clip, clips, movement

__all__ = ["SIZES", "FakeEncoder", "Said", "clip", "clips", "config", "engine", "material", "model", "movement"]

SIZES: dict[str, Any] = {
    "codes": 12, "code_size": 8, "vq_width": 8, "decoder_blocks": 1, "vq_window": 16, "text_hidden": 8, "text_size": 6,
    "motion_hidden": 12, "t2m_layers": 1, "m2t_layers": 1, "width": 16, "inner": 16, "heads": 2, "head_size": 8,
    "batch_size": 4, "vq_batch_size": 4, "top_k": 6, "longest": 40,
}  # fmt: skip
PHRASES = ("A person {}.", "Someone {} slowly, taking two steps.")


class FakeEncoder:
    """A vector for every word, the same whatever stands beside it."""

    name, size = "fake", 6

    def encode(self, sentences: Sequence[str]) -> EncodedText:
        """As `TextEncoder.encode`."""
        rows = [["[CLS]", *pieces, "[SEP]"] for pieces in self.pieces(sentences)]
        longest = max(map(len, rows), default=0)
        tokens = torch.zeros(len(rows), longest, self.size)
        mask = torch.zeros(len(rows), longest, dtype=torch.bool)
        for place, row in enumerate(rows):
            tokens[place, : len(row)] = torch.stack([self._vector(word) for word in row])
            mask[place, : len(row)] = True
        mean = tokens.sum(1) / mask.sum(1, keepdim=True).clamp_min(1)
        return EncodedText(torch.nn.functional.normalize(mean, dim=-1), tokens, mask)

    def pieces(self, sentences: Sequence[str]) -> list[list[str]]:
        """Words."""
        return [sentence.lower().replace(".", " .").split() for sentence in sentences]

    def _vector(self, word: str) -> torch.Tensor:
        seed = int.from_bytes(hashlib.sha256(word.encode()).digest()[:4], "big")
        return torch.from_numpy(np.random.default_rng(seed).normal(size=self.size)).half().float()


class Said:
    """Captions of the tiny clips and of their mirror images."""

    def __init__(self) -> None:
        made = [clip for one in clips(3) for clip in (one, one.mirror())]
        names = sorted({clip.action or "" for clip in made})
        self.sentences = tuple(phrase.format(f"does {name}") for name in names for phrase in PHRASES)
        self._rows = {name: np.array([2 * place, 2 * place + 1]) for place, name in enumerate(names)}

    def of(self, clip: Clip) -> np.ndarray:
        """(2,) of a clip."""
        return self._rows[clip.action or ""]


def material() -> Material:
    return Material(Said(), FakeEncoder())


def config(*parts: str, **changes: Any) -> TM2TConfig:
    """Settings of a few units each, with all parts if none is named."""
    words = Words.of(Said().sentences).known
    return SMALL.replaced(**{**SIZES, "words": words, "parts": parts or tuple(PARTS.values()), **changes})


def model(seed: int = 0, *parts: str, **changes: Any) -> TM2T:
    """Random weights; features on a human scale, tokens that are not all the same."""
    torch.manual_seed(seed)
    made = TM2T(config(*parts, **changes))
    with torch.no_grad():
        features = np.concatenate([HUMANML3D.encode(one.motion) for one in clips(1)])
        made.mean.copy_(torch.from_numpy(features.mean(0)))
        for part in LAYOUT:
            made.std[LAYOUT[part.name]] = max(float(features[:, LAYOUT[part.name]].std()), 0.1) / part.emphasis
        latents = made.tokenizer.latents(made.normalised(torch.from_numpy(features))[None]).flatten(0, 1)
        made.tokenizer.codebook.weight.copy_(latents[:: len(latents) // made.config.codes][: made.config.codes])
    return made.eval()


def engine(**changes: Any) -> TM2TEngine:
    """An engine that makes nonsense, but makes it as a trained one does."""
    return TM2TEngine(model(**changes), "0" * 64, FakeEncoder())
