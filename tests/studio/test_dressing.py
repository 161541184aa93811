"""The body of a project: chosen, shaped, kept, undone, exported."""

from __future__ import annotations

import sqlite3

import pytest

from engines.errors import FormatError, OutOfRangeError
from studio import tasks
from studio.library import open_library, schema
from studio.proportions import bone_scale, factors, proportions
from studio.session import Session
from studio.settings import ExportSettings, Settings, parse_settings
from studio.takes import TakeList
from tests.studio.fakes import sway
from tests.viewers.test_character_bodies import made
from viewers import bodies
from viewers.bodies import character


@pytest.fixture
def dressed(session, settle):
    session.start()
    settle(session)
    return session


def test_a_slider_shows_at_once_and_is_one_step_when_let_go(dressed):
    state, steps = dressed.state, []
    state.param.watch(lambda event: steps.append(event.new), "undo_name")
    for weight in (0.5, 0.7, 0.9):
        dressed.dressing.reshape({"weight": weight}, keep=False)
        assert state.worn.shape == {"weight": weight}
    assert steps == []
    dressed.dressing.reshape({"weight": 0.9})
    assert (state.undo_name, state.shape) == ("change weight", {"weight": 0.9})
    dressed.dressing.reshape({"gender": 7.0})
    assert state.shape == {"weight": 0.9, "gender": 1.0}, "within the slider's bounds"
    dressed.undo()
    assert state.worn.shape == state.shape == {"weight": 0.9}
    dressed.undo()
    assert (state.worn, state.shape) == ("anny", {})
    dressed.redo()
    assert state.worn.shape == {"weight": 0.9}


def test_a_character_is_worn_and_missed_where_its_file_is_gone(session, settle, tmp_path, monkeypatch):
    monkeypatch.setenv("MOTIONLOOM_CHARACTERS", str(tmp_path))
    name = character.save(made(), "Ada")
    session.start()
    settle(session)
    session.dressing.wear(name)
    settle(session)
    assert session.state.worn is bodies.get(name) and session.state.undo_name == f"wear {name}"
    assert session.state.export_settings().body == name
    (tmp_path / "Ada.npz").unlink()
    session.dressing._loaded.clear()
    session.dressing._show(name, {})
    settle(session)
    assert session.state.worn == "anny" and "no such character" in session.state.body_error


def test_what_was_only_dragged_goes_with_reset(dressed):
    dressed.dressing.reshape({"weight": 0.9}, keep=False)
    dressed.dressing.reset()
    assert (dressed.state.worn, dressed.state.shape, dressed.state.undo_name) == ("anny", {}, "generate walk")


def test_another_body_begins_in_its_usual_shape(dressed, settle):
    state = dressed.state
    dressed.dressing.reshape({"height": 0.8})
    dressed.dressing.wear("mannequin")
    settle(dressed)
    assert (state.worn.name, state.shape, len(state.sliders)) == ("mannequin", {}, 10)
    dressed.dressing.wear("nobody")
    assert state.body == "mannequin"
    dressed.undo()
    assert (state.worn.name, state.shape) == ("anny", {"height": 0.8})


def test_a_body_that_is_not_here_is_said_and_the_usual_one_stands_in(dressed, settle, monkeypatch):
    monkeypatch.delenv("MOTIONLOOM_SMPL", raising=False)
    dressed.takes.dress({"name": "smpl", "shape": {}})
    settle(dressed)
    assert (dressed.state.body, dressed.state.worn) == ("smpl", "anny")
    assert "MOTIONLOOM_SMPL" in dressed.state.body_error


def test_the_body_is_kept_with_the_project(tmp_path):
    file = tmp_path / "library.db"
    library = open_library(str(file))
    mine, other = library.create("Mine"), library.create("Other")
    takes = TakeList(library.shelf(mine))
    takes.dress({"name": "anny", "shape": {"weight": 0.7}}, "change weight")
    takes.dress({"name": "mannequin", "shape": {}})
    takes.undo()
    library.close()
    again = open_library(str(file))
    shelf = again.shelf(mine)
    assert (shelf.body, shelf.undo_name, shelf.redo_name) == (
        {"name": "anny", "shape": {"weight": 0.7}}, "change weight", "change the body",
    )  # fmt: skip
    assert again.shelf(other).body == {}
    shelf.undo()
    assert again.shelf(mine).body == {}
    again.close()


def test_a_library_of_version_1_gets_a_place_for_the_body(tmp_path):
    file = tmp_path / "library.db"
    library = open_library(str(file))
    key = library.create("Old")
    library.close()
    with sqlite3.connect(file) as connection:
        connection.execute("alter table projects drop column body")
        connection.execute("alter table projects drop column sequence")
        connection.execute("alter table takes drop column caption")
        connection.execute("update library set version = 1")
    again = open_library(str(file))
    assert again.shelf(key).body == {}
    TakeList(again.shelf(key)).dress({"name": "stick", "shape": {}})
    assert again.shelf(key).body == {"name": "stick", "shape": {}}
    again.close()
    with sqlite3.connect(file) as connection:
        assert connection.execute("select version from library").fetchone() == (schema.VERSION,)


def test_the_settings_file_says_the_body(dressed, tmp_path):
    dressed.dressing.reshape({"weight": 0.9})
    read = parse_settings(dressed.files.settings_file()[1])
    assert (read.export.body, read.export.shape) == ("anny", {"weight": 0.9})
    with pytest.raises(FormatError, match="shape"):
        parse_settings('{"export": {"shape": {"weight": "fat"}}}')
    assert parse_settings(Settings().to_json()) == Settings()


def test_a_file_shows_the_shape(tmp_path):
    import trimesh

    motion = sway(frames=4)
    plain = tasks.export(motion, tmp_path / "plain.glb", ExportSettings(("glb",)))
    tall = tasks.export(motion, tmp_path / "tall.glb", ExportSettings(("glb",), shape={"height": 0.8}))
    heights = [trimesh.load(path).extents[1] for path in (plain, tall)]
    body = bodies.get("anny")
    assert heights[1] / heights[0] == pytest.approx(body.shaped(height=0.8).height / body.height, rel=0.02)
    with pytest.raises(OutOfRangeError, match="height"):
        tasks.export(motion, tmp_path / "no.glb", ExportSettings(("glb",), shape={"height": 3.0}))
    assert not (tmp_path / "no.glb").exists()


@pytest.mark.parametrize(
    ("values", "scale"),
    [
        ({}, {}),
        ({"height": 1.2}, {"*": 1.2}),
        ({"legs": 1.1}, dict.fromkeys(("left_knee", "right_knee", "left_ankle", "right_ankle"), 1.1)),
        ({"height": 0.8, "shoulders": 1.25}, {"*": 0.8, "left_shoulder": 1.0, "right_shoulder": 1.0}),
    ],
)
def test_sliders_of_bones_and_settings_of_joints_are_each_other(values, scale):
    assert bone_scale(values) == scale
    assert {name: factor for name, factor in factors(scale).items() if factor != 1.0} == values
    assert proportions(scale) == ", ".join(f"{name} × {factor:g}" for name, factor in values.items())


def test_proportions_no_slider_made_are_said_by_joint():
    assert proportions({"left_knee": 1.1}) == "left_knee × 1.1"


def told(state) -> set[str]:
    """What the pictures of the gallery show, without the colour."""
    return {picture.split(" ", 1)[1] for picture in state.thumbnails.values()}


def test_the_pictures_of_takes_show_the_body_they_have(dressed, settle):
    state = dressed.state
    plain = state.thumbnails
    assert told(state) == {"anny"}
    dressed.dressing.reshape({"weight": 0.9}, keep=False)
    settle(dressed)
    assert state.thumbnails == plain, "not while it is dragged"
    dressed.dressing.reshape({"weight": 0.9})
    settle(dressed)
    assert told(state) == {"anny {'weight': 0.9}"}
    dressed.generate()
    settle(dressed)
    assert (len(state.thumbnails), told(state)) == (8, {"anny {'weight': 0.9}"})
    dressed.undo()
    dressed.undo()
    settle(dressed)
    assert {take.id: state.thumbnails[take.id] for take in state.takes} == plain


def test_pictures_of_another_body_are_drawn_again_when_the_project_is_opened(engine, queue, settle, tmp_path):
    library = open_library(str(tmp_path / "library.db"))
    first = Session(queue=queue, library=library)
    first.start()
    settle(first)
    first.dressing.reshape({"weight": 0.9})
    settle(first)
    key, kept = first.state.project, first.state.thumbnails
    again = Session(queue=queue, library=library)
    again.start(key)
    settle(again)
    assert again.state.thumbnails == kept
    library.shelf(key).keep_pictures({2: "data:image/webp;base64,drawn before the studio was killed"})
    last = Session(queue=queue, library=library)
    last.start(key)
    settle(last)
    assert last.state.thumbnails == kept
    for session in (first, again, last):
        session.close()
    library.close()
