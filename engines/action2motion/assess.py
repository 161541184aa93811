"""How good a trained Action2Motion is, on held-out clips and on its own draws: the figures of the model card.

The evaluators and metrics of the papers are a matter of their own; recognition here is by nearest neighbours among real
training clips, which needs no training and is measured on held-out real clips in the same way.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch

from engines.action2motion.data import Sequences
from engines.action2motion.engine import Action2MotionEngine
from engines.action2motion.model import Draws
from engines.action2motion.representation import encode
from engines.datasets import Clip
from engines.metrics import physical
from engines.motion import Motion

FRAMES = 60
"""Length of the compared stretch at 20 fps."""
NEIGHBOURS = 5


@dataclass(frozen=True)
class Figure:
    """A mean with its 95 % interval (bootstrap over motions)."""

    mean: float
    low: float
    high: float

    def __str__(self) -> str:
        return f"{self.mean:.3g} ({self.low:.3g} to {self.high:.3g})"


@dataclass(frozen=True)
class Assessment:
    """Figures of generated and of held-out real motions, and how well each action is recognised."""

    generated: dict[str, Figure]
    real: dict[str, Figure]
    recognised: dict[str, float]
    """Action -> share of its draws whose nearest real clips say that action."""
    real_recognised: dict[str, float]
    joint_error_cm: float
    """Mean distance of reconstructed joints of held-out clips, root-relative, latents from the posterior."""
    kl_nats: float
    """Nats a model frame between posterior and prior on the same clips."""


def assess(engine: Action2MotionEngine, train: Sequence[Clip], test: Sequence[Clip], draws: int = 8) -> Assessment:
    """All figures; `draws` motions an action."""
    known = set(engine.config.actions)
    train = [clip for clip in train if clip.action in known]
    test = [clip for clip in test if clip.action in known]
    bank = np.stack([fingerprint(clip.motion) for clip in train])
    labels = [clip.action or "" for clip in train]
    made = {a: engine.generate_many(a, count=draws, frames=FRAMES, seed=11) for a in engine.config.actions}
    generated = [motion for motions in made.values() for motion in motions]
    shown = {action: [recognise(motion, bank, labels) for motion in motions] for action, motions in made.items()}
    seen: dict[str, list[bool]] = {}
    for clip in test:
        seen.setdefault(clip.action or "", []).append(recognise(clip.motion, bank, labels) == clip.action)
    error, kl = _reconstruction(engine, test)
    return Assessment(
        generated=_figures(generated),
        real=_figures([clip.motion[:FRAMES] for clip in test]),
        recognised={action: float(np.mean([said == action for said in names])) for action, names in shown.items()},
        real_recognised={action: float(np.mean(right)) for action, right in seen.items()},
        joint_error_cm=error,
        kl_nats=kl,
    )


def fingerprint(motion: Motion) -> np.ndarray:
    """What a motion looks like over its first three seconds: joints in the heading frame and travel, flattened."""
    stretch = motion[: min(len(motion), FRAMES)]
    features = encode(stretch)
    at = np.minimum(np.arange(0, FRAMES, 3), len(stretch) - 1)
    travel = np.cumsum(features.velocity, axis=0)[at] * np.array([3.0, 3.0, 2.0])
    moved = features.positions[at] - features.positions[at].mean(axis=0)
    return np.concatenate([features.positions[at].ravel(), 1.5 * moved.ravel(), travel.ravel()]).astype(np.float32)


def recognise(motion: Motion, bank: np.ndarray, labels: list[str]) -> str:
    """The action most of the nearest real clips show, the nearest counting most."""
    distance = np.linalg.norm(bank - fingerprint(motion), axis=1)
    nearest = np.argsort(distance)[:NEIGHBOURS]
    votes: dict[str, float] = {}
    for i in nearest:
        name = labels[int(i)]
        votes[name] = votes.get(name, 0.0) + 1.0 / (1e-6 + float(distance[i]))
    return max(votes, key=lambda name: votes[name])


def _figures(motions: Sequence[Motion]) -> dict[str, Figure]:
    rows = [physical.summary(motion) for motion in motions]
    return {name: _interval(np.array([row[name] for row in rows])) for name in rows[0]}


def _interval(values: np.ndarray) -> Figure:
    rng = np.random.default_rng(0)
    means = values[rng.integers(0, len(values), (1000, len(values)))].mean(axis=1)
    return Figure(float(values.mean()), float(np.quantile(means, 0.025)), float(np.quantile(means, 0.975)))


def _reconstruction(engine: Action2MotionEngine, clips: Sequence[Clip]) -> tuple[float, float]:
    """Joint error in centimetres and KL in nats a frame on held-out clips, teacher-forced."""
    from engines.action2motion.losses import gaussian_kl

    sequences = Sequences(clips, engine.config)
    batch = sequences.draw(np.random.default_rng(0), size=min(256, len(sequences)))
    silent = torch.zeros(*batch.mask.shape, engine.config.latent_size)
    with torch.inference_mode():
        poses, gaussians = engine.model.reconstruct(
            batch.vectors, batch.conditions, batch.positions, Draws(silent, forced=batch.mask.shape[1])
        )
    error = (poses.positions - batch.positions).norm(dim=-1).mean()
    return 100 * float(error), float(gaussian_kl(*gaussians).sum(-1).mean())
