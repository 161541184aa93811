"""Left for right."""

from __future__ import annotations

import re

import numpy as np

from engines.skeletons.skeleton import Skeleton


def mirror(turns: np.ndarray, path: np.ndarray, skeleton: Skeleton) -> tuple[np.ndarray, np.ndarray]:
    """Rotations (T, J, 4) and root path (T, 3) reflected in the plane x = 0, paired joints changing places.

    A reflection S = diag(-1, 1, 1) turns a rotation R into S R S: the quaternion keeps w and x and flips y and z.
    """
    turns = np.asarray(turns)[:, skeleton.mirror_index] * np.array([1.0, 1.0, -1.0, -1.0])
    return turns, np.asarray(path) * np.array([-1.0, 1.0, 1.0])


_SIDES = {
    "left": "right", "right": "left", "clockwise": "counterclockwise",
    "counterclockwise": "clockwise", "counter-clockwise": "clockwise", "anticlockwise": "clockwise",
}  # fmt: skip
_PATTERN = re.compile(r"(?<![a-z])(" + "|".join(sorted(_SIDES, key=len, reverse=True)) + r")(?![a-z])", re.IGNORECASE)


def mirror_words(text: str) -> str:
    """A label or sentence with left and right (and the senses of turning) exchanged, capitals kept."""

    def swapped(match: re.Match[str]) -> str:
        word = _SIDES[match[0].lower()]
        return word.capitalize() if match[0][0].isupper() else word

    return _PATTERN.sub(swapped, text)
