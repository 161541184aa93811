"""TM2T's three networks in one module, those that are there."""

from __future__ import annotations

from typing import Any

import torch
from torch import Tensor, nn

from engines.features.humanml3d import HUMANML3D
from engines.text.words import Words
from engines.tm2t import transformer
from engines.tm2t.attentive import AttentiveGRU, GRUSizes
from engines.tm2t.config import PARTS, TM2TConfig
from engines.tm2t.tokenizer import AveragedCodebook, Codebook, MotionTokenizer
from engines.tm2t.transformer import Translator
from engines.tm2t.vocabulary import MotionTokens

LAYOUT = HUMANML3D.layout
HIDDEN_FEATURES = LAYOUT.part("contacts").size
"""At the end of the features; the encoder is not shown them."""
LONGEST_SENTENCE = 48
"""Words, punctuation and marks."""


class TM2T(nn.Module):
    """Tokenizer, motion2text and text2motion, as far as `config.parts` names them.

    Args:
        config: with its vocabulary.
    """

    mean: Tensor
    std: Tensor
    tokenizer: MotionTokenizer
    motion2text: Translator | None
    text2motion: AttentiveGRU | Translator | None

    def __init__(self, config: TM2TConfig) -> None:
        super().__init__()
        self.config = config
        self.tokens = MotionTokens(config.codes)
        self.words = Words(config.words)
        self.trained = ""
        """The part that is trained now; the others evaluate, whatever mode the whole is in."""
        self.register_buffer("mean", torch.zeros(LAYOUT.size))
        self.register_buffer("std", torch.ones(LAYOUT.size))
        self.tokenizer = make_tokenizer(config)
        self.motion2text = make_motion2text(config) if PARTS["m2t"] in config.parts else None
        self.text2motion = make_text2motion(config) if PARTS["t2m"] in config.parts else None

    def train(self, mode: bool = True) -> TM2T:
        """As torch's, but for frozen parts."""
        super().train(mode)
        for name, part in self.named_children():
            if self.trained and name != self.trained:
                part.eval()
        return self

    def freeze_all_but(self, part: str) -> None:
        """Train one part; the others neither learn nor drop anything."""
        self.trained = part
        for name, child in self.named_children():
            for parameter in child.parameters():
                parameter.requires_grad_(name == part and not _is_averaged(child, parameter))
        self.train(self.training)

    def normalised(self, features: Tensor) -> Tensor:
        """Features (..., D) as the tokenizer sees them."""
        return (features - self.mean) / self.std

    def denormalised(self, values: Tensor) -> Tensor:
        """The way back."""
        return values * self.std + self.mean


def _is_averaged(child: nn.Module, parameter: Tensor) -> bool:
    """Is it the codebook that follows by averages, not by gradients?"""
    book = getattr(child, "codebook", None)
    return isinstance(book, AveragedCodebook) and parameter is book.weight


def make_tokenizer(config: TM2TConfig) -> MotionTokenizer:
    """The tokenizer of the settings, weights drawn from torch's generator."""
    if config.codebook_update == "ema":
        book = AveragedCodebook(config.codes, config.code_size, config.codebook_decay, config.codebook_least)
    else:
        book = Codebook(config.codes, config.code_size)
    widths = (config.code_size, config.vq_width, LAYOUT.size)
    channels = (config.vq_width, config.code_size)
    return MotionTokenizer(LAYOUT.size, HIDDEN_FEATURES, channels, widths, config.decoder_blocks, book)


def make_motion2text(config: TM2TConfig) -> Translator:
    """Motion tokens -> words."""
    return Translator(
        transformer.Sizes(
            source=MotionTokens(config.codes).size,
            target=Words(config.words).size,
            layers=config.m2t_layers,
            source_places=config.longest_tokens + 2,
            target_places=LONGEST_SENTENCE,
            **_widths(config),
        )
    )


def make_text2motion(config: TM2TConfig) -> AttentiveGRU | Translator:
    """Word vectors -> motion tokens."""
    tokens = MotionTokens(config.codes).size
    if config.backbone == "gru":
        return AttentiveGRU(
            GRUSizes(
                config.text_size, tokens, config.text_hidden, config.motion_hidden, config.motion_layers,
                config.late_attention,
            )
        )  # fmt: skip
    return Translator(
        transformer.Sizes(
            source=config.text_size,
            target=tokens,
            layers=config.t2m_layers,
            source_vectors=True,
            target_places=config.longest_tokens + 2,
            **_widths(config),
        )
    )


def _widths(config: TM2TConfig) -> dict[str, Any]:
    names = ("width", "inner", "heads", "head_size", "dropout")
    return {name: getattr(config, name) for name in names}
