"""How a picture sees the world: weak perspective, the camera looking along -Z at a person who faces it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float


@dataclass(frozen=True)
class View:
    """Weak perspective: depth changes neither size nor place. Picture right is +X, picture up is +Y."""

    scale: float
    """Pixels a metre."""
    centre: tuple[float, float]
    """The pixel (x to the right, y down) where world x = 0, y = 0 falls."""

    def project(self, points: Float[np.ndarray, "*batch 3"]) -> Float[np.ndarray, "*batch 2"]:
        """Pixels (..., 2), x to the right and y down, of points (..., 3) in metres."""
        points = np.asarray(points, dtype=np.float64)
        return points[..., :2] * (self.scale, -self.scale) + self.centre

    def unproject(
        self, pixels: Float[np.ndarray, "*batch 2"], depth: Float[np.ndarray, "*#batch"] | float = 0.0
    ) -> Float[np.ndarray, "*batch 3"]:
        """Points (..., 3) in metres, at world z = `depth`, that fall on pixels (..., 2)."""
        flat = (np.asarray(pixels, dtype=np.float64) - self.centre) / (self.scale, -self.scale)
        z = np.broadcast_to(np.asarray(depth, dtype=np.float64), flat.shape[:-1])
        return np.concatenate([flat, z[..., None]], axis=-1)
