"""Writing beside and renaming."""

from __future__ import annotations

import os
import stat

import pytest

from engines.errors import FormatError
from engines.formats import atomic_path, files


def test_the_file_appears_whole_and_nothing_else(tmp_path):
    path = tmp_path / "walk.bvh"
    with atomic_path(path) as temporary:
        temporary.write_text("half")
        assert temporary.parent == tmp_path and temporary.suffix == ".bvh"
        assert not path.exists()
        temporary.write_text("whole")
    assert path.read_text() == "whole"
    assert [p.name for p in tmp_path.iterdir()] == ["walk.bvh"]


def test_failure_leaves_the_old_file_and_nothing_else(tmp_path):
    path = tmp_path / "walk.bvh"
    path.write_text("old")
    with pytest.raises(KeyError), atomic_path(path) as temporary:
        temporary.write_text("half")
        raise KeyError
    assert path.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["walk.bvh"]


def test_a_failing_disk_is_told_as_a_format_error(tmp_path):
    path = tmp_path / "walk.bvh"
    with pytest.raises(FormatError, match=r"cannot be written: no space left on device"), atomic_path(path):
        raise OSError(28, "No space left on device")
    assert not list(tmp_path.iterdir())


def test_permissions_are_those_of_any_new_file(tmp_path):
    with atomic_path(tmp_path / "a") as temporary:
        temporary.write_text("x")
    (tmp_path / "b").write_text("x")
    modes = [stat.S_IMODE((tmp_path / name).stat().st_mode) for name in "ab"]
    assert modes[0] == modes[1]


def test_places_that_cannot_be_written(tmp_path):
    for path in (tmp_path, tmp_path / "none" / "walk.bvh", tmp_path / "nul\0.bvh"):
        with pytest.raises(FormatError), atomic_path(path):
            pytest.fail("entered")


def test_size_limits():
    files.check_size("f", 1_000, 22)
    with pytest.raises(FormatError, match="joints; accepted: at most"):
        files.check_size("f", 1, files.MAX_JOINTS + 1)
    with pytest.raises(FormatError, match="accepted: at most 545,454 frames"):
        files.check_size("f", files.MAX_JOINT_FRAMES, 22)


def test_only_ordinary_files_are_read(tmp_path):
    fifo = tmp_path / "pipe"
    os.mkfifo(fifo)
    with pytest.raises(FormatError, match="not an ordinary file"):
        files.read_bytes(fifo)
