"""One motion set behind another without a jump: what is apart at the seam dies away over the frames after it."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from engines.errors import OutOfRangeError
from engines.geometry import rotations
from engines.motion import Motion

SECONDS = 0.5


def join(before: Motion, after: Motion, seconds: float = SECONDS) -> Motion:
    """`before`, frame for frame, and then `after`, which takes over its pose and speed and leaves them smoothly.

    The distance between how `before` would go on and how `after` begins, in the pose, the place and the speed of both,
    is added to `after` and dies away (as in Bollo 2018, "Inertialization", with a cubic).

    Args:
        before: two frames or more for its speed to be known.
        after: where it should be, on the same skeleton at the same frame rate.
        seconds: until nothing is left of the distance; at most all of `after`.

    Raises:
        OutOfRangeError: `seconds` is negative.
        SkeletonError: another skeleton.
    """
    if not seconds >= 0:
        raise OutOfRangeError("seconds", seconds, "0 or more")
    joined = before.concat(after)
    at, fade = len(before), min(round(seconds * before.fps), len(joined) - len(before))
    if fade < 1:
        return joined
    turns, path = joined.rotations.copy(), joined.translation.copy()
    # how the one goes on, how the other begins: what a frame adds
    going = _turned(turns[at - 2], turns[at - 1]) if at > 1 else np.zeros((turns.shape[1], 3))
    coming = _turned(turns[at], turns[at + 1]) if at + 1 < len(turns) else going
    gap = _turned(turns[at], rotations.multiply(rotations.rotvec_to_quaternion(going), turns[at - 1]))
    turns[at : at + fade] = rotations.multiply(
        rotations.rotvec_to_quaternion(_dying(gap, going - coming, fade)), turns[at : at + fade]
    )
    going = path[at - 1] - path[at - 2] if at > 1 else np.zeros(3)
    coming = path[at + 1] - path[at] if at + 1 < len(path) else going
    path[at : at + fade] += _dying(path[at - 1] + going - path[at], going - coming, fade)
    return joined.replaced(rotations=turns, translation=path)


def _turned(a: Float[np.ndarray, "J 4"], b: Float[np.ndarray, "J 4"]) -> Float[np.ndarray, "J 3"]:
    """The rotation vectors that lead from one pose to the other, in the parents' frames."""
    return rotations.quaternion_to_rotvec(rotations.multiply(b, rotations.invert(a)))


def _dying(gap: Float[np.ndarray, "*rest"], speed: Float[np.ndarray, "*rest"], frames: int) -> np.ndarray:
    """(frames, *rest) from a distance and its change a frame to nothing of both."""
    u = (np.arange(frames) / frames).reshape(-1, *[1] * gap.ndim)
    return gap * (2 * u**3 - 3 * u**2 + 1) + speed * frames * (u**3 - 2 * u**2 + u)
