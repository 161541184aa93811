"""Tables: every number under a name that says what it is."""

from __future__ import annotations

import csv

import numpy as np
import pytest

from engines import formats
from engines.errors import FormatError
from engines.skeletons.skeleton import Skeleton
from tests.engines.formats.conftest import random_motion


def table(path) -> tuple[list[str], np.ndarray]:
    with path.open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    return header, np.array(rows, dtype=float)


def test_columns_hold_what_they_say(tmp_path, motion):
    header, values = table(formats.write(motion, tmp_path / "walk.csv"))
    held = dict(zip(header, values.T, strict=True))
    assert header[:6] == ["frame", "time_s", "pelvis_x_m", "pelvis_y_m", "pelvis_z_m", "pelvis_qw"]
    np.testing.assert_array_equal(held["frame"], np.arange(7))
    np.testing.assert_allclose(held["time_s"], np.arange(7) / 30, atol=1e-6)
    joint = motion.skeleton.index("left_wrist")
    np.testing.assert_allclose(held["left_wrist_y_m"], motion.positions[:, joint, 1], atol=1e-6)
    for column, name in enumerate("wxyz"):
        np.testing.assert_allclose(held[f"left_wrist_q{name}"], motion.rotations[:, joint, column], atol=1e-8)
    assert values.shape == (7, 2 + 7 * 22)


def test_names_with_commas_and_many_frames(tmp_path):
    skeleton = Skeleton("odd", ('a,"b', "c"), (-1, 0), np.zeros((2, 3)))
    header, values = table(formats.write(random_motion(600, skeleton=skeleton), tmp_path / "odd.csv"))
    assert header[2] == 'a,"b_x_m' and values.shape == (600, 16)
    assert (tmp_path / "odd.csv").read_bytes().count(b"-0.000000,") == 0


def test_tables_are_not_read(tmp_path, motion):
    path = formats.write(motion, tmp_path / "walk.csv")
    with pytest.raises(FormatError, match="of no kind that is known here"):
        formats.read(path)
