"""`motionloom character`: pictures, meshes and rigged files perform, and are kept."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from engines import formats
from engines.formats.gltf import Gltf
from tests.engines.character.people import arms_down, needs_networks
from tests.engines.character.test_meshes import obj, picture
from tests.viewers.poses import stride
from tests.viewers.textured import checkers, textured
from viewers import bodies
from viewers.camera import Camera
from viewers.moderngl_renderer import Renderer
from viewers.scene import Actor, Scene

SMALL = ("--width", "96", "--fps", "5")


@pytest.fixture
def here(run, tmp_path, monkeypatch):
    """A folder with a motion, a rigged .glb, and a place for characters."""
    monkeypatch.setenv("MOTIONLOOM_CHARACTERS", str(tmp_path / "mine"))
    stride(6).write(tmp_path / "stride.npz")
    formats.write(stride(4), tmp_path / "eva.glb", skin=textured(checkers()))
    return tmp_path


def test_a_rigged_file_performs_and_is_kept(run, here, engine):
    code, out, err = run("character", "eva.glb", "--seconds", "1", "--save", "Eva", "-o", "walk.mp4", *SMALL)
    assert (code, out.split(), err) == (0, ["character:Eva", "walk.mp4"], "")
    assert engine.calls == [{"action": "walk", "count": 1, "frames": 20, "seed": 7}]
    assert (here / "walk.mp4").stat().st_size > 500 and "character:Eva" in bodies.available()
    for name in ("a.glb", "a.html", "a.png", "a.gif"):
        options = ("--four-views", *SMALL) if name == "a.gif" else ()
        assert run("character", "character:Eva", "--motion", "stride.npz", "-o", name, *options)[0] == 0
        assert (here / name).stat().st_size > 500
    gltf = Gltf(here / "a.glb", (here / "a.glb").read_bytes())
    assert gltf.document["images"] and gltf.document["nodes"][-1]["name"] == "character:Eva"
    assert run("character", "eva.glb", "--save", "Twin")[:2] == (0, "character:Twin\n"), "kept, and nothing else"


def test_what_cannot_be_is_said_before_anything_is_done(run, here):
    code, _, err = run("character", "eva.glb", "-o", "walk.bvh")
    assert code == 1 and "--out" in err and ".mp4" in err and ".glb" in err
    code, _, err = run("character", "eva.glb", "--save", "../Eva")
    assert code == 1 and "letters" in err and not (here / "mine").exists()
    code, _, err = run("character", "character:Nobody", "-o", "a.mp4")
    assert code == 1 and "no such character" in err
    (here / "cat.jpg").write_bytes(b"meow")
    code, _, err = run("character", "cat.jpg", "-o", "a.mp4")
    assert code == 1 and "cat.jpg" in err and "Traceback" not in err
    picture().save(here / "skin.png")
    obj(here)
    assert run("character", "box.obj", "--height", "175", "-o", "a.mp4")[0] == 1


@needs_networks
def test_a_picture_of_a_person_performs(run, here):
    person = Scene((Actor(arms_down(), "anny"),), Camera("front", fov=0.2), backdrop="light")
    with Renderer(384, 512) as renderer:
        Image.fromarray(renderer.frame(person)).save(here / "ada.png")
    code, out, _ = run(
        "character", "ada.png", "--motion", "stride.npz", "--height", "1.8", "--save", "Ada", "-o", "ada.glb"
    )
    assert (code, out.split()) == (0, ["character:Ada", "ada.glb"])
    body = bodies.get("character:Ada")
    assert body.height == pytest.approx(1.8, abs=0.08) and body.texture is not None
    chest = body.colours[np.linalg.norm(body.vertices - [0, 0.3, 0.15], axis=1).argmin()].astype(int)
    assert chest[2] > chest[0] + 30, "the shirt is blue"
