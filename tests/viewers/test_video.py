"""Video files: what is in them, and that failures leave nothing behind."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image

import viewers
from engines.errors import Cancelled, FormatError, OutOfRangeError, UnknownLabelError
from tests.viewers import poses
from viewers import encoder
from viewers.camera import Camera
from viewers.scene import Scene
from viewers.video import VideoSettings, render, write_video


def read(path: Path) -> tuple[dict, list[np.ndarray]]:
    """What ffmpeg says of a video, and its pictures."""
    reader = imageio_ffmpeg.read_frames(str(path))
    meta = next(reader)
    width, height = meta["size"]
    return meta, [np.frombuffer(raw, np.uint8).reshape(height, width, 3) for raw in reader]


def plain(count: int, size: tuple[int, int] = (64, 48), colour: tuple[int, ...] = (200, 40, 90)) -> list[np.ndarray]:
    frames = [np.full((size[1], size[0], len(colour)), colour, np.uint8) for _ in range(count)]
    for number, frame in enumerate(frames):
        frame[:8, : 4 * number + 4] = 255
    return frames


def test_an_mp4_holds_what_was_put_in(tmp_path: Path) -> None:
    path = write_video(plain(9), tmp_path / "a.mp4", 30.0)
    meta, frames = read(path)
    assert meta["codec"] == "h264" and meta["pix_fmt"].startswith("yuv420p")
    assert meta["size"] == (64, 48) and meta["fps"] == pytest.approx(30.0)
    assert len(frames) == 9
    assert np.abs(frames[4][30:40, 20:40].astype(int) - (200, 40, 90)).max() < 8, "colours survive the way to BT.709"
    assert path.read_bytes().find(b"moov") < path.read_bytes().find(b"mdat"), "it can be played while it downloads"
    assert [p.name for p in tmp_path.iterdir()] == ["a.mp4"]


def test_a_webm_holds_what_was_put_in(tmp_path: Path) -> None:
    meta, frames = read(write_video(plain(9), tmp_path / "a.webm", 30.0))
    assert meta["codec"] == "vp9" and meta["pix_fmt"].startswith("yuv420p")
    assert meta["size"] == (64, 48) and meta["fps"] == pytest.approx(30.0)
    assert len(frames) == 9
    assert np.abs(frames[4][30:40, 20:40].astype(int) - (200, 40, 90)).max() < 12
    assert [p.name for p in tmp_path.iterdir()] == ["a.webm"]


def test_a_gif_holds_what_was_put_in(tmp_path: Path) -> None:
    path = write_video(plain(7), tmp_path / "a.GIF", 20.0)
    with Image.open(path) as gif:
        assert gif.n_frames == 7 and gif.size == (64, 48)
        assert gif.info["duration"] == 50 and gif.info["loop"] == 0
        gif.seek(3)
        assert np.abs(np.asarray(gif.convert("RGB"))[30, 30].astype(int) - (200, 40, 90)).max() < 8


@pytest.mark.parametrize("size", [(63, 48), (64, 47), (33, 21)])
@pytest.mark.parametrize("suffix", ["mp4", "webm", "gif"])
def test_odd_sizes_become_even(tmp_path: Path, size: tuple[int, int], suffix: str) -> None:
    meta, frames = read(write_video(plain(3, size), tmp_path / f"a.{suffix}", 10.0))
    assert meta["size"] == (size[0] + size[0] % 2, size[1] + size[1] % 2)
    assert len(frames) == 3


@pytest.mark.parametrize("suffix", ["mp4", "webm", "gif"])
def test_one_frame_is_a_video_too(tmp_path: Path, suffix: str) -> None:
    path = write_video(plain(1), tmp_path / f"a.{suffix}", 24.0)
    if suffix == "gif":
        with Image.open(path) as gif:
            assert gif.n_frames == 1
    else:
        assert len(read(path)[1]) == 1


def test_four_channels_and_generators_are_taken(tmp_path: Path) -> None:
    seen: list[tuple[int, int | None]] = []
    frames = (frame for frame in plain(5, colour=(10, 200, 30, 255)))
    path = write_video(frames, tmp_path / "a.mp4", 10.0, progress=lambda *now: seen.append(now))
    assert seen == [(n, None) for n in range(1, 6)]
    assert np.abs(read(path)[1][2][40, 40].astype(int) - (10, 200, 30)).max() < 10


def test_cancel_leaves_nothing(tmp_path: Path) -> None:
    asked = iter([False, False, False, True])
    with pytest.raises(Cancelled):
        write_video(plain(50), tmp_path / "a.mp4", 30.0, cancel=lambda: next(asked))
    with pytest.raises(Cancelled):
        write_video(plain(50), tmp_path / "b.gif", 30.0, cancel=lambda: True)
    assert not list(tmp_path.iterdir())


def test_a_failure_keeps_the_file_there_was(tmp_path: Path) -> None:
    path = tmp_path / "a.mp4"
    path.write_bytes(b"the old one")

    def broken() -> Iterator[np.ndarray]:
        yield from plain(3)
        raise RuntimeError("the picture could not be drawn")

    with pytest.raises(RuntimeError, match="could not be drawn"):
        write_video(broken(), path, 30.0)
    assert path.read_bytes() == b"the old one"
    assert [p.name for p in tmp_path.iterdir()] == ["a.mp4"]


def test_an_encoder_that_gives_up_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(encoder._ARGUMENTS, ".mp4", ["-c:v", "no_such_codec", "-f", "mp4"])
    with pytest.raises(FormatError, match=r"the encoder stopped: .+"):
        write_video(plain(200, (320, 240)), tmp_path / "a.mp4", 30.0)
    assert not list(tmp_path.iterdir())


def test_wrong_requests_are_refused_before_anything_is_written(tmp_path: Path) -> None:
    for frames, name, fps, error, said in (
        (plain(2), "a.avi", 30.0, FormatError, r"\.mp4, \.webm or \.gif"),
        (plain(2), "a.mp4", 0.0, OutOfRangeError, "fps"),
        ([], "a.mp4", 30.0, OutOfRangeError, "number of frames"),
        ([*plain(2), *plain(1, (32, 32))], "a.mp4", 30.0, OutOfRangeError, "size of a frame"),
        ([np.zeros((8, 8), np.uint8)], "a.mp4", 30.0, OutOfRangeError, "frame"),
        (plain(2), "missing/a.mp4", 30.0, FormatError, "cannot be written"),
    ):
        with pytest.raises(error, match=said):
            write_video(frames, tmp_path / name, fps)
    assert not list(tmp_path.iterdir())


def test_a_motion_becomes_a_video(tmp_path: Path) -> None:
    motion, seen = poses.stride(20), []
    path = viewers.render(motion, tmp_path / "walk.mp4", width=161, height=120, progress=lambda *now: seen.append(now))
    meta, frames = read(path)
    assert meta["size"] == (162, 120) and len(frames) == 30 and meta["fps"] == pytest.approx(30.0)
    assert seen == [(n, 30) for n in range(1, 31)]
    assert np.abs(frames[0].astype(int) - frames[10]).max() > 60, "it moves"


def test_a_scene_becomes_a_gif_of_sane_size(tmp_path: Path) -> None:
    scene = Scene.of([poses.stride(8), poses.stand()], camera=Camera("front"))
    path = render(scene, tmp_path / "pair.gif")
    with Image.open(path) as gif:
        assert gif.size == (480, 270) and gif.n_frames == 8
    assert path.stat().st_size < 600_000


def test_cancelling_a_render_leaves_nothing_and_the_next_one_works(tmp_path: Path) -> None:
    count = iter(range(100))
    with pytest.raises(Cancelled):
        render(poses.stride(40), tmp_path / "a.mp4", width=64, height=48, cancel=lambda: next(count) > 5)
    assert not list(tmp_path.iterdir())
    assert len(read(render(poses.stride(4), tmp_path / "a.mp4", width=64, height=48, fps=20))[1]) == 4


def test_settings_are_named_and_completed() -> None:
    assert VideoSettings().filled(".mp4") == VideoSettings(1280, 720, 30.0)
    assert VideoSettings(width=641).filled(".mp4") == VideoSettings(642, 362, 30.0)
    assert VideoSettings(height=100, fps=12).filled(".gif") == VideoSettings(178, 100, 12)
    with pytest.raises(UnknownLabelError, match="did you mean 'width'"):
        render(poses.stand(), "a.mp4", widht=3)
    with pytest.raises(UnknownLabelError, match="camera"):
        render(poses.stand(), "a.mp4", camera="behind")
    with pytest.raises(OutOfRangeError, match="width"):
        render(poses.stand(), "a.mp4", width=-4)


def test_the_package_offers_its_parts_lazily() -> None:
    assert viewers.render is render and viewers.write_video is write_video
    with pytest.raises(AttributeError, match="MotionPlayer"):
        _ = viewers.nothing_like_it
