"""What a motion leaves on the floor, with no graphics API in it: dots under the root, prints of the feet."""

from __future__ import annotations

import numpy as np

from engines.motion import Motion

TRAIL_COLOUR, CONTACT_COLOUR = "#5b9bff", "#ffd166"
TRAIL_OPACITY, CONTACT_OPACITY = (0.28, 0.95, 0.95), (0.0, 0.85, 0.16)
"""Of a mark before, during and after its span of time."""
_DOT = 0.014
_PRINT = {"ankle": (0.045, 0.035), "toe": (0.055, 0.042)}


def trail(motion: Motion, offset: tuple[float, float, float]) -> np.ndarray:
    """(T, 8) one dot a frame under the root."""
    dots = np.zeros((len(motion), 8))
    dots[:, :2] = motion.positions[:, 0, [0, 2]] + np.array(offset)[[0, 2]]
    dots[:, 2] = 1.0
    dots[:, 4:6] = _DOT
    dots[:, 6:] = (np.arange(len(motion)) / motion.fps)[:, None]
    return dots


def contact_prints(motion: Motion, offset: tuple[float, float, float]) -> np.ndarray:
    """(M, 8) a print under each ankle and toe for each stretch of frames in contact, along the foot."""
    prints = []
    for foot, (ankle, toe) in enumerate(motion.skeleton.feet):
        places = {
            "ankle": motion.positions[:, motion.skeleton.index(ankle)],
            "toe": motion.positions[:, motion.skeleton.index(toe)],
        }
        for part, (kind, place) in enumerate(places.items()):
            for start, end in _stretches(motion.contacts[:, foot, part]):
                along = (places["toe"] - places["ankle"])[start:end, [0, 2]].mean(0)
                length = np.linalg.norm(along)
                along = along / length if length > 1e-6 else np.array([0.0, 1.0])
                centre = place[start:end, [0, 2]].mean(0) + np.array(offset)[[0, 2]]
                prints.append([*centre, *along, *_PRINT[kind], start / motion.fps, end / motion.fps])
    return np.array(prints).reshape(-1, 8)


def _stretches(flags: np.ndarray) -> list[tuple[int, int]]:
    """(start, end) of each run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags.astype(np.int8), [0]])))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]
