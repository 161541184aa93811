"""motionloom's engine side: everything about motion that needs no screen.

`read` a motion file, `load` an engine and let it `generate`; what comes out is a `Motion`, and what one can do with it
is in `engines.motion`.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from engines.errors import MotionloomError
from engines.motion import Motion, Provenance, Segment
from engines.skeletons import SMPL22, Skeleton

__version__ = "0.1.0"
__all__ = [
    "SMPL22", "Motion", "MotionloomError", "Provenance", "Segment", "Skeleton", "available", "load", "read",
]  # fmt: skip


def read(path: str | Path, **options: Any) -> Motion:
    """Read a motion file, its format told by extension and content; see `engines.formats.read`."""
    from engines import formats

    return formats.read(path, **options)


def load(name: str, **options: Any) -> Any:
    """Load a generation engine with its shipped weights; see `engines.registry.load`."""
    from engines import registry

    return registry.load(name, **options)


def available() -> dict[str, str]:
    """Names of the engines and a line about each."""
    from engines import registry

    return registry.available()
