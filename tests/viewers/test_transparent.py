"""Pictures without a background, and four views in one."""

from __future__ import annotations

import subprocess
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image

from engines.errors import FormatError, OutOfRangeError, UnknownLabelError
from tests.viewers import poses
from viewers.camera import Camera
from viewers.four_views import SEAM, VIEWS, FourViews
from viewers.moderngl_renderer import Renderer, straight
from viewers.scene import Actor, Backdrop, Scene
from viewers.video import render, render_pngs, write_video

SIZE = (160, 120)


def walk(**options) -> Scene:
    return Scene((Actor(poses.stride(12), **options),), Camera("left"))


def over(picture: np.ndarray, colour: tuple[int, int, int]) -> np.ndarray:
    """(H, W, 3) a picture (H, W, 4) laid over a colour."""
    alpha = picture[..., 3:] / 255.0
    return picture[..., :3] * alpha + np.array(colour) * (1 - alpha)


def test_laid_over_a_colour_it_is_what_is_drawn_on_that_colour() -> None:
    plain = Backdrop(centre="#336699", edge="#336699", floor="#336699", grid="#336699")
    scene = walk(trail=True, contacts=True, label="Hi", show="both").replaced(backdrop=plain)
    with Renderer(*SIZE) as renderer:
        solid = renderer.frame(scene, 0.3)
        clear = renderer.frame(scene.replaced(transparent=True), 0.3)
    assert clear.shape == (120, 160, 4) and clear[..., 3].min() == 0 and clear[..., 3].max() == 255
    drawn = np.abs(solid.astype(int) - (0x33, 0x66, 0x99)).max(-1) > 40
    laid = over(clear, (0x33, 0x66, 0x99))
    assert drawn.sum() > 500
    # the floor's light is part of a backdrop, so the colours behind differ a little
    assert np.abs(laid - solid)[drawn].mean() < 4
    assert (clear[drawn][:, 3] > 0).mean() > 0.99


def test_opaque_pictures_are_opaque_everywhere() -> None:
    with Renderer(*SIZE) as renderer:
        pictures = renderer.pictures(walk(trail=True, contacts=True, label="Hi"), np.array([0.0, 0.2]))
        assert all((picture[..., 3] == 255).all() for picture in pictures)


def test_colours_are_divided_by_alpha() -> None:
    picture = np.array([[[0, 0, 0, 0], [50, 100, 128, 128], [9, 8, 7, 255]]], np.uint8)
    assert straight(picture).tolist() == [[[0, 0, 0, 0], [100, 199, 255, 128], [9, 8, 7, 255]]]


def test_a_webm_keeps_its_alpha(tmp_path: Path) -> None:
    path = render(walk(), tmp_path / "a.webm", width=160, height=120, fps=10, transparent=True)
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-loglevel", "error", "-c:v", "libvpx-vp9", "-i", str(path)]
    raw = subprocess.run([*command, "-f", "rawvideo", "-pix_fmt", "rgba", "-"], capture_output=True, check=True).stdout
    frames = np.frombuffer(raw, np.uint8).reshape(-1, 120, 160, 4)
    assert len(frames) == 6
    with Renderer(*SIZE) as renderer:
        wanted = renderer.frame(walk().replaced(transparent=True), 0.3)
    assert np.abs(frames[3][..., 3].astype(int) - wanted[..., 3]).mean() < 4
    assert frames[3][:10, :10, 3].max() < 10 and frames[3][..., 3].max() > 250


def test_a_gif_and_numbered_pictures_too_but_no_mp4(tmp_path: Path) -> None:
    scene = walk().replaced(transparent=True)
    with Image.open(render(scene, tmp_path / "a.gif", width=80, height=60)) as gif:
        alpha = np.asarray(gif.convert("RGBA"))[..., 3]
    assert set(np.unique(alpha)) == {0, 255}
    folder = render_pngs(scene, tmp_path / "out", width=80, height=60, fps=5)
    with Image.open(folder / "frame-00001.png") as picture:
        assert picture.mode == "RGBA" and picture.getextrema()[3] == (0, 255)
    with pytest.raises(FormatError, match=r"cannot be transparent; accepted: \.webm"):
        render(scene, tmp_path / "a.mp4")
    with pytest.raises(FormatError, match="cannot be transparent"):
        write_video([np.zeros((4, 4, 4), np.uint8)], tmp_path / "a.mp4", 5.0, transparent=True)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.gif", "out"]


def test_each_of_the_four_views_is_the_picture_through_its_camera() -> None:
    scene = walk(contacts=True)
    with FourViews(242, 182) as four:
        whole = next(four.pictures(scene, np.array([0.25]))).copy()
    assert whole.shape == (182, 242, 4)
    size = (242 - SEAM) // 2, (182 - SEAM) // 2
    corners = [(0, 0), (0, 242 - size[0]), (182 - size[1], 0), (182 - size[1], 242 - size[0])]
    parts = []
    with Renderer(*size) as renderer:
        for (top, left), (_, camera) in zip(corners, VIEWS, strict=True):
            part = whole[top : top + size[1], left : left + size[0], :3].astype(int)
            alone = renderer.frame(scene.replaced(camera=camera), 0.25)
            apart = np.abs(part - alone).max(-1)
            assert apart[30:].max() < 12, "but for grain"
            assert apart[:20, :60].max() > 60, "and the name in the corner"
            parts.append(part)
    assert all(np.abs(one - other).max() > 60 for i, one in enumerate(parts) for other in parts[:i])


def test_seen_from_above_the_head_hides_the_feet() -> None:
    """From the top a standing figure is small in both directions; its height is not seen."""
    name, camera = VIEWS[2]
    assert name == "top"
    scene = Scene((Actor(poses.stand()),), Camera("left"), floor=False)
    with Renderer(120, 120) as renderer:
        empty = renderer.frame(
            scene.replaced(
                actors=(Actor(poses.stand().moved((99.0, 0, 0))),),
                camera=Camera("left", distance=3.0, target=(0.0, 0.9, 0.0)),
            )
        )
        side = (
            np.abs(
                renderer.frame(scene.replaced(camera=Camera("left", distance=3.0, target=(0.0, 0.9, 0.0)))).astype(int)
                - empty
            ).max(-1)
            > 25
        )
        top = (
            np.abs(
                renderer.frame(scene.replaced(camera=camera.replaced(distance=3.0, target=(0.0, 0.9, 0.0)))).astype(int)
                - empty
            ).max(-1)
            > 25
        )
    rows = [np.ptp(np.flatnonzero(seen.any(1))) for seen in (side, top)]
    assert rows[1] < 0.45 * rows[0]


def test_four_views_become_a_video_and_wrong_words_are_told(tmp_path: Path) -> None:
    path = render(walk(), tmp_path / "a.mp4", width=160, height=120, fps=10, views="four")
    reader = imageio_ffmpeg.read_frames(str(path))
    assert next(reader)["size"] == (160, 120) and len(list(reader)) == 6
    around = render(walk(), tmp_path / "c.mp4", width=160, height=120, fps=10, views="around")
    assert around.read_bytes() != path.read_bytes()
    with pytest.raises(UnknownLabelError, match="unknown views 'for'; did you mean 'four'"):
        render(walk(), tmp_path / "b.mp4", views="for")
    with pytest.raises(OutOfRangeError, match="size of four views"):
        FourViews(2, 2)
