"""Motions as BVH text; `bvh` is the reader and says what the format is.

The HIERARCHY is the skeleton's rest pose as it is: of `smpl22` a clean T-pose, Y up, facing +Z. Blender's importer,
left at its own settings (-Z forward, Y up), turns that upright (tried with Blender 4.5: joints agree to a
micrometre). Lengths are in centimetres unless told otherwise, which is what Blender (with scale 0.01), MotionBuilder
and Maya expect.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from engines.errors import FormatError, OutOfRangeError
from engines.formats.bvh_text import FPS_RANGE
from engines.formats.files import atomic_path
from engines.geometry import rotations
from engines.motion import Motion
from engines.skeletons.skeleton import Skeleton

_ROWS = 256
"""Frames formatted at once: enough to be fast, few enough to be small."""


def write(motion: Motion, path: str | Path, scale: float = 100.0, order: str = "ZXY") -> Path:
    """Write a motion as BVH.

    Args:
        motion: any motion.
        path: the file.
        scale: units of the file in one metre; 100 writes centimetres.
        order: the three axes of the rotation channels, e.g. "ZXY" or "XYZ".

    Returns:
        The path. White space and braces in joint names become underscores. End sites are written for joints without
        children; labels and provenance have no place in a BVH.

    Raises:
        FormatError: the file cannot be written, or the frame rate cannot be told in one.
        OutOfRangeError: a scale that is not positive, or an order that is not three different axes.
    """
    path, order = Path(path), order.upper()
    if sorted(order) != ["X", "Y", "Z"]:
        raise OutOfRangeError("order", order, "X, Y and Z in some order, such as 'ZXY'")
    if not (np.isfinite(scale) and scale > 0):
        raise OutOfRangeError("scale", scale, "a positive number")
    if not FPS_RANGE[0] <= motion.fps <= FPS_RANGE[1]:
        raise FormatError(path, f"a frame rate of {motion.fps:g}; accepted: from {FPS_RANGE[0]} to {FPS_RANGE[1]:g}.")
    channels = _channels(motion, _depth_first(motion.skeleton), scale, order)
    seconds = np.format_float_positional(1 / motion.fps, trim="0")
    with atomic_path(path) as temporary, temporary.open("w", encoding="utf-8", newline="\n") as file:
        file.write(_hierarchy(motion.skeleton, scale, order))
        file.write(f"MOTION\nFrames: {len(motion)}\nFrame Time: {seconds}\n")
        for start in range(0, len(motion), _ROWS):
            file.write(_rows(channels[start : start + _ROWS]))
    return path


def _depth_first(skeleton: Skeleton) -> list[int]:
    """Joint indices in the order in which a hierarchy lists them."""
    joints, stack = [], [0]
    while stack:
        joint = stack.pop()
        joints.append(joint)
        stack.extend(reversed(skeleton.children[joint]))
    return joints


def _names(skeleton: Skeleton) -> list[str]:
    """Joint names that every BVH reader takes as one word, no two alike."""
    names: list[str] = []
    for joint in skeleton.joints:
        bare = re.sub(r"[\s{}]+", "_", joint) or "joint"
        name, count = bare, 2
        while name in names:
            name, count = f"{bare}_{count}", count + 1
        names.append(name)
    return names


def _hierarchy(skeleton: Skeleton, scale: float, order: str) -> str:
    """The HIERARCHY section, written without recursion."""
    names = _names(skeleton)
    turns = " ".join(f"{axis}rotation" for axis in order)
    lines = ["HIERARCHY"]
    stack: list[tuple[int, int]] = [(0, 0)]  # joint, depth; a closing brace is a joint of -1
    while stack:
        joint, depth = stack.pop()
        tab = "\t" * depth
        if joint < 0:
            lines.append(tab + "}")
            continue
        offset = skeleton.offsets[joint] * scale if joint else np.zeros(3)  # the root's is in its position channels
        lines += [
            f"{tab}{'JOINT' if joint else 'ROOT'} {names[joint]}",
            tab + "{",
            f"{tab}\tOFFSET {_numbers(offset)}",
            f"{tab}\tCHANNELS " + (f"3 {turns}" if joint else f"6 Xposition Yposition Zposition {turns}"),
        ]
        stack.append((-1, depth))
        stack.extend((child, depth + 1) for child in reversed(skeleton.children[joint]))
        if not skeleton.children[joint]:
            end = np.asarray(skeleton.end_offsets.get(skeleton.joints[joint], np.zeros(3))) * scale
            lines += [f"{tab}\tEnd Site", tab + "\t{", f"{tab}\t\tOFFSET {_numbers(end)}", tab + "\t}"]
    return "\n".join(lines) + "\n"


def _channels(motion: Motion, joints: list[int], scale: float, order: str) -> np.ndarray:
    """(T, 3 + 3 J) root place in file units, then the angles in degrees, joints in the hierarchy's order."""
    angles = np.degrees(rotations.quaternion_to_euler(motion.rotations[:, joints], order))
    angles = np.unwrap(angles, axis=0, period=360.0)  # programs that interpolate angles must not spin
    root = (motion.translation + motion.skeleton.offsets[0]) * scale
    return np.concatenate([root, angles.reshape(len(motion), -1)], axis=1)


def _rows(values: np.ndarray) -> str:
    """Lines of numbers with six decimals (1e-8 m in centimetres), by one format for all."""
    line = " ".join(["%.6f"] * values.shape[1]) + "\n"
    rounded = np.round(values, 6) + 0.0  # never -0.000000
    return (line * len(values)) % tuple(rounded.ravel().tolist())


def _numbers(values: np.ndarray) -> str:
    return _rows(values[None]).rstrip()
