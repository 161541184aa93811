"""Settings of Text2Motion, saved as JSON beside its weights."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from engines.config import Config
from engines.config import preset as named
from engines.errors import OutOfRangeError, UnknownLabelError

STAGES = ("autoencoder", "text2length", "text2motion")
"""In the order in which they are trained; each is also the name of what it trains."""
Stage = Literal["autoencoder", "text2length", "text2motion"]


@dataclass(frozen=True)
class Text2MotionConfig(Config):
    """Sizes and schedules of all three stages; the defaults are the preset `small`, which ships."""

    parts: tuple[str, ...] = ()
    """Which of `STAGES` the weights hold."""
    words: tuple[str, ...] = ()
    """Of the captions, to say which words of a prompt are not among them."""
    text_encoder: str = "minilm"
    """Of `engines.text`; its token vectors are what sentences are read as."""
    text_size: int = 384
    """Their size."""

    snippet_codes: bool = True
    """Generate snippet codes; if not, frames themselves (the paper's ablation "w/o SnC")."""
    attention: bool = True
    """Attend to single words ("w/o Att")."""
    tags: bool = True
    """Tell parts of speech and kinds of motion words ("w/o PoS")."""
    sides: bool = True
    """Tell which words name a side or a way, and which; the paper's vectors of words need it less."""
    position: bool = True
    """Tell how many codes are still to come ("w/o PoE")."""

    code_size: int = 192
    """Numbers of a snippet code."""
    autoencoder_hidden: int = 256
    """Channels between its convolutions."""
    dropout: float = 0.2
    """In the motion encoder."""
    text_hidden: int = 128
    """Of each direction of text2motion's text encoder."""
    length_hidden: int = 128
    """... of text2length's."""
    length_tags: bool = True
    """Tell text2length parts of speech and kinds of motion words."""
    attention_size: int = 256
    latent_size: int = 64
    latent_hidden: int = 256
    """Of the GRUs of prior and posterior."""
    motion_hidden: int = 384
    """Of the generator's."""

    window: int = 64
    """Frames of a training window of the autoencoder."""
    shortest: int = 20
    """Frames of the shortest motion that is learned from, and that text2length tells."""
    longest: int = 200
    """Frames of the longest one."""
    sparsity: float = 0.001
    """Weight of the size of codes (lambda_spr, equation 4.2)."""
    smoothness: float = 0.001
    """Weight of the difference of neighbouring codes (lambda_smt)."""
    motion_weight: float = 1.0
    """Weight of the decoded motion (lambda_mot, equation 4.6)."""
    kl_weight: float = 0.02
    """lambda_KL."""
    kl_ramp: int = 4_000
    """Steps over which it rises from nothing; 0: it is there from the start."""
    teacher_forcing: float = 0.4
    """Chance that a motion is fed with its real codes while it is learned, p_tf."""
    teacher_forcing_first: float = 1.0
    """... at the first step."""
    teacher_forcing_steps: int = 8_000
    """Steps over which it falls from the first to the last; 0: it is the last from the start."""
    curriculum_first: int = 8
    """Codes that are generated at first, T_cur."""
    curriculum_steps: int = 8_000
    """Steps over which they become as many as the longest motion has; 0: one more each time validation gets worse."""
    keep_short: bool = True
    """Learn from motions shorter than the codes that are aimed for, too; the paper leaves them out."""
    cut_end: float = 0.5
    """Chance that a motion loses its last four frames."""
    decoder_rate: float = 0.1
    """Learning rate of the motion decoder while text2motion is learned, a share of the others'."""

    batch_size: int = 32
    """Motions."""
    autoencoder_batch: int = 128
    """Windows."""
    texts_each: int = 2
    """Captions of a motion in a batch."""
    label_balance: float = 0.5
    """A label with n clips is drawn with a chance proportional to n ** label_balance."""
    autoencoder_steps: int = 10_000
    length_steps: int = 4_000
    steps: int = 20_000
    """Training steps of text2motion; the two above are of the stages before."""
    learning_rate: float = 4e-4
    final_learning_rate: float = 1e-5
    weight_decay: float = 0.0
    average: float = 0.999
    """Decay of the moving average of the weights."""
    clip_norm: float = 0.5
    """Gradients longer than this are shortened to it."""

    extra: Mapping[str, Any] = field(default_factory=dict)
    """Notes that travel with the weights."""

    @property
    def frames_a_code(self) -> int:
        """4, or 1 without snippet codes."""
        return 4 if self.snippet_codes else 1

    @property
    def longest_codes(self) -> int:
        """Of the longest motion."""
        return self.longest // self.frames_a_code

    @property
    def classes(self) -> int:
        """Lengths that text2length tells apart, T_max: 4, 8, ... `longest` frames."""
        return self.longest // 4

    def steps_of(self, stage: Stage) -> int:
        """Training steps of a stage."""
        return getattr(self, _STEPS[stage])

    def with_steps(self, stage: Stage, steps: int) -> Text2MotionConfig:
        """A copy with other steps of a stage."""
        return self.replaced(**{_STEPS[stage]: steps})

    def checked(self) -> Text2MotionConfig:
        """Itself, once every number is in its range.

        Raises:
            OutOfRangeError: one is not; the message says which and what would be accepted.
        """
        for name in _COUNTS:
            if getattr(self, name) < 1:
                raise OutOfRangeError(name, getattr(self, name), "1 or more")
        for name in ("teacher_forcing", "teacher_forcing_first", "dropout", "cut_end"):
            if not 0 <= getattr(self, name) <= 1:
                raise OutOfRangeError(name, getattr(self, name), "0 to 1")
        for name in _NOT_NEGATIVE:
            if getattr(self, name) < 0:
                raise OutOfRangeError(name, getattr(self, name), "0 or more")
        for name in ("window", "shortest", "longest"):
            if getattr(self, name) % 4:
                raise OutOfRangeError(name, getattr(self, name), "a multiple of 4, the frames of a code")
        for name in ("latent_hidden", "motion_hidden"):
            if getattr(self, name) % 2:
                raise OutOfRangeError(name, getattr(self, name), "an even number: sines and cosines of time to arrival")
        if self.shortest > self.longest:
            raise OutOfRangeError("shortest", self.shortest, f"up to {self.longest}, the longest")
        if self.curriculum_first > self.classes:
            raise OutOfRangeError("curriculum_first", self.curriculum_first, f"up to {self.classes}, the longest")
        return self


_STEPS = {"autoencoder": "autoencoder_steps", "text2length": "length_steps", "text2motion": "steps"}
_COUNTS = (
    "text_size", "code_size", "autoencoder_hidden", "text_hidden", "length_hidden", "attention_size", "latent_size",
    "latent_hidden", "motion_hidden", "window", "shortest", "longest", "curriculum_first", "batch_size",
    "autoencoder_batch", "texts_each", "autoencoder_steps", "length_steps", "steps",
)  # fmt: skip
_NOT_NEGATIVE = (
    "sparsity", "smoothness", "motion_weight", "kl_weight", "kl_ramp", "teacher_forcing_steps", "curriculum_steps",
    "decoder_rate", "label_balance", "learning_rate", "clip_norm",
)  # fmt: skip

SMALL = Text2MotionConfig()
PAPER = Text2MotionConfig(
    text_encoder="glove", text_size=300, sides=False, code_size=512, autoencoder_hidden=512, text_hidden=512,
    length_hidden=512, attention_size=512, latent_size=128, latent_hidden=1024, motion_hidden=1024, shortest=40,
    kl_weight=0.01, kl_ramp=0, teacher_forcing_first=0.4, teacher_forcing_steps=0, curriculum_steps=0, keep_short=False,
    texts_each=1, label_balance=1.0, autoencoder_steps=100_000, length_steps=50_000, steps=300_000, learning_rate=2e-4,
    final_learning_rate=2e-4, average=0.0,
)  # fmt: skip
"""Thesis, section 4.4 "Implementation Details": sizes, weights, rates, teacher forcing, T_cur and T_max; the words of
GloVe. What it leaves open (channels inside the autoencoder, batches, steps) is our choice."""
PRESETS = {"small": SMALL, "paper": PAPER}


def preset(name: str) -> Text2MotionConfig:
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
