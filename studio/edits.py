"""What may be done to a motion before it is shown and exported, the motion itself staying as it is."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from engines import Motion
from engines.errors import UnknownLabelError
from engines.geometry.cleanup import plant_feet
from engines.geometry.polish import close_loop, smooth
from studio.settings import EDITS

WORDS = {
    "smooth": "Smooth", "feet": "Foot clean-up", "loop": "Close loop", "mirror": "Mirror", "in_place": "In place",
}  # fmt: skip
"""What a button says."""
_ACTS: dict[str, Callable[[Motion], Motion]] = {
    "smooth": smooth,
    "feet": plant_feet,
    "loop": close_loop,
    "mirror": Motion.mirror,
    "in_place": Motion.in_place,
}


def apply(motion: Motion, names: Iterable[str]) -> Motion:
    """The motion with those edits done to it.

    Raises:
        UnknownLabelError: there is no such edit.
        SkeletonError: a skeleton without feet to hold, or that cannot be mirrored.
    """
    wanted = list(names)
    for name in wanted:
        if name not in EDITS:
            raise UnknownLabelError("edit", name, EDITS)
    for name in EDITS:
        motion = _ACTS[name](motion) if name in wanted else motion
    return motion
