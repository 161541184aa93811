"""`motionloom render`: every option reaches the picture."""

from __future__ import annotations

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image

from tests.studio.fakes import sway
from tests.viewers.poses import stride

SMALL = ("--width", "96", "--height", "96", "--fps", "20")


@pytest.fixture
def picture(run, tmp_path):
    """A function of options: the first of the pictures that the command writes, as an array."""
    sway(frames=12).write(tmp_path / "walk.bvh")
    numbers = iter(range(100))

    def made(*options: str) -> np.ndarray:
        out = f"frames{next(numbers)}"
        assert run("render", "walk.bvh", "-o", out, *SMALL, "--camera", "left", *options)[0] == 0
        with Image.open(tmp_path / out / "frame-00012.png") as image:
            return np.asarray(image).astype(int)

    return made


@pytest.mark.parametrize(
    "options",
    [
        ("--show", "skeleton"), ("--show", "both"), ("--body", "stick"), ("--trail",), ("--ghosts", "4"),
        ("--label", "Hello"), ("--backdrop", "light"), ("--views", "four"), ("--shape", "height=0.8"),
        ("--views", "around"), ("--body", "anny", "--shape", "gender=1", "--shape", "weight=0.9"),
    ],
)  # fmt: skip
def test_each_option_is_seen(picture, options):
    assert (np.abs(picture(*options) - picture()).max(-1) > 20).sum() > 8


def test_contacts_mark_the_floor(run, tmp_path):
    stride(20).write(tmp_path / "walk.npz")
    assert stride(20).contacts.any()
    for name, options in (("plain", ()), ("marked", ("--contacts",))):
        assert run("render", "walk.npz", "-o", name, *SMALL, "--show", "skeleton", *options)[0] == 0
    clips = [
        np.stack([np.asarray(Image.open(path)).astype(int) for path in sorted((tmp_path / name).iterdir())])
        for name in ("plain", "marked")
    ]
    assert (np.abs(clips[0] - clips[1]).max(-1) > 20).sum() > 20


def test_no_backdrop_is_transparent_and_mp4_cannot_be(run, tmp_path, picture):
    assert picture("--backdrop", "none").shape == (96, 96, 4)
    code, _, err = run("render", "walk.bvh", "-o", "a.mp4", *SMALL, "--backdrop", "none")
    assert code == 1 and "MP4 videos cannot be transparent" in err and not (tmp_path / "a.mp4").exists()
    assert run("render", "walk.bvh", "-o", "a.webm", *SMALL, "--backdrop", "none")[0] == 0
    assert next(imageio_ffmpeg.read_frames(str(tmp_path / "a.webm")))["codec"] == "vp9"


def test_a_page_plays_offline(run, tmp_path):
    sway(frames=5).write(tmp_path / "walk.bvh")
    code, out, _ = run(
        "render", "walk.bvh", "-o", "walk.html", "--show", "both", "--label", "A walk", "--shape", "age=1"
    )
    assert (code, out) == (0, "walk.html\n")
    text = (tmp_path / "walk.html").read_text(encoding="utf-8")
    assert "<title>A walk</title>" in text and '"show": "both"' in text


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (("--shape", "weight"), "--shape is 'weight'; accepted: NAME=VALUE, as in weight=0.7"),
        (("--shape", "wieght=1"), "did you mean 'weight'"),
        (("--shape", "weight=7"), "weight is 7"),
        (("--body", "any"), "unknown body 'any'"),
        (("--body", "SMPLX_NEUTRAL.npz"), "SMPLX_NEUTRAL.npz: there is no such file"),
        (("--ghosts", "-1"), "ghosts is -1"),
    ],
)
def test_mistakes_are_one_line(run, tmp_path, options, says):
    sway(frames=3).write(tmp_path / "walk.bvh")
    code, out, err = run("render", "walk.bvh", "-o", "a.gif", *options)
    assert (code, out, err.count("\n")) == (1, "", 1) and says in err
    assert [path.name for path in tmp_path.iterdir()] == ["walk.bvh"]


def test_a_window_without_a_screen_says_so(run, tmp_path, monkeypatch):
    pytest.importorskip("glfw")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    sway(frames=3).write(tmp_path / "walk.bvh")
    code, _, err = run("render", "walk.bvh", "--window")
    assert code == 1 and "a window needs a screen" in err
