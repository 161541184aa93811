"""What a session makes of a picture, a mesh or a rigged file: seen, corrected, made, worn, kept."""

from __future__ import annotations

import io
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from engines.character import landmarks, making
from engines.character.picture import Picture
from engines.character.rigged import read_rigged
from engines.character.sighting import Sighting
from engines.errors import FormatError
from engines.formats import write
from studio import likeness
from studio.casting import FOLLOWERS, SHOWN, mask_uri
from studio.session import Session
from tests.viewers.poses import stride
from tests.viewers.textured import checkers, textured
from viewers import bodies
from viewers.bodies import character as kept

SIZE = (300, 400)


@pytest.fixture(scope="module")
def sighting() -> Sighting:
    """Made by hand: landmarks in a grid, a box for a silhouette."""
    drawn = np.random.default_rng(3)
    mask = np.zeros(SIZE[::-1], np.float32)
    mask[100:300, 100:200] = 1
    places = drawn.normal(size=(33, 3))
    points = 150 + 40 * places[:, :2] * (1, -1)
    return Sighting(
        Picture(np.full((*SIZE[::-1], 3), 90, np.uint8), "ada.jpg"), points, np.ones(33), places, mask, ("a remark.",)
    )


@pytest.fixture(scope="module")
def eva(tmp_path_factory) -> bytes:
    """A rigged .glb."""
    return write(stride(4), tmp_path_factory.mktemp("eva") / "eva.glb", skin=textured(checkers())).read_bytes()


@pytest.fixture
def folder(tmp_path, monkeypatch) -> None:
    monkeypatch.setenv("MOTIONLOOM_CHARACTERS", str(tmp_path / "mine"))


@pytest.fixture
def cast(folder, session, settle, sighting, eva, monkeypatch) -> Session:  # noqa: PLR0917
    """A session on the tab, with a stand-in for what takes long: whatever is seen becomes the rigged one."""
    find = likeness.find

    def quick(source, name, height=None):
        return (
            replace(sighting, picture=replace(sighting.picture, name=name))
            if name == "ada.jpg"
            else find(source, name, height)
        )

    def build(found, template, *, name, height, progress, cancel):
        progress(0.5, "Fitting a body")
        made = making.from_rigged(read_rigged(eva, "eva.glb"), name)
        return replace(made, provenance={"height": height, "nose": found.points[0].tolist(), "remarks": ["blurred."]})

    monkeypatch.setattr(likeness, "find", quick)
    monkeypatch.setattr(making, "build", build)
    session.start()
    session.state.compose_tab = "character"
    settle(session)
    return session


def opened(session, settle, name="ada.jpg", data=b"picture"):
    session.casting.open(name, data)
    settle(session)
    return session.casting.state


def test_a_picture_is_seen_corrected_made_and_worn(cast, settle, sighting):
    casting = cast.casting
    assert casting.problem().startswith("Drop a picture")
    state = opened(cast, settle)
    assert (state.file, state.called, state.error) == ("ada.jpg", "ada", "")
    assert state.picture.startswith("data:image/jpeg")
    casting.move("nose", (20.0, 30.0))
    state.height = 1.7
    assert casting.problem() == ""
    casting.make()
    settle(cast)
    assert (state.make_error, state.making, cast.state.message) == (
        "",
        False,
        "ada is worn by the takes of this project.",
    )
    assert (cast.state.body, state.characters) == ("character:ada", ["ada"])
    assert cast.state.worn.name == "character:ada", "the stage wears it"
    from engines.character.character import load

    about = load(kept.file_of("ada")).provenance
    assert (about["height"], about["nose"]) == (1.7, [20.0, 30.0])
    cast.undo()
    settle(cast)
    assert cast.state.body == bodies.DEFAULT, "wearing is a step"
    assert state.characters == ["ada"], "the file stays"


def test_a_joint_takes_what_hangs_on_it_along_and_stays_in_the_picture(cast, settle, sighting):
    state = opened(cast, settle)
    before = sighting.points
    wrist, finger = landmarks.index("left_wrist"), landmarks.index("left_index")
    cast.casting.move("left_wrist", before[wrist] + (5, -7))
    after = state.found.points
    np.testing.assert_allclose(after[finger] - before[finger], (5, -7))
    still = [i for i, name in enumerate(landmarks.NAMES) if name not in ("left_wrist", *FOLLOWERS["left_wrist"])]
    np.testing.assert_array_equal(after[still], before[still])
    cast.casting.move("left_wrist", (9000, -4))
    assert state.found.points[wrist].tolist() == [SIZE[0], 0]
    cast.casting.move("left_pinky", (1, 1))
    assert len(state.corrections) == 2, "what is not drawn cannot be moved"


def test_the_silhouette_is_painted_and_taken_back(cast, settle, sighting):
    casting, state = cast.casting, opened(cast, settle)
    casting.paint([(20, 20), (60, 20)], 5, True)
    casting.paint([(150, 200)], 10, False)
    mask = state.found.mask
    assert mask[20, 40] == 1 and mask[24, 20] == 1 and mask[30, 40] == 0
    assert mask[200, 150] == 0 and mask[200, 165] == 1
    assert casting.undo()
    assert state.found.mask[200, 150] == 1 and state.found.mask[20, 40] == 1
    assert casting.undo() and not casting.undo()
    np.testing.assert_array_equal(state.found.mask, sighting.mask)
    casting.paint([], 5, True)
    casting.paint([(float("nan"), 1)], 5, True)
    assert state.corrections == ()


def test_the_page_gets_the_silhouette_as_transparency_and_small(sighting):
    import base64

    uri = mask_uri(np.kron(sighting.mask, np.ones((4, 4), np.float32)))
    alpha = np.asarray(Image.open(io.BytesIO(base64.b64decode(uri.partition(",")[2]))))[..., 1]
    assert alpha.shape == (SHOWN, SHOWN * 3 // 4)
    assert (alpha[SHOWN // 2, SHOWN * 3 // 8], alpha[0, 0]) == (255, 0)


def test_what_cannot_be_used_is_said_and_what_was_open_stays(cast, settle):
    state = opened(cast, settle)
    for name, data, says in (("cat.jpg", b"meow", "no picture"), ("x.ply", b"", "x.ply"), ("x.zip", b"PK", "x.zip")):
        opened(cast, settle, name, data)
        assert says in state.error and name in state.error
        assert state.file == "ada.jpg"
    state.called = "../etc"
    assert "letters" in cast.casting.problem()
    cast.casting.make()
    assert not state.making
    cast.casting.receive({"id": "k", "name": "a.jpg", "start": 5, "size": 9, "data": b"12"})
    assert state.error == "a.jpg: the upload broke off; try again."


def test_a_rigged_file_is_made_without_a_picture_and_a_failure_is_said(cast, settle, eva, monkeypatch):
    casting = cast.casting
    casting.receive({"id": "k", "name": "eva.glb", "start": 0, "size": len(eva), "data": eva[:1000]})
    casting.receive({"id": "k", "name": "eva.glb", "start": 1000, "size": len(eva), "data": eva[1000:]})
    settle(cast)
    state = casting.state
    assert (state.file, state.picture, state.called) == ("eva.glb", "", "eva")
    casting.make()
    settle(cast)
    assert cast.state.body == "character:eva"
    assert casting.forecast().startswith("Replaces")

    def fail(*_args, **_more):
        raise FormatError("ada.jpg", "is too dark.")

    monkeypatch.setattr(making, "build", fail)
    opened(cast, settle)
    casting.make()
    settle(cast)
    assert (state.make_error, state.making, state.words) == ("ada.jpg: is too dark.", False, "")


def test_those_that_are_kept_are_renamed_and_deleted(cast, settle, eva):
    casting, state = cast.casting, cast.casting.state
    for called in ("eva", "bea"):
        opened(cast, settle, "eva.glb", eva)
        state.called = called
        casting.make()
        settle(cast)
    assert opened(cast, settle, "eva.glb", eva).called == "eva 2", "a name that is free"
    casting.rename("bea", "eva")
    settle(cast)
    assert "another character" in state.list_error
    casting.rename("bea", "cleo")
    settle(cast)
    assert (state.characters, cast.state.body, state.list_error) == (["cleo", "eva"], "character:cleo", "")
    assert bodies.get("character:cleo").name == "character:cleo"
    casting.wear("eva")
    settle(cast)
    assert cast.state.body == "character:eva"
    casting.delete("eva")
    settle(cast)
    assert (state.characters, cast.state.body) == (["cleo"], bodies.DEFAULT)
    casting.delete("../cleo")
    settle(cast)
    assert state.characters == ["cleo"]


def test_one_made_anew_under_its_name_is_what_is_worn(cast, settle, eva):
    opened(cast, settle, "eva.glb", eva)
    for _ in range(2):
        cast.casting.make()
        settle(cast)
        worn = cast.state.worn
    assert worn is not None and cast.dressing._loaded["character:eva"] is worn
    assert worn is bodies.get("character:eva"), "read anew"


def test_without_the_networks_the_tab_says_what_to_install(cast, monkeypatch):
    from engines.character import models

    monkeypatch.setattr(models, "installed", lambda: False)
    cast.state.compose_tab = "action"
    cast.state.compose_tab = "character"
    assert "make character" in cast.casting.state.missing
