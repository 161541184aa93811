"""The Text2Motion engine: a sentence in, Motions of the length it calls for out."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor

from engines import text
from engines.actions import Action
from engines.errors import Cancelled, CheckpointError, MotionloomError, OutOfRangeError, UnknownLabelError, demand_whole
from engines.motion import Motion, Provenance, Segment
from engines.text import TextEncoder
from engines.text.prompts import CheckedPrompt, PromptCheck
from engines.text.words import Words
from engines.text2motion import output, train, words
from engines.text2motion.config import Text2MotionConfig
from engines.text2motion.model import Text2Motion, generate
from engines.text2motion.networks import UNIT
from engines.text2motion.packed import PackedVAE
from engines.weights_file import SHIPPED

MAX_COUNT = 1024
USUAL = "small"
"""The variant whose weights have no name of their own."""
_BATCH = 64
"""Motions made together: bounds memory, lets progress and cancel be heard."""

Progress = Callable[[int, int], None]


@dataclass(frozen=True, eq=False)
class Lengths:
    """How long a motion of a sentence may be."""

    frames: np.ndarray
    """(L,) lengths at 20 a second, ascending."""
    chances: np.ndarray
    """(L,) float64, of each; they add to 1."""

    @property
    def likeliest(self) -> int:
        """Frames."""
        return int(self.frames[int(self.chances.argmax())])

    @property
    def mean(self) -> float:
        """Frames."""
        return float((self.frames * self.chances).sum())

    def draw(self, uniform: float) -> int:
        """Frames, by a draw in [0, 1)."""
        return int(self.frames[min(int((self.chances.cumsum() <= uniform).sum()), len(self.frames) - 1)])


@dataclass(frozen=True, eq=False)
class WordAttention:
    """What each snippet of a motion looked at."""

    words: tuple[str, ...]
    """Words and pieces of words of the prompt, start and end marks (empty) included."""
    weights: np.ndarray
    """(S, words) float32, rows add to 1."""
    frames: int
    """Of a snippet."""


class Text2MotionEngine:
    """Sentences to motion; `engines.load("text2motion")` makes one.

    Args:
        model: with text2motion.
        weights_hash: SHA-256 of its weights.
        encoder: of words; the one of the settings if none.
        variant: which of `variants` it is.
    """

    name = "text2motion"
    description = "Sentences become motions as long as they call for (temporal VAE, Guo et al. 2022)."
    licence = "CC BY-NC 4.0 (trained on Bandai-Namco clips)"
    fps = output.FPS
    actions: tuple[Action, ...] = ()
    """It takes sentences only."""

    def __init__(
        self, model: Text2Motion, weights_hash: str, encoder: TextEncoder | None = None, variant: str = USUAL
    ) -> None:
        if model.text2motion is None:
            raise CheckpointError(
                "these weights hold no text2motion; train it (motionloom train text2motion --stage text2motion)."
            )
        self.model = model.eval().requires_grad_(False)
        self.config: Text2MotionConfig = model.config
        self.weights_hash, self.variant = weights_hash, variant
        self.variants: tuple[str, ...] = tuple(dict.fromkeys([*variants(), variant]))
        self.max_frames = self.config.longest
        able = {"text", "variants", "scale_bones"}
        able |= {"lengths"} if model.text2length is not None else set()
        able |= {"word_attention"} if model.text2motion.attention is not None else set()
        self.capabilities = frozenset(able)
        self._encoder = encoder
        self._packed = PackedVAE(model.text2motion)
        self._reader: PromptCheck | None = None

    # ---- what a person asks for ---------------------------------------------------------------------------

    def generate(self, prompt: str, seconds: float | None = None, seed: int = 0, **options: Any) -> Motion:
        """One motion of a sentence; see `generate_many`.

        Args:
            prompt: a sentence in English.
            seconds: how long; drawn from `lengths(prompt)` if it is not said.
            seed: as there.
            options: as there.
        """
        if seconds is not None:
            options["frames"] = _frames_of(seconds, self.max_frames)
        return self.generate_many(prompt=prompt, count=1, seed=seed, **options)[0]

    def generate_many(  # noqa: PLR0913 - the request of a person, each part optional
        self,
        action: str | None = None,
        count: int = 4,
        frames: int | None = None,
        seed: int = 0,
        *,
        prompt: str | None = None,
        temperature: float = 1.0,
        bone_scale: Mapping[str, float] | None = None,
        progress: Progress | None = None,
        cancel: Callable[[], bool] | None = None,
    ) -> list[Motion]:
        """Different motions of one sentence, in batched passes.

        Args:
            action: a sentence too, where no prompt is given.
            count: 1 to 1024.
            frames: exactly so many, 1 to `max_frames` at 20 fps; each motion's are drawn from `lengths(prompt)` if it
                is not said.
            seed: 0 to 2^63 - 1; the same seed gives the same motions, and motion i does not depend on `count`
                beyond rounding.
            prompt: a sentence in English.
            temperature: by which the prior's deviations are multiplied, 0 to 2; below 1 nearer to the usual.
            bone_scale: joint -> factor for the bone that leads to it, "*" for all.
            progress: called with (motions done, count).
            cancel: asked between batches; stops with `Cancelled`.

        Returns:
            Motions; where a person should know something of how theirs was read, `provenance.parameters["unmet"]`
            says it.

        Raises:
            MotionloomError: the prompt is empty or cannot be read, or no length is said and the weights tell none.
            OutOfRangeError: a number is outside its range.
        """
        demand_whole("count", count, 1, MAX_COUNT)
        asked = _Asked([prompt or action or ""] * count, range(count), frames, seed, temperature, bone_scale)
        return self._make(asked, progress, cancel)

    def generate_each(  # noqa: PLR0913 - as `generate_many`
        self,
        prompts: Sequence[str],
        frames: int | None = None,
        seed: int = 0,
        *,
        temperature: float = 1.0,
        progress: Progress | None = None,
        cancel: Callable[[], bool] | None = None,
    ) -> list[Motion]:
        """A motion of each of many sentences, in batched passes; arguments as in `generate_many`."""
        demand_whole("number of prompts", len(prompts), 1, MAX_COUNT)
        return self._make(_Asked(prompts, [0] * len(prompts), frames, seed, temperature, None), progress, cancel)

    def lengths(self, prompt: str) -> Lengths:
        """How long motions of a sentence are, as text2length has learned it.

        Raises:
            MotionloomError: the prompt is empty or cannot be read, or the weights hold no text2length.
        """
        return self._lengths(words.read([self.read(prompt).sentence], self.encoder))[0]

    def expected_frames(self, action: str | None = None, prompt: str | None = None) -> int:
        """How long a motion of a sentence likely is where nobody says it; errors as `lengths`."""
        return self.lengths(prompt or action or "").likeliest

    def attention(self, motion: Motion) -> WordAttention:
        """What each snippet of a motion made by this engine looked at while it was made.

        Raises:
            MotionloomError: the motion was made by another engine or with other weights, or words are not attended to.
        """
        told, origin = motion.provenance.parameters, motion.provenance
        if origin.source != self.name or origin.weights != self.weights_hash or not origin.prompt:
            raise MotionloomError("word attention is known only of motions that this engine made of a sentence.")
        if "word_attention" not in self.capabilities:
            raise MotionloomError("these weights were trained without attention to words.")
        asked = _Asked([origin.prompt], [origin.index], told.get("frames"), origin.seed or 0,
                       told.get("temperature", 1.0), None)  # fmt: skip
        heat: list[Tensor] = []
        made = self._codes(asked, heat)
        weights = torch.stack(heat, 1)[0, : int(made.count[0])].numpy()
        (pieces,) = self.encoder.pieces([origin.prompt])
        return WordAttention(("", *pieces[: weights.shape[1] - 2], ""), weights, self.config.frames_a_code)

    # ---- how it is made -----------------------------------------------------------------------------------

    @property
    def encoder(self) -> TextEncoder:
        """Of words; loaded when it is first needed."""
        if self._encoder is None:
            self._encoder = text.load(self.config.text_encoder)
        return self._encoder

    def read(self, prompt: str) -> CheckedPrompt:
        """A prompt as this engine reads it: checked, with the words it does not know.

        Raises:
            MotionloomError: it is empty or cannot be read.
            OutOfRangeError: it is too long.
        """
        if self._reader is None:
            self._reader = PromptCheck(Words(self.config.words), self.encoder)
        return self._reader.read(prompt)

    def _make(self, asked: _Asked, progress: Progress | None, cancel: Callable[[], bool] | None) -> list[Motion]:
        asked.check(self.max_frames)
        readings = {prompt: self.read(prompt) for prompt in dict.fromkeys(asked.prompts)}
        made: list[Motion] = []
        for first in range(0, len(asked.prompts), _BATCH):
            if cancel and cancel():
                raise Cancelled(f"cancelled after {len(made)} of {len(asked.prompts)} motions; none was kept")
            part = asked.part(first, readings)
            told = {"frames": asked.frames, "temperature": asked.temperature, "variant": self.variant}
            drawn = self._codes(part)
            motions = output.to_motions(drawn.codes, drawn.count, self.model, drawn.frames)
            for motion, prompt, place in zip(motions, asked.prompts[first:], part.indices, strict=False):
                made.append(self._finished(motion, readings[prompt], place, asked, told))
            if progress:
                progress(len(made), len(asked.prompts))
        return made

    def _finished(
        self, motion: Motion, reading: CheckedPrompt, place: int, asked: _Asked, told: Mapping[str, Any]
    ) -> Motion:
        parameters = dict(told)
        if said := reading.notes():
            parameters["unmet"] = said
        if asked.bone_scale:
            parameters["bone_scale"] = dict(asked.bone_scale)
        origin = Provenance(self.name, self.weights_hash, reading.sentence, asked.seed, place, parameters)
        labels = (Segment(0, len(motion), "text", reading.sentence),)
        done = motion.replaced(labels=labels, provenance=origin)
        return done.scale_bones(asked.bone_scale) if asked.bone_scale else done

    @torch.inference_mode()
    def _codes(self, asked: _Asked, heat: list[Tensor] | None = None) -> _Made:
        """Codes of sentences that were read."""
        net, config = self.model.text2motion, self.config
        assert net is not None
        different = list(dict.fromkeys(asked.prompts))
        rows = torch.tensor([different.index(sentence) for sentence in asked.prompts])
        read = words.read(different, self.encoder)
        streams = [_stream(asked.seed, index) for index in asked.indices]
        uniform = [stream.random() for stream in streams]
        if asked.frames is None:
            lengths = self._lengths(read)
            frames = [lengths[row].draw(draw) for row, draw in zip(rows.tolist(), uniform, strict=True)]
        else:
            frames = [asked.frames] * len(asked.prompts)
        # whole fours of frames are made, whatever of the last is kept
        count = torch.tensor([-(-kept // UNIT) * UNIT // config.frames_a_code for kept in frames])
        most = int(count.max())
        shape = (config.longest_codes, net.sizes.latent)
        noise = np.stack([stream.standard_normal(shape, dtype=np.float32)[:most] for stream in streams])
        steps = self._packed.steps(self.model.read(read.rows(rows)), count, most)
        scaled = torch.from_numpy(noise) * asked.temperature
        codes = generate(steps, self.model.start(len(count)), scaled, heat)
        return _Made(codes, count, frames)

    @torch.inference_mode()
    def _lengths(self, read: words.WordBatch) -> list[Lengths]:
        config = self.config
        if self.model.text2length is None:
            raise MotionloomError("these weights do not tell how long a motion is; say it (frames or seconds).")
        logits = self.model.length_logits(read).double()
        frames = UNIT * np.arange(1, config.classes + 1)
        allowed = frames >= config.shortest
        chances = logits[:, torch.from_numpy(allowed)].softmax(-1).numpy()
        return [Lengths(frames[allowed], row) for row in chances]


@dataclass(frozen=True)
class _Asked:
    """A request: a motion a prompt."""

    prompts: Sequence[str]
    indices: Sequence[int]
    """Which of the seed's streams each is drawn from."""
    frames: int | None
    seed: int
    temperature: float
    bone_scale: Mapping[str, float] | None

    def check(self, most: int) -> None:
        """Refuse numbers that are not accepted."""
        if self.frames is not None:
            demand_whole("frames", self.frames, 1, most)
        demand_whole("seed", self.seed, 0, 2**63 - 1)
        if isinstance(self.temperature, bool) or not 0.0 <= self.temperature <= 2.0:
            raise OutOfRangeError("temperature", self.temperature, "0 to 2")

    def part(self, first: int, readings: Mapping[str, CheckedPrompt]) -> _Asked:
        """Some of it, made together, prompts as they were read."""
        chosen = slice(first, first + _BATCH)
        prompts = [readings[prompt].sentence for prompt in self.prompts[chosen]]
        return _Asked(prompts, self.indices[chosen], self.frames, self.seed, self.temperature, self.bone_scale)


@dataclass(frozen=True)
class _Made:
    """Codes of some motions of a request."""

    codes: Tensor
    """(B, S, C)."""
    count: Tensor
    """(B,) codes of each."""
    frames: list[int]
    """... and frames."""


def variants() -> tuple[str, ...]:
    """Those whose weights ship: the usual one first, then text2motion-NAME.safetensors."""
    found = sorted(path.stem.removeprefix("text2motion-") for path in SHIPPED.glob("text2motion-*.safetensors"))
    return (USUAL, *found)


def load(variant: str = USUAL, checkpoint: str | Path | None = None) -> Any:
    """The engine with shipped weights, with weights of `motionloom train text2motion`, or the authors' checkpoints.

    Args:
        variant: one of `variants()`.
        checkpoint: weights written by `motionloom train text2motion` (.safetensors with its .json beside it), or a
            folder with the authors' files (see `official_engine.load`).

    Raises:
        UnknownLabelError: no such variant.
        CheckpointError: a file is missing, damaged or of another architecture.
    """
    if variant not in variants():
        raise UnknownLabelError("variant of text2motion", variant, variants())
    shipped = SHIPPED / ("text2motion.safetensors" if variant == USUAL else f"text2motion-{variant}.safetensors")
    path = Path(checkpoint) if checkpoint else shipped
    if path.is_dir():
        from engines.text2motion import official_engine

        return official_engine.load(path)
    model = train.load(path)
    try:
        return Text2MotionEngine(model, hashlib.sha256(path.read_bytes()).hexdigest(), variant=variant)
    except CheckpointError as error:
        raise CheckpointError(f"{path}: {error}") from error


def _stream(seed: int, index: int) -> np.random.Generator:
    """Everything random of one motion, whatever else is made beside it."""
    return np.random.default_rng(np.random.SeedSequence([seed, index]))


def _frames_of(seconds: float, most: int) -> int:
    if isinstance(seconds, bool) or not isinstance(seconds, int | float) or not 0.05 <= seconds <= most / output.FPS:
        raise OutOfRangeError("seconds", seconds, f"0.05 to {most / output.FPS:g}")
    return max(1, round(seconds * output.FPS))
