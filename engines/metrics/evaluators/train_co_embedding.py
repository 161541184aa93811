"""Train the co-embedding of motions and sentences on the real clips, and measure it on those held out.

Every motion of a batch is to be nearer to its own sentence than to the others', and the other way round (InfoNCE, van
den Oord et al. 2018; with a learnt temperature, Radford et al. 2021). Half of a batch are the mirror images of the
other half, so that sides have to be told apart. A sentence that is true of another motion of the batch as well is not
held against it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor, nn

from engines import weights_file
from engines.datasets import Clip
from engines.datasets.captions import captions
from engines.datasets.captions.encoded import HELD_OUT_SEED, EncodedCaptions
from engines.errors import OutOfRangeError
from engines.geometry.mirror import mirror_words
from engines.metrics import protocol, retrieval
from engines.metrics.evaluators.co_embedding import CoEmbedding, CoEmbeddingConfig, CoEmbeddingNet
from engines.metrics.evaluators.trunk import BONES, InRow, describe, in_row, sampled
from engines.metrics.protocol import Estimate
from engines.training.loop import TrainingPlan, TrainingState, train

_SHARPEST = float(np.log(100.0))
_EXCLUDED = -1e4


class Batch(NamedTuple):
    """Motions and a sentence for each."""

    motions: InRow
    sentences: Tensor
    """(B, E) the encoder's vectors."""
    also: Tensor
    """(B, B) whether sentence j is true of motion i as well, though it was drawn for another one."""


class Pairs:
    """Clips and their mirror images as descriptions, each with its captions.

    Args:
        clips: prepared ones.
        told: their captions.
        longest: frames of a description.

    Raises:
        OutOfRangeError: no clips.
        UnknownLabelError: a clip without captions.
    """

    def __init__(self, clips: Sequence[Clip], told: EncodedCaptions, longest: int) -> None:
        if not clips:
            raise OutOfRangeError("number of clips to train on", 0, "1 or more")
        both = [seen for clip in clips for seen in (clip, clip.mirror())]
        self.rows = [describe(clip.motion, longest) for clip in both]
        self.told = told
        said = [told.of(clip) for clip in both]
        self.counts = np.array([len(rows) for rows in said])
        self.said = np.stack([np.pad(rows, (0, self.counts.max() - len(rows)), mode="edge") for rows in said])
        kinds = [str((clip.action or clip.label or clip.name, clip.style)) for clip in both]
        _, self.kinds, sizes = np.unique(kinds, return_inverse=True, return_counts=True)
        self.sides = np.unique([sides_of(sentence) for sentence in told.sentences], return_inverse=True)[1]
        weight = sizes[self.kinds[::2]] ** -0.5
        self.probability = weight / weight.sum()

    def draw(self, rng: np.random.Generator, size: int) -> Batch:
        """Motions at varied speed, trembling a little, each followed by its mirror image; the sentences alike."""
        clips = rng.choice(len(self.probability), size=size // 2, p=self.probability)
        picks = np.stack([2 * clips, 2 * clips + 1], axis=1).ravel()
        share = np.repeat(rng.random(size // 2), 2)  # the same place in the captions of both, which differ in sides
        said = self.said[picks, (share * self.counts[picks]).astype(int)]
        rows = in_row([_varied(self.rows[pick], rng) for pick in picks])
        sentences = torch.from_numpy(self.told.vectors[said].astype(np.float32))
        return Batch(rows, sentences, torch.from_numpy(self._also(picks, said)))

    def _also(self, picks: np.ndarray, said: np.ndarray) -> np.ndarray:
        """(B, B) sentence j is among the captions of motion i, or was said with the same sides of one of its kind."""
        listed = (self.said[picks][:, :, None] == said).any(axis=1)
        sides, kinds = self.sides[said], self.kinds[picks]
        alike = (kinds[:, None] == kinds) & (sides[:, None] == sides)
        return (listed | alike) & ~np.eye(len(picks), dtype=bool)


def sides_of(sentence: str) -> str:
    """The words of a sentence that a mirror exchanges, in order."""
    pairs = zip(sentence.lower().split(), mirror_words(sentence.lower()).split(), strict=True)
    return " ".join(here.strip(".,") for here, there in pairs if here != there)


def contrast(net: CoEmbeddingNet, batch: Batch) -> dict[str, Tensor]:
    """How surely a motion finds its own sentence among the others', and a sentence its motion (cross entropies)."""
    cosines = net.motions(batch.motions) @ net.texts(batch.sentences).T
    logits = (net.sharpness.clamp(max=_SHARPEST).exp() * cosines).masked_fill(batch.also, _EXCLUDED)
    own = torch.arange(len(logits))
    entropy = nn.functional.cross_entropy
    return {"motion_to_text": entropy(logits, own) / 2, "text_to_motion": entropy(logits.T, own) / 2}


def fit(  # noqa: PLR0913, PLR0917 - what a training needs, each part but three optional
    config: CoEmbeddingConfig,
    clips: Sequence[Clip],
    told: EncodedCaptions,
    checkpoint: Path | None = None,
    seed: int = 0,
    progress: Callable[[TrainingState], None] | None = None,
    cancel: Callable[[], bool] | None = None,
) -> CoEmbedding:
    """Train on clips (the training split) and their captions; goes on where there is a checkpoint.

    Raises:
        OutOfRangeError: no clips, or the captions are of another encoder.
        UnknownLabelError: a clip without captions.
        Everything that `training.loop.train` raises.
    """
    if told.vectors.shape[1] != config.encoder_size:
        raise OutOfRangeError("size of the captions' vectors", told.vectors.shape[1], f"{config.encoder_size}")
    pairs = Pairs(clips, told, config.longest)
    torch.manual_seed(seed)
    net = CoEmbeddingNet(config)
    net.motions.scale_to(pairs.rows)
    state = TrainingState(
        net, TrainingPlan.of(config, seed, final_learning_rate=1e-5, optimiser="adamw", average=0.995)
    )
    if checkpoint and checkpoint.exists():
        state.restore(checkpoint)

    def losses(now: TrainingState) -> dict[str, Tensor]:
        batch = pairs.draw(now.rng, config.batch_size)
        torch.manual_seed(int(now.rng.integers(2**31)))  # of the dropout, so that resuming is exact
        return contrast(net.train(), batch)

    train(state, losses, checkpoint, progress, cancel)
    net.load_state_dict(state.averaged)
    return CoEmbedding(net)


@dataclass(frozen=True)
class Measured:
    """How well motions and sentences that nothing was trained on find each other."""

    figures: dict[str, Estimate]
    """R-precision both ways in pools of 32, and again with no sentence twice in a pool; multimodal distance."""
    sides: float
    """Share of captions with sides that are nearer to their motion than the same caption with sides exchanged."""
    sided: int
    """How many captions have sides."""


def measure(evaluator: CoEmbedding, clips: Sequence[Clip], repeats: int = 20, seed: int = 0) -> Measured:
    """Measure on clips that were held out, with captions drawn as no training draws them.

    Each repeat draws a caption a clip, and pools. Sides are asked of the clips and of their mirror images.

    Raises:
        OutOfRangeError: too few clips to fill a pool.
    """
    said = [captions(clip, HELD_OUT_SEED) for clip in clips]
    texts = evaluator.texts([sentence for some in said for sentence in some])
    motions = evaluator.motions([clip.motion for clip in clips])
    counts = np.array([len(some) for some in said])
    starts = np.cumsum(counts) - counts
    _, identity = np.unique([sentence for some in said for sentence in some], return_inverse=True)

    def once(rng: np.random.Generator) -> dict[str, float]:
        chosen = starts + rng.integers(0, counts)
        own, same = texts[chosen], identity[chosen]
        found = {
            "r_precision": retrieval.r_precision(motions, own, seed=rng),
            "r_precision_different": retrieval.r_precision(motions, own, seed=rng, identity=same),
            "motion_r_precision": retrieval.r_precision(own, motions, seed=rng),
        }
        ranks = {f"{name}_top{k}": share for name, shares in found.items() for k, share in enumerate(shares, start=1)}
        return {**ranks, "multimodal_distance": retrieval.multimodal_distance(motions, own)}

    right = _sides_right(evaluator, [seen for clip in clips for seen in (clip, clip.mirror())])
    return Measured(protocol.repeat(once, repeats, seed), float(np.mean(right)) if len(right) else 0.0, len(right))


def _sides_right(evaluator: CoEmbedding, clips: Sequence[Clip]) -> np.ndarray:
    """(N,) of all captions with sides: is the motion nearer to it than to the same with sides exchanged."""
    told = [(i, sentence) for i, clip in enumerate(clips) for sentence in captions(clip, HELD_OUT_SEED)]
    told = [(i, sentence) for i, sentence in told if sides_of(sentence)]
    if not told:
        return np.zeros(0, dtype=bool)
    motions = evaluator.motions([clip.motion for clip in clips])[[i for i, _ in told]]
    here = evaluator.texts([sentence for _, sentence in told])
    there = evaluator.texts([mirror_words(sentence) for _, sentence in told])
    return (motions * here).sum(1) > (motions * there).sum(1)


def export(evaluator: CoEmbedding, path: Path, **notes: object) -> str:
    """Weights (float16; running statistics float32) and settings beside each other; gives the weights' SHA-256."""
    settings = replace(evaluator.config, extra=dict(notes)).to_json()
    return weights_file.write(evaluator.net.state_dict(), settings, path)


def _varied(row: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """A little faster or slower, begun later and ended sooner; another body, and a camera that trembles."""
    speed = rng.uniform(0.94, 1.06)
    late, soon = rng.uniform(0.0, 0.05 * len(row), size=2)
    made = sampled(row, np.arange(late, len(row) - 1 - soon, speed), speed)
    made[:, :BONES] += rng.normal(scale=0.05, size=BONES)
    return made + 0.01 * rng.standard_normal(size=made.shape, dtype=np.float32)
