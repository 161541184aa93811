"""An engine on the released Text2Motion: the authors' own checkpoints in, Motions out.

A folder is given, whose files are told by what they hold: the checkpoint of text2motion with its autoencoder, that of
the length estimator (each .tar, .pth, .pt or .safetensors, at any depth), `mean.npy` and `std.npy` as text2motion was
trained with, and the released words, `our_vab_words.pkl` with `our_vab_data.npy`. Without an estimator lengths must be
said.

The release read sentences through a tagger that also gave nouns and verbs in their base form; ours is
`engines.text.tags`, and words the release does not have as they are, are looked up in their base forms.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor

from engines import features
from engines.errors import Cancelled, CheckpointError, MotionloomError, demand_whole
from engines.motion import Motion, Provenance, Segment
from engines.text import tags
from engines.text.glove import END, START, UNKNOWN, GloVe, read_array, read_words
from engines.text.lexicon import base_forms
from engines.text.prompts import tidy
from engines.text2motion import official
from engines.text2motion.engine import MAX_COUNT, Lengths
from engines.text2motion.model import generate
from engines.text2motion.networks import UNIT, LengthEstimator
from engines.text2motion.official_weights import OfficialParts, parts_of
from engines.text2motion.packed import PackedVAE
from engines.text2motion.words import WordBatch

_SUFFIXES = {".tar", ".pth", ".pt", ".safetensors"}
_BATCH = 32
_DIALECTS = {263: "humanml3d-official", 251: "kit-official"}


class OfficialText2Motion:
    """Generates with released checkpoints; `engines.load("text2motion", checkpoint=folder)` makes one.

    Args:
        parts: networks.
        mean: (D,) of the features.
        std: (D,).
        words: those of the release.
        weights_hash: SHA-256 over the files of the networks.

    Raises:
        CheckpointError: no VAE or no autoencoder, or sizes that do not go together.
    """

    name = "text2motion"
    description = "The authors' own Text2Motion (Guo et al. 2022)."
    licence = "that of the checkpoint; the authors release theirs for research"
    variant = "official"
    variants = ("official",)
    actions = ()
    max_frames = official.LONGEST

    def __init__(
        self, parts: OfficialParts, mean: np.ndarray, std: np.ndarray, words: GloVe, weights_hash: str
    ) -> None:
        if parts.vae is None or parts.autoencoder is None:
            raise CheckpointError("text2motion and its autoencoder are needed")
        if len(mean) not in _DIALECTS or mean.shape != std.shape:
            raise CheckpointError(
                f"mean.npy has shape {mean.shape}, std.npy {std.shape}; accepted: {' or '.join(map(str, _DIALECTS))} "
                "numbers in both"
            )
        if parts.vae.sizes.word != words.size or parts.autoencoder.decoder.out.out_features != len(mean):
            raise CheckpointError(
                f"the networks take words of {parts.vae.sizes.word} numbers and tell "
                f"{parts.autoencoder.decoder.out.out_features} features; the words have {words.size}, mean.npy has "
                f"{len(mean)}"
            )
        self.vae, self.autoencoder, self.words, self.weights_hash = parts.vae, parts.autoencoder, words, weights_hash
        self._packed = PackedVAE(parts.vae) if parts.vae.sizes.layers == 1 else None
        self.estimator: LengthEstimator | None = parts.lengths
        self.mean, self.std = torch.from_numpy(mean).float(), torch.from_numpy(std).float()
        self.codec = features.get(_DIALECTS[len(mean)])
        self.fps = self.codec.fps
        self.capabilities = frozenset({"text"} | ({"lengths"} if parts.lengths is not None else set()))

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
        """Different motions of one sentence, as the release makes them; as `Text2MotionEngine.generate_many`."""
        demand_whole("count", count, 1, MAX_COUNT)
        demand_whole("seed", seed, 0, 2**63 - 1)
        if frames is not None:
            demand_whole("frames", frames, 1, self.max_frames)
        sentence = tidy(prompt or action or "")
        read, unknown = self.read(sentence)
        said = [f"The released words have no {word!r}." for word in unknown]
        told = {"frames": frames, "variant": self.variant, **({"unmet": said} if said else {})}
        made: list[Motion] = []
        for first in range(0, count, _BATCH):
            if cancel and cancel():
                raise Cancelled(f"cancelled after {len(made)} of {count} motions; none was kept")
            places = range(first, min(count, first + _BATCH))
            for place, motion in zip(places, self._motions(read, frames, seed, places), strict=True):
                origin = Provenance(self.name, self.weights_hash, sentence, seed, place, told)
                labels = (Segment(0, len(motion), "text", sentence),)
                made.append(motion.replaced(labels=labels, provenance=origin))
            if progress:
                progress(len(made), count)
        return made

    @torch.inference_mode()
    def lengths(self, prompt: str) -> Lengths:
        """The estimator's chances of 1 code and more, which is a class each.

        Raises:
            MotionloomError: the prompt cannot be read, or there is no estimator.
        """
        chances = self._logits(self.read(tidy(prompt))[0]).double().softmax(-1)[1:]
        return Lengths(UNIT * np.arange(1, len(chances) + 1), (chances / chances.sum()).numpy())

    def expected_frames(self, action: str | None = None, prompt: str | None = None) -> int:
        """How long a motion of a sentence likely is where nobody says it; errors as `lengths`."""
        return self.lengths(prompt or action or "").likeliest

    def read(self, sentence: str) -> tuple[WordBatch, list[str]]:
        """A sentence between its marks, and the words that are not known."""
        found = [word for word in tags.words_of(sentence) if word[0].isalnum()][: official.SENTENCE]
        vectors, kinds, unknown = [self.words.vector(START)], [tags.OTHER], []
        for word, part in zip(found, tags.parts_of_speech(found), strict=True):
            known = self._known(word, part)
            unknown += [] if known else [word]
            vectors.append(self.words.vector(known or UNKNOWN))
            kinds.append(tags.released_tag(known or word, part, known is not None))
        rows = torch.from_numpy(np.stack([*vectors, self.words.vector(END)]))
        one_hot = torch.from_numpy(tags.one_hot(np.array([*kinds, tags.OTHER])))
        return WordBatch(rows[None], one_hot[None], torch.tensor([len(rows)])), unknown

    def _known(self, word: str, part: str) -> str | None:
        """The word as the release knows it: nouns and verbs in their base form before others, but for "left"."""
        forms = base_forms(word)
        if part in {"NOUN", "VERB"} and word != "left":
            forms = [*forms[1:], word]
        return next((form for form in forms if form in self.words), None)

    @torch.inference_mode()
    def _motions(self, read: WordBatch, frames: int | None, seed: int, places: range) -> list[Motion]:
        streams = [np.random.default_rng(np.random.SeedSequence([seed, place])) for place in places]
        draws = [torch.from_numpy(stream.random(official.DRAWS)) for stream in streams]
        if frames is None:
            logits, least = self._logits(read), official.LEAST[len(self.mean)]
            count = torch.tensor([official.drawn_length(logits, draw, least) for draw in draws])
            count = count.clamp_max(self.max_frames // UNIT)
        else:
            count = torch.full((len(places),), -(-frames // UNIT))
        shape = (self.max_frames // UNIT, self.vae.sizes.latent)
        noise = np.stack([stream.standard_normal(shape, dtype=np.float32) for stream in streams])
        rows = torch.zeros(len(places), dtype=torch.long)
        told, most = self.vae.reader(*read.rows(rows)), int(count.max())
        # past their end, where the release looks up other times to arrival, motions are cut
        steps = self.vae.steps(told, count) if self._packed is None else self._packed.steps(told, count, most)
        start = official.start(self.autoencoder, len(places))
        codes = generate(steps, start, torch.from_numpy(noise)[:, :most])
        return [self._motion(row[: int(n)], frames) for row, n in zip(codes, count, strict=True)]

    def _motion(self, codes: Tensor, frames: int | None) -> Motion:
        values = self.autoencoder.decode(codes[None])[0] * self.std + self.mean
        motion = self.codec.decode(values.numpy(), source="positions").on_ground().face_front()
        return motion if frames is None else motion[: min(frames, len(motion))]

    def _logits(self, read: WordBatch) -> Tensor:
        if self.estimator is None:
            raise MotionloomError("this checkpoint does not tell how long a motion is; say it (frames or seconds).")
        return self.estimator(*read)[0]


def load(folder: Path) -> OfficialText2Motion:
    """The engine of a folder with the authors' files.

    Args:
        folder: see the module.

    Raises:
        CheckpointError: something is missing, damaged or of another architecture.
    """
    found: dict[str, Any] = {}
    digest = hashlib.sha256()
    for path in sorted(path for path in folder.rglob("*") if path.suffix in _SUFFIXES):
        new = {name: net for name, net in vars(parts_of(path)).items() if net is not None}
        # an autoencoder by itself is that of text2motion before its decoder was fine-tuned
        found |= {name: net for name, net in new.items() if "vae" in new or name not in found}
        digest.update(path.read_bytes())
    if not found:
        raise CheckpointError(
            f"{folder}: holds no checkpoint; accepted: files ending in {', '.join(sorted(_SUFFIXES))}"
        )
    mean, std, vectors = (read_array(_one(folder, name)) for name in ("mean.npy", "std.npy", "our_vab_data.npy"))
    try:
        words = GloVe(read_words(_one(folder, "our_vab_words.pkl")), vectors)
        return OfficialText2Motion(OfficialParts(**found), mean, std, words, digest.hexdigest())
    except CheckpointError as error:
        raise CheckpointError(f"{folder}: {error}") from error


def _one(folder: Path, name: str) -> Path:
    path = next(iter(sorted(folder.rglob(name))), None)
    if path is None:
        raise CheckpointError(f"{folder}: holds no {name}, which the checkpoints need")
    return path
