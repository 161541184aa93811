"""UTD-MHAD skeletons: MATLAB files with the 20 joints of a first Kinect, 30 frames a second (Chen et al. 2015).

The Kinect sees the person from the front: X points to the person's right, Y up, Z away from the camera. Half a turn
about Y makes it ours: left is +X, and the person faces +Z.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from engines.errors import FormatError
from engines.formats import mat5
from engines.formats.files import check_size, read_bytes
from engines.formats.registry import Format
from engines.motion import Motion, Provenance
from engines.skeletons import roles

MAX_BYTES = 64 * 2**20
"""No .mat file larger than this is read."""
FPS = 30.0
"""Frames a second of the Kinect."""
FARTHEST = 100.0
"""Metres: no joint is farther from the Kinect than this."""
NARROWEST = 0.001
"""Metres: hips, shoulders and the ends of the trunk are farther apart than this, even where the Kinect falters."""
VARIABLE = "d_skel"
"""Name of the array in the file."""
JOINTS = (
    "head", "shoulder_center", "spine", "hip_center",
    "left_shoulder", "left_elbow", "left_wrist", "left_hand",
    "right_shoulder", "right_elbow", "right_wrist", "right_hand",
    "left_hip", "left_knee", "left_ankle", "left_foot",
    "right_hip", "right_knee", "right_ankle", "right_foot",
)  # fmt: skip
"""Joint names in the order of the file's rows."""


def read_points(path: str | Path) -> tuple[dict[str, np.ndarray], float]:
    """Joint positions of a UTD-MHAD skeleton file.

    Returns:
        joint name -> (T, 3) metres, Y up, facing about +Z, the Kinect at the origin; and frames a second, 30.

    Raises:
        FormatError: missing, damaged, or without a finite 20 x 3 x T array `d_skel`.
    """
    path = Path(path)
    points = _load(path) * np.array([-1.0, 1.0, -1.0])
    return {name: points[:, j] for j, name in enumerate(JOINTS)}, FPS


def _load(path: Path) -> np.ndarray:
    """(T, 20, 3) as in the file."""
    try:
        listed = mat5.variables(read_bytes(path, MAX_BYTES))
    except ValueError as error:
        raise FormatError(path, f"is no MATLAB file that can be read: {error}.") from error
    found = next((variable for variable in listed if variable.name == VARIABLE), None)
    shape = found.shape if found else ()
    if found is None or len(shape) != 3 or shape[:2] != (len(JOINTS), 3) or shape[2] < 1:
        held = ", ".join(str(variable) for variable in listed[:8]) or "nothing"
        raise FormatError(path, f"holds {held}; accepted: {VARIABLE}, 20 x 3 x frames.")
    check_size(path, shape[2], len(JOINTS))
    try:
        points = found.array()
    except ValueError as error:
        raise FormatError(path, f"{VARIABLE} cannot be read: {error}. Is the file cut short?") from error
    if points.dtype.kind != "f" or not np.isfinite(points).all():
        raise FormatError(path, f"{VARIABLE} holds values that are not finite real numbers.")
    far = np.flatnonzero(np.abs(points).max(axis=(0, 1)) > FARTHEST)
    if len(far):
        raise FormatError(path, f"frame {far[0]} has joints beyond {FARTHEST:g} m; accepted: metres from the Kinect.")
    return points.transpose(2, 0, 1).astype(np.float64)


def read(path: str | Path) -> Motion:
    """Read a UTD-MHAD skeleton file as a motion of `smpl22`, standing on the floor.

    The Kinect gives places, not rotations, so these are found by `geometry.retarget.from_points`.

    Raises:
        FormatError: as `read_points`, or a frame in which the trunk has collapsed (a Kinect that lost the person).
    """
    from engines.geometry import retarget

    path = Path(path)
    points, fps = read_points(path)
    _check_body(path, points)
    known = roles.recognise(JOINTS)
    try:
        motion = retarget.from_points({role: points[joint] for role, joint in known.items()}, fps)
    except ValueError as error:  # SkeletonError, or SciPy's on points that no body can take
        raise FormatError(path, f"its points make no pose of a body: {error}") from error
    return motion.on_ground().replaced(provenance=Provenance(source=path.name, parameters={"format": "utd_mat"}))


def _check_body(path: Path, points: dict[str, np.ndarray]) -> None:
    """Refuse frames whose trunk has no width or no height."""
    spans = (("left_hip", "right_hip"), ("left_shoulder", "right_shoulder"), ("hip_center", "shoulder_center"))
    for start, end in spans:
        lost = np.flatnonzero(np.linalg.norm(points[start] - points[end], axis=-1) < NARROWEST)
        if len(lost):
            raise FormatError(path, f"in frame {lost[0]}, {start} and {end} fall together; accepted: a whole body.")


def sniff(path: Path, head: bytes) -> bool:
    """Does the file begin as a MATLAB 5 file?"""
    return head.startswith(b"MATLAB 5.0 MAT-file")


FORMAT = Format("utd_mat", (".mat",), "UTD-MHAD Kinect skeleton", sniff, read)
