"""How good a trained Action2Motion is, on held-out clips and on its own draws: the figures of the model card.

The papers' whole tables are made by `motionloom evaluate`; this is what fits on a card.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch

from engines.action2motion.data import Sequences
from engines.action2motion.engine import Action2MotionEngine
from engines.action2motion.model import Draws
from engines.datasets import Clip
from engines.metrics import evaluators, physical
from engines.motion import Motion

FRAMES = 60
"""Length of the compared stretch at 20 fps."""


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
    """Action -> share of its draws that the shipped recogniser takes for it."""
    real_recognised: dict[str, float]
    joint_error_cm: float
    """Mean distance of reconstructed joints of held-out clips, root-relative, latents from the posterior."""
    kl_nats: float
    """Nats a model frame between posterior and prior on the same clips."""


def assess(engine: Action2MotionEngine, test: Sequence[Clip], draws: int = 8) -> Assessment:
    """All figures; `draws` motions an action, `test` clips that were held out."""
    recogniser = evaluators.load("action")
    test = [clip for clip in test if clip.action in engine.config.actions]
    made = {a: engine.generate_many(a, count=draws, frames=FRAMES, seed=11) for a in engine.config.actions}
    seen: dict[str, list[bool]] = {}
    for clip, said in zip(test, recogniser.recognise([clip.motion[:FRAMES] for clip in test]), strict=True):
        seen.setdefault(clip.action or "", []).append(said == clip.action)
    error, kl = _reconstruction(engine, test)
    return Assessment(
        generated=_figures([motion for motions in made.values() for motion in motions]),
        real=_figures([clip.motion[:FRAMES] for clip in test]),
        recognised={
            action: float(np.mean([said == action for said in recogniser.recognise(motions)]))
            for action, motions in made.items()
        },
        real_recognised={action: float(np.mean(right)) for action, right in seen.items()},
        joint_error_cm=error,
        kl_nats=kl,
    )


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
