"""How networks see a Motion: representations with named parts, each a `Codec`, found by name.

`get("humanml3d").encode(motion)` is (T, 263) float32, and `.decode(features, source=...)` the Motion again.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

from engines.errors import UnknownLabelError
from engines.features.codec import Codec, Source, Start
from engines.features.layout import Layout, Part, Statistics


def _humanml3d() -> Codec:
    from engines.features.humanml3d import HUMANML3D

    return HUMANML3D


def _kit() -> Codec:
    from engines.features.humanml3d import KIT

    return KIT


def _style() -> Codec:
    from engines.features.style import STYLE

    return STYLE


def _smplh() -> Codec:
    from engines.features.smplh import SMPLH_HOUSE

    return SMPLH_HOUSE


def _lie() -> Codec:
    from engines.features.lie import LIE

    return LIE


def _official(name: str) -> Callable[[], Codec]:
    def made() -> Codec:
        from engines.features import official

        return official.CODECS[name]

    return made


_CODECS: dict[str, tuple[str, Callable[[], Codec]]] = {
    "humanml3d": ("263 numbers a frame of 22 joints at 20 fps (Guo et al. 2022)", _humanml3d),
    "kit": ("251 numbers a frame of KIT-ML's 21 joints at 12.5 fps", _kit),
    "style": ("260 numbers a frame of 21 joints at 30 fps (latent stylization)", _style),
    "smplh": ("315 numbers a frame, SMPL-H rotations and translation at 20 fps (MultiAct)", _smplh),
    "lie": ("74 numbers a frame, so(3) vectors and root velocities at 20 fps (Action2Motion)", _lie),
    "humanml3d-official": (
        "as the released code computes humanml3d, for the authors' checkpoints",
        _official("humanml3d"),
    ),
    "kit-official": ("as the released code computes kit, for the authors' checkpoints", _official("kit")),
    "style-official": ("as the released code computes style, for the authors' checkpoints", _official("style")),
    "smplh-official": ("as the released code reads and writes smplh, for the authors' checkpoints", _official("smplh")),
}


def available() -> dict[str, str]:
    """Names of the representations and a line about each."""
    return {name: line for name, (line, _) in _CODECS.items()}


@lru_cache(maxsize=32)
def get(name: str) -> Codec:
    """The representation of that name.

    Raises:
        UnknownLabelError: there is none; the nearest names are listed.
    """
    if name not in _CODECS:
        raise UnknownLabelError("representation", name, _CODECS)
    return _CODECS[name][1]()


__all__ = ["Codec", "Layout", "Part", "Source", "Start", "Statistics", "available", "get"]
