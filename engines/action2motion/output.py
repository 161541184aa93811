"""From the networks' poses at their rate to Motions at the house rate, a whole batch at once."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from jaxtyping import Float
from scipy.interpolate import CubicSpline

from engines.action2motion.model import Poses
from engines.action2motion.representation import travel
from engines.geometry import inverse, rotations
from engines.motion import Motion
from engines.skeletons import SMPL22


class Upsampler:
    """Cubic splines through the model's frames, as one matrix: smooth in speed, exact on the frames themselves.

    Args:
        steps: the model's frames.
        fps: their rate.
        house_fps: wanted rate.
        frames: wanted frames; times past the last model frame hold it.
    """

    def __init__(self, steps: int, fps: float, house_fps: float, frames: int) -> None:
        self.steps, self.frames, self.fps = steps, frames, house_fps
        self.times = np.minimum(np.arange(frames) * (fps / house_fps), steps - 1)

    def __call__(self, values: Float[np.ndarray, " steps *rest"]) -> Float[np.ndarray, " frames *rest"]:
        """(steps, ...) -> (frames, ...)."""
        if self.steps == 1:
            return np.repeat(values, self.frames, axis=0)
        if self.steps > _MATRIX_LIMIT:
            return CubicSpline(np.arange(self.steps), values, bc_type="natural")(self.times)
        matrix = _spline_matrix(self.steps, tuple(self.times))
        return (matrix @ values.reshape(len(values), -1)).reshape(self.frames, *values.shape[1:])


_MATRIX_LIMIT = 128
"""Up to so many model frames a stored matrix is faster than making a spline each time."""


@lru_cache(maxsize=32)
def _spline_matrix(steps: int, times: tuple[float, ...]) -> np.ndarray:
    """(frames, steps) weights of a natural cubic spline through the steps."""
    return CubicSpline(np.arange(steps), np.eye(steps), bc_type="natural")(times).astype(np.float32)


def to_motions(poses: Poses, upsample: Upsampler) -> list[Motion]:
    """One Motion a row of the batch, starting above the origin and facing +Z."""
    vectors, velocity = poses.vectors.numpy(), poses.velocity.numpy().copy()
    velocity[0] = 0.0
    count = vectors.shape[1]
    yaw, ground = travel(velocity)
    yaw, ground = upsample(yaw), upsample(ground)
    if poses.matrices is None:
        return [
            _from_positions(upsample(poses.positions.numpy()[:, i]), yaw[:, i], ground[:, i], upsample.fps)
            for i in range(count)
        ]
    height = upsample(vectors[..., :1])
    turns = rotations.rotvec_to_quaternion(vectors[..., 1:].reshape(*vectors.shape[:2], -1, 3))
    turns = np.asarray(upsample(rotations.continuous(turns).astype(np.float32)), dtype=np.float64)
    turns /= np.sqrt(np.einsum("...i,...i->...", turns, turns))[..., None]  # several times faster than a norm over 4
    turns[:, :, 0] = rotations.multiply(rotations.yaw_quaternion(yaw), turns[:, :, 0])
    path = np.concatenate([ground[..., :1], height, ground[..., 1:]], axis=-1)
    return [Motion(SMPL22, turns[:, i], path[:, i], upsample.fps) for i in range(count)]


def _from_positions(positions: np.ndarray, yaw: np.ndarray, ground: np.ndarray, fps: float) -> Motion:
    """The plain decoder gives joints in the heading frame: turned, moved, and brought back to rotations."""
    world = rotations.rotate(rotations.yaw_quaternion(yaw)[:, None], positions)
    world[..., [0, 2]] += ground[:, None]
    turns, path = inverse.inverse(world, SMPL22)
    return Motion(SMPL22, turns, path, fps)
