"""Videos of a known motion, rendered, written and read back; and what is refused."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest

from engines import SMPL22, Motion
from engines.character import models, video
from engines.errors import Cancelled, FormatError
from engines.geometry import contacts, rotations
from tests.engines.character.people import needs_networks
from viewers.camera import Camera
from viewers.scene import Actor, Scene
from viewers.video import VideoSettings, render

FPS = 12.0
FRAMES = 24


def waving() -> Motion:
    """The right arm is raised and waves, the knees bend and straighten, the head turns."""
    time = np.linspace(0, 2 * np.pi, FRAMES)
    pose = np.zeros((FRAMES, len(SMPL22), 3))
    turns = {
        "left_shoulder": (0, 0, -1.2), "right_shoulder": (0, 0, -0.5), "right_elbow": (0, 0, -0.9),
        "left_hip": (0, 0, 0.1), "right_hip": (0, 0, -0.1),
    }  # fmt: skip
    for joint, turn in turns.items():
        pose[:, SMPL22.index(joint)] = turn
    pose[:, SMPL22.index("right_elbow"), 2] += 0.6 * np.sin(time)
    bend = 0.4 - 0.4 * np.cos(time)
    for side in ("left", "right"):
        for joint, share in (("hip", -1.0), ("knee", 2.0), ("ankle", -1.0)):
            pose[:, SMPL22.index(f"{side}_{joint}"), 0] = share * bend
    motion = Motion(SMPL22, rotations.rotvec_to_quaternion(pose), np.zeros((FRAMES, 3)), FPS)
    lowest = motion.positions[..., 1].min(axis=1) - 0.0277
    return motion.replaced(translation=np.stack([0 * lowest, -lowest, 0 * lowest], axis=1))


@pytest.fixture(scope="module")
def filmed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("film") / "wave.mp4"
    camera = Camera("front", pitch=0.03, fov=0.6)
    scene = Scene((Actor(waving()),), camera, backdrop="light")
    return render(scene, path, **vars(VideoSettings(360, 480, FPS)))


@needs_networks
def test_a_filmed_motion_is_read_back(filmed: Path) -> None:
    told: list[tuple[int, int | None]] = []
    motion, truth = video.read(filmed, progress=lambda done, total: told.append((done, total))), waving()
    assert len(motion) == FRAMES and motion.fps == FPS and motion.skeleton == SMPL22
    assert motion.provenance.source == "wave.mp4"
    assert told == [(frame, FRAMES) for frame in range(1, FRAMES + 1)]
    seen, known = (m.positions - m.positions[:, :1] for m in (motion, truth))
    error = np.linalg.norm(seen - known, axis=-1)
    assert error.mean() < 0.08
    assert error[:, SMPL22.index("left_wrist")].mean() < 0.2  # and not the right one's place
    right = SMPL22.index("right_wrist")
    assert np.corrcoef(seen[:, right, 0], known[:, right, 0])[0, 1] > 0.9
    height = SMPL22.index("pelvis")
    assert np.corrcoef(motion.positions[:, height, 1], truth.positions[:, height, 1])[0, 1] > 0.9
    assert abs(motion.positions[:, height, 1].mean() - truth.positions[:, height, 1].mean()) < 0.08
    assert np.allclose(motion.positions[0, 0, [0, 2]], 0, atol=1e-9)
    assert np.ptp(motion.positions[:, 0, [0, 2]], axis=0).max() < 0.25
    feet = motion.positions[:, [SMPL22.index(name) for pair in SMPL22.feet for name in pair]]
    speed = contacts.joint_speed(feet, motion.fps)
    assert motion.contacts.mean() > 0.4
    assert speed[motion.contacts.reshape(FRAMES, -1)].mean() < 0.1


@needs_networks
def test_reading_stops_when_asked(filmed: Path) -> None:
    asked = iter([False, False, True])
    with pytest.raises(Cancelled):
        video.read(filmed, cancel=lambda: next(asked))


def made(path: Path, *arguments: str) -> Path:
    """A video that ffmpeg makes up."""
    import imageio_ffmpeg

    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-v", "error", "-f", "lavfi", *arguments, str(path)]
    subprocess.run(command, check=True)
    return path


def test_too_long_a_video_is_refused_from_its_header(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    long = made(tmp_path / "long.mp4", "-i", "color=gray:s=64x64:r=1:d=7200")
    monkeypatch.setattr(models, "largest", lambda pixels: pytest.fail("a frame was looked at"))
    with pytest.raises(FormatError, match=r"7200 s; accepted: up to 60 s"):
        video.read(long)


@needs_networks
def test_a_video_of_nobody_is_refused(tmp_path: Path) -> None:
    empty = made(tmp_path / "empty.mp4", "-i", "testsrc=s=320x240:r=4:d=1")
    with pytest.raises(FormatError, match="a person in 0 of 4 frames"):
        video.read(empty)


@pytest.mark.parametrize(("data", "told"), [(b"", "no video"), (b"hello", "no video")])
def test_what_is_no_video_is_refused(tmp_path: Path, data: bytes, told: str) -> None:
    path = tmp_path / "walk.mp4"
    path.write_bytes(data)
    with pytest.raises(FormatError, match=told):
        video.read(path)
    with pytest.raises(FormatError, match="is not there"):
        video.read(tmp_path / "none.mp4")


def track(frames: int, found: np.ndarray, places: np.ndarray, drift: np.ndarray) -> video._Track:
    """Somebody 200 pixels a metre, seen through a lens of 800 pixels."""
    points = 200 * (places[..., :2] * (1, -1)) + drift[:, None]
    return video._Track(points, places, np.ones((frames, 33)), found, 800.0, 20.0)


def test_lost_frames_lie_between_those_around_them_and_trembling_is_gone() -> None:
    frames = 60
    still = np.random.default_rng(0).normal(0, 0.4, (33, 3))
    moving = still + np.linspace(0, 1, frames)[:, None, None]
    found = np.ones(frames, bool)
    found[20:30] = False
    shaken = moving + np.random.default_rng(1).normal(0, 0.02, moving.shape)
    shaken[20:30] = 99
    filled = video._filled(track(frames, found, shaken, np.zeros((frames, 2))))
    assert np.abs(filled.places - moving)[5:-5].max() < 0.12  # by far less than what stood in the lost frames
    assert np.abs(filled.places - moving)[5:20].std() < 0.012


def test_a_step_to_the_side_goes_as_far_as_the_picture_shows_and_nearer_is_toward_the_camera() -> None:
    frames = 40
    walker = video._Track(*_walker(frames), np.ones(frames, bool), 800.0, 20.0)
    path = video._in_picture(walker)
    assert np.isclose(np.ptp(path[:, 0]), 1.0, atol=0.1)  # 200 pixels, 200 pixels a metre
    nearer = video._Track(walker.points * 1.25, *_walker(frames)[1:], walker.found, 800.0, 20.0)
    assert np.isclose(video._in_picture(nearer)[0, 2] - path[0, 2], 4.0 - 3.2, atol=0.1)


def _walker(frames: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points, places and sureness of a house body that glides a metre to the picture's right, four metres away."""
    still = Motion(SMPL22, np.tile(rotations.IDENTITY, (1, 22, 1)), np.zeros((1, 3)), 20.0).positions[0]
    places = np.zeros((frames, 33, 3))
    for name, joint in video.landmarks.JOINTS.items():
        places[:, video.landmarks.index(name)] = still[SMPL22.index(joint)]
    glide = np.stack([np.linspace(0, 200, frames), np.zeros(frames)], axis=1)
    return 200 * places[..., :2] * (1, -1) + glide[:, None], places, np.ones((frames, 33))


def test_a_limb_short_in_the_picture_points_at_the_camera_or_away() -> None:
    frames = 40
    points, places, seen = _walker(frames)
    elbow, wrist, tip = (video.landmarks.index(f"left_{name}") for name in ("elbow", "wrist", "index"))
    places[:, tip] = places[:, wrist]
    shin = [video.landmarks.index(f"left_{name}") for name in ("ankle", "heel", "toe")]
    bent = np.arange(frames) >= 20
    points[bent, wrist, 0] = points[bent, elbow, 0] + 24  # half as long as it is
    places[bent, wrist, 0] = places[bent, elbow, 0] + 0.12
    places[bent, wrist, 2] = places[bent, elbow, 2] - 0.05  # the network sees little, but which way
    deep = video._deepened(video._Track(points, places, seen, np.ones(frames, bool), 800.0, 20.0)).places
    assert np.median(deep[30:, wrist, 2] - deep[30:, elbow, 2]) < -0.12
    assert np.abs(deep[:10, wrist, 2] - deep[:10, elbow, 2]).max() < 0.03
    assert np.allclose(deep[:, tip] - deep[:, wrist], places[:, tip] - places[:, wrist])
    assert np.allclose(deep[:, shin, 2], places[:, shin, 2], atol=0.02)


@pytest.mark.parametrize(("lean", "after"), [(0.2, 0.0), (-0.3, 0.0), (1.2, 1.2)], ids=["down", "up", "lying"])
def test_who_stands_is_set_upright_and_who_lies_is_not(lean: float, after: float) -> None:
    points, places, seen = _walker(30)
    turn = rotations.rotvec_to_matrix(np.array([lean, 0.0, 0.0]))
    straight = video._levelled(video._Track(points, places, seen, np.ones(30, bool), 800.0, 20.0)).places
    leaning = video._Track(points, straight @ turn.T, seen, np.ones(30, bool), 800.0, 20.0)
    wanted = straight @ rotations.rotvec_to_matrix(np.array([after, 0.0, 0.0])).T
    assert np.allclose(video._levelled(leaning).places, wanted, atol=1e-6)
