"""Damaged files: a Motion or a FormatError, nothing else, soon and in little room.

A few hundred examples here, the same ones every time; `python -m tests.engines.formats.mutations FILE...` goes on for
as long as it is told, on real files. What that finds is kept at the end of this module.
"""

from __future__ import annotations

import json
import time
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
import scipy.io
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from engines import formats
from engines.errors import FormatError
from engines.formats import amass, npz
from engines.formats.gltf import Gltf
from tests.engines.formats.conftest import SMALL_BVH, random_motion
from tests.engines.formats.mutations import KINDS, ROOM, SLOW, damaged, read
from tests.engines.formats.test_amc import SMALL_AMC, SMALL_ASF
from tests.engines.formats.test_glb import LIMB, foreign
from tests.engines.formats.test_utd_mat import standing

EDITS = st.lists(
    st.tuples(
        st.integers(0, KINDS - 1), st.floats(0, 1, exclude_max=True), st.integers(1, 20), st.integers(0, 2**16 - 1)
    ),
    min_size=1,
    max_size=4,
)
FILES = ["small.bvh", "ours.npz", "amass.npz", "kinect.mat", "packed.mat", "ours.glb", "foreign.glb", "1.amc", "1.asf"]


def make(folder: Path, name: str) -> Path:
    """A small whole file of that name; an .asf is damaged and read through its .amc."""
    path = folder / name
    match name:
        case "small.bvh":
            path.write_text(SMALL_BVH)
        case "ours.npz":
            npz.write(random_motion(3).labelled("walk"), path)
        case "amass.npz":
            amass.write(random_motion(3), path)
        case "ours.glb":
            formats.write(random_motion(3), path)
        case "foreign.glb":
            spline = [[0, 0, 0, 0], [0, 0, 0, 1], [0, 0, 0, 0]] * 3
            swing = [(2, "rotation", spline, "CUBICSPLINE"), (1, "translation", [[0, 90, 0]] * 3, "STEP")]
            foreign(path, LIMB, swing, skin=[1, 2, 3])
        case "1.amc" | "1.asf":
            (folder / "1.amc").write_text(SMALL_AMC)
            (folder / "1.asf").write_text(SMALL_ASF)
        case _:
            scipy.io.savemat(path, {"d_skel": standing(3)}, do_compression=name == "packed.mat")
    return path


@pytest.mark.parametrize("name", FILES)
def test_damage_gives_a_motion_or_a_format_error(tmp_path_factory, name):
    folder = tmp_path_factory.mktemp("fuzz")
    path = make(folder, name)
    whole, entry = path.read_bytes(), path.with_suffix(".amc") if name == "1.asf" else path
    assert read(entry) == "read"
    seen = set()

    @settings(max_examples=60, derandomize=True, deadline=None, database=None, suppress_health_check=list(HealthCheck))
    @given(EDITS)
    def check(edits):
        path.write_bytes(damaged(whole, edits))
        start = time.monotonic()
        seen.add(read(entry))
        assert time.monotonic() - start < SLOW

    check()
    assert "refused" in seen


def test_every_beginning_of_a_bvh_is_refused(tmp_path):
    path = tmp_path / "cut.bvh"
    for length in range(1, len(SMALL_BVH.rstrip()) - 1, 7):
        path.write_text(SMALL_BVH[:length])
        with pytest.raises(FormatError):
            formats.read(path)


@pytest.mark.parametrize("name", ["ours.glb", "ours.npz", "kinect.mat"])
def test_every_beginning_of_a_binary_file_is_refused(tmp_path, name):
    path = make(tmp_path, name)
    whole = path.read_bytes()
    for length in range(1, len(whole) - 1, max(len(whole) // 40, 1)):
        path.write_bytes(whole[:length])
        with pytest.raises(FormatError):
            formats.read(path)


# ---- found, and kept ----------------------------------------------------------------------------------------


def test_a_library_that_quotes_the_file_is_cut_short(tmp_path):
    """A zip whose entry claims a name of 64 kB: the message held all of it, 95,000 characters of noise."""
    path = make(tmp_path, "amass.npz")
    data = bytearray(path.read_bytes() + b"\xff" * 70000)
    at = data.index(b"PK\x03\x04")
    data[at + 26 : at + 28] = b"\xff\xff"
    path.write_bytes(data)
    with pytest.raises(FormatError) as told:
        formats.read(path)
    assert len(told.value.problem) <= 1001


def glb_with(tmp_path: Path, change) -> Path:
    """A .glb whose description was changed by hand."""
    path = formats.write(random_motion(3), tmp_path / "a.glb")
    gltf = Gltf(path, path.read_bytes())
    change(gltf.document)
    text = json.dumps(gltf.document).encode()
    text += b" " * (-len(text) % 4)
    head = b"glTF" + np.array([2, 28 + len(text) + len(gltf._binary), len(text)], "<u4").tobytes() + b"JSON"
    body = np.array([len(gltf._binary)], "<u4").tobytes() + b"BIN\0" + gltf._binary
    path.write_bytes(head + text + body)
    return path


def bomb(document: dict) -> None:
    """Every channel claims more values than the file has bytes."""
    for accessor in document["accessors"]:
        accessor["count"] = 2**31


def chain(document: dict) -> None:
    """A hundred thousand nodes in a row, the skeleton at its end."""
    document["nodes"] = [{"children": [i + 1]} for i in range(100_000)] + [{}]
    document["skins"] = [{"joints": [100_000]}]


def ages(document: dict) -> None:
    """A clock that runs for ages: few keys, billions of frames."""
    document["animations"][0]["extras"] = {"fps": 1e-9}
    for accessor in document["accessors"]:
        accessor["componentType"] = 5126


def deep(document: dict) -> None:
    """Values of the wrong kind wherever a number is wanted."""
    document["animations"][0]["samplers"][0]["input"] = [[1]]


def strange(document: dict) -> None:
    """A name and a parent that are no text and no number."""
    document["nodes"][0] |= {"name": {"a": 1}, "children": [True]}


@pytest.mark.parametrize("change", [bomb, chain, deep, strange])
def test_descriptions_that_lie_are_refused_soon_and_in_little_room(tmp_path, change):
    path = glb_with(tmp_path, change)
    start = time.monotonic()
    with pytest.raises(FormatError):
        formats.read(path)
    assert time.monotonic() - start < SLOW
    tracemalloc.start()  # on its own, since it makes Python several times slower
    try:
        with pytest.raises(FormatError):
            formats.read(path)
        assert tracemalloc.get_traced_memory()[1] < ROOM / 8
    finally:
        tracemalloc.stop()


def test_a_stated_rate_that_the_keys_belie_is_not_believed(tmp_path):
    assert formats.read(glb_with(tmp_path, ages)).fps == pytest.approx(30.0)
