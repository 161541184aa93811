"""What every representation offers: Motion -> features -> Motion, and the same on arrays of many clips."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Literal, NamedTuple

import numpy as np

from engines.errors import OutOfRangeError
from engines.features import arrays
from engines.features.layout import Layout
from engines.geometry import inverse
from engines.motion import Motion
from engines.skeletons import Skeleton

Source = Literal["rotations", "positions"]
"""Where a decoded Motion's rotations come from: the features' own rotations, or `geometry.inverse` of the positions."""


class Start(NamedTuple):
    """Where bodies stand before the first frame of their features, which say only how they move on."""

    yaw: np.ndarray | float = 0.0
    """(...) heading, radians about +Y."""
    ground: np.ndarray | tuple[float, float] = (0.0, 0.0)
    """(..., 2) x and z of the root, metres."""


class Codec(ABC):
    """A representation of motion. Array functions take leading batch dimensions and are float32 in the features.

    Frames and rows are as many. What a row says of the way to the next frame is, in a clip's last row, what the row
    before says; encode a stream in stretches that overlap by one frame and drop each stretch's last row.
    """

    name: str
    """What the registry calls it."""
    skeleton: Skeleton
    """The body that it encodes and decodes."""
    fps: float
    """Rate of the rows, frames a second."""
    layout: Layout
    """Its parts."""
    sources: tuple[Source, ...] = ("rotations", "positions")
    """What `decode` can take the rotations from."""

    def encode(self, motion: Motion) -> np.ndarray:
        """A Motion as features (T, size) float32, brought to the codec's skeleton and rate first.

        Raises:
            SkeletonError: a skeleton that cannot be retargeted.
        """
        motion = self.fitted(motion)
        return self.encode_arrays(motion.rotations, motion.translation)

    def decode(self, features: np.ndarray, *, source: Source, start: Start | None = None) -> Motion:
        """Features (T, size) as a Motion on the codec's skeleton; T rows give T frames.

        Args:
            features: not normalised.
            source: "rotations" uses the rotations the features hold; "positions" finds them anew from the positions.
                Which to choose is told where the codec is defined.
            start: where the body stands; by default above the origin, facing +Z.

        Raises:
            OutOfRangeError: another shape, NaN, or a source the codec does not have.
        """
        features = self.layout.check(features)
        if features.ndim != 2:
            raise OutOfRangeError("shape of the features", features.shape, f"(frames, {self.layout.size}) of one clip")
        turns, path, _ = self.decode_arrays(features, source=source, start=start)
        return Motion(self.skeleton, turns, path, self.fps)

    def fitted(self, motion: Motion) -> Motion:
        """The motion on the codec's skeleton and at its rate: what `encode` encodes."""
        return motion.resample(self.fps).retarget(self.skeleton)

    def start(self, motion: Motion) -> Start:
        """Where a motion stands at its first frame: what features leave out and `decode` takes back."""
        first = self.fitted(motion[:1])
        return Start(float(first.heading[0]), first.positions[0, 0, [0, 2]])

    @abstractmethod
    def encode_arrays(self, turns: np.ndarray, path: np.ndarray, contacts: np.ndarray | None = None) -> np.ndarray:
        """Movement of many clips as features (..., T, size) float32.

        Args:
            turns: (..., T, J, 4) unit quaternions wxyz, parent-relative.
            path: (..., T, 3) root translation, metres.
            contacts: (..., T, 4) left ankle, left toe, right ankle, right toe on the ground, 0 or 1; found from the
                movement if not given, by where each foot stands over the whole clip (give them for a stream).
        """

    @abstractmethod
    def decode_arrays(
        self, features: np.ndarray, *, source: Source, start: Start | None = None
    ) -> tuple[np.ndarray, np.ndarray, Start]:
        """Features (..., T, size) as quaternions (..., T, J, 4), root path (..., T, 3), and where the next row starts.

        Raises:
            OutOfRangeError: a source the codec does not have.
        """

    @abstractmethod
    def positions(self, features: np.ndarray, start: Start | None = None) -> np.ndarray:
        """Joint positions (..., T, J, 3) float32 of features (..., T, size), metres, straight from what they hold."""

    def check_source(self, source: str) -> None:
        """Refuse a source this codec lacks.

        Raises:
            OutOfRangeError: with the accepted ones.
        """
        if source not in self.sources:
            raise OutOfRangeError("source", source, f"{' or '.join(map(repr, self.sources))} for {self.name!r}")


def through_inverse(positions: np.ndarray, skeleton: Skeleton) -> tuple[np.ndarray, np.ndarray]:
    """`geometry.inverse` of positions (..., T, J, 3), clip by clip: quaternions (..., T, J, 4), path (..., T, 3)."""
    lead = positions.shape[:-3]
    solved = [inverse.inverse(clip, skeleton) for clip in positions.reshape(-1, *positions.shape[-3:])]
    turns, path = (np.stack(parts) for parts in zip(*solved, strict=True))
    return turns.reshape(*lead, *turns.shape[1:]), path.reshape(*lead, *path.shape[1:])


def continuous(turns: np.ndarray) -> np.ndarray:
    """Quaternions (..., T, J, 4) with signs that do not jump in time; changed in place.

    As `rotations.continuous`, for many clips, and quick where there is nothing to do.
    """
    flips = np.einsum("...c,...c->...", turns[..., 1:, :, :], turns[..., :-1, :, :]) < 0
    joints = np.flatnonzero(flips.reshape(-1, flips.shape[-1]).any(axis=0))
    if len(joints):
        odd = np.cumsum(flips[..., joints], axis=-2) % 2 == 1
        turns[..., 1:, joints, :] *= np.where(odd, -1.0, 1.0)[..., None]
    return turns


def joints_of(turns: np.ndarray, path: np.ndarray, skeleton: Skeleton) -> np.ndarray:
    """Forward kinematics of quaternions (..., T, J, 4) and root translations (..., T, 3): (..., T, J, 3) float32."""
    world = arrays.world(arrays.quaternion_to_matrix(arrays.planes(turns)), skeleton.parents)
    joints = arrays.place(world, skeleton.offsets, skeleton.parents)
    return arrays.unplanes(joints, turns.shape[:-2]) + (path + skeleton.offsets[0])[..., None, :].astype(np.float32)
