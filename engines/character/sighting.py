"""What is known of one person in a picture: landmarks, depth, silhouette. All of it may be corrected by hand."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, UInt8

from engines.character import landmarks, mask, models
from engines.character.picture import Picture
from engines.errors import FormatError, OutOfRangeError

BYSTANDER = 0.5
"""People smaller than this share of the largest stand in the background, and are left out."""
_LOOKS = ((0, 0, 1, 0), (0.01, 0.01, 1.1, 0.08), (-0.01, 0.01, 0.95, -0.08), (0.01, -0.01, 1.05, -0.05))
"""Crops a little apart (see `Crop.moved`): the mean of what the network says of them is steadier than any."""
_UNSEEN = 0.2
_LEANING, _SEATED = 35.0, 50.0
"""Degrees from the vertical from which a trunk leans, and a thigh is a seated one's."""
_TALL = 400
"""Pixels from nose to toes below which a texture is blurred."""
_PARTS = {
    "the head": ("nose", "left_eye_outer", "right_eye_outer"),
    "the left foot": ("left_heel", "left_toe"),
    "the right foot": ("right_heel", "right_toe"),
}
_HANDS = {"the left hand": ("left_wrist", "left_index"), "the right hand": ("right_wrist", "right_index")}
_GOOD = "one whole person, standing, head and feet in the picture"


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
        return projected_scale(self.points, self.places, self.seen)


def projected_scale(
    points: Float[np.ndarray, "N 2"], places: Float[np.ndarray, "N 3"], seen: Float[np.ndarray, " N"]
) -> float:
    """Pixels a metre: the one that lays places (N, 3) best over points (N, 2), y down, by least squares."""
    weights = seen + 1e-3
    flat = places[:, :2] * (1, -1)
    flat = flat - np.average(flat, axis=0, weights=weights)
    drawn = points - np.average(points, axis=0, weights=weights)
    return float(np.einsum("n,nc,nc", weights, flat, drawn) / np.einsum("n,nc,nc", weights, flat, flat))


def look(picture: Picture) -> Sighting:
    """What is seen of the one person in a picture.

    Raises:
        FormatError: nobody, several people, or not the whole of one; it says which.
        MissingDependencyError: the networks are not installed.
    """
    people = _people(picture.pixels)
    if not people:
        raise FormatError(picture.name, f"nobody was found in it; accepted: {_GOOD}, and not too small in it.")
    sizes = np.array([body.crop.side for body in people])
    near = int((sizes >= BYSTANDER * sizes.max()).sum())
    if near > 1:
        raise FormatError(picture.name, f"{near} people were found in it; crop it to the one that is meant.")
    first = people[int(sizes.argmax())]
    looks = [models.examine(picture.pixels, first.following.moved(*shift)) for shift in _LOOKS]
    points, seen, places = (
        np.mean([getattr(body, name) for body in looks], axis=0) for name in ("points", "seen", "places")
    )
    missing = _missing(picture, points, seen, _PARTS)
    if missing:
        raise FormatError(picture.name, f"outside it or hidden: {', '.join(missing)}; accepted: {_GOOD}.")
    found = Sighting(picture, points, seen, places, mask.silhouette(picture.pixels, looks))
    if not (found.mask > 0.5).any():
        raise FormatError(picture.name, f"the person cannot be told from the background; accepted: {_GOOD}.")
    return replace(found, remarks=(*_bystanders(len(people) - 1), *_remarks(found)))


def _people(pixels: UInt8[np.ndarray, "H W 3"]) -> list[models.Body]:
    """Everybody in a picture.

    The detector looks at the whole, and where it finds someone at squares of half its length too, for others: alone
    these show it people where there are none.
    """
    found = models.detect(pixels)
    height, width = pixels.shape[:2]
    side = max(height, width) // 2
    for top in _starts(height, side) if found else ():
        for left in _starts(width, side):
            within = models.detect(pixels[top : top + side, left : left + side])
            found += [replace(crop, centre=crop.centre + np.array([left, top])) for crop in within]
    people: list[models.Body] = []
    for crop in found:
        body = models.examine(pixels, models.examine(pixels, crop).following)
        if body.score > models.SURE and not any(_same(body, other) for other in people):
            people.append(body)
    return people


def _starts(length: int, side: int) -> list[int]:
    """Where windows begin so that they overlap by half."""
    count = max(1, int(np.ceil(2 * (length - side) / side)) + 1)
    return [int(at) for at in np.linspace(0, max(0, length - side), count)]


def _same(one: models.Body, other: models.Body) -> bool:
    """Do the boxes about two bodies share more than half of the smaller one?"""
    low = np.maximum(one.points.min(axis=0), other.points.min(axis=0))
    high = np.minimum(one.points.max(axis=0), other.points.max(axis=0))
    smaller = min(np.ptp(body.points, axis=0).prod() for body in (one, other))
    return bool(np.clip(high - low, 0, None).prod() > 0.5 * smaller)


def _missing(
    picture: Picture,
    points: Float[np.ndarray, "33 2"],
    seen: Float[np.ndarray, " 33"],
    parts: dict[str, tuple[str, ...]],
) -> list[str]:
    """Which parts lie outside a picture or are hidden."""
    shown = ((points >= 0) & (points <= picture.size)).all(axis=1) & (seen > _UNSEEN)
    return [part for part, names in parts.items() if not any(shown[landmarks.index(name)] for name in names)]


def _bystanders(count: int) -> list[str]:
    return [f"{count} more in the background {'is' if count == 1 else 'are'} left out."] if count else []


def _remarks(sighting: Sighting) -> list[str]:
    """What makes a body hard to see, in words."""
    shown = sighting.picture, sighting.points, sighting.seen
    said = [f"{hand} is outside the picture or hidden." for hand in _missing(*shown, _HANDS)]
    at = dict(zip(landmarks.NAMES, sighting.places, strict=True))
    trunk = (at["left_shoulder"] + at["right_shoulder"] - at["left_hip"] - at["right_hip"]) / 2
    thighs = [at[f"{side}_hip"] - at[f"{side}_knee"] for side in ("left", "right")]
    if _tilt(trunk) > _LEANING or min(map(_tilt, thighs)) > _SEATED:
        said.append("the person does not stand upright, and what is folded is guessed; a standing person is better.")
    across = at["left_shoulder"] - at["right_shoulder"]
    if abs(across[0]) < abs(across[2]):
        said.append("the person is seen from the side: the other side is guessed; from the front is better.")
    elif across[0] < 0:
        said.append("the person is seen from behind: the face is guessed; from the front is better.")
    tall = float(np.ptp(sighting.points[:, 1]))
    if tall < _TALL:
        said.append(
            f"the person is only {tall:.0f} pixels tall, so the texture is blurred; {_TALL} or more are better."
        )
    border = (sighting.mask[0], sighting.mask[-1], sighting.mask[:, 0], sighting.mask[:, -1])
    if any((edge > 0.5).sum() > 2 for edge in border):
        said.append("the person touches the picture's edge; what lies beyond it is guessed.")
    return said


def _tilt(vector: Float[np.ndarray, " 3"]) -> float:
    """Degrees from straight up."""
    return float(np.degrees(np.arctan2(np.hypot(vector[0], vector[2]), vector[1])))
