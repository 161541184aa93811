from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
import zipfile
from dataclasses import replace

import numpy as np
import pytest

import engines
from engines.errors import Cancelled, FormatError, OutOfRangeError
from studio import downloads, exchange, tasks
from studio.exchange import read_upload
from studio.settings import parse_settings
from tests.engines.geometry.test_opening import opened
from tests.studio.fakes import sway


@pytest.fixture
def started(session, settle):
    session.start()
    settle(session)
    return session


def bvh(tmp_path) -> bytes:
    return sway(frames=12).write(tmp_path / "walk.bvh").read_bytes()


def test_a_dropped_file_becomes_a_take(started, settle, tmp_path):
    started.files.import_file("walk.bvh", bvh(tmp_path))
    settle(started)
    state, take = started.state, started.state.take()
    assert state.import_error == ""
    assert state.import_status.startswith("Imported walk.bvh: 12 frames")
    assert (take.source, take.settings, take.motion.frames) == ("walk.bvh", None, 12)
    assert state.shown == [take.id]
    assert take.id in state.thumbnails
    assert started.files.settings_file() == ("", "")


def test_a_reference_pose_in_front_is_left_out(started, settle, tmp_path):
    motion = opened(sway(frames=12), 1)
    started.files.import_file("cmu.bvh", motion.write(tmp_path / "cmu.bvh").read_bytes())
    settle(started)
    assert started.state.take().motion.frames == 12
    assert "12 frames" in started.state.import_status
    assert "reference pose" in started.state.import_status


def piece(name: str, start: int, size: int, data: bytes) -> dict:
    return {"id": "key", "name": name, "start": start, "size": size, "data": data}


def test_pieces_in_order_make_a_file(started, settle, tmp_path):
    data = bvh(tmp_path)
    for start in range(0, len(data), 1000):
        started.files.receive(piece("folder/walk.bvh", start, len(data), data[start : start + 1000]))
    settle(started)
    assert started.state.take().source == "walk.bvh"


@pytest.mark.parametrize(
    "pieces",
    [
        [(5, 10, b"12345")],
        [(0, 10, b"12345"), (7, 10, b"890")],
        [(0, 4, b"12345")],
        [(0, exchange.UPLOAD_LIMIT + 1, b"1")],
    ],
    ids=["middle first", "gap", "more than said", "too large"],
)
def test_pieces_that_do_not_fit_are_refused_and_forgotten(started, pieces):
    for start, size, data in pieces:
        started.files.receive(piece("a.bvh", start, size, data))
    assert started.state.import_error == "a.bvh: the upload broke off; try again."
    assert started.files._arriving == {}


@pytest.mark.parametrize(
    ("name", "data", "says"),
    [
        ("notes.txt", b"hello", "notes.txt: files of this kind are not read; accepted: .amc, .asf, .bvh"),
        ("empty.bvh", b"", "empty.bvh: the file is empty"),
        ("broken.bvh", b"HIERARCHY\nROOT hips\n{\n  OFFSET 0 0\n", "broken.bvh:"),
        ("broken.npz", b"PK\x03\x04 not really", "broken.npz:"),
    ],
)
def test_a_bad_file_is_told_by_its_own_name(started, settle, name, data, says):
    started.files.import_file(name, data)
    settle(started)
    assert started.state.import_error.startswith(says)
    assert "/tmp" not in started.state.import_error
    assert started.state.import_status == ""
    assert len(started.takes) == 4


def test_upload_is_bounded(monkeypatch):
    monkeypatch.setattr(exchange, "UPLOAD_LIMIT", 10)
    with pytest.raises(OutOfRangeError, match=r"size of big\.bvh"):
        read_upload("big.bvh", b"x" * 11)
    with pytest.raises(FormatError, match=r"broken|kind|HIERARCHY|not"):
        read_upload("big.bvh", b"x" * 10)


@pytest.mark.parametrize(
    ("kind", "name"), [("bvh", "take-2-walk.bvh"), ("npz", "take-2-walk.npz"), ("amass", "take-2-walk.amass.npz")]
)
def test_export_offers_the_file_under_its_name(started, settle, kind, name):
    state = started.state
    state.param.update(selected="take-2", export_format=kind)
    started.files.export()
    settle(started)
    assert (state.export_status, state.export_name, state.export_error) == ("done", name, "")
    _route, key, offered = state.export_url.split("/")
    path = downloads.find(key, offered)
    assert path.stat().st_size == state.export_bytes > 0
    back = engines.read(path)
    np.testing.assert_allclose(back.positions, started.takes.get("take-2").motion.positions, atol=2e-3)
    started.close()
    assert downloads.find(key, offered) is None


def test_named_scene_is_part_of_file_names(started, settle):
    started.state.param.update(scene="Morning scene", export_format="bvh")
    started.files.export()
    settle(started)
    assert started.state.export_name == "morning-scene-take-1-walk.bvh"


def test_ticked_takes_are_exported_together(started, settle):
    state = started.state
    state.param.update(selected="take-3", compared=["take-1", "take-3"], export_format="npz")
    started.files.export()
    settle(started)
    assert (state.export_status, state.export_name, state.export_progress) == ("done", "2-takes.zip", 1.0)
    _route, key, offered = state.export_url.split("/")
    path = downloads.find(key, offered)
    with zipfile.ZipFile(path) as archive:
        assert archive.namelist() == ["take-1-walk.npz", "take-3-walk.npz"]
    assert [file.name for file in path.parent.iterdir()] == ["2-takes.zip"]
    state.selected = "take-2"
    assert [take.id for take in started.files.chosen()] == ["take-2"]


def test_cancel_of_an_export_leaves_no_file(started, settle, monkeypatch):
    going = threading.Event()

    def forever(_motion, path, _how, progress, _cancel):
        path.write_bytes(b"half")
        try:
            for step in range(10_000):
                progress(step, 10_000)
                going.set()
                threading.Event().wait(0.005)
        except Cancelled:
            path.unlink()
            raise

    monkeypatch.setattr(tasks, "export", forever)
    started.files.export()
    assert going.wait(10)
    assert started.state.export_status == "running"
    started.files.export()
    started.files.cancel_export()
    settle(started)
    assert (started.state.export_status, started.state.export_url) == ("cancelled", "")
    assert not [p for p in started.files.folder.rglob("*") if p.is_file()]


def test_failed_export_says_why(started, settle, monkeypatch):
    def broken(*_args):
        raise OutOfRangeError("width", 1, "more")

    monkeypatch.setattr(tasks, "export", broken)
    started.files.export()
    settle(started)
    assert (started.state.export_status, started.state.export_error) == ("failed", "width is 1; accepted: more.")


def test_settings_file_makes_the_very_take_again(started, engine):
    name, text = started.files.settings_file("take-3")
    assert name == "take-3.json"
    settings = parse_settings(text)
    assert settings.generate.take == 3
    (motion,) = tasks.generate(replace(settings.generate))
    assert (motion.rotations == started.takes.get("take-3").motion.rotations).all()
    assert motion.provenance.index == 2
    assert json.loads(text)["export"]["formats"] == ["mp4"]


def test_download_needs_both_key_and_name(tmp_path):
    file = tmp_path / "a.bvh"
    file.write_text("x")
    _route, key, name = downloads.offer(file).split("/")
    assert downloads.find(key, name) == file
    assert downloads.find(key, "b.bvh") is None
    assert downloads.find("wrong", name) is None
    file.unlink()
    assert downloads.find(key, name) is None


def test_a_glb_is_imported_and_a_lone_amc_is_told_what_it_lacks(tmp_path):
    sent = sway(frames=12)
    motion = read_upload("walk.GLB", sent.write(tmp_path / "walk.glb").read_bytes())
    assert len(motion) == 12 and motion.fps == sent.fps
    with pytest.raises(FormatError, match=r"^38_01\.amc: needs its skeleton: an \.asf beside it.* motionloom convert"):
        read_upload("38_01.amc", b":FULLY-SPECIFIED\n:DEGREES\n1\nroot 0 0 0 0 0 0\n")


def test_files_of_a_studio_that_was_killed_are_cleared_away_and_no_others(tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    dead = subprocess.Popen([sys.executable, "-c", ""])
    dead.wait(20)
    names = [f"motionloom-{dead.pid}-abc", f"motionloom-{os.getpid()}-abc", "motionloom-notes-abc", "other-1-abc"]
    for name in names:
        (tmp_path / name).mkdir()
        (tmp_path / name / "walk.mp4").write_text("half a file")
    exchange.sweep()
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(names[1:])
