"""Rotation conversions for NumPy arrays: unit quaternions `wxyz`, matrices, rotation vectors, 6-D, Euler.

The maths is `scipy.spatial.transform.Rotation`; here it only gets leading batch dimensions and our
scalar-first quaternion order. The torch counterpart is the `roma` library.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])


def _apply(values: np.ndarray, item_ndim: int, convert) -> np.ndarray:
    """Flatten the leading dimensions of `values`, convert, and restore them."""
    values = np.asarray(values, dtype=np.float64)
    lead = values.shape[: values.ndim - item_ndim]
    item = values.shape[values.ndim - item_ndim :]
    if 0 in lead:
        probe = convert(np.eye(3)[None] if item == (3, 3) else np.ones((1, *item)))
        return np.zeros(lead + probe.shape[1:])
    result = convert(values.reshape(-1, *item))
    return result.reshape(*lead, *result.shape[1:])


def quaternion_to_matrix(quaternion: Float[np.ndarray, "*batch 4"]) -> Float[np.ndarray, "*batch 3 3"]:
    """(..., 4) wxyz -> (..., 3, 3). Not a library call only because this closed form is several times faster."""
    q = np.asarray(quaternion, dtype=np.float64)
    w, x, y, z = np.moveaxis(q, -1, 0)  # (..., 4) -> 4 of (...)
    scale = 2.0 / np.maximum((q * q).sum(-1), np.finfo(np.float64).tiny)
    matrix = np.empty((*q.shape[:-1], 3, 3))
    matrix[..., 0, 0] = 1 - scale * (y * y + z * z)
    matrix[..., 0, 1] = scale * (x * y - z * w)
    matrix[..., 0, 2] = scale * (x * z + y * w)
    matrix[..., 1, 0] = scale * (x * y + z * w)
    matrix[..., 1, 1] = 1 - scale * (x * x + z * z)
    matrix[..., 1, 2] = scale * (y * z - x * w)
    matrix[..., 2, 0] = scale * (x * z - y * w)
    matrix[..., 2, 1] = scale * (y * z + x * w)
    matrix[..., 2, 2] = 1 - scale * (x * x + y * y)
    return matrix


def matrix_to_quaternion(matrix: Float[np.ndarray, "*batch 3 3"]) -> Float[np.ndarray, "*batch 4"]:
    """(..., 3, 3) -> (..., 4) wxyz with w >= 0. A near-rotation is projected onto the nearest one."""
    return _apply(matrix, 2, lambda m: Rotation.from_matrix(m).as_quat(canonical=True, scalar_first=True))


def rotvec_to_quaternion(rotvec: Float[np.ndarray, "*batch 3"]) -> Float[np.ndarray, "*batch 4"]:
    """(..., 3) axis times angle, radians -> (..., 4) wxyz."""
    return _apply(rotvec, 1, lambda v: Rotation.from_rotvec(v).as_quat(scalar_first=True))


def quaternion_to_rotvec(quaternion: Float[np.ndarray, "*batch 4"]) -> Float[np.ndarray, "*batch 3"]:
    """(..., 4) wxyz -> (..., 3) axis times angle, angle in [0, pi]."""
    return _apply(quaternion, 1, lambda q: Rotation.from_quat(q, scalar_first=True).as_rotvec())


def rotvec_to_matrix(rotvec: Float[np.ndarray, "*batch 3"]) -> Float[np.ndarray, "*batch 3 3"]:
    """(..., 3) axis times angle, radians -> (..., 3, 3)."""
    return _apply(rotvec, 1, lambda v: Rotation.from_rotvec(v).as_matrix())


def matrix_to_rotvec(matrix: Float[np.ndarray, "*batch 3 3"]) -> Float[np.ndarray, "*batch 3"]:
    """(..., 3, 3) -> (..., 3) axis times angle, angle in [0, pi]."""
    return _apply(matrix, 2, lambda m: Rotation.from_matrix(m).as_rotvec())


def euler_to_quaternion(angles: Float[np.ndarray, "*batch 3"], order: str) -> Float[np.ndarray, "*batch 4"]:
    """(..., 3) intrinsic Euler angles in radians, applied in `order` ("ZXY", ...) -> (..., 4) wxyz."""
    return _apply(angles, 1, lambda e: Rotation.from_euler(order.upper(), e).as_quat(scalar_first=True))


def quaternion_to_euler(quaternion: Float[np.ndarray, "*batch 4"], order: str) -> Float[np.ndarray, "*batch 3"]:
    """(..., 4) wxyz -> (..., 3) intrinsic Euler angles in radians, in `order` ("ZXY", ...).

    At gimbal lock the third angle is set to zero (the rotation is still right).
    """
    from warnings import catch_warnings, simplefilter

    with catch_warnings():
        simplefilter("ignore", UserWarning)  # scipy announces gimbal lock, which the docstring covers
        return _apply(quaternion, 1, lambda q: Rotation.from_quat(q, scalar_first=True).as_euler(order.upper()))


def matrix_to_rot6d(matrix: Float[np.ndarray, "*batch 3 3"]) -> Float[np.ndarray, "*batch 6"]:
    """(..., 3, 3) -> (..., 6): the first two columns, one after the other (Zhou et al. 2019)."""
    matrix = np.asarray(matrix)
    return np.concatenate([matrix[..., 0], matrix[..., 1]], axis=-1)


def rot6d_to_matrix(rot6d: Float[np.ndarray, "*batch 6"]) -> Float[np.ndarray, "*batch 3 3"]:
    """(..., 6) two columns, not necessarily orthonormal -> (..., 3, 3) by Gram-Schmidt."""
    rot6d = np.asarray(rot6d, dtype=np.float64)
    first = normalise(rot6d[..., :3])
    second = rot6d[..., 3:]
    second = normalise(second - (first * second).sum(-1, keepdims=True) * first)
    return np.stack([first, second, np.cross(first, second)], axis=-1)


def normalise(vectors: Float[np.ndarray, "*batch N"]) -> Float[np.ndarray, "*batch N"]:
    """(..., N) -> the same with unit length along the last axis; zero vectors stay zero."""
    vectors = np.asarray(vectors, dtype=np.float64)
    norm = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(norm > 0, norm, 1.0)


def multiply(
    left: Float[np.ndarray, "*#batch 4"], right: Float[np.ndarray, "*#batch 4"]
) -> Float[np.ndarray, "*batch 4"]:
    """Hamilton product of quaternions (..., 4) wxyz: first `right`, then `left`."""
    lw, lx, ly, lz = np.moveaxis(np.asarray(left, dtype=np.float64), -1, 0)
    rw, rx, ry, rz = np.moveaxis(np.asarray(right, dtype=np.float64), -1, 0)
    return np.stack(
        [
            lw * rw - lx * rx - ly * ry - lz * rz,
            lw * rx + lx * rw + ly * rz - lz * ry,
            lw * ry - lx * rz + ly * rw + lz * rx,
            lw * rz + lx * ry - ly * rx + lz * rw,
        ],
        axis=-1,
    )


def invert(quaternion: Float[np.ndarray, "*batch 4"]) -> Float[np.ndarray, "*batch 4"]:
    """Inverse of unit quaternions (..., 4) wxyz."""
    return np.asarray(quaternion, dtype=np.float64) * np.array([1.0, -1.0, -1.0, -1.0])


def rotate(
    quaternion: Float[np.ndarray, "*#batch 4"], vectors: Float[np.ndarray, "*#batch 3"]
) -> Float[np.ndarray, "*batch 3"]:
    """Vectors (..., 3) turned by quaternions (..., 4) wxyz; leading dimensions broadcast."""
    quaternion, vectors = np.asarray(quaternion, np.float64), np.asarray(vectors, np.float64)
    axis, w = quaternion[..., 1:], quaternion[..., :1]
    twice = 2.0 * np.cross(axis, vectors)
    return vectors + w * twice + np.cross(axis, twice)


def between(
    start: Float[np.ndarray, "*#batch 3"], end: Float[np.ndarray, "*#batch 3"]
) -> Float[np.ndarray, "*batch 4"]:
    """Shortest rotation (..., 4) wxyz that turns directions `start` (..., 3) onto `end` (..., 3).

    Opposite directions turn half a circle about some axis across them; a zero vector gives the identity.
    """
    start, end = np.broadcast_arrays(normalise(start), normalise(end))
    w = 1.0 + (start * end).sum(-1, keepdims=True)
    axis = np.cross(start, end)
    across = np.cross(start, np.where(np.abs(start[..., :1]) < 0.9, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]))
    opposite = w < 1e-9
    quaternion = np.concatenate([np.where(opposite, 0.0, w), np.where(opposite, across, axis)], axis=-1)
    quaternion = normalise(quaternion)
    return np.where(np.linalg.norm(quaternion, axis=-1, keepdims=True) > 0, quaternion, IDENTITY)


def angle(quaternion: Float[np.ndarray, "*batch 4"]) -> Float[np.ndarray | np.floating, "*batch"]:
    """Rotation angle (...) in [0, pi] of unit quaternions (..., 4) wxyz; of one quaternion, one number."""
    quaternion = np.asarray(quaternion, dtype=np.float64)
    return 2.0 * np.arctan2(np.linalg.norm(quaternion[..., 1:], axis=-1), np.abs(quaternion[..., 0]))


def continuous(quaternion: Float[np.ndarray, "T *batch 4"]) -> Float[np.ndarray, "T *batch 4"]:
    """(T, ..., 4) with signs chosen so that neighbours in time lie on the same hemisphere."""
    quaternion = np.array(quaternion, dtype=np.float64)
    if len(quaternion) > 1:
        flips = (quaternion[1:] * quaternion[:-1]).sum(-1) < 0
        sign = np.where(np.cumsum(flips, axis=0) % 2 == 1, -1.0, 1.0)
        quaternion[1:] *= sign[..., None]
    return quaternion


def slerp(
    times: Float[np.ndarray, " T"], quaternion: Float[np.ndarray, "T J 4"], new_times: Float[np.ndarray, " N"]
) -> Float[np.ndarray, "N J 4"]:
    """Spherical interpolation of (T, J, 4) wxyz given at increasing `times` (T,) to `new_times` (N,) -> (N, J, 4).

    Written out because scipy's Slerp takes one track at a time.
    """
    after = np.clip(np.searchsorted(times, new_times, side="right"), 1, len(times) - 1)
    share = np.clip((new_times - times[after - 1]) / (times[after] - times[after - 1]), 0.0, 1.0)[:, None]
    start, end = quaternion[after - 1], quaternion[after]
    cosine = (start * end).sum(-1)
    end = np.where(cosine[..., None] < 0, -end, end)
    theta = np.arccos(np.clip(np.abs(cosine), 0.0, 1.0))
    small = theta < 1e-6
    sine = np.where(small, 1.0, np.sin(theta))
    first = np.where(small, 1.0 - share, np.sin((1.0 - share) * theta) / sine)
    second = np.where(small, share, np.sin(share * theta) / sine)
    return normalise(first[..., None] * start + second[..., None] * end)


def yaw_quaternion(yaw: Float[np.ndarray, "*batch"] | float) -> Float[np.ndarray, "*batch 4"]:
    """Rotation about +Y by `yaw` (...) radians -> (..., 4) wxyz; yaw 0 faces +Z, positive turns towards +X."""
    half = np.asarray(yaw, dtype=np.float64) / 2
    zero = np.zeros_like(half)
    return np.stack([np.cos(half), zero, np.sin(half), zero], axis=-1)
