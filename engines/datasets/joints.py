"""Joint positions of other bodies (arrays of .npy files) as motions of the house skeleton."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from engines.errors import FormatError
from engines.formats.files import check_size, existing_file
from engines.geometry import retarget, rotations
from engines.motion import Motion
from engines.skeletons import SMPL22

_FAR = 1e6
"""Coordinates from here on are taken for damage."""
_UPRIGHT = {
    # the axis of the data that points from the feet to the neck -> what turns it to +Y (a proper rotation, wxyz)
    (1, 1): (1.0, 0.0, 0.0, 0.0),
    (1, -1): (0.0, 1.0, 0.0, 0.0),
    (2, 1): (np.sqrt(0.5), -np.sqrt(0.5), 0.0, 0.0),
    (2, -1): (np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0),
    (0, 1): (np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)),
    (0, -1): (np.sqrt(0.5), 0.0, 0.0, -np.sqrt(0.5)),
}

SMPL24 = {role: index for index, role in enumerate(SMPL22.joints)}
"""SMPL's 24 joints: the house's 22, then the hands."""


def load_npy(path: Path) -> np.ndarray:
    """An array of numbers from a .npy file, nothing unpickled.

    Raises:
        FormatError: missing, damaged, or no array of numbers.
    """
    existing_file(path)
    try:
        # mapped first: a file that claims more than it holds is refused before anything is allocated for it
        values = np.array(np.load(path, mmap_mode="r", allow_pickle=False))
    except (OSError, ValueError, EOFError, TypeError, AttributeError) as error:
        raise FormatError(path, f"is no .npy array that can be read ({error}).") from error
    if values.dtype.kind != "f":
        raise FormatError(path, "holds no floating point numbers; accepted: an array (frames, joints, 3).")
    return values


def shape_of(path: Path) -> tuple[int, ...]:
    """The shape a .npy file states, () if it is none; the array itself is not read. Never raises."""
    try:
        return np.load(path, mmap_mode="r", allow_pickle=False).shape
    except (OSError, ValueError, EOFError, TypeError, AttributeError):
        return ()


def from_joints(
    path: Path, joints: np.ndarray, roles: Mapping[str, int], fps: float, *, turned: bool = False
) -> Motion:
    """A motion of `smpl22` from the joint positions of another body, of any unit of length.

    Args:
        path: the file they come from, for messages.
        joints: (T, J, 3).
        roles: joint name of `smpl22` -> index among the J.
        fps: frames a second.
        turned: the axes are a camera's or unknown: find which way is up, and whether left and right are exchanged.

    Raises:
        FormatError: another shape, values that are not finite, or a body without size.
    """
    needed = max(roles.values()) + 1
    if joints.ndim != 3 or joints.shape[1] < needed or joints.shape[2] != 3 or len(joints) == 0:
        raise FormatError(path, f"has shape {joints.shape}; accepted: (frames, {needed} or more joints, 3).")
    check_size(path, len(joints), len(SMPL22))
    if not (np.abs(joints) < _FAR).all():  # False for NaN
        bad = np.flatnonzero(~(np.abs(joints) < _FAR).all(axis=(1, 2)))[0]
        raise FormatError(path, f"frame {bad} holds values that are not finite, or beyond reason.")
    points = {role: joints[:, index].astype(np.float64) for role, index in roles.items()}
    stature = np.linalg.norm(points["neck"] - _feet(points), axis=-1).max()
    if stature < 1e-6:
        raise FormatError(path, "all joints lie in one point; accepted: a body.")
    return retarget.from_points(_upright(points) if turned else points, fps)


def _upright(points: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Turned so that the body stands along +Y, and mirrored if its toes would point backward."""
    body = np.median(points["neck"] - _feet(points), axis=0)
    axis = int(np.abs(body).argmax())
    turn = np.array(_UPRIGHT[axis, 1 if body[axis] > 0 else -1])
    points = {role: rotations.rotate(turn, value) for role, value in points.items()}
    if "left_foot" in points:
        ahead = np.cross(points["left_hip"] - points["right_hip"], [0.0, 1.0, 0.0])
        toes = sum(points[f"{side}_foot"] - points[f"{side}_ankle"] for side in ("left", "right"))
        if np.median(np.einsum("tc,tc->t", ahead, np.asarray(toes))) < 0:
            points = {role: value * np.array([-1.0, 1.0, 1.0]) for role, value in points.items()}
    return points


def _feet(points: Mapping[str, np.ndarray]) -> np.ndarray:
    return (points["left_ankle"] + points["right_ankle"]) / 2
