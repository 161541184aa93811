"""Motions as a CSV table for spreadsheets and statistics: a row a frame, a column a number.

Columns, each naming its unit: `frame`, `time_s`, then for every joint J its place in the world `J_x_m`, `J_y_m`,
`J_z_m` (metres, Y up) and its parent-relative rotation `J_qw`, `J_qx`, `J_qy`, `J_qz` (a unit quaternion, no unit).
Written only: a table has no place for the skeleton itself.
"""

from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np

from engines.formats.files import atomic_path
from engines.formats.registry import Format
from engines.motion import Motion

_ROWS = 256
"""Frames formatted at once."""


def write(motion: Motion, path: str | Path) -> Path:
    """Write a motion as CSV (RFC 4180, UTF-8, a point for decimals).

    Returns:
        The path. Labels and provenance have no place in a table.

    Raises:
        FormatError: the file cannot be written.
    """
    path = Path(path)
    line = "%d,%.6f," + ",".join(["%.6f,%.6f,%.6f,%.8f,%.8f,%.8f,%.8f"] * len(motion.skeleton)) + "\r\n"
    numbers = np.concatenate([motion.positions, motion.rotations], axis=-1).reshape(len(motion), -1)
    frames = np.arange(len(motion))
    # adding zero makes no -0.000000 of a small negative number
    values = np.column_stack([frames, frames / motion.fps, np.round(numbers, 8) + 0.0])
    with atomic_path(path) as temporary, temporary.open("w", encoding="utf-8", newline="") as file:
        file.write(_header(motion.skeleton.joints))
        for start in range(0, len(values), _ROWS):
            rows = values[start : start + _ROWS]
            file.write((line * len(rows)) % tuple(rows.ravel().tolist()))
    return path


def columns(joints: tuple[str, ...]) -> list[str]:
    """The names of the columns for these joints."""
    parts = ("x_m", "y_m", "z_m", "qw", "qx", "qy", "qz")
    return ["frame", "time_s", *(f"{joint}_{part}" for joint in joints for part in parts)]


def _header(joints: tuple[str, ...]) -> str:
    """The first line, names quoted where they need it."""
    text = io.StringIO()
    csv.writer(text).writerow(columns(joints))
    return text.getvalue()


def sniff(path: Path, head: bytes) -> bool:
    """Tables are not read."""
    return False


FORMAT = Format("csv", (".csv",), "table of joint positions and rotations", sniff, None, write)
