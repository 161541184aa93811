"""Edits: switched on and off, shown, exported, saved, the motion itself staying as it is."""

from __future__ import annotations

import numpy as np
import pytest

import engines
from engines.errors import UnknownLabelError
from engines.geometry.cleanup import plant_feet
from engines.geometry.polish import smooth
from studio import edits, tasks
from studio.settings import EDITS, ExportSettings, Settings, parse_settings, read_settings, write_settings
from tests.studio.fakes import sway


@pytest.fixture
def started(session, settle):
    session.start()
    settle(session)
    return session


def shown(session, settle, take_id: str):
    """The motion of a take as the stage shows it, once that is worked out."""
    session.editing.motion(session.takes.get(take_id))
    settle(session)
    return session.editing.motion(session.takes.get(take_id))


def same(a, b) -> bool:
    return np.array_equal(a.rotations, b.rotations) and np.array_equal(a.translation, b.translation)


def test_each_edit_has_words_and_an_act():
    assert set(edits.WORDS) == set(edits._ACTS) == set(EDITS)
    motion = sway(frames=30)
    assert same(edits.apply(motion, []), motion)
    for name in EDITS:
        assert not same(edits.apply(motion, [name]), motion), name


def test_they_are_done_in_one_order_however_they_are_named():
    motion = sway(frames=30)
    wanted = plant_feet(smooth(motion)).mirror().in_place()
    assert same(edits.apply(motion, ["in_place", "mirror", "feet", "smooth", "smooth"]), wanted)


def test_an_edit_that_is_none():
    with pytest.raises(UnknownLabelError, match="unknown edit 'mirrored'; did you mean 'mirror'"):
        edits.apply(sway(frames=3), ["mirrored"])
    with pytest.raises(UnknownLabelError, match="unknown edit"):
        ExportSettings(edits=("upside down",))


def test_switched_on_shown_and_switched_off(started, settle):
    before, metrics = started.takes.get("take-2").motion, started.takes.get("take-2").metrics
    started.editing.set("take-2", ["mirror", "feet", "nonsense"])
    assert started.takes.get("take-2").edits == ("feet", "mirror")
    assert started.state.undo_name == "edit take 2"
    after = shown(started, settle, "take-2")
    assert same(after, plant_feet(before).mirror())
    assert started.editing.metrics(started.takes.get("take-2"))["foot_skate"] < metrics["foot_skate"]
    assert started.takes.get("take-2").motion is before, "the motion itself stays"
    started.undo()
    assert shown(started, settle, "take-2") is before
    assert started.editing.metrics(started.takes.get("take-2")) is metrics
    started.redo()
    assert shown(started, settle, "take-2") is after, "kept at hand"


def test_until_it_is_worked_out_the_take_is_shown_as_it_was_made(started, settle):
    dispatch, waiting = started.dispatch, []
    started.dispatch = waiting.append
    started.editing.set("take-1", ["mirror"])
    take = started.takes.get("take-1")
    assert started.editing.motion(take) is take.motion
    assert started.editing.motion(take) is take.motion, "asked twice, worked out once"
    settle(started)
    counted = started.state.edited
    started.dispatch = dispatch
    for act in waiting:
        act()
    assert started.state.edited == counted + 1
    assert same(started.editing.motion(take), take.motion.mirror())


def test_an_edit_that_cannot_be_done_is_said(started, settle, monkeypatch):
    rod = engines.skeletons.Skeleton("rod", ("base", "tip"), (-1, 0), np.array([[0.0, 0, 0], [0, 1.0, 0]]))
    turns = np.zeros((5, 2, 4))
    turns[..., 0] = 1
    motion = engines.Motion(rod, turns, np.zeros((5, 3)), 20.0)
    (take,) = started.takes.add([motion], group="rod", source="rod.bvh")
    started.editing.set(take.id, ["feet"])
    assert shown(started, settle, take.id) is motion
    assert started.state.message == "Take 5 is shown as it was made: skeleton 'rod' names no feet to hold."


def test_an_export_has_them_and_so_has_the_settings_file(started, settle, tmp_path):
    started.editing.set("take-2", ["mirror", "in_place"])
    started.select("take-2")
    started.state.export_format = "npz"
    started.files.export()
    settle(started)
    (file,) = started.files.folder.rglob("*.npz")
    written = engines.read(file)
    assert same(written, started.takes.get("take-2").motion.mirror().in_place())
    _name, text = started.files.settings_file()
    settings = parse_settings(text)
    assert settings.export.edits == ("mirror", "in_place")
    (motion,) = tasks.generate(settings.generate)
    tasks.export(motion, tmp_path / "again.npz", settings.export)
    assert same(engines.read(tmp_path / "again.npz"), written)


def test_the_settings_file_keeps_them(tmp_path):
    path = write_settings(Settings(export=ExportSettings(edits=("in_place", "smooth"))), tmp_path / "s.json")
    assert read_settings(path).export.edits == ("smooth", "in_place")
    assert parse_settings("{}").export.edits == ()


def test_the_command_line_has_them(run, tmp_path):
    sway(frames=30).write(tmp_path / "walk.npz")
    code, _out, err = run("convert", str(tmp_path / "walk.npz"), "out.npz", "--edit", "mirror", "--edit", "in_place")
    assert (code, err) == (0, "")
    assert same(engines.read(tmp_path / "out.npz"), sway(frames=30).mirror().in_place())
    code, _out, err = run("convert", str(tmp_path / "walk.npz"), "out.npz", "--edit", "turn")
    assert (code, "unknown edit 'turn'" in err) == (1, True)
