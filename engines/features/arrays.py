"""Rotations of many bodies as planes: arrays with components in front and frames last, float32.

Quaternions are (4, J, N), matrices (3, 3, J, N), points (3, J, N), N frames of any number of clips. Every operation
then runs over long rows, several times as fast as the same over (N, J, 3, 3): `benchmarks/features.py` has the
speeds. Values are those of `engines.geometry.rotations` and `kinematics` up to float32 (tests/engines/features).
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from engines.geometry.kinematics import depth_levels


def planes(values: np.ndarray) -> np.ndarray:
    """(..., J, C) -> (C, J, N) float32, N the product of the leading dimensions."""
    held = np.asarray(values)
    return np.ascontiguousarray(held.reshape(-1, *held.shape[-2:]).transpose(2, 1, 0), dtype=np.float32)


def unplanes(values: np.ndarray, lead: tuple[int, ...]) -> np.ndarray:
    """(C, J, N) -> (*lead, J, C), contiguous."""
    return np.ascontiguousarray(values.transpose(2, 1, 0)).reshape(*lead, values.shape[1], values.shape[0])


def quaternion_to_matrix(quaternion: np.ndarray) -> np.ndarray:
    """Unit quaternions (4, ...) wxyz -> (3, 3, ...)."""
    w, x, y, z = quaternion
    x2, y2, z2 = x + x, y + y, z + z
    xx, yy, zz, xy, xz, yz = x * x2, y * y2, z * z2, x * y2, x * z2, y * z2
    wx, wy, wz = w * x2, w * y2, w * z2
    matrix = np.empty((3, 3, *quaternion.shape[1:]), quaternion.dtype)
    for row, column, first, second in (
        (0, 1, xy, -wz), (0, 2, xz, wy), (1, 0, xy, wz), (1, 2, yz, -wx), (2, 0, xz, -wy), (2, 1, yz, wx),
    ):  # fmt: skip
        np.add(first, second, out=matrix[row, column])
    for axis, first, second in ((0, yy, zz), (1, xx, zz), (2, xx, yy)):
        np.subtract(1, first + second, out=matrix[axis, axis])
    return matrix


def rotation_to_quaternion(first: np.ndarray, second: np.ndarray, third: np.ndarray) -> np.ndarray:
    """Columns (3, ...) of rotation matrices -> quaternions (4, ...) wxyz."""
    (xx, yx, zx), (xy, yy, zy), (xz, yz, zz) = first, second, third
    trace = xx + yy + zz
    quaternion = np.empty((4, *first.shape[1:]), first.dtype)
    twice = np.sqrt(np.maximum(trace + 1, 1e-6))
    np.multiply(twice, 0.5, out=quaternion[0])
    scale = 0.5 / twice
    for out, plus, minus in ((1, zy, yz), (2, xz, zx), (3, yx, xy)):
        np.multiply(plus - minus, scale, out=quaternion[out])
    steep = trace < -0.5  # past 151 degrees w is small, and the three others would lose their digits
    if steep.any():
        quaternion[:, steep] = _steep(first[:, steep], second[:, steep], third[:, steep])
    return quaternion


def _steep(first: np.ndarray, second: np.ndarray, third: np.ndarray) -> np.ndarray:
    """Columns (3, K) of rotations by any angle -> quaternions (4, K) from whichever component is largest."""
    (xx, yx, zx), (xy, yy, zy), (xz, yz, zz) = first, second, third
    # four times the quaternion's outer product with itself: any row is the quaternion times one of its components
    outer = np.array(
        [
            [1 + xx + yy + zz, zy - yz, xz - zx, yx - xy],
            [zy - yz, 1 + xx - yy - zz, xy + yx, xz + zx],
            [xz - zx, xy + yx, 1 - xx + yy - zz, yz + zy],
            [yx - xy, xz + zx, yz + zy, 1 - xx - yy + zz],
        ]
    )
    largest = np.diagonal(outer).argmax(axis=1)
    row = outer[largest, :, np.arange(len(largest))]
    return (row / np.linalg.norm(row, axis=1, keepdims=True)).T


def rot6d_to_columns(rot6d: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(6, ...) two columns, not necessarily orthonormal -> three orthonormal columns (3, ...), by Gram-Schmidt.

    Columns too short or too alike to tell a rotation give finite numbers, and no rotation in particular.
    """
    first = unit(rot6d[:3])
    second = unit(rot6d[3:] - dot(first, rot6d[3:]) * first)
    return first, second, cross(first, second)


def dot(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Inner products (...) of vectors (3, ...)."""
    return left[0] * right[0] + left[1] * right[1] + left[2] * right[2]


def cross(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Cross products of vectors (3, ...)."""
    shape = np.broadcast_shapes(left.shape, right.shape)
    result = np.empty(shape, np.result_type(left, right))
    for out, a, b in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        np.subtract(left[a] * right[b], left[b] * right[a], out=result[out])
    return result


def unit(vectors: np.ndarray) -> np.ndarray:
    """Vectors (3, ...) with length one; those without length stay zero."""
    return vectors / np.maximum(np.sqrt(dot(vectors, vectors)), 1e-12)


def compose(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Matrix products (3, 3, ...): first `right`, then `left`."""
    product = left[:, 0, None] * right[None, 0]
    product += left[:, 1, None] * right[None, 1]
    product += left[:, 2, None] * right[None, 2]
    return product


def multiply(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Hamilton products of quaternions (4, ...) wxyz: first `right`, then `left`."""
    (a, b, c, d), (e, f, g, h) = left, right
    return np.stack(
        [
            a * e - b * f - c * g - d * h,
            a * f + b * e + c * h - d * g,
            a * g - b * h + c * e + d * f,
            a * h + b * g - c * f + d * e,
        ]
    )


def invert(quaternion: np.ndarray) -> np.ndarray:
    """Inverse of unit quaternions (4, ...) wxyz."""
    return np.concatenate([quaternion[:1], -quaternion[1:]])


def world(local: np.ndarray, parents: tuple[int, ...]) -> np.ndarray:
    """Parent-relative rotations (3, 3, J, N) accumulated from the root, a level of the tree at a time."""
    turned = np.empty_like(local)
    turned[:, :, 0] = local[:, :, 0]
    for level in depth_levels(parents)[1:]:
        first, last = level[0], level[-1] + 1
        joints = slice(first, last) if level == tuple(range(first, last)) else list(level)
        turned[:, :, joints] = compose(turned[:, :, [parents[joint] for joint in level]], local[:, :, joints])
    return turned


def place(matrices: np.ndarray, offsets: np.ndarray, parents: tuple[int, ...]) -> np.ndarray:
    """Joints (3, J, N) relative to the root from world rotations (3, 3, J, N) and rest offsets (J, 3), metres.

    Where a joint is, is linear in all rotations on the way to it: one product of large matrices.
    """
    spread = _reach(parents, np.asarray(offsets, np.float64).tobytes())
    return spread @ matrices.reshape(3, -1, matrices.shape[-1])


def slopes(matrices: np.ndarray) -> np.ndarray:
    """First two columns of matrices (3, 3, ...), one after the other: the 6-D rotation (6, ...) of Zhou et al."""
    return np.concatenate([matrices[:, 0], matrices[:, 1]])


def unyaw(vectors: np.ndarray, cosine: np.ndarray, sine: np.ndarray) -> np.ndarray:
    """Vectors (3, ...) of the world in the frame of a body that faces yaw (cosine, sine of it given)."""
    x, y, z = vectors
    return np.stack([cosine * x - sine * z, y, sine * x + cosine * z])


def yaw(vectors: np.ndarray, cosine: np.ndarray, sine: np.ndarray) -> np.ndarray:
    """Vectors (3, ...) from the frame of a body that faces yaw into the world."""
    return unyaw(vectors, cosine, -sine)


@lru_cache(maxsize=16)
def _reach(parents: tuple[int, ...], offsets: bytes) -> np.ndarray:
    """(J, 3 * J) how far a joint (row) lies along each axis of each joint's frame (columns, axis by axis)."""
    rest = np.frombuffer(offsets).reshape(-1, 3)
    reach = np.zeros((len(parents), 3, len(parents)), np.float32)
    for joint, parent in enumerate(parents):
        if parent >= 0:
            reach[joint] = reach[parent]
            reach[joint, :, parent] += rest[joint]
    return reach.reshape(len(parents), -1)
