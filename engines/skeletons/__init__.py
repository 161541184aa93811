"""Skeletons: the definition and the named ones."""

from __future__ import annotations

from engines.errors import UnknownLabelError
from engines.skeletons.skeleton import Skeleton
from engines.skeletons.smpl22 import SMPL22

_NAMED = {SMPL22.name: SMPL22}


def get(name: str) -> Skeleton:
    """The named skeleton definition.

    Raises:
        UnknownLabelError: no definition of that name; the message lists the nearest.
    """
    if name not in _NAMED:
        raise UnknownLabelError("skeleton", name, _NAMED)
    return _NAMED[name]


__all__ = ["SMPL22", "Skeleton", "get"]
