from __future__ import annotations

import pytest

from studio.quality import level_of, measures

REAL = {"foot_skate": 0.04, "jitter": 40.0, "ground_penetration": 0.001}


def test_numbers_come_in_a_persons_units_beside_those_of_real_motion():
    skate, jitter, floor = measures({"ground_penetration": 0.0013, "foot_skate": 0.05, "jitter": 130.0}, REAL)
    assert (skate.text, skate.real, skate.level, skate.word) == ("5.0 cm/s", "4.0", "good", "skate 5.0")
    assert (jitter.text, jitter.level) == ("130 m/s³", "poor")
    assert (floor.text, floor.level) == ("0.1 cm", "good")


@pytest.mark.parametrize(
    ("value", "real", "level"),
    [(0.06, 0.04, "good"), (0.061, 0.04, "fair"), (0.12, 0.04, "fair"), (0.13, 0.04, "poor"), (0.009, None, "good"),
     (0.007, 0.0, "good"), (0.02, 0.001, "fair")],
)  # fmt: skip
def test_levels_stand_between_real_motion_and_three_times_it(value, real, level):
    assert level_of(value, real, floor=0.01) == level


def test_what_is_missing_or_not_a_number_is_left_out():
    assert measures({"jitter": float("nan"), "wingspan": 2.0}, REAL) == []
    assert measures({"jitter": 1.0}, {})[0].real == ""
