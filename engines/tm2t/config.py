"""Settings of TM2T, saved as JSON beside its weights."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from engines.config import Config
from engines.config import preset as named
from engines.errors import OutOfRangeError, UnknownLabelError

STAGES = ("vq", "m2t", "t2m")
"""In the order in which they are trained."""
Stage = Literal["vq", "m2t", "t2m"]
PARTS = {"vq": "tokenizer", "m2t": "motion2text", "t2m": "text2motion"}
"""Stage -> what it trains."""


@dataclass(frozen=True)
class TM2TConfig(Config):
    """Sizes and schedules of all three stages; the defaults are the preset `small`, which ships."""

    parts: tuple[str, ...] = ()
    """Which of `PARTS` the weights hold."""
    words: tuple[str, ...] = ()
    """Of the captions, in the order of their embeddings."""
    text_encoder: str = "minilm"
    """Of `engines.text`; text2motion reads its token vectors."""
    text_size: int = 384
    """Their size."""

    codes: int = 1024
    """K, entries of the codebook."""
    code_size: int = 192
    """Numbers of an entry."""
    vq_width: int = 192
    """Channels of the tokenizer's convolutions."""
    decoder_blocks: int = 3
    """Residual blocks at the start of the tokenizer's decoder."""
    codebook_update: Literal["gradient", "ema"] = "ema"
    """gradient is the paper's; ema moves entries to the mean of what they stand for and wakes those never used."""
    codebook_decay: float = 0.99
    """Of the moving averages."""
    codebook_least: float = 0.3
    """An entry used less than this often a batch, on average, starts again from a latent of the batch; 0: never."""
    commitment: float = 0.25
    """beta of equation 6.3."""
    movement_weight: float = 2.5
    """On how positions and rotations change from frame to frame, in the tokenizer's loss; the thesis has 0."""
    vq_window: int = 64
    """Frames of a training window."""
    longest: int = 200
    """Frames of the longest motion."""

    text_hidden: int = 192
    """Of each direction of the sentence encoder."""
    motion_hidden: int = 384
    """Of the attentive decoder."""
    motion_layers: int = 1
    """Its GRU layers."""
    late_attention: bool = False
    """Attend after the GRU rather than before it."""
    backbone: Literal["gru", "transformer"] = "gru"
    """Of text2motion."""
    t2m_layers: int = 3
    """Of the transformer of text2motion, encoder and decoder each."""
    m2t_layers: int = 3
    """Of motion2text."""
    width: int = 192
    """Of both transformers."""
    inner: int = 512
    """Of their feed-forward parts."""
    heads: int = 6
    head_size: int = 32
    dropout: float = 0.1

    batch_size: int = 64
    """Motions."""
    vq_batch_size: int = 128
    """Windows, of the stage vq."""
    texts_each: int = 2
    """Captions of a motion in a batch."""
    label_balance: float = 0.5
    """A label with n clips is drawn with a chance proportional to n ** label_balance."""
    label_smoothing: float = 0.1
    teacher_forcing: float = 0.4
    """Chance that a batch of the attentive GRU is fed with the real tokens (thesis 6.3.3)."""
    alignment: float = 1.0
    """Weight of the inverse alignment, the second term of equation 6.7; 0 trains without."""
    temperature: float = 1.0
    """tau of the Gumbel-softmax."""
    top_k: int = 10
    """Motion tokens are drawn among so many of the likeliest; the thesis has 100. Of the sixty prompts 57 % were
    recognised with 100, 61 % with 20, 63 % with 5, 58 % with 1 (weights of 2,100 steps)."""

    steps: int = 20_000
    """Training steps that the schedules span."""
    learning_rate: float = 3e-4
    final_learning_rate: float = 1e-5
    weight_decay: float = 1e-2
    average: float = 0.999
    """Decay of the moving average of the weights."""
    clip_norm: float = 1.0
    """Gradients longer than this are shortened to it."""

    extra: Mapping[str, Any] = field(default_factory=dict)
    """Notes that travel with the weights."""

    @property
    def longest_tokens(self) -> int:
        """Motion tokens of the longest motion, four frames each."""
        return self.longest // 4

    def checked(self) -> TM2TConfig:
        """Itself, once every number is in its range.

        Raises:
            OutOfRangeError: one is not; the message says which and what would be accepted.
        """
        for name in _COUNTS:
            if getattr(self, name) < 1:
                raise OutOfRangeError(name, getattr(self, name), "1 or more")
        for name in ("teacher_forcing", "label_smoothing", "dropout", "codebook_decay"):
            if not 0 <= getattr(self, name) <= 1:
                raise OutOfRangeError(name, getattr(self, name), "0 to 1")
        for name in ("alignment", "commitment", "movement_weight", "codebook_least", "learning_rate"):
            if getattr(self, name) < 0:
                raise OutOfRangeError(name, getattr(self, name), "0 or more")
        for name in ("vq_window", "longest"):
            if getattr(self, name) % 4:
                raise OutOfRangeError(name, getattr(self, name), "a multiple of 4, the frames of a token")
        if self.temperature <= 0:
            raise OutOfRangeError("temperature", self.temperature, "above 0")
        return self


_COUNTS = (
    "text_size", "codes", "code_size", "vq_width", "decoder_blocks", "vq_window", "longest", "text_hidden",
    "motion_hidden", "motion_layers", "t2m_layers", "m2t_layers", "width", "inner", "heads", "head_size", "batch_size",
    "vq_batch_size", "texts_each", "top_k", "steps",
)  # fmt: skip

SMALL = TM2TConfig()
PAPER = TM2TConfig(
    text_encoder="glove", text_size=300, codes=1024, code_size=1024, vq_width=1024, codebook_update="gradient",
    commitment=1.0, movement_weight=0.0, top_k=100, longest=196, text_hidden=512, motion_hidden=1024, t2m_layers=3,
    m2t_layers=4, width=512, inner=2048, heads=8, head_size=64, texts_each=1, label_balance=1.0, label_smoothing=0.0,
    learning_rate=2e-4, final_learning_rate=2e-4, weight_decay=0.0, steps=200_000,
)  # fmt: skip
"""Thesis, section 6.3.3: the sizes, the rate, the teacher forcing; the words of GloVe."""
PRESETS = {"small": SMALL, "paper": PAPER}


def preset(name: str) -> TM2TConfig:
    """A named preset; `UnknownLabelError` if there is no such one."""
    return named(name, PRESETS)


def check_stage(name: str) -> Stage:
    """The stage of that name.

    Raises:
        UnknownLabelError: no such stage.
    """
    if name not in STAGES:
        raise UnknownLabelError("stage", name, STAGES)
    return name  # pyright: ignore[reportReturnType]
