"""Pose strips: the right frames, side by side, whole."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image

from engines.errors import Cancelled, FormatError, OutOfRangeError
from tests.viewers import poses
from viewers import strips
from viewers.camera import Camera
from viewers.gl.context import NoGraphicsError
from viewers.moderngl_renderer import Renderer
from viewers.scene import Actor, Scene
from viewers.video import render_pngs


def test_frames_are_spread_from_first_to_last():
    motion = poses.stride(61)
    assert strips.spread(motion, 5) == [0, 15, 30, 45, 60]
    assert strips.spread(motion[:3], 8) == [0, 1, 2]
    assert strips.every(motion, 20) == [0, 20, 40, 60]
    with pytest.raises(OutOfRangeError, match="number of poses is 0"):
        strips.spread(motion, 0)
    with pytest.raises(OutOfRangeError, match="2 or more"):
        strips.every(poses.stride(100), 1)


def test_each_cell_is_the_pose_of_its_frame():
    motion = poses.stride(40)
    frames = [0, 13, 39]
    camera = Camera(yaw=0.5, distance=4.0, target=(0.0, 0.9, 0.0))
    picture = strips.strip(motion, frames, height=96, body="stick", camera=camera)
    assert picture.shape == (96, 3 * 72, 3) and picture.dtype == np.uint8
    cells = np.split(picture, 3, axis=1)
    still = Scene((Actor(motion.in_place(), "stick"),), camera)
    with Renderer(72, 96) as renderer:
        for frame, cell in zip(frames, cells, strict=True):
            there = renderer.frame(still, frame / motion.fps).astype(int)
            assert np.abs(there - cell).max() < 8  # the backdrop is dithered
            assert all(np.abs(there - other).max() > 40 for other in cells if other is not cell)


def test_every_pose_is_whole(tmp_path):
    """No figure is cut by the edge of its cell: at the edges a strip is as a strip of the floor alone would be."""
    motion = poses.stride(40)
    path = strips.write_strip(motion, tmp_path / "a.png", [0, 20, 39], height=120, body="stick", width=270)
    with Image.open(path) as image:
        picture = np.asarray(image.convert("RGB")).astype(int)
    assert picture.shape == (120, 270, 3)
    for cell in np.split(picture, 3, axis=1):
        figure = cell.max(axis=-1) > 120  # the stick figure is bright, the dark backdrop is not
        assert figure.sum() > 100
        assert not figure[[0, -1]].any() and not figure[:, [0, -1]].any()


@pytest.mark.parametrize(
    ("frames", "options", "message"),
    [
        ([], {}, "frames is"),
        ([99], {}, "one or more of 0 to 9"),
        ([0, 1], {"width": 1}, "width of the strip is 0"),
        ([0, 1], {"width": 40000}, "1 to 16384"),
    ],
)
def test_what_cannot_be_is_told(frames, options, message):
    with pytest.raises(OutOfRangeError, match=message):
        strips.strip(poses.stride(10), frames, **options)


def test_a_strip_is_a_png(tmp_path):
    with pytest.raises(FormatError, match=r"strips end in \.png"):
        strips.write_strip(poses.stride(10), tmp_path / "a.jpg")
    assert not list(tmp_path.iterdir())


def test_pngs_are_the_frames(tmp_path):
    motion = poses.stride(5)
    scene = Scene((Actor(motion, "stick"),))
    told = []
    folder = render_pngs(
        scene, tmp_path / "out", progress=lambda *n: told.append(n), width=64, height=48, fps=motion.fps
    )
    assert sorted(p.name for p in folder.iterdir()) == [f"frame-{n:05d}.png" for n in range(1, 6)]
    assert told == [(n, 5) for n in range(1, 6)]
    with Renderer(64, 48) as renderer, Image.open(folder / "frame-00003.png") as image:
        np.testing.assert_array_equal(np.asarray(image), list(renderer.frames(scene, motion.fps))[2])
    with pytest.raises(FormatError, match="already there"):
        render_pngs(scene, folder)
    with pytest.raises(Cancelled):
        render_pngs(scene, tmp_path / "other", cancel=lambda: True, width=64, height=48)
    assert [p.name for p in tmp_path.iterdir()] == ["out"]


def test_a_motion_in_a_notebook_shows_a_strip(monkeypatch):
    """Through the entry point, since engines know no viewer; in words where nothing can draw."""
    pytest.importorskip("IPython")
    from IPython.core.formatters import DisplayFormatter

    formatter, motion = DisplayFormatter(), poses.stride(20)
    shown, _ = formatter.format(motion)
    with Image.open(io.BytesIO(shown["image/png"])) as picture:
        assert picture.size == (8 * 150, 200)
    assert shown["text/plain"].startswith("<Motion 20 frames")

    def dark(*_args, **_options):
        raise NoGraphicsError("no OpenGL here")

    monkeypatch.setattr(strips, "strip", dark)
    assert set(formatter.format(motion)[0]) == {"text/plain"}
    monkeypatch.setattr("engines.motion._drawings", tuple)
    assert set(formatter.format(motion)[0]) == {"text/plain"}
