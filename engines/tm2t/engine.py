"""The TM2T engine: a sentence in, Motions out; a Motion in, sentences out."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch
from torch import Tensor

from engines import text
from engines.actions import Action
from engines.errors import Cancelled, CheckpointError, MotionloomError, OutOfRangeError, UnknownLabelError, demand_whole
from engines.motion import Motion, Provenance, Segment
from engines.text import TextEncoder
from engines.text.prompts import CheckedPrompt, PromptCheck
from engines.tm2t import output, search, train
from engines.tm2t.attentive import AttentiveGRU
from engines.tm2t.config import TM2TConfig
from engines.tm2t.losses import read_sentences
from engines.tm2t.model import LONGEST_SENTENCE, TM2T
from engines.tm2t.output import TokenFigures
from engines.tm2t.packed import PackedGRU
from engines.tm2t.sampling import sample, uniforms
from engines.tm2t.vocabulary import FRAMES_A_TOKEN
from engines.weights_file import SHIPPED

MAX_COUNT = 1024
_BATCH = 64
"""Motions made together: bounds memory, lets progress and cancel be heard."""
_LEAST = 5
"""Tokens of the shortest motion that ends by itself, 1 s; no clip of the training is shorter."""
_NEVER_ENDED = "It had come to no end when it was as long as motions may be; it was cut there."

Progress = Callable[[int, int], None]


class Caption(NamedTuple):
    """A sentence that describes a motion."""

    sentence: str
    score: float
    """Log-probability over the number of words ** 0.7: nearer 0 is likelier."""


@dataclass(frozen=True, eq=False)
class WordAttention:
    """What each motion token looked at."""

    words: tuple[str, ...]
    """Words and pieces of words of the prompt, start and end marks included."""
    weights: np.ndarray
    """(t, words) float32, rows add to 1."""
    codes: np.ndarray
    """(t,) the tokens, four frames each."""
    frames: int = FRAMES_A_TOKEN
    """Of a token."""


@dataclass(frozen=True)
class _Made:
    """Tokens of some motions of a request."""

    codes: list[Tensor]
    ended: list[bool]
    heat: list[np.ndarray]


class TM2TEngine:
    """Text and motion both ways; `engines.load("tm2t")` makes one.

    Args:
        model: with the parts it was trained in.
        weights_hash: SHA-256 of its weights.
        encoder: of words; the one of the settings if none.
        variant: which of `variants` it is.
        dtype: of the weights that every step of text2motion reads.
    """

    name = "tm2t"
    description = "Sentences become motions and motions become sentences, by motion tokens (Guo et al. 2022)."
    licence = "CC BY-NC 4.0 (trained on Bandai-Namco clips)"
    fps = output.FPS
    variants: tuple[str, ...] = ("small",)
    actions: tuple[Action, ...] = ()
    """None: it is told in sentences alone."""

    def __init__(
        self,
        model: TM2T,
        weights_hash: str,
        encoder: TextEncoder | None = None,
        variant: str = "small",
        dtype: torch.dtype = torch.float32,
    ) -> None:
        self.model = model.eval().requires_grad_(False)
        self.config: TM2TConfig = model.config
        self.weights_hash, self.variant = weights_hash, variant
        self.max_frames = self.config.longest
        abilities = {"text", "lengths"} if model.text2motion is not None else set()
        abilities |= {"word_attention"} if isinstance(model.text2motion, AttentiveGRU) else set()
        abilities |= {"caption"} if model.motion2text is not None else set()
        self.capabilities = frozenset(abilities | {"variants", "tokens"})
        self._encoder = encoder
        early = isinstance(model.text2motion, AttentiveGRU) and not self.config.late_attention
        self._packed = PackedGRU(model.text2motion, dtype) if early else None  # pyright: ignore[reportArgumentType]
        self._reader: PromptCheck | None = None

    # ---- text to motion -----------------------------------------------------------------------------------

    def generate(self, prompt: str, seconds: float | None = None, seed: int = 0, **options: Any) -> Motion:
        """One motion of a sentence; see `generate_many`.

        Args:
            prompt: a sentence in English.
            seconds: how long; the model ends by itself if it is not said.
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
        top_k: int | None = None,
        temperature: float = 1.0,
        bone_scale: Mapping[str, float] | None = None,
        progress: Progress | None = None,
        cancel: Callable[[], bool] | None = None,
    ) -> list[Motion]:
        """Different motions of one sentence, in batched passes.

        Args:
            action: a sentence too, where no prompt is given.
            count: 1 to 1024.
            frames: exactly so many, 1 to `max_frames` at 20 fps; each motion ends by itself if it is not said.
            seed: 0 to 2^63 - 1; the same seed gives the same motions, and motion i does not depend on `count`
                beyond rounding.
            prompt: a sentence in English.
            top_k: draw each token among so many of the likeliest; the settings' if none, 1 always the likeliest.
            temperature: above 1 more even, below 1 more often the likeliest; 0.1 to 5.
            bone_scale: joint -> factor for the bone that leads to it, "*" for all.
            progress: called with (motions done, count).
            cancel: asked between batches; stops with `Cancelled`.

        Returns:
            Motions; where a person should know something of how theirs was read, `provenance.parameters["unmet"]`
            says it.

        Raises:
            MotionloomError: the prompt is empty or cannot be read, or the weights make no motions.
            OutOfRangeError: a number is outside its range.
        """
        demand_whole("count", count, 1, MAX_COUNT)
        return self._make([prompt or action or ""] * count, range(count), frames, seed, top_k, temperature,
                          bone_scale, progress, cancel)  # fmt: skip

    def generate_each(  # noqa: PLR0913 - as `generate_many`
        self,
        prompts: Sequence[str],
        frames: int | None = None,
        seed: int = 0,
        *,
        top_k: int | None = None,
        temperature: float = 1.0,
        progress: Progress | None = None,
        cancel: Callable[[], bool] | None = None,
    ) -> list[Motion]:
        """A motion of each of many sentences, in batched passes; arguments as in `generate_many`."""
        demand_whole("number of prompts", len(prompts), 1, MAX_COUNT)
        return self._make(prompts, [0] * len(prompts), frames, seed, top_k, temperature, None, progress, cancel)

    def attention(self, motion: Motion) -> WordAttention:
        """What each token of a motion made by this engine looked at while it was made.

        Raises:
            MotionloomError: the motion was made by another engine or with other weights, or by a transformer.
        """
        told, origin = motion.provenance.parameters, motion.provenance
        if origin.source != self.name or origin.weights != self.weights_hash or not origin.prompt:
            raise MotionloomError("word attention is known only of motions that this engine made of a sentence.")
        if not isinstance(self.model.text2motion, AttentiveGRU):
            raise MotionloomError("these weights translate by a transformer, which attends in many ways at once.")
        made = self._tokens(
            [origin.prompt], [origin.index], told.get("frames"), origin.seed or 0,
            told.get("top_k", self.config.top_k), told.get("temperature", 1.0), heat=True,
        )  # fmt: skip
        (pieces,) = self.encoder.pieces([origin.prompt])
        weights = made.heat[0]
        lack = weights.shape[1] - len(pieces)
        words = ("", *pieces, *[""] * (lack - 1)) if lack > 0 else tuple(pieces[: weights.shape[1]])
        return WordAttention(words, weights, made.codes[0].numpy())

    # ---- motion to text -----------------------------------------------------------------------------------

    def caption(self, motion: Motion, beams: int = 2, count: int = 3) -> list[Caption]:
        """Sentences that describe a motion, the likeliest first.

        Args:
            motion: of any skeleton and rate; of one longer than `max_frames` the middle is described.
            beams: of the search, 1 to 16; as many as `count` at least are used.
            count: how many sentences at most, 1 to 16.

        Raises:
            OutOfRangeError: a number is outside its range.
            MotionloomError: the weights hold no motion2text.
        """
        return self.caption_many([motion], beams, count)[0]

    def caption_many(self, motions: Sequence[Motion], beams: int = 2, count: int = 3) -> list[list[Caption]]:
        """Sentences for each of many motions, in one batched search; arguments as in `caption`."""
        net, words = self.model.motion2text, self.model.words
        if net is None:
            raise MotionloomError("these weights hold no motion2text; train it (motionloom train tm2t --stage m2t).")
        demand_whole("beams", beams, 1, 16)
        demand_whole("count", count, 1, 16)
        kept = max(beams, count)
        told: list[list[Caption]] = []
        for first in range(0, len(motions), _BATCH):
            rows = [self._middle(output.to_tokens(motion, self.model)) for motion in motions[first : first + _BATCH]]
            tokens = self.model.tokens.rows([row.numpy() for row in rows])
            with torch.inference_mode():
                source = net.read(tokens, tokens != self.model.tokens.pad).repeated(kept)
                found = search.beam_search(net.steps(source), words, len(rows), kept, LONGEST_SENTENCE - 1)
            for sentences in found:
                best = {words.sentence(one.words): one.score for one in reversed(sentences)}
                ranked = sorted(best.items(), key=lambda pair: -pair[1])
                told.append([Caption(sentence, score) for sentence, score in ranked[:count]])
        return told

    # ---- tokens -------------------------------------------------------------------------------------------

    def tokens(self, motion: Motion) -> np.ndarray:
        """(t,) the motion tokens of a motion, four frames each."""
        return output.to_tokens(motion, self.model).numpy()

    def from_tokens(self, codes: Sequence[int]) -> Motion:
        """The motion that tokens stand for, four frames each.

        Raises:
            OutOfRangeError: none, too many, or one that is not in the codebook.
        """
        rows = torch.as_tensor(list(codes), dtype=torch.long)
        if not len(rows) >= 1 or rows.min() < 0 or rows.max() >= self.config.codes:
            raise OutOfRangeError("codes", list(codes)[:8], f"one or more of 0 to {self.config.codes - 1}")
        (motion,) = output.to_motions([rows], self.model)
        return motion.replaced(provenance=Provenance(self.name, self.weights_hash, parameters={"codes": rows.tolist()}))

    def gallery(self, codes: Sequence[int] | None = None) -> TokenFigures:
        """The tokens, each decoded by itself to its four frames: all of them, or some."""
        if codes is not None and not all(0 <= code < self.config.codes for code in codes):
            raise OutOfRangeError("codes", list(codes)[:8], f"0 to {self.config.codes - 1}")
        return output.figures(self.model, codes)

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
            self._reader = PromptCheck(self.model.words, self.encoder)
        return self._reader.read(prompt)

    def _make(  # noqa: PLR0913, PLR0917 - the request of a person
        self, prompts: Sequence[str], indices: Sequence[int], frames: int | None, seed: int, top_k: int | None,
        temperature: float, bone_scale: Mapping[str, float] | None, progress: Progress | None,
        cancel: Callable[[], bool] | None,
    ) -> list[Motion]:  # fmt: skip
        if self.model.text2motion is None:
            raise MotionloomError("these weights hold no text2motion; train it (motionloom train tm2t --stage t2m).")
        if frames is not None:
            demand_whole("frames", frames, 1, self.max_frames)
        demand_whole("seed", seed, 0, 2**63 - 1)
        among = self.config.top_k if top_k is None else top_k
        demand_whole("top_k", among, 1, self.config.codes)
        if not 0.1 <= temperature <= 5.0:
            raise OutOfRangeError("temperature", temperature, "0.1 to 5")
        readings = {prompt: self.read(prompt) for prompt in dict.fromkeys(prompts)}
        told = {"frames": frames, "top_k": among, "temperature": temperature, "variant": self.variant}
        if bone_scale:
            told["bone_scale"] = dict(bone_scale)
        made: list[Motion] = []
        for first in range(0, len(prompts), _BATCH):
            if cancel and cancel():
                raise Cancelled(f"cancelled after {len(made)} of {len(prompts)} motions; none was kept")
            rows = [readings[prompt] for prompt in prompts[first : first + _BATCH]]
            places = indices[first : first + _BATCH]
            drawn = self._tokens([row.sentence for row in rows], places, frames, seed, among, temperature)
            for motion, row, place, ended in zip(
                output.to_motions(drawn.codes, self.model, frames), rows, places, drawn.ended, strict=True
            ):
                said = row.notes() + ([] if ended else [_NEVER_ENDED])
                parameters = {**told, "unmet": said} if said else told
                origin = Provenance(self.name, self.weights_hash, row.sentence, seed, place, parameters)
                labels = (Segment(0, len(motion), "text", row.sentence),)
                done = motion.replaced(labels=labels, provenance=origin)
                made.append(done.scale_bones(bone_scale) if bone_scale else done)
            if progress:
                progress(len(made), len(prompts))
        return made

    @torch.inference_mode()
    def _tokens(  # noqa: PLR0913, PLR0917 - what a draw depends on
        self, sentences: Sequence[str], indices: Sequence[int], frames: int | None, seed: int, among: int,
        temperature: float, heat: bool = False,
    ) -> _Made:  # fmt: skip
        net, marks = self.model.text2motion, self.model.tokens
        different = list(dict.fromkeys(sentences))
        encoded = self.encoder.encode(different)
        rows = torch.tensor([different.index(sentence) for sentence in sentences])
        vectors, lengths = encoded.tokens[rows], encoded.mask.sum(1)[rows]
        if isinstance(net, AttentiveGRU):
            steps: Any = (self._packed or net).steps(net.read(vectors, lengths))
        else:
            assert net is not None
            steps = net.steps(read_sentences(net, vectors, lengths))
        exactly = None if frames is None else -(-frames // FRAMES_A_TOKEN)
        most = self.config.longest_tokens
        seen: list[Tensor] | None = [] if heat else None
        uniform = uniforms(seed, list(indices), most)
        drawn = sample(steps, marks, uniform, among, temperature, exactly, _LEAST, seen)
        counts = drawn.lengths.tolist()
        codes = [row[:count] for row, count in zip(drawn.tokens, counts, strict=True)]
        ended = [exactly is not None or count < most for count in counts]
        looked = torch.stack(seen, 1).numpy() if seen else np.zeros((len(codes), 0, 0), dtype=np.float32)
        return _Made(codes, ended, [row[:count] for row, count in zip(looked, counts, strict=True)])

    def _middle(self, codes: Tensor) -> Tensor:
        spare = max(0, len(codes) - self.config.longest_tokens)
        return codes[spare // 2 : spare // 2 + self.config.longest_tokens]


def load(variant: str = "small", checkpoint: str | Path | None = None) -> Any:
    """The engine with shipped weights, with weights of `motionloom train tm2t`, or with the authors' checkpoints.

    Args:
        variant: small.
        checkpoint: weights written by `motionloom train tm2t` (.safetensors with its .json beside it), or a folder
            with the authors' files (see `official_engine.load`).

    Raises:
        UnknownLabelError: no such variant.
        CheckpointError: a file is missing, damaged or of another architecture.
    """
    if variant not in TM2TEngine.variants:
        raise UnknownLabelError("variant of tm2t", variant, TM2TEngine.variants)
    path = Path(checkpoint) if checkpoint else SHIPPED / "tm2t.safetensors"
    if path.is_dir():
        from engines.tm2t import official_engine

        return official_engine.load(path)
    model = train.load(path)
    if not model.config.parts:
        raise CheckpointError(f"{path}: its settings name no part of TM2T")
    return TM2TEngine(model, hashlib.sha256(path.read_bytes()).hexdigest(), variant=variant)


def _frames_of(seconds: float, most: int) -> int:
    if isinstance(seconds, bool) or not isinstance(seconds, int | float) or not 0.05 <= seconds <= most / output.FPS:
        raise OutOfRangeError("seconds", seconds, f"0.05 to {most / output.FPS:g}")
    return max(1, round(seconds * output.FPS))
