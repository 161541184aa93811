"""Bad BVH files: one clear message with the line, quickly, and little memory."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest

from engines import formats
from engines.errors import FormatError
from engines.formats import bvh, bvh_text, files
from tests.engines.formats.conftest import SMALL_BVH

LINES = SMALL_BVH.split("\n")
FIRST_FRAME = LINES.index("Frame Time: 0.0333333") + 2  # 1-based


def changed(old: str, new: str) -> str:
    assert old in SMALL_BVH
    return SMALL_BVH.replace(old, new, 1)


def read_text(tmp_path, text: str | bytes):
    path = tmp_path / "bad.bvh"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return bvh.read(path)


CASES = {
    "too few numbers": (changed("5 10 0 80", "5 10 80"), FIRST_FRAME + 2, "frame 2 has 14 numbers; accepted: 15"),
    "too many numbers": (changed("5 10 0 80", "5 10 0 0 80"), FIRST_FRAME + 2, "frame 2 has 16 numbers"),
    "too many in the first": (changed("0 90 0", "0 90 0 1"), FIRST_FRAME, "frame 0 has 16 numbers"),
    "one short, one long": (
        changed("0 90 0", "0 90").replace("1 91 2", "1 91 2 3"), FIRST_FRAME, "frame 0 has 14 numbers"),
    "a word": (changed("1 91 2", "1 oops 2"), FIRST_FRAME + 1, "'oops' in frame 1; accepted: finite numbers"),
    "decimal comma": (changed("1 91 2", "1,5 91 2"), FIRST_FRAME + 1, "'1,5' in frame 1"),
    "nan": (changed("1 91 2", "1 nan 2"), FIRST_FRAME + 1, "'nan'"),
    "inf": (changed("1 91 2", "1 -inf 2"), FIRST_FRAME + 1, "'-inf'"),
    "overflow": (changed("1 91 2", "1 1e999 2"), FIRST_FRAME + 1, "'1e999'"),
    "underscore": (changed("1 91 2", "1 9_1 2"), FIRST_FRAME + 1, "'9_1'"),
    "fewer frames": (changed("Frames: 3", "Frames: 4"), FIRST_FRAME + 2, "ends after 3 frames; Frames states 4"),
    "more frames": (changed("Frames: 3", "Frames: 2"), FIRST_FRAME + 2, "more lines of numbers than the 2"),
    "no frames": (changed("Frames: 3", "Frames: 0"), FIRST_FRAME - 2, "Frames is '0'; accepted: a whole number"),
    "negative frames": (changed("Frames: 3", "Frames: -3"), FIRST_FRAME - 2, "Frames is '-3'"),
    "absurd frames": (changed("Frames: 3", "Frames: 999999999"), FIRST_FRAME - 2, "claims 999,999,999 frames"),
    "many frames": (changed("Frames: 3", "Frames: 2000000"), FIRST_FRAME + 2, "ends after 3 frames"),
    "frame time 0": (changed("0.0333333", "0"), FIRST_FRAME - 1, "Frame Time is '0'; accepted: seconds"),
    "frame time negative": (changed("0.0333333", "-0.03"), FIRST_FRAME - 1, "Frame Time is '-0.03'"),
    "frame time nan": (changed("0.0333333", "nan"), FIRST_FRAME - 1, "Frame Time is 'nan'"),
    "no frame time": (changed("Frame Time: 0.0333333\n", ""), FIRST_FRAME - 1, "where 'Frame Time: seconds'"),
    "ends after motion": (SMALL_BVH.split("Frames")[0], FIRST_FRAME - 2, "accepted next: 'Frames: N'"),
    "ends in hierarchy": ("\n".join(LINES[:8]), 8, "ends inside the HIERARCHY"),
    "ends after hierarchy": (SMALL_BVH.split("MOTION")[0], 30, "accepted next: MOTION"),
    "unclosed brace": (changed("}\nMOTION", "MOTION"), 29, "ends inside the HIERARCHY"),
    "extra brace": (changed("MOTION", "}\nMOTION"), 30, "'}' after the last joint"),
    "two roots": (changed("MOTION", "ROOT B\n{\n}\nMOTION"), 30, "only one ROOT"),
    "no brace": (changed("JOINT Spine\n\t{", "JOINT Spine\n"), 8, "'OFFSET' where the { of joint 'Spine'"),
    "no name": (changed("JOINT Spine", "JOINT"), 7, "a joint without a name"),
    "same name": (changed("LeftArm", "Spine"), 20, "a second joint is named 'Spine' (the first is on line 6)"),
    "offset of two": (changed("OFFSET 0 10 0", "OFFSET 0 10"), 9, "'CHANNELS' where a number of an OFFSET"),
    "offset of words": (changed("OFFSET 0 10 0", "OFFSET 0 up 0"), 8, "'up' where a number"),
    "offset nan": (changed("OFFSET 0 10 0", "OFFSET 0 nan 0"), 8, "'nan' where a number"),
    "no offset": (changed("\t\tOFFSET 0 10 0\n", ""), 28 - 1 - 9, "joint 'Spine' ends without OFFSET"),
    "no channels": (changed("\t\tCHANNELS 3 Zrotation Xrotation Yrotation\n\t\tJ", "\t\tJ"), 18, "without CHANNELS"),
    "two offsets": (changed("OFFSET 0 10 0", "OFFSET 0 1 0 OFFSET 0 1 0"), 8, "a second OFFSET"),
    "too many channels": (changed("CHANNELS 6", "CHANNELS 60"), 5, "'60' where the number of channels"),
    "channel unknown": (changed("CHANNELS 3 Z", "CHANNELS 3 W"), 9, "'Wrotation' is no channel"),
    "position twice": (changed("Xposition Y", "Yposition Y"), 5, "the same position channel twice"),
    "channels short": (changed("CHANNELS 3 Z", "CHANNELS 4 Z"), 10, "'JOINT' is no channel"),
    "unknown word": (changed("JOINT LeftArm", "BONE LeftArm"), 20, "'BONE' where OFFSET, CHANNELS, JOINT"),
    "another word first": ("BVH\n" + SMALL_BVH, 1, "'BVH' where HIERARCHY is expected"),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_the_message_names_file_line_and_trouble(tmp_path, case):
    text, line, message = CASES[case]
    with pytest.raises(FormatError) as caught:
        read_text(tmp_path, text)
    assert message in str(caught.value)
    assert (caught.value.line, caught.value.path) == (line, tmp_path / "bad.bvh")
    assert str(caught.value).startswith(f"{tmp_path / 'bad.bvh'}:{line}: ")


def test_windows_line_ends_do_not_shift_the_line(tmp_path):
    with pytest.raises(FormatError) as caught:
        read_text(tmp_path, changed("1 91 2", "1 oops 2").replace("\n", "\r\n"))
    assert caught.value.line == FIRST_FRAME + 1


def test_thousands_deep(tmp_path):
    deep = "".join(f"JOINT j{i}\n{{\nOFFSET 0 0 0\nCHANNELS 0\n" for i in range(5000))
    with pytest.raises(FormatError, match="more than 200 deep"):
        read_text(tmp_path, "HIERARCHY\nROOT r\n{\nOFFSET 0 0 0\nCHANNELS 0\n" + deep)


def test_thousands_of_joints(tmp_path):
    many = "".join(f"JOINT j{i}\n{{\nOFFSET 0 0 0\nCHANNELS 0\n}}\n" for i in range(files.MAX_JOINTS))
    with pytest.raises(FormatError, match="more than 2,000 joints"):
        read_text(tmp_path, "HIERARCHY\nROOT r\n{\nOFFSET 0 0 0\nCHANNELS 0\n" + many)


def test_an_endless_hierarchy(tmp_path):
    text = "HIERARCHY ROOT r " + "{ " * (bvh_text.MAX_HIERARCHY_BYTES // 2)
    with pytest.raises(FormatError, match="HIERARCHY is longer"):
        read_text(tmp_path, text)


def test_no_channels_at_all(tmp_path):
    text = "HIERARCHY\nROOT r\n{\nOFFSET 0 0 0\nCHANNELS 0\n}\nMOTION\nFrames: 1\nFrame Time: 1\n\n"
    with pytest.raises(FormatError, match="no joint has CHANNELS"):
        read_text(tmp_path, text)


def test_claimed_frames_are_not_allocated_for(tmp_path):
    """As many frames as are allowed, claimed by a file of three, cost no memory."""
    text = changed("Frames: 3", f"Frames: {files.MAX_JOINT_FRAMES // 4}")
    path = tmp_path / "bad.bvh"
    path.write_text(text)
    tracemalloc.start()
    with pytest.raises(FormatError, match="ends after 3 frames"):
        bvh.read(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 2**20


def test_one_line_of_a_million_numbers_is_not_read(tmp_path):
    path = tmp_path / "bad.bvh"
    path.write_text(SMALL_BVH.split("0 90 0")[0].replace("Frames: 3", "Frames: 1") + "0 " * 1_000_000)
    tracemalloc.start()
    with pytest.raises(FormatError, match="frame 0 has more than 15 numbers"):
        bvh.read(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 20 * 2**20


def test_shapes_of_other_files(tmp_path):
    binary = np.random.default_rng(0).bytes(5000)
    for data, message in ((b"", "empty"), (binary, "HIERARCHY"), (b"\0" * 100, "HIERARCHY"), (b" \n\n", "HIERARCHY")):
        with pytest.raises(FormatError, match=message):
            read_text(tmp_path, data)
    with pytest.raises(FormatError, match="directory"):
        formats.read(tmp_path)
    with pytest.raises(FormatError, match="no such file"):
        formats.read(tmp_path / "missing.bvh")
    with pytest.raises(FormatError, match="cannot be opened"):
        formats.read(tmp_path / ("x" * 5000))
    with pytest.raises(FormatError):
        formats.read("nul\0byte.bvh")


def test_files_past_the_limit_are_not_opened(tmp_path, monkeypatch, small_bvh):
    monkeypatch.setattr(files, "MAX_FILE_BYTES", 100)
    with pytest.raises(FormatError, match=r"has \d+ bytes; accepted: at most 100"):
        files.read_bytes(small_bvh, 100)
