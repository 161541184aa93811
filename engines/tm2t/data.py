"""Real clips for TM2T: windows of features, then motion tokens beside captions, mirrored clips among them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import torch
from jaxtyping import Float, Int
from torch import Tensor

from engines.datasets import Clip
from engines.errors import MotionloomError
from engines.features import Statistics
from engines.features.humanml3d import HUMANML3D
from engines.text.token_vectors import TokenVectors
from engines.tm2t.config import TM2TConfig
from engines.tm2t.model import LAYOUT, LONGEST_SENTENCE, TM2T
from engines.tm2t.vocabulary import FRAMES_A_TOKEN
from engines.training.devices import ALONE, Share

OFFSETS = FRAMES_A_TOKEN
"""A clip is cut into tokens from each of its first frames on (thesis 6.3.3, "randomly cutting off 0 to 4 frames")."""
_TAIL = 1 / 3
"""Chance that a clip also loses its last token."""
_SPOKEN_OF = 0.6
"""A caption speaks of the whole clip: of a longer one so much must be seen."""
_VALIDATION_SEED = 1


class Told(Protocol):
    """Captions of clips, `engines.datasets.captions.encoded.EncodedCaptions` for one."""

    @property
    def sentences(self) -> tuple[str, ...]:
        """All different ones."""
        ...

    def of(self, clip: Clip) -> np.ndarray:
        """(K,) which of them describe a clip."""
        ...


def mirrored(clips: Sequence[Clip]) -> list[Clip]:
    """Every clip and its mirror image.

    Raises:
        MotionloomError: there is none.
    """
    if not clips:
        raise MotionloomError("no clip to train on; run: motionloom data prepare, or choose other corpora.")
    return [clip for original in clips for clip in (original, original.mirror())]


class Windows:
    """Features of all clips of a split, drawn from as windows of equal length.

    Args:
        clips: with their mirror images (`mirrored`).
        config: says how long and how many.
    """

    def __init__(self, clips: Sequence[Clip], config: TM2TConfig) -> None:
        self.config = config
        # half precision: a millimetre at most, and twice the clips in the same memory
        parts = [HUMANML3D.encode(clip.motion).astype(np.float16) for clip in clips]
        self.lengths = np.array([len(part) for part in parts])
        self.starts = np.concatenate([[0], np.cumsum(self.lengths)[:-1]])
        self.features = np.concatenate(parts)
        self.probability = balanced(clips, config.label_balance) * np.maximum(1.0, self.lengths / config.vq_window)
        self.probability[self.lengths < FRAMES_A_TOKEN] = 0.0
        self.probability /= self.probability.sum()

    def __len__(self) -> int:
        return len(self.lengths)

    def statistics(self) -> tuple[Tensor, Tensor]:
        """Mean and deviation (D,) of the features; root and contacts count five times as much (thesis 6.3.3)."""
        clips = (self.clip(place).astype(np.float32) for place in range(len(self)))
        found = Statistics.measure(clips, LAYOUT).emphasised(LAYOUT)
        return torch.tensor(found.mean), torch.tensor(found.std)

    def clip(self, place: int) -> np.ndarray:
        """(T, D) float16 features of one clip."""
        return self.features[self.starts[place] : self.starts[place] + self.lengths[place]]

    def draw(self, rng: np.random.Generator, share: Share = ALONE) -> Float[Tensor, "B T D"]:
        """A random batch, or this process's share of it: clips of about the same length, so that none is padded."""
        size = self.config.vq_batch_size
        picks = rng.choice(len(self), size=4 * size, p=self.probability)
        most = np.minimum(self.lengths[picks], self.config.vq_window)
        # alike lengths together, ties in any order
        order = np.lexsort((rng.random(len(picks)), most))
        quarter = int(rng.integers(4))
        rows = order[quarter * size : (quarter + 1) * size]
        length = int(most[rows].min()) // FRAMES_A_TOKEN * FRAMES_A_TOKEN
        begin = (rng.random(size) * (self.lengths[picks[rows]] - length + 1)).astype(int)
        return self._cut(picks[rows][share.rows], begin[share.rows], length).to(share.device)

    def each(self, share: Share = ALONE) -> Iterator[Float[Tensor, "B T D"]]:
        """Every clip once, from its beginning, the same each time."""
        size, usable = self.config.vq_batch_size, np.flatnonzero(self.lengths >= FRAMES_A_TOKEN)
        order = usable[np.argsort(self.lengths[usable], kind="stable")]
        order = np.resize(order, -(-len(order) // size) * size)
        for first in range(0, len(order), size):
            picks = order[first : first + size]
            length = min(int(self.lengths[picks].min()), self.config.longest) // FRAMES_A_TOKEN * FRAMES_A_TOKEN
            yield self._cut(picks[share.rows], np.zeros(len(picks[share.rows]), dtype=int), length).to(share.device)

    def _cut(self, picks: np.ndarray, begin: np.ndarray, length: int) -> Tensor:
        index = (self.starts[picks] + begin)[:, None] + np.arange(length)
        return torch.from_numpy(self.features[index].astype(np.float32))


@dataclass(frozen=True)
class Batch:
    """Motions as tokens, and several captions of each."""

    tokens: Int[Tensor, "M L"]
    """Between their marks, padded."""
    words: Int[Tensor, "R N"]
    """R = M x texts, those of a motion beside each other; between their marks, padded."""
    vectors: Float[Tensor, "R W E"]
    """Of the captions' tokens; empty for motion2text."""
    lengths: Int[Tensor, " R"]
    """Tokens of each caption."""
    texts: int
    """Captions of each motion."""
    steps: float
    """Tokens to be told in the whole batch, [EOM] included, over the number of processes."""
    said: float
    """Words to be told in the whole batch, likewise."""


class Pairs:
    """Motion tokens and captions of all clips of a split.

    Args:
        clips: with their mirror images (`mirrored`).
        model: with its tokenizer.
        told: captions of these clips.
        vectors: of the sentences of `told`; none for motion2text.

    Raises:
        MotionloomError: no clip has both a caption and a length that fits.
    """

    def __init__(self, clips: Sequence[Clip], model: TM2T, told: Told, vectors: TokenVectors | None = None) -> None:
        self.config, self.marks, self.vocabulary = model.config, model.tokens, model.words
        self.vectors = vectors
        windows = Windows(clips, self.config)
        coded = [tokens_of(windows.clip(place), model) for place in range(len(clips))]
        fits = [place for place, rows in enumerate(coded) if self._fits(rows)]
        if not fits:
            raise MotionloomError("no clip is of a length that TM2T can be trained on (0.4 s to 16 s).")
        self.coded = [coded[place] for place in fits]
        self.captions = [np.asarray(told.of(clips[place])) for place in fits]
        self.probability = balanced([clips[place] for place in fits], self.config.label_balance)
        chosen = {int(row) for rows in self.captions for row in rows}
        most = LONGEST_SENTENCE - 2
        self.words = {row: self.vocabulary.indices(told.sentences[row])[:most] for row in sorted(chosen)}

    def __len__(self) -> int:
        return len(self.coded)

    def draw(self, rng: np.random.Generator, share: Share = ALONE) -> Batch:
        """A random batch, or this process's share of it: motions of about the same length."""
        size = self.config.batch_size
        picks = rng.choice(len(self), size=4 * size, p=self.probability)
        length = np.array([self.coded[pick].shape[1] for pick in picks])
        order = np.lexsort((rng.random(len(picks)), length))
        quarter = int(rng.integers(4))
        return self._batch(picks[order[quarter * size : (quarter + 1) * size]], rng, share)

    def each(self, share: Share = ALONE) -> Iterator[Batch]:
        """Every clip once with some of its captions, the same each time."""
        rng = np.random.default_rng(_VALIDATION_SEED)
        order = np.argsort([rows.shape[1] for rows in self.coded], kind="stable")
        size = self.config.batch_size
        order = np.resize(order, -(-len(order) // size) * size)
        for first in range(0, len(order), size):
            yield self._batch(order[first : first + size], rng, share)

    def _fits(self, rows: np.ndarray) -> bool:
        return 2 <= rows.shape[1] <= self.config.longest_tokens / _SPOKEN_OF

    def _batch(self, picks: np.ndarray, rng: np.random.Generator, share: Share) -> Batch:
        texts = self.config.texts_each
        motions = [self._window(pick, rng) for pick in picks]
        said = np.array([self._chosen(pick, texts, rng) for pick in picks])
        steps = sum(len(motion) + 1 for motion in motions) * texts
        spoken = sum(len(self.words[int(row)]) + 1 for row in said.flat)
        rows = said[share.rows].reshape(-1)
        words = self.vocabulary.rows([self.words[int(row)] for row in rows])
        if self.vectors is None:
            vectors, lengths = torch.zeros(len(rows), 0, 0), torch.zeros(len(rows), dtype=torch.long)
        else:
            vectors, lengths = self.vectors.rows(rows)
        tokens = self.marks.rows(motions[share.rows])
        tokens, words, vectors, lengths = (part.to(share.device) for part in (tokens, words, vectors, lengths))
        return Batch(tokens, words, vectors, lengths, texts, steps / share.world, spoken / share.world)

    def _window(self, pick: int, rng: np.random.Generator) -> np.ndarray:
        """Tokens of a clip, from one of its first frames on, with or without its last."""
        row = self.coded[pick][int(rng.integers(OFFSETS))]
        where, tail = rng.random(), rng.random() < _TAIL
        if tail and len(row) > 3:
            row = row[:-1]
        spare = max(0, len(row) - self.config.longest_tokens)
        first = int(where * (spare + 1))
        return row[first : first + self.config.longest_tokens]

    def _chosen(self, pick: int, texts: int, rng: np.random.Generator) -> np.ndarray:
        """Captions of a clip, different ones as far as there are."""
        rows = self.captions[pick]
        return rng.choice(rows, size=texts, replace=len(rows) < texts)


@torch.no_grad()
def tokens_of(features: np.ndarray, model: TM2T) -> np.ndarray:
    """(OFFSETS, t) int16 codes of one clip, cut from each of its first frames on; features (T, D), not normalised."""
    count = (len(features) - OFFSETS + 1) // FRAMES_A_TOKEN
    if count < 1:
        return np.zeros((OFFSETS, 0), dtype=np.int16)
    device = model.mean.device
    rows = np.stack([features[offset : offset + count * FRAMES_A_TOKEN] for offset in range(OFFSETS)])
    codes = model.tokenizer.encode(model.normalised(torch.from_numpy(rows.astype(np.float32)).to(device)))
    return codes.cpu().numpy().astype(np.int16)


def balanced(clips: Sequence[Clip], balance: float) -> np.ndarray:
    """(N,) chance of each clip: a label with n clips is drawn with a chance proportional to n ** balance."""
    names = [clip.action or clip.label or "" for clip in clips]
    counts = {name: names.count(name) for name in set(names)}
    weight = np.array([counts[name] ** (balance - 1.0) for name in names])
    return weight / weight.sum()
