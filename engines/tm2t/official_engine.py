"""An engine on the released TM2T: the authors' own checkpoints in, Motions and sentences out.

A folder is given, whose files are told by what they hold: the checkpoints of tokenizer, text2motion and motion2text
(each .tar, .pth, .pt or .safetensors, at any depth), `mean.npy` and `std.npy` as the tokenizer was trained with, and
the released words, `our_vab_words.pkl` with `our_vab_data.npy`. What is not there cannot be asked for.

Words are looked up as they are, or in another of their forms (the release was trained on dictionary forms); those the
release does not have are its `unk`, and are named.
"""

from __future__ import annotations

import hashlib
import pickle
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor

from engines import features
from engines.errors import Cancelled, CheckpointError, MotionloomError, OutOfRangeError
from engines.motion import Motion, Provenance, Segment
from engines.text.prompts import forms, tidy
from engines.text.words import split
from engines.tm2t.attentive import AttentiveGRU
from engines.tm2t.engine import MAX_COUNT, Caption
from engines.tm2t.official import BEAMS, MAX_STEPS, MAX_WORDS, TOP_K, beam_search
from engines.tm2t.official_weights import OfficialParts, parts_of
from engines.tm2t.sampling import sample, uniforms
from engines.tm2t.vocabulary import FRAMES_A_TOKEN, MotionTokens

_SUFFIXES = {".tar", ".pth", ".pt", ".safetensors"}
_LONGEST_CAPTION = 20
"""Words read of a sentence."""
_BATCH = 64
_DIALECTS = {263: "humanml3d-official", 251: "kit-official"}


@dataclass(frozen=True)
class OfficialWords:
    """The words of the release and their vectors."""

    words: tuple[str, ...]
    """sos, eos and unk among them."""
    vectors: np.ndarray
    """(N, E) float32."""

    def index(self, word: str) -> int | None:
        """Of a word, or of one of its forms."""
        found = (self.words.index(form) for form in forms(word) if form in self.words)
        return next(found, None)


class OfficialTM2T:
    """Generates and captions with released checkpoints; `engines.load("tm2t", checkpoint=folder)` makes one.

    Args:
        parts: networks.
        mean: (D,) of the features.
        std: (D,).
        words: those of the release.
        weights_hash: SHA-256 over the files of the networks.

    Raises:
        CheckpointError: there is neither text to motion nor motion to text in it.
    """

    name = "tm2t"
    description = "The authors' own TM2T (Guo et al. 2022)."
    licence = "that of the checkpoint; the authors release theirs for research"
    variant = "official"
    variants = ("official",)
    max_frames = MAX_STEPS * FRAMES_A_TOKEN

    def __init__(
        self, parts: OfficialParts, mean: np.ndarray, std: np.ndarray, words: OfficialWords, weights_hash: str
    ) -> None:
        if parts.tokenizer is None or (parts.text2motion is None and parts.motion2text is None):
            raise CheckpointError("a tokenizer, and text2motion or motion2text or both, are needed")
        if len(mean) not in _DIALECTS:
            raise CheckpointError(f"mean.npy has {len(mean)} numbers; accepted: {' or '.join(map(str, _DIALECTS))}")
        self.parts, self.words, self.weights_hash = parts, words, weights_hash
        self.tokenizer = parts.tokenizer
        self.mean, self.std = torch.from_numpy(mean).float(), torch.from_numpy(std).float()
        self.codec = features.get(_DIALECTS[len(mean)])
        self.fps = self.codec.fps
        self.marks = MotionTokens(len(self.tokenizer.codebook.weight))
        able = {"text", "lengths"} if isinstance(parts.text2motion, AttentiveGRU) else set()
        self.capabilities = frozenset(able | ({"caption"} if parts.motion2text is not None else set()))

    def generate(self, prompt: str, seconds: float | None = None, seed: int = 0, **options: Any) -> Motion:
        """One motion of a sentence; see `generate_many`."""
        frames = None if seconds is None else max(1, round(seconds * self.fps))
        return self.generate_many(prompt=prompt, count=1, frames=frames, seed=seed, **options)[0]

    def generate_many(  # noqa: PLR0913 - the request of a person, each part optional
        self,
        action: str | None = None,
        count: int = 4,
        frames: int | None = None,
        seed: int = 0,
        *,
        prompt: str | None = None,
        progress: Callable[[int, int], None] | None = None,
        cancel: Callable[[], bool] | None = None,
    ) -> list[Motion]:
        """Different motions of one sentence, as the release draws them; arguments as `TM2TEngine.generate_many`."""
        net = self.parts.text2motion
        if not isinstance(net, AttentiveGRU):
            raise MotionloomError("this checkpoint makes no motions: it holds no attentive GRU of text2motion.")
        for name, value, most in (("count", count, MAX_COUNT), ("frames", frames, self.max_frames)):
            if value is not None and not 1 <= value <= most:
                raise OutOfRangeError(name, value, f"a whole number from 1 to {most:,}")
        sentence = tidy(prompt or action or "")
        vectors, unknown = self._vectors(sentence)
        said = [f"The released words have no {word!r}." for word in unknown]
        exactly = None if frames is None else -(-frames // FRAMES_A_TOKEN)
        told = {"frames": frames, "variant": self.variant, **({"unmet": said} if said else {})}
        made: list[Motion] = []
        for first in range(0, count, _BATCH):
            if cancel and cancel():
                raise Cancelled(f"cancelled after {len(made)} of {count} motions; none was kept")
            places = range(first, min(count, first + _BATCH))
            rows = vectors[None].expand(len(places), -1, -1)
            with torch.inference_mode():
                steps = net.steps(net.read(rows, torch.full((len(places),), len(vectors))))
                uniform = uniforms(seed, places, MAX_STEPS)
                drawn = sample(steps, self.marks, uniform, TOP_K, exactly=exactly, least=1)
            for place, row, length in zip(places, drawn.tokens, drawn.lengths.tolist(), strict=True):
                origin = Provenance(self.name, self.weights_hash, sentence, seed, place, told)
                motion = self.motion(row[:length])
                motion = motion if frames is None else motion[: min(frames, len(motion))]
                labels = (Segment(0, len(motion), "text", sentence),)
                made.append(motion.replaced(labels=labels, provenance=origin))
            if progress:
                progress(len(made), count)
        return made

    def caption(self, motion: Motion, beams: int = BEAMS, count: int = 1) -> list[Caption]:
        """The sentence that the release finds for a motion; one, whatever `count` is."""
        net = self.parts.motion2text
        if net is None:
            raise MotionloomError("this checkpoint holds no motion2text.")
        if not 1 <= beams <= 16:
            raise OutOfRangeError("beams", beams, "a whole number from 1 to 16")
        rows = torch.from_numpy(self.codec.encode(motion)[: self.max_frames])
        codes = self.tokenizer.encode(((rows - self.mean) / self.std)[None])[0]
        tokens = self.marks.rows([codes.numpy()])
        pad = net.sizes.target - 1
        begin, end = self.words.words.index("sos"), self.words.words.index("eos")
        steps = net.steps(net.read(tokens, torch.ones_like(tokens, dtype=torch.bool)).repeated(beams))
        found = beam_search(steps, begin, end, pad, beams, min(MAX_WORDS, net.sizes.target_places))
        words = [self.words.words[place] for place in found.result if place not in {begin, end, pad}]
        sentence = " ".join(words)
        return [Caption(sentence[:1].upper() + sentence[1:], float("nan"))][:count]

    @torch.inference_mode()
    def motion(self, codes: Tensor) -> Motion:
        """The Motion that codes (t,) stand for, on the house skeleton."""
        values = self.tokenizer.decode(codes[None])[0] * self.std + self.mean
        return self.codec.decode(values.numpy(), source="positions").on_ground().face_front()

    def _vectors(self, sentence: str) -> tuple[Tensor, list[str]]:
        """Vectors (N, E) of a sentence between its marks, and the words that are not known."""
        words = [word for word in split(sentence) if word[0].isalnum()][:_LONGEST_CAPTION]
        places = [self.words.index(word) for word in words]
        unk, begin, end = (self.words.words.index(mark) for mark in ("unk", "sos", "eos"))
        rows = [begin, *(unk if place is None else place for place in places), end]
        unknown = [word for word, place in zip(words, places, strict=True) if place is None]
        return torch.from_numpy(self.words.vectors[rows]).float(), unknown


def load(folder: Path, heads: int = 8) -> OfficialTM2T:
    """The engine of a folder with the authors' files.

    Args:
        folder: see the module.
        heads: of its transformers; their weights do not tell.

    Raises:
        CheckpointError: something is missing, damaged or of another architecture.
    """
    found: dict[str, Any] = {}
    digest = hashlib.sha256()
    for path in sorted(path for path in folder.rglob("*") if path.suffix in _SUFFIXES):
        parts = parts_of(path, heads)
        found |= {name: net for name, net in vars(parts).items() if net is not None}
        digest.update(path.read_bytes())
    if not found:
        raise CheckpointError(
            f"{folder}: holds no checkpoint; accepted: files ending in {', '.join(sorted(_SUFFIXES))}"
        )
    mean, std, vectors = (_array(folder, name) for name in ("mean.npy", "std.npy", "our_vab_data.npy"))
    words = OfficialWords(tuple(_words(_one(folder, "our_vab_words.pkl"))), vectors)
    missing = [mark for mark in ("sos", "eos", "unk") if mark not in words.words]
    if missing or len(words.words) != len(vectors):
        raise CheckpointError(f"{folder}: {len(words.words)} words for {len(vectors)} vectors, lacking {missing}")
    try:
        return OfficialTM2T(OfficialParts(**found), mean, std, words, digest.hexdigest())
    except CheckpointError as error:
        raise CheckpointError(f"{folder}: {error}") from error


def _one(folder: Path, name: str) -> Path:
    path = next(iter(sorted(folder.rglob(name))), None)
    if path is None:
        raise CheckpointError(f"{folder}: holds no {name}, which the checkpoints need")
    return path


def _array(folder: Path, name: str) -> np.ndarray:
    path = _one(folder, name)
    try:
        return np.load(path, allow_pickle=False)
    except (OSError, ValueError) as error:
        raise CheckpointError(f"{path}: cannot be read as an array: {error}") from error


class _TextOnly(pickle.Unpickler):
    """Reads lists of words; anything that would run code is refused."""

    def find_class(self, module: str, name: str) -> Any:
        """No class is wanted."""
        raise pickle.UnpicklingError(f"it asks for {module}.{name}")


def _words(path: Path) -> Sequence[str]:
    try:
        with path.open("rb") as file:
            words = _TextOnly(file).load()
    except (OSError, EOFError, ValueError, IndexError, KeyError, pickle.UnpicklingError) as error:
        raise CheckpointError(f"{path}: cannot be read as a list of words: {error}") from error
    if not isinstance(words, list) or not all(isinstance(word, str) for word in words):
        raise CheckpointError(f"{path}: holds a {type(words).__name__}, not a list of words")
    return words
