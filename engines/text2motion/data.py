"""Real clips for Text2Motion: windows of features, and motions beside captions, mirrored clips among them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import torch
from jaxtyping import Float, Int
from torch import Tensor

from engines.datasets import Clip
from engines.errors import MotionloomError
from engines.text2motion.config import Text2MotionConfig
from engines.text2motion.model import LAYOUT
from engines.text2motion.networks import UNIT
from engines.text2motion.words import Captions, WordBatch
from engines.tm2t.config import TM2TConfig
from engines.tm2t.data import Told, Windows, balanced, mirrored
from engines.training.devices import ALONE, Share

_SPOKEN_OF = 0.6
"""A caption speaks of the whole clip: of a longer one so much must be seen."""
_VALIDATION_SEED = 1

__all__ = ["MotionBatch", "Pairs", "TextBatch", "Told", "Windows", "mirrored", "windows"]


class TextBatch(NamedTuple):
    """Sentences and how long the motions are that they describe."""

    words: WordBatch
    units: Int[Tensor, " R"]
    """Lengths, in fours of frames."""
    sentences: float
    """Of the whole batch, over the number of processes."""


class MotionBatch(NamedTuple):
    """Motions and several sentences of each."""

    features: Float[Tensor, "M T D"]
    """Not normalised, cut to what is aimed for; padding means nothing."""
    count: Int[Tensor, " M"]
    """Codes that are here."""
    whole: Int[Tensor, " M"]
    """... and of the whole motion."""
    words: WordBatch
    """R = M x texts, those of a motion beside each other."""
    texts: int
    steps: float
    """Codes to be told in the whole batch, over the number of processes."""


def windows(clips: Sequence[Clip], config: Text2MotionConfig) -> Windows:
    """Windows of features for the autoencoder, as TM2T's tokenizer is trained on them."""
    like = TM2TConfig(
        vq_window=config.window,
        vq_batch_size=config.autoencoder_batch,
        label_balance=config.label_balance,
        longest=config.longest,
    )
    return Windows(clips, like)


class Pairs:
    """Motions and captions of all clips of a split.

    Args:
        clips: with their mirror images (`mirrored`).
        config: says how long and how many.
        told: captions of these clips.
        captions: the same sentences, as tokens.

    Raises:
        MotionloomError: no clip has a length that fits.
    """

    def __init__(self, clips: Sequence[Clip], config: Text2MotionConfig, told: Told, captions: Captions) -> None:
        self.config, self.captions = config, captions
        self.windows = windows(clips, config)
        most = config.longest / _SPOKEN_OF
        self.places = [at for at, frames in enumerate(self.windows.lengths) if config.shortest <= frames <= most]
        if not self.places:
            raise MotionloomError(
                f"no clip is of a length that Text2Motion can be trained on ({config.shortest} to {most:.0f} frames)."
            )
        self.frames = np.minimum(self.windows.lengths[self.places], config.longest) // UNIT * UNIT
        """(N,) of each at most."""
        self.said = [np.asarray(told.of(clips[at])) for at in self.places]
        self.probability = balanced([clips[at] for at in self.places], config.label_balance)

    def __len__(self) -> int:
        return len(self.places)

    def draw(self, rng: np.random.Generator, aim: int, share: Share = ALONE) -> MotionBatch:
        """A random batch, or this process's share of it: motions of about the same length.

        Args:
            rng: alike in all processes.
            aim: fours of frames that are generated; motions are cut to so many.
            share: which part.
        """
        return self._motions(self._picks(rng, aim), aim, rng, share)

    def each(self, aim: int, share: Share = ALONE) -> Iterator[MotionBatch]:
        """Every clip once with some of its captions, the same each time."""
        rng = np.random.default_rng(_VALIDATION_SEED)
        for picks in self._all():
            yield self._motions(picks, aim, rng, share)

    def draw_texts(self, rng: np.random.Generator, share: Share = ALONE) -> TextBatch:
        """A random batch of sentences with the lengths of their motions."""
        return self._texts(rng.choice(len(self), size=self.config.batch_size, p=self.probability), rng, share)

    def each_texts(self, share: Share = ALONE) -> Iterator[TextBatch]:
        """Some sentences of every clip, the same each time."""
        rng = np.random.default_rng(_VALIDATION_SEED)
        for picks in self._all():
            yield self._texts(picks, rng, share)

    def _picks(self, rng: np.random.Generator, aim: int) -> np.ndarray:
        size = self.config.batch_size
        chance = self.probability
        if not self.config.keep_short:
            # the paper trains on motions that are as long as the codes that are aimed for, or longer
            chance = chance * (self.frames >= min(aim * UNIT, self.frames.max()))
            chance /= chance.sum()
        picks = rng.choice(len(self), size=4 * size, p=chance)
        length = np.minimum(self.frames[picks], aim * UNIT)
        # alike lengths together, ties in any order
        order = np.lexsort((rng.random(len(picks)), length))
        quarter = int(rng.integers(4))
        return picks[order[quarter * size : (quarter + 1) * size]]

    def _all(self) -> Iterator[np.ndarray]:
        size = self.config.batch_size
        order = np.argsort(self.frames, kind="stable")
        order = np.resize(order, -(-len(order) // size) * size)
        yield from (order[first : first + size] for first in range(0, len(order), size))

    def _motions(self, picks: np.ndarray, aim: int, rng: np.random.Generator, share: Share) -> MotionBatch:
        texts, each = self.config.texts_each, self.config.frames_a_code
        parts = [self._window(pick, rng) for pick in picks]
        said = np.array([self._chosen(pick, texts, rng) for pick in picks])
        here = np.array([min(len(part), aim * UNIT) for part in parts])
        rows = range(len(picks))[share.rows]
        features = np.zeros((len(rows), int(here.max()), LAYOUT.size), dtype=np.float32)
        for place, row in enumerate(rows):
            features[place, : here[row]] = parts[row][: here[row]]
        whole = np.array([len(part) for part in parts])[share.rows]
        return MotionBatch(
            torch.from_numpy(features).to(share.device),
            torch.from_numpy(here[share.rows] // each).to(share.device),
            torch.from_numpy(whole // each).to(share.device),
            self.captions.batch(said[share.rows].reshape(-1)).to(share.device),
            texts,
            float(here.sum() / each) * texts / share.world,
        )

    def _texts(self, picks: np.ndarray, rng: np.random.Generator, share: Share) -> TextBatch:
        texts = self.config.texts_each
        units = np.array([len(self._window(pick, rng)) // UNIT for pick in picks])
        said = np.array([self._chosen(pick, texts, rng) for pick in picks])
        words = self.captions.batch(said[share.rows].reshape(-1)).to(share.device)
        told = torch.from_numpy(units[share.rows].repeat(texts)).to(share.device)
        return TextBatch(words, told, len(picks) * texts / share.world)

    def _window(self, pick: int, rng: np.random.Generator) -> np.ndarray:
        """(T, D) features of a clip from one of its first frames on, with or without its last four (thesis 4.4)."""
        clip, frames = self.windows.clip(self.places[pick]), int(self.frames[pick])
        where, cut = rng.random(), rng.random() < self.config.cut_end
        if cut and frames - UNIT >= self.config.shortest:
            frames -= UNIT
        first = int(where * (len(clip) - frames + 1))
        return clip[first : first + frames]

    def _chosen(self, pick: int, texts: int, rng: np.random.Generator) -> np.ndarray:
        """Captions of a clip, different ones as far as there are."""
        rows = self.said[pick]
        return rng.choice(rows, size=texts, replace=len(rows) < texts)
