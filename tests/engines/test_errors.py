"""Errors speak to a person: what, where, and what would be accepted."""

from __future__ import annotations

import pytest

from engines import errors


def test_a_file_error_says_where() -> None:
    error = errors.FormatError("walk.bvh", "no MOTION section", line=12)
    assert str(error) == "walk.bvh:12: no MOTION section"
    assert (error.path.name, error.problem) == ("walk.bvh", "no MOTION section")
    assert str(errors.FormatError("walk.bvh", "empty")) == "walk.bvh: empty"


def test_a_range_error_says_what_is_accepted() -> None:
    assert str(errors.OutOfRangeError("frames", -1, "1 to 400")) == "frames is -1; accepted: 1 to 400."


def test_an_unknown_label_lists_the_nearest() -> None:
    error = errors.UnknownLabelError("action", "wlak", ["walk", "wash", "jump", "run"])
    assert error.nearest[0] == "walk"
    assert len(error.nearest) == 3
    assert "did you mean 'walk'" in str(error)
    assert "(4 known)" in str(error)


@pytest.mark.parametrize(
    ("asked", "expected"),
    [("hand", "wave left hand"), ("WALK ", "walk"), ("jmp", "jump"), ("walk quickly", "walk")],
)
def test_nearest_prefers_names_that_hold_the_word(asked: str, expected: str) -> None:
    assert errors.nearest(asked, ["wave left hand", "walk", "jump", "squat"])[0] == expected


def test_nearest_of_nothing() -> None:
    assert errors.nearest("", ["a", "b"], count=1) != []
    assert errors.nearest("a", []) == []


def test_a_missing_package_names_the_extra() -> None:
    error = errors.MissingDependencyError("panel", "studio", "the studio")
    assert str(error) == "the studio needs the package 'panel': pip install 'motionloom[studio]'"
    assert isinstance(error, ImportError)


def test_all_are_caught_as_one() -> None:
    kinds = [errors.FormatError("f", "p"), errors.OutOfRangeError("n", 0, "1"), errors.UnknownLabelError("a", "b", "c"),
             errors.SkeletonError(), errors.CheckpointError(), errors.Cancelled(),
             errors.MissingDependencyError("p", "e", "x")]  # fmt: skip
    assert all(isinstance(error, errors.MotionloomError) for error in kinds)
    assert all(isinstance(kinds[i], ValueError) for i in (1, 2, 3))
