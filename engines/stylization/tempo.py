"""How fast each style moves beside the same content done normally: old people wave slowly, yet walk at a usual cadence.

The thesis leaves tempo to the content (section 5.2.2 changes poses, frame by frame). Here each style has two factors,
measured on its clips: for contents on one spot and for contents that travel.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from engines.datasets import Clip
from engines.geometry import rotations
from engines.motion import Motion

NEUTRAL = ("normal", "neutral")
"""Styles that the others are measured against."""
_TRAVELS = 0.3
"""m/s, mean speed of the root from which on a motion travels."""
_SLOWEST, _FASTEST = 0.5, 2.0


def travels(motion: Motion) -> bool:
    """Whether a motion goes somewhere rather than being done on one spot."""
    way = np.linalg.norm(np.diff(motion.translation[:, [0, 2]], axis=0), axis=-1).sum()
    return bool(way > _TRAVELS * motion.duration)


def pace(motion: Motion) -> float:
    """Root mean square frequency of the joints' turning, rad/s: how fast they turn by how far they do."""
    turns = rotations.quaternion_to_matrix(motion.rotations[:, 1:]).reshape(len(motion), -1)
    spread = np.square(turns - turns.mean(axis=0)).sum(axis=1).mean()
    speed = np.square(np.diff(turns, axis=0) * motion.fps).sum(axis=1).mean()
    return float(np.sqrt(speed / max(spread, 1e-9)))


def measured(clips: Sequence[Clip], styles: Sequence[str]) -> tuple[tuple[float, float], ...]:
    """Pace of each style beside a neutral one: (standing, travelling), both 0.5 to 2; 1 where nothing can be compared.

    Of each content the medians are compared, and of the contents the median is taken.
    """
    found: dict[tuple[str, str], list[tuple[float, bool]]] = defaultdict(list)
    for clip in clips:
        if clip.style and clip.action and len(clip.motion) > 2:
            found[clip.action, clip.style].append((pace(clip.motion), travels(clip.motion)))
    middle = {key: np.median([value for value, _ in seen]) for key, seen in found.items()}
    moving = {key: np.mean([moved for _, moved in seen]) > 0.5 for key, seen in found.items()}
    ratios: dict[tuple[str, bool], list[float]] = defaultdict(list)
    for action, style in found:
        for neutral in NEUTRAL:
            if (action, neutral) in found:
                ratios[style, bool(moving[action, neutral])].append(middle[action, style] / middle[action, neutral])

    def of(style: str, moves: bool) -> float:
        seen = ratios.get((style, moves))
        return float(np.clip(np.median(seen), _SLOWEST, _FASTEST)) if seen else 1.0

    return tuple((of(style, False), of(style, True)) for style in styles)


def at_pace(motion: Motion, factor: float) -> Motion:
    """The motion done `factor` times as fast, path and all: standing feet stay where they stand."""
    return motion.resample(motion.fps / factor).replaced(fps=motion.fps)
