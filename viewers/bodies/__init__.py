"""Bodies: skins for skeletons. `get("anny")` is the default figure, `get("stick")` works for any skeleton.

Others: "mannequin" (the package mannequin-x), and a person's own SMPL, SMPL-H and SMPL-X model files, by their path or
by the environment (`viewers.bodies.smpl`); characters of one's own (`viewers.bodies.character`).
Shapes: `get("anny").shaped(weight=0.8, gender=1.0)`.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path, PurePath

from engines.errors import MotionloomError, UnknownLabelError
from engines.geometry.skins import skinning_matrices
from engines.motion import Motion
from engines.skeletons import SMPL22
from engines.skeletons.skeleton import Skeleton
from viewers.bodies import character
from viewers.bodies.body import Body, Slider

_SMPL = {"smpl": "MOTIONLOOM_SMPL", "smplh": "MOTIONLOOM_SMPLH", "smplx": "MOTIONLOOM_SMPLX"}
_NAMES = ("anny", "stick", "mannequin", *_SMPL)
_FILES = (".npz", ".pkl")
DEFAULT = "anny"


def available() -> tuple[str, ...]:
    """Names of the bodies that `get` can make here and now, the default first."""
    there = {name: bool(os.environ.get(variable)) for name, variable in _SMPL.items()}
    there["mannequin"] = find_spec("mannequin") is not None
    return (*(name for name in _NAMES if there.get(name, True)), *character.saved())


def get(name: str = DEFAULT, skeleton: Skeleton | None = None) -> Body:
    """A body by name, stretched to `skeleton`'s bone lengths when one is given.

    Args:
        name: "anny", "stick", "mannequin"; "smpl", "smplh", "smplx" (from the environment); "character:NAME"; or the
            path of a SMPL model file (.npz) or of a character.
        skeleton: default: the body's own. "stick" takes any skeleton; the others need smpl22's joints, with any bone
            lengths.

    Raises:
        UnknownLabelError: no body of that name; the message lists the nearest.
        SkeletonError: the body cannot wear that skeleton; `body_for` finds a way.
        MissingDependencyError: it comes with a package that is not installed.
        FormatError: there is no model file, or none that can be read.
    """
    if name.startswith(character.PREFIX) or (PurePath(name).suffix.lower() in _FILES and character.is_one(Path(name))):
        body = character.get(name)
        return body if skeleton is None else body.fitted(skeleton)
    if name in _SMPL or PurePath(name).suffix.lower() in _FILES:  # a file may be another tomorrow
        from viewers.bodies import smpl

        body = smpl.from_environment(name) if name in _SMPL else smpl.load(name)
        return body if skeleton is None else body.fitted(skeleton)
    return _named(name, skeleton)


@lru_cache(maxsize=32)
def _named(name: str, skeleton: Skeleton | None) -> Body:
    if name == "stick":
        from viewers.bodies.stick import stick

        return stick(skeleton or SMPL22)
    if name == "anny":
        from viewers.bodies.anny import load
    elif name == "mannequin":
        from viewers.bodies.mannequin import load
    else:
        raise UnknownLabelError("body", name, _NAMES)
    return load() if skeleton is None else load().fitted(skeleton)


def wanted(name: str | None = None, shape: Mapping[str, float] | None = None) -> str | Body:
    """The body a person asked for, as `Actor.body` takes it.

    Args:
        name: as in `get`; None for the default.
        shape: sliders and their values; none for the body as it comes.

    Raises:
        UnknownLabelError: a slider the body does not have, or no such body.
        OutOfRangeError: a value out of a slider's bounds.
        FormatError: there is no model file, or none that can be read.
        MissingDependencyError: it comes with a package that is not installed.
    """
    return get(name or DEFAULT).shaped(**shape) if shape else name or DEFAULT


def body_for(motion: Motion, name: str | Body = DEFAULT) -> tuple[Body, Motion]:
    """A body for a motion on any skeleton, and the motion as that body plays it.

    A motion on the body's own joints is played as it is, the body stretched to its bone lengths; a body with bones of
    its own (SMPL's, the mannequin, a shaped one) keeps them, and the motion's way is scaled by its legs. A motion on
    other joints is retargeted, and so is any to a character with joints of its own; where that is impossible the stick
    figure stands in.

    Raises:
        UnknownLabelError: no body of that name.
        MissingDependencyError: it comes with a package that is not installed.
        FormatError: there is no model file, or none that can be read.
    """
    if isinstance(name, str) and name == "stick":
        return get(name, motion.skeleton), motion
    body = name if isinstance(name, Body) else get(name)
    if body.skeleton == motion.skeleton:
        return body, motion
    if _same_tree(body.skeleton, motion.skeleton):
        return _seated(motion, body) if body.own_bones else (_fitted(body, motion.skeleton), motion)
    try:
        moved = motion.retarget(SMPL22 if body.own_bones else body.skeleton)
    except MotionloomError:
        if isinstance(name, Body):
            raise
        return get("stick", motion.skeleton), motion
    return _seated(moved, body) if body.own_bones else (body, moved)


@lru_cache(maxsize=32)
def _fitted(body: Body, skeleton: Skeleton) -> Body:
    return body.fitted(skeleton)


def _seated(motion: Motion, body: Body) -> tuple[Body, Motion]:
    from viewers.bodies.seating import seated

    own = motion.skeleton.rest_positions[:, 1]
    sole = float(own.min() - get(DEFAULT, motion.skeleton).vertices[:, 1].min())
    return body, seated(motion, body, sole)


def _same_tree(one: Skeleton, other: Skeleton) -> bool:
    return one.joints == other.joints and one.parents == other.parents


__all__ = ["DEFAULT", "Body", "Slider", "available", "body_for", "get", "skinning_matrices", "wanted"]
