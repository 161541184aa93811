"""What is known of one person in a picture: landmarks, depth, silhouette. All of it may be corrected by hand."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from engines.character import landmarks
from engines.character.picture import Picture
from engines.errors import OutOfRangeError


@dataclass(frozen=True, eq=False)
class Sighting:
    """One person as a picture shows them. Pixels are x to the right, y down; landmarks as `landmarks.NAMES`."""

    picture: Picture
    points: Float[np.ndarray, "33 2"]
    """(33, 2) landmarks in the picture, pixels (fractions count)."""
    seen: Float[np.ndarray, " 33"]
    """(33,) from 0 (hidden or outside) to 1 (in plain sight)."""
    places: Float[np.ndarray, "33 3"]
    """(33, 3) landmarks in the round: metres about the hips' middle, Y up, +Z toward the camera, +X picture right."""
    mask: Float[np.ndarray, "H W"]
    """(H, W) float32, 1 where the person is."""
    remarks: tuple[str, ...] = ()
    """What a person should know before a body is made of this: far from standing, an arm unseen ..."""

    def moved(self, landmark: str, to: tuple[float, float]) -> Sighting:
        """With one landmark put by hand at a pixel (x, y); it then counts as seen.

        Its place goes along, sideways and up and down, by the scale of the other landmarks; its depth stays.

        Raises:
            UnknownLabelError: no such landmark.
            OutOfRangeError: a pixel outside the picture.
        """
        index = landmarks.index(landmark)
        width, height = self.picture.size
        if not (0 <= to[0] <= width and 0 <= to[1] <= height):
            raise OutOfRangeError("pixel", to, f"x from 0 to {width}, y from 0 to {height}")
        points, seen, places = self.points.copy(), self.seen.copy(), self.places.copy()
        step = (np.asarray(to) - points[index]) / self.scale
        places[index, :2] += step * (1, -1)
        points[index], seen[index] = to, 1.0
        return replace(self, points=points, seen=seen, places=places)

    def painted(self, mask: Float[np.ndarray, "H W"]) -> Sighting:
        """With another silhouette, of the picture's size, 0 to 1.

        Raises:
            OutOfRangeError: another size.
        """
        mask = np.asarray(mask, dtype=np.float32)
        if mask.shape != self.mask.shape:
            raise OutOfRangeError("size of the mask", mask.shape, f"the picture's, {self.mask.shape}")
        return replace(self, mask=np.clip(mask, 0, 1))

    @property
    def scale(self) -> float:
        """Pixels a metre: the one that lays `places` best over `points`, the well seen counting most."""
        weights = self.seen + 1e-3
        flat = self.places[:, :2] * (1, -1)
        flat = flat - np.average(flat, axis=0, weights=weights)
        drawn = self.points - np.average(self.points, axis=0, weights=weights)
        return float(np.einsum("n,nc,nc", weights, flat, drawn) / np.einsum("n,nc,nc", weights, flat, flat))
