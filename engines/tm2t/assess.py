"""How good a trained TM2T is on clips held out: the figures of its card.

The table of texts is made by `motionloom evaluate`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from engines.datasets import Clip
from engines.evaluation import prompts
from engines.metrics import evaluators, physical
from engines.metrics.evaluators import co_embedding
from engines.motion import Motion
from engines.tm2t.engine import TM2TEngine

PHYSICAL = ("foot_skate", "jitter", "ground_penetration")


@dataclass(frozen=True)
class Caption:
    """What is said of a held-out clip."""

    clip: str
    action: str
    human: str
    """A sentence that the data has of it."""
    made: str
    fit: float
    """Cosine of the made sentence and the clip, by the text evaluator."""
    human_fit: float


@dataclass(frozen=True)
class Assessment:
    """Metres, seconds, and shares from 0 to 1."""

    clips: int
    error: float
    """Mean distance of a joint of a held-out clip, as seen from its root, after tokens and back."""
    recognised: tuple[float, float]
    """Clips recognised as their action: after tokens and back, real."""
    lost: dict[str, tuple[int, int]] = field(default_factory=dict)
    """Action -> clips that are recognised only before tokens and back, and clips."""
    physics: dict[str, tuple[float, float]] = field(default_factory=dict)
    """Means: after tokens and back, real."""
    codes: int = 0
    """Entries of the codebook that the clips use."""
    captions: list[Caption] = field(default_factory=list)
    prompts: list[prompts.Answer] = field(default_factory=list)
    """Of the sixty; none where text2motion is not trained."""


def assess(
    engine: TM2TEngine, clips: Sequence[Clip], sentences: Sequence[str], seed: int = 0, most: int = 300
) -> Assessment:
    """All figures.

    Args:
        engine: to be judged.
        clips: held out, each with an action.
        sentences: of each clip, one that describes it.
        seed: of the choice of clips.
        most: clips that are looked at.
    """
    places = np.random.default_rng(seed).permutation(len(clips))[:most].tolist()
    chosen = [clips[place] for place in places]
    real = [clip.motion[: engine.config.longest] for clip in chosen]
    back = [engine.from_tokens(engine.tokens(motion).tolist()) for motion in real]
    recogniser, judge = evaluators.load("action"), co_embedding.load()

    def right(motions: Sequence[Motion]) -> np.ndarray:
        said = recogniser.recognise(motions)
        return np.array([name == clip.action for name, clip in zip(said, chosen, strict=True)])

    kept, known = right(back), right(real)
    names = np.array([clip.action or "" for clip in chosen])
    made = [found[0].sentence for found in engine.caption_many(real, count=1)]
    human = [str(sentences[place]) for place in places]
    fits, human_fits = judge.similarity(made, real), judge.similarity(human, real)
    return Assessment(
        clips=len(chosen),
        error=float(np.mean([_apart(a, b) for a, b in zip(back, real, strict=True)])),
        recognised=(float(kept.mean()), float(known.mean())),
        lost={
            str(name): (int((known & ~kept)[names == name].sum()), int((names == name).sum()))
            for name in np.unique(names)
        },
        physics={key: (_mean(back, key), _mean(real, key)) for key in PHYSICAL},
        codes=len({int(code) for motion in real for code in engine.tokens(motion)}),
        captions=[
            Caption(clip.name, clip.action or "", human[row], made[row], float(fits[row]), float(human_fits[row]))
            for row, clip in enumerate(chosen)
        ],
        prompts=prompts.answers(lambda asked: engine.generate_many(asked, count=4, seed=seed), recogniser)
        if "text2motion" in engine.config.parts
        else [],
    )


def _apart(made: Motion, real: Motion) -> float:
    """Mean distance of joints as seen from the root, metres."""
    frames = min(len(made), len(real))
    a, b = (motion.positions[:frames] - motion.positions[:frames, :1] for motion in (made, real))
    return float(np.linalg.norm(a - b, axis=-1).mean())


def _mean(motions: Sequence[Motion], key: str) -> float:
    return float(np.mean([physical.summary(motion)[key] for motion in motions]))
