"""Bodies: skins for skeletons. `get("anny")` is the default figure, `get("stick")` works for any skeleton."""

from __future__ import annotations

from functools import lru_cache

from engines.errors import MotionloomError, UnknownLabelError
from engines.motion import Motion
from engines.skeletons import SMPL22
from engines.skeletons.skeleton import Skeleton
from viewers.bodies.body import Body, skinning_matrices

_NAMES = ("anny", "stick")
DEFAULT = "anny"


def available() -> tuple[str, ...]:
    """Names that `get` takes, the default first."""
    return _NAMES


@lru_cache(maxsize=32)
def get(name: str = DEFAULT, skeleton: Skeleton | None = None) -> Body:
    """A body by name, fitted to `skeleton`'s bone lengths when one is given.

    Args:
        name: one of `available()`.
        skeleton: default: smpl22. "anny" needs smpl22's joints (any bone lengths); "stick" takes any skeleton.

    Raises:
        UnknownLabelError: no body of that name; the message lists the nearest.
        SkeletonError: the body cannot wear that skeleton; `body_for` finds a way.
    """
    skeleton = skeleton or SMPL22
    if name == "stick":
        from viewers.bodies.stick import stick

        return stick(skeleton)
    if name == "anny":
        from viewers.bodies.anny import load

        return load().fitted(skeleton)
    raise UnknownLabelError("body", name, _NAMES)


def body_for(motion: Motion, name: str | Body = DEFAULT) -> tuple[Body, Motion]:
    """A body for a motion on any skeleton, and the motion as that body plays it.

    A motion on the body's own joints is played as it is, the body stretched to its bone lengths. One on other
    joints is retargeted; where that is impossible the stick figure stands in.

    Raises:
        UnknownLabelError: no body of that name.
    """
    if isinstance(name, Body):
        if name.skeleton == motion.skeleton:
            return name, motion
        if _same_tree(name.skeleton, motion.skeleton):
            return name.fitted(motion.skeleton), motion
        return name, motion.retarget(name.skeleton)
    if name == "stick" or _same_tree(SMPL22, motion.skeleton):
        return get(name, motion.skeleton), motion
    body = get(name)
    try:
        return body, motion.retarget(body.skeleton)
    except MotionloomError:
        return get("stick", motion.skeleton), motion


def _same_tree(one: Skeleton, other: Skeleton) -> bool:
    return one.joints == other.joints and one.parents == other.parents


__all__ = ["DEFAULT", "Body", "available", "body_for", "get", "skinning_matrices"]
