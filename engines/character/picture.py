"""A picture as it comes from a person: a file, its bytes or an open image, made upright sRGB of bounded size."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import UInt8


@dataclass(frozen=True, eq=False)
class Picture:
    """An upright picture without transparency."""

    pixels: UInt8[np.ndarray, "H W 3"]
    """(H, W, 3) sRGB."""
    name: str = "picture"
    """The file's name, for messages and provenance."""

    @property
    def size(self) -> tuple[int, int]:
        """Width and height, pixels."""
        return self.pixels.shape[1], self.pixels.shape[0]
