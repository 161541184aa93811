"""Cameras as pure functions of time: where the eye is, what fits in the frame, and the matrices for it.

Angles in radians, distances in metres. Yaw 0 looks the figure in the face (eye on +Z), positive yaw moves the
eye towards +X; positive pitch raises it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from jaxtyping import Float
from scipy.ndimage import gaussian_filter1d

from engines.errors import OutOfRangeError, UnknownLabelError

Mode = Literal["orbit", "follow", "front", "back", "left", "right"]
MODES: tuple[Mode, ...] = ("orbit", "follow", "front", "back", "left", "right")
_FACING = {"front": 0.0, "back": np.pi, "left": np.pi / 2, "right": -np.pi / 2}
FOLLOW_SMOOTHING = 0.6
"""Seconds (standard deviation) over which a following camera evens out the path of the body."""
SIDE_PITCH = 0.06
"""The front, back, left and right views look down this little, so that the floor is still seen."""


@dataclass(frozen=True)
class Camera:
    """How a scene is looked at. What is left None is chosen so that everything fits.

    Raises:
        UnknownLabelError: no such mode.
        OutOfRangeError: field of view or distance are no use.
    """

    mode: Mode = "orbit"
    """orbit: still, the whole motion in view; follow: goes along with the body; front, back, left, right: still,
    seen from that side (of a body facing +Z)."""
    yaw: float | None = None
    """Radians; default: three quarters from the front for orbit and follow, the named side for the others."""
    pitch: float | None = None
    """Radians above the horizon."""
    distance: float | None = None
    """Metres from the target; default: as near as the framing allows."""
    target: tuple[float, float, float] | None = None
    """Point looked at; for follow, a shift from the body's middle."""
    fov: float = 0.60
    """Vertical field of view, radians."""
    fill: float = 0.86
    """Share of the frame that automatic framing lets the bodies take."""

    def __post_init__(self) -> None:
        if self.mode not in MODES:
            raise UnknownLabelError("camera", self.mode, MODES)
        if not 0.05 <= self.fov <= 2.5:
            raise OutOfRangeError("fov", self.fov, "0.05 to 2.5 radians")
        if self.distance is not None and not self.distance > 0:
            raise OutOfRangeError("camera distance", self.distance, "a positive number of metres")

    @property
    def angles(self) -> tuple[float, float]:
        """(yaw, pitch) with the defaults filled in."""
        side = self.mode in _FACING
        yaw = _FACING[self.mode] if side else 0.62
        pitch = SIDE_PITCH if side else 0.20
        return (yaw if self.yaw is None else self.yaw, pitch if self.pitch is None else self.pitch)

    def replaced(self, **changes) -> Camera:
        """A copy with some fields changed."""
        return replace(self, **changes)


@dataclass(frozen=True)
class CameraTrack:
    """A camera over N moments."""

    eye: Float[np.ndarray, "N 3"]
    """(N, 3) where it stands."""
    target: Float[np.ndarray, "N 3"]
    """(N, 3) what it looks at."""
    fov: float
    """Vertical field of view, radians."""
    near: float
    """Distance of the near plane, metres."""
    far: float
    """Distance of the far plane, metres."""

    def views(self) -> Float[np.ndarray, "N 4 4"]:
        """(N, 4, 4) world to camera."""
        return view_matrix(self.eye, self.target)

    def projection(self, aspect: float) -> Float[np.ndarray, "4 4"]:
        """(4, 4) camera to clip space."""
        return projection_matrix(self.fov, aspect, self.near, self.far)


def direction(yaw: float, pitch: float) -> Float[np.ndarray, " 3"]:
    """(3,) unit vector from the target to the eye."""
    return np.array([np.sin(yaw) * np.cos(pitch), np.sin(pitch), np.cos(yaw) * np.cos(pitch)])


def view_matrix(
    eye: Float[np.ndarray, "*#batch 3"], target: Float[np.ndarray, "*#batch 3"]
) -> Float[np.ndarray, "*batch 4 4"]:
    """World to camera (..., 4, 4) for column vectors: x right, y up, looking along -z."""
    eye, target = np.asarray(eye, np.float64), np.asarray(target, np.float64)
    back = eye - target
    back = back / np.linalg.norm(back, axis=-1, keepdims=True)
    side = np.cross(np.broadcast_to([0.0, 1.0, 0.0], back.shape), back)
    length = np.linalg.norm(side, axis=-1, keepdims=True)
    side = np.where(
        length > 1e-6, side / np.where(length > 1e-6, length, 1.0), [1.0, 0.0, 0.0]
    )  # looking straight down
    turn = np.stack([side, np.cross(back, side), back], axis=-2)
    view = np.zeros((*turn.shape[:-2], 4, 4))
    view[..., :3, :3] = turn
    view[..., :3, 3] = -np.einsum("...ab,...b->...a", turn, eye)
    view[..., 3, 3] = 1.0
    return view


def projection_matrix(fov: float, aspect: float, near: float, far: float) -> Float[np.ndarray, "4 4"]:
    """(4, 4) OpenGL perspective for column vectors; `fov` vertical in radians, `aspect` width / height."""
    scale = 1.0 / np.tan(fov / 2)
    depth = near - far
    return np.array(
        [
            [scale / aspect, 0, 0, 0],
            [0, scale, 0, 0],
            [0, 0, (far + near) / depth, 2 * far * near / depth],
            [0, 0, -1, 0],
        ]
    )


@dataclass(frozen=True)
class Subject:
    """What a camera has to look at, over N moments."""

    points: Float[np.ndarray, "N P 3"]
    """(N, P, 3) points that must stay in the frame."""
    roots: Float[np.ndarray, "N 3"]
    """(N, 3) what a following camera goes along with."""
    rate: float
    """Moments a second, for the smoothing."""


def camera_track(camera: Camera, subject: Subject, aspect: float) -> CameraTrack:
    """The camera at each of the subject's N moments, for a picture of `aspect` width / height."""
    yaw, pitch = camera.angles
    look = direction(yaw, pitch)
    if camera.mode == "follow":
        return _follow(camera, look, subject, aspect)
    everything = subject.points.reshape(-1, 3)  # (N, P, 3) -> (N * P, 3)
    middle, distance = frame_points(everything, look, camera.fov, aspect, camera.fill)
    target = middle if camera.target is None else np.asarray(camera.target, np.float64)
    if camera.target is not None:
        distance = _distance(everything - target, look, camera.fov, aspect, camera.fill)
    distance = camera.distance or distance
    return _track(camera, np.tile(target, (len(subject.points), 1)), look, distance, everything)


def _follow(camera: Camera, look: np.ndarray, subject: Subject, aspect: float) -> CameraTrack:
    """Along a smoothed path of the roots on the floor, at one height, at a distance that fits every moment."""
    sigma = FOLLOW_SMOOTHING * subject.rate
    path = gaussian_filter1d(np.asarray(subject.roots, np.float64), sigma, axis=0, mode="nearest")
    path[:, 1] = 0.0
    around = (subject.points - path[:, None]).reshape(-1, 3)
    middle, distance = frame_points(around, look, camera.fov, aspect, camera.fill)
    shift = middle if camera.target is None else np.array([0.0, middle[1], 0.0]) + camera.target
    return _track(camera, path + shift, look, camera.distance or distance, subject.points.reshape(-1, 3))


def _track(
    camera: Camera, targets: np.ndarray, look: np.ndarray, distance: float, everything: np.ndarray
) -> CameraTrack:
    eye = targets + distance * look
    radius = float(np.linalg.norm(everything - everything.mean(0), axis=-1).max())
    return CameraTrack(eye, targets, camera.fov, max(0.05, 0.02 * distance), distance + 2 * radius + 60.0)


def frame_points(
    points: Float[np.ndarray, "M 3"], look: Float[np.ndarray, " 3"], fov: float, aspect: float, fill: float = 0.86
) -> tuple[Float[np.ndarray, " 3"], float]:
    """Where to look and from how far, so that points (M, 3) fill the share `fill` of the picture.

    Returns:
        target (3,) and distance, metres.
    """
    turn = view_matrix(look, np.zeros(3))[:3, :3]
    seen = points @ turn.T
    low, high = seen.min(0), seen.max(0)
    middle = (low + high) / 2
    half = np.tan(fov / 2) * fill
    for _ in range(4):  # perspective makes near points larger, so the middle of the picture shifts a little
        depth = _needed(seen - middle, half, aspect)
        places = (seen[:, :2] - middle[:2]) / (depth - (seen[:, 2] - middle[2]))[:, None]
        middle[:2] += depth * (places.min(0) + places.max(0)) / 2
    return middle @ turn, max(_needed(seen - middle, half, aspect), 0.3)


def _distance(points: np.ndarray, look: np.ndarray, fov: float, aspect: float, fill: float) -> float:
    """How far an eye in direction `look` must stand from the origin to see points (M, 3)."""
    turn = view_matrix(look, np.zeros(3))[:3, :3]
    return max(_needed(points @ turn.T, np.tan(fov / 2) * fill, aspect), 0.3)


def _needed(seen: np.ndarray, half: float, aspect: float) -> float:
    """Distance from which camera-space points (M, 3) around the origin lie within the half-width `half`."""
    return float((seen[:, 2] + np.maximum(np.abs(seen[:, 0]) / aspect, np.abs(seen[:, 1])) / half).max())
