"""The project's own .npz: nothing is lost, nothing is believed."""

from __future__ import annotations

import json
import zipfile
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest

from engines.errors import FormatError
from engines.formats import arrays, npz
from engines.motion import Motion, Provenance, Segment
from engines.skeletons.skeleton import Skeleton
from tests.engines.formats.conftest import random_motion


def full_motion() -> Motion:
    """A motion with every field set, and numbers that text would round."""
    return random_motion(11, fps=1 / 3).replaced(
        labels=(Segment(0, 5, "action", "jump"), Segment(3, 11, "text", "he said “no” – наверх")),
        provenance=Provenance("engine", "a" * 64, "jump", 2**63, 3, {"guidance": 0.1, "nested": {"list": [1, None]}}),
    )


def assert_same(one: Motion, other: Motion) -> None:
    for name in ("rotations", "translation"):
        assert getattr(one, name).tobytes() == getattr(other, name).tobytes()
    mine, theirs = one.skeleton, other.skeleton
    for name in ("name", "joints", "parents", "feet", "mirror_pairs"):
        assert getattr(mine, name) == getattr(theirs, name)
    assert mine.offsets.tobytes() == theirs.offsets.tobytes()
    for name in ("end_offsets", "hinges"):
        assert list(getattr(mine, name)) == list(getattr(theirs, name))
        for key, value in getattr(mine, name).items():
            assert np.asarray(value, np.float64).tobytes() == getattr(theirs, name)[key].tobytes()
    assert one.fps == other.fps
    assert one.labels == other.labels
    assert asdict(one.provenance) == asdict(other.provenance)


def test_everything_comes_back_bit_for_bit(tmp_path):
    motion = full_motion()
    assert_same(motion, npz.read(npz.write(motion, tmp_path / "m.npz")))


def test_a_bare_skeleton_comes_back(tmp_path):
    motion = random_motion(1, skeleton=Skeleton("one", ("root",), (-1,), np.array([[0.1, 0.2, 0.3]])))
    assert_same(motion, npz.read(npz.write(motion, tmp_path / "m.npz")))


def test_the_same_motion_gives_the_same_bytes(tmp_path):
    first, second = (npz.write(full_motion(), tmp_path / name).read_bytes() for name in ("a.npz", "b.npz"))
    assert first == second


def test_bytes_are_those_of_the_file_and_come_back(tmp_path):
    motion = full_motion()
    data = npz.to_bytes(motion)
    assert data == npz.write(motion, tmp_path / "m.npz").read_bytes()
    assert_same(motion, npz.from_bytes(data))


@pytest.mark.parametrize("cut", [0, 1, 22, 500, -1])
def test_bytes_cut_short_are_named(cut):
    with pytest.raises(FormatError, match=r"^take 3: ") as caught:
        npz.from_bytes(npz.to_bytes(full_motion())[:cut], "take 3")
    assert str(caught.value.path) == "take 3"


def test_bytes_of_another_archive_are_refused(tmp_path):
    np.savez(tmp_path / "m.npz", speed=np.arange(3))
    with pytest.raises(FormatError, match=r"an \.npz with other arrays"):
        npz.from_bytes((tmp_path / "m.npz").read_bytes())


def test_numpy_reads_it_without_pickle(tmp_path):
    motion = full_motion()
    with np.load(npz.write(motion, tmp_path / "m.npz"), allow_pickle=False) as held:
        np.testing.assert_array_equal(held["rotations"], motion.rotations)
        assert json.loads(held["motionloom"].tobytes())["version"] == 1


def test_numpy_values_in_the_parameters_are_written_as_plain_ones(tmp_path):
    motion = random_motion().replaced(provenance=Provenance(parameters={"a": np.float32(0.5), "b": np.arange(3)}))
    again = npz.read(npz.write(motion, tmp_path / "m.npz"))
    assert again.provenance.parameters == {"a": 0.5, "b": [0, 1, 2]}


@pytest.mark.parametrize("value", [object(), float("nan"), {1, 2}])
def test_what_json_cannot_say_is_refused_and_nothing_is_left(tmp_path, value):
    motion = random_motion().replaced(provenance=Provenance(parameters={"a": value}))
    with pytest.raises(FormatError, match="JSON"):
        npz.write(motion, tmp_path / "m.npz")
    assert not list(tmp_path.iterdir())


def rewritten(tmp_path: Path, header=None, **replaced) -> Path:
    """A written file with parts of it changed; None removes an array, `header` changes the JSON in place."""
    path = npz.write(full_motion(), tmp_path / "m.npz")
    with np.load(path) as held:
        parts = {name: held[name] for name in held.files}
    if header:
        stated = json.loads(parts["motionloom"].tobytes())
        header(stated)
        parts["motionloom"] = np.frombuffer(json.dumps(stated).encode(), np.uint8)
    parts |= replaced
    return arrays.save(path, {name: values for name, values in parts.items() if values is not None})


NAN = np.full((11, 3), np.nan)
BAD = {
    "later version": ({"header": lambda h: h.update(version=2)}, "of version 2"),
    "no version": ({"header": lambda h: h.pop("version")}, "entry is damaged"),
    "no fps": ({"header": lambda h: h.pop("fps")}, "is damaged"),
    "fps of words": ({"header": lambda h: h.update(fps="fast")}, "is damaged"),
    "fps zero": ({"header": lambda h: h.update(fps=0)}, "fps is 0"),
    "joint missing": ({"header": lambda h: h["skeleton"]["joints"].pop()}, "is damaged"),
    "parents wrong": ({"header": lambda h: h["skeleton"]["parents"].reverse()}, "root first"),
    "feet unknown": ({"header": lambda h: h["skeleton"].update(feet=[["a", "b"]])}, "no joint 'a'"),
    "label kind": ({"header": lambda h: h["labels"].append([0, 1, "mood", "sad"])}, "'mood' is no kind of label"),
    "labels flat": ({"header": lambda h: h.update(labels=[3])}, "is damaged"),
    "seed of words": ({"header": lambda h: h["provenance"].update(seed="x")}, "provenance"),
    "skeleton a list": ({"header": lambda h: h.update(skeleton=[])}, "is damaged"),
    "header no JSON": ({"motionloom": np.arange(40, dtype=np.uint8)}, "entry is damaged"),
    "rotations missing": ({"rotations": None}, "'rotations' is missing"),
    "float32": ({"rotations": np.ones((11, 22, 4), np.float32)}, "accepted: float64"),
    "shape": ({"rotations": np.ones((11, 21, 4))}, "shape"),
    "scalar": ({"rotations": np.float64(1.0)}, "is damaged"),
    "zero frames": ({"rotations": np.ones((0, 22, 4)), "translation": np.ones((0, 3))}, "number of frames is 0"),
    "not finite": ({"translation": NAN}, "not finite"),
    "ends not finite": ({"ends": np.full((5, 3), np.inf)}, "finite points"),
    "ends too few": ({"ends": np.zeros((2, 3))}, "5 names for finite points of shape"),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_damage_is_named(tmp_path, case):
    change, message = BAD[case]
    path = rewritten(tmp_path, **change)
    with pytest.raises(FormatError, match=message) as caught:
        npz.read(path)
    assert caught.value.path == path


def test_cut_short(tmp_path):
    path = npz.write(full_motion(), tmp_path / "m.npz")
    whole = path.read_bytes()
    for length in (1, 10, len(whole) // 2, len(whole) - 1):
        path.write_bytes(whole[:length])
        with pytest.raises(FormatError):
            npz.read(path)


def test_someone_elses_npz(tmp_path):
    np.savez(tmp_path / "m.npz", speed=np.arange(3))
    with pytest.raises(FormatError, match=r"an \.npz with speed; accepted: a motionloom \.npz, or AMASS"):
        npz.read(tmp_path / "m.npz")


def npy_claiming(shape: tuple[int, ...], dtype: str = "<f8") -> bytes:
    """A .npy file that claims a shape and holds eight bytes."""
    header = f"{{'descr': '{dtype}', 'fortran_order': False, 'shape': {shape}, }}".encode()
    header += b" " * (64 - (len(header) + 11) % 64) + b"\n"
    return b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header + b"\0" * 8


def zipped(path: Path, **entries: bytes) -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in entries.items():
            archive.writestr(f"{name}.npy", data)
    return path


@pytest.mark.parametrize("shape", [(2**28,), (2**60, 2**60), (-1,), (3,)])
def test_a_claimed_shape_is_not_believed(tmp_path, shape):
    with pytest.raises(FormatError, match="'motionloom' cannot be read: it claims shape"):
        npz.read(zipped(tmp_path / "bomb.npz", motionloom=npy_claiming(shape)))


def test_a_bomb_is_not_unpacked(tmp_path, monkeypatch):
    monkeypatch.setattr(arrays, "MAX_ARRAY_BYTES", 2**20)
    with pytest.raises(FormatError, match=r"claims 2,097,152 bytes unpacked; accepted: at most 1,048,576"):
        npz.read(zipped(tmp_path / "bomb.npz", motionloom=b"\0" * 2**21))


def test_an_understated_size_is_caught(tmp_path):
    """The table of contents says 100 bytes where there are many more."""
    path = zipped(tmp_path / "lie.npz", motionloom=npy_claiming((2**16,)) + b"\0" * 2**19)
    data = bytearray(path.read_bytes())
    at = data.rfind(b"PK\x01\x02")
    data[at + 24 : at + 28] = (100).to_bytes(4, "little")
    path.write_bytes(data)
    with pytest.raises(FormatError, match="cannot be read"):
        npz.read(path)


def test_pickles_are_never_loaded(tmp_path):
    np.savez(tmp_path / "m.npz", motionloom=np.array([print], dtype=object))
    with pytest.raises(FormatError, match="pickled objects are never read"):
        npz.read(tmp_path / "m.npz")


def test_an_endless_table_of_contents_is_not_read(tmp_path):
    path = npz.write(full_motion(), tmp_path / "m.npz")
    data = bytearray(path.read_bytes())
    at = data.rfind(b"PK\x05\x06")
    data[at + 12 : at + 16] = (2**31).to_bytes(4, "little")
    path.write_bytes(data)
    with pytest.raises(FormatError, match="table of contents claims 2,147,483,648 bytes"):
        npz.read(path)
