"""The networks that find people in pictures: BlazePose's detector and landmark network, run by LiteRT.

Bazarevsky et al., "BlazePose: On-device Real-time Body Pose tracking", 2020. Their weights (Apache-2.0) lie in
mediapipe's wheel, which is looked up but never imported.
"""

from __future__ import annotations

import importlib.util
import threading
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from jaxtyping import Float, UInt8
from PIL import Image
from scipy.ndimage import map_coordinates
from scipy.special import expit

from engines.errors import MissingDependencyError, MotionloomError

DETECTOR = "pose_detection/pose_detection.tflite"
LANDMARKER = "pose_landmark/pose_landmark_full.tflite"
_THREADS = 2
SURE = 0.5
"""A detection, or a crop's answer whether it holds a person, counts from here."""
_OVERLAP = 0.3
"""Detections whose boxes overlap more than this are one person's."""
_ANCHORS = ((8, 2), (16, 2), (32, 6))
"""Stride in pixels, anchors a cell: 28 * 28 * 2 + 14 * 14 * 2 + 7 * 7 * 6 = 2254 as the detector's outputs say."""
_MARGIN = 1.25
"""Side of a crop, as a multiple of the circle about a person."""
_LANDMARKS = 33
_AROUND = slice(33, 35)
"""After the landmarks: the hips' middle, and a point on the circle about the person."""
_KERNEL = 3
"""Cells of the heat map on each side of a landmark that refine it."""


@dataclass(frozen=True, eq=False)
class Crop:
    """A turned square of a picture."""

    centre: Float[np.ndarray, " 2"]
    """Pixel, x to the right and y down."""
    side: float
    """Pixels."""
    angle: float
    """Radians by which the square is turned, clockwise as one looks at it."""

    @classmethod
    def about(cls, hips: Float[np.ndarray, " 2"], rim: Float[np.ndarray, " 2"]) -> Crop:
        """The square about the circle through `rim` round the hips' middle, turned so that `rim` is straight up."""
        x, y = rim - hips
        side = max(2 * _MARGIN * float(np.hypot(x, y)), 1.0)
        return cls(np.asarray(hips, dtype=np.float64), side, float(np.arctan2(x, -y)))

    @property
    def axes(self) -> Float[np.ndarray, "2 2"]:
        """Rows: the square's right and down, unit vectors in the picture."""
        cos, sin = np.cos(self.angle), np.sin(self.angle)
        return np.array([[cos, sin], [-sin, cos]])

    def to_picture(self, points: Float[np.ndarray, "*batch 2"]) -> Float[np.ndarray, "*batch 2"]:
        """Pixels of points given from (0, 0) to (1, 1) across the square."""
        return (np.asarray(points) - 0.5) * self.side @ self.axes + self.centre

    def from_picture(self, pixels: Float[np.ndarray, "*batch 2"]) -> Float[np.ndarray, "*batch 2"]:
        """Where pixels lie in the square, from (0, 0) to (1, 1)."""
        return (np.asarray(pixels) - self.centre) @ self.axes.T / self.side + 0.5

    def moved(self, right: float, down: float, grown: float, turned: float) -> Crop:
        """Another square near this one: moved by shares of its side, grown by a factor, turned by radians."""
        shift = np.array([right, down]) * self.side @ self.axes
        return Crop(self.centre + shift, self.side * grown, self.angle + turned)

    def cut(self, pixels: UInt8[np.ndarray, "H W 3"], size: int) -> Float[np.ndarray, "size size 3"]:
        """The square as (size, size, 3) from 0 to 1; outside the picture its border goes on."""
        step = max(1, int(self.side / (1.5 * size)))
        source = np.asarray(Image.fromarray(pixels).reduce(step)) if step > 1 else pixels
        grid = (np.arange(size) + 0.5) / size
        wanted = self.to_picture(np.stack(np.meshgrid(grid, grid), axis=-1)) / step - 0.5
        at = [wanted[..., 1], wanted[..., 0]]
        channels = [map_coordinates(source[..., c], at, np.float32, order=1, mode="nearest") for c in range(3)]
        return np.stack(channels, axis=-1) / 255


@dataclass(frozen=True, eq=False)
class Body:
    """What the landmark network says of one crop."""

    score: float
    """0 to 1: is there a person."""
    points: Float[np.ndarray, "33 2"]
    """(33, 2) pixels of the picture."""
    seen: Float[np.ndarray, " 33"]
    """(33,) 0 to 1."""
    places: Float[np.ndarray, "33 3"]
    """(33, 3) metres about the hips' middle; +X picture right, +Y up, +Z toward the camera."""
    inside: Float[np.ndarray, "256 256"]
    """Silhouette in the crop, 0 to 1."""
    crop: Crop
    """The crop that was looked at."""
    following: Crop
    """A crop that fits the person better, or that of the next frame."""


class _Network:
    """A .tflite file, ready to run; one thread at a time."""

    def __init__(self, path: Path, interpreter: type) -> None:
        try:
            self.interpreter = interpreter(model_path=str(path), num_threads=_THREADS)
            self.interpreter.allocate_tensors()
        except (ValueError, RuntimeError) as problem:
            raise MotionloomError(f"{path} cannot be run ({problem}); install mediapipe 0.10.21 again.") from problem
        self.lock = threading.Lock()

    def __call__(self, values: Float[np.ndarray, "S S 3"]) -> dict[str, np.ndarray]:
        """Named outputs without the batch axis."""
        with self.lock:
            self.interpreter.set_tensor(self.interpreter.get_input_details()[0]["index"], values[None])
            self.interpreter.invoke()
            return {
                out["name"]: self.interpreter.get_tensor(out["index"])[0]
                for out in self.interpreter.get_output_details()
            }


def detect(pixels: UInt8[np.ndarray, "H W 3"]) -> list[Crop]:
    """Crops about the people in a picture, surest first.

    Raises:
        MissingDependencyError: the networks are not installed.
    """
    height, width = pixels.shape[:2]
    whole = Crop(np.array([width / 2, height / 2]), float(max(width, height)), 0.0)
    square = Image.new("RGB", (224, 224))
    scale = 224 / whole.side
    small = Image.fromarray(pixels).resize(
        (max(1, round(width * scale)), max(1, round(height * scale))), Image.Resampling.BOX
    )
    square.paste(small, ((224 - small.width) // 2, (224 - small.height) // 2))
    out = _network(DETECTOR)(np.asarray(square, dtype=np.float32) / 127.5 - 1)
    scores = expit(np.clip(out["Identity_1"][:, 0], -100, 100))
    likely = scores > SURE
    # centre, size, hips, rim, shoulders, rim of the upper body
    values = out["Identity"][likely].reshape(-1, 6, 2) / 224
    values[:, [0, 2, 3, 4, 5]] += _anchors()[likely, None]
    return [Crop.about(*whole.to_picture(found[2:4])) for found in _merged(values, scores[likely])]


def examine(pixels: UInt8[np.ndarray, "H W 3"], crop: Crop) -> Body:
    """What there is of a person in a crop of a picture.

    Raises:
        MissingDependencyError: the networks are not installed.
    """
    out = _network(LANDMARKER)(crop.cut(pixels, 256))
    marks = out["Identity"].reshape(-1, 5)
    flat = _refined(marks[:, :2] / 256, expit(out["Identity_3"]))
    points = crop.to_picture(flat)
    turned = out["Identity_4"].reshape(-1, 3)[:_LANDMARKS].astype(np.float64)
    turned[:, :2] = turned[:, :2] @ crop.axes
    return Body(
        score=float(out["Identity_1"][0]),
        points=points[:_LANDMARKS],
        seen=expit(marks[:_LANDMARKS, 3:]).min(axis=1).astype(np.float64),
        places=turned * (1, -1, -1),
        inside=expit(out["Identity_2"][..., 0]),
        crop=crop,
        following=Crop.about(*points[_AROUND]),
    )


def largest(pixels: UInt8[np.ndarray, "H W 3"]) -> Body | None:
    """The largest person that the detector finds in a picture, looked at twice.

    Raises:
        MissingDependencyError: the networks are not installed.
    """
    bodies = [examine(pixels, examine(pixels, crop).following) for crop in detect(pixels)]
    return max((body for body in bodies if body.score >= SURE), key=lambda body: body.crop.side, default=None)


def _refined(flat: Float[np.ndarray, "N 2"], heat: Float[np.ndarray, "h w N"]) -> Float[np.ndarray, "N 2"]:
    """Landmarks (0 to 1) moved to the middle of the heat around them, where there is enough of it."""
    refined = flat.astype(np.float64)
    height, width = heat.shape[:2]
    for index, (x, y) in enumerate(flat * (width, height)):
        left, top = int(x) - _KERNEL, int(y) - _KERNEL
        rows = slice(max(top, 0), max(top + 2 * _KERNEL + 1, 0))
        columns = slice(max(left, 0), max(left + 2 * _KERNEL + 1, 0))
        near = heat[rows, columns, index]
        if near.size and near.max() > SURE:
            down, right = np.indices(near.shape)
            at_x = columns.start + (near * right).sum() / near.sum()
            at_y = rows.start + (near * down).sum() / near.sum()
            refined[index] = at_x / width, at_y / height
    return refined


def _merged(values: Float[np.ndarray, "N 6 2"], scores: Float[np.ndarray, " N"]) -> list[Float[np.ndarray, "6 2"]]:
    """One mean a person, surest first: non-maximum suppression, each of those suppressed counting by its score."""
    low, high = values[:, 0] - values[:, 1] / 2, values[:, 0] + values[:, 1] / 2
    left, people = np.argsort(-scores), []
    while len(left):
        best = left[0]
        shared = np.clip(np.minimum(high[left], high[best]) - np.maximum(low[left], low[best]), 0, None).prod(axis=1)
        union = values[left, 1].prod(axis=1) + values[best, 1].prod() - shared
        same = shared > _OVERLAP * union
        same[0] = True
        people.append(np.average(values[left[same]], axis=0, weights=scores[left[same]]))
        left = left[~same]
    return people


@cache
def _anchors() -> Float[np.ndarray, "2254 2"]:
    """Middles of the detector's anchors, (x, y) from 0 to 1."""
    grids = []
    for stride, each in _ANCHORS:
        cells = (np.arange(224 // stride) + 0.5) * stride / 224
        grid = np.stack(np.meshgrid(cells, cells), axis=-1).reshape(-1, 2)
        grids.append(np.repeat(grid, each, axis=0))
    return np.concatenate(grids)


def installed() -> bool:
    """Can pictures be looked at here?"""
    return importlib.util.find_spec("ai_edge_litert") is not None and all(map(_file, (DETECTOR, LANDMARKER)))


def _file(name: str) -> Path | None:
    """Where a network lies in the mediapipe wheel, which is looked up without importing it."""
    found = importlib.util.find_spec("mediapipe")
    path = Path(found.origin).parent / "modules" / name if found and found.origin else None
    return path if path and path.is_file() else None


@cache
def _network(name: str) -> _Network:
    """A network of the mediapipe wheel.

    Raises:
        MissingNetworksError: it is not installed.
    """
    path = _file(name)
    if path is None:
        raise MissingNetworksError
    try:
        from ai_edge_litert.interpreter import Interpreter
    except ImportError as problem:
        raise MissingNetworksError from problem
    return _Network(path, Interpreter)


class MissingNetworksError(MissingDependencyError):
    """What finds people in pictures is not installed; the message says how to."""

    def __init__(self) -> None:
        super().__init__("ai-edge-litert", "character", "looking at pictures")
        self.msg += (
            ", and the networks in mediapipe's wheel: make character (or pip install --no-deps mediapipe==0.10.21; "
            "it is only read, so what it asks for is not needed)."
        )
