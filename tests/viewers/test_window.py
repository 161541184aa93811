"""The OpenGL window: what hands do to it without one, and the window itself where there is a virtual screen."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from engines.errors import MissingDependencyError
from tests.viewers import poses
from viewers import window
from viewers.camera import Camera, CameraTrack
from viewers.display import NoDisplayError
from viewers.steering import Steering
from viewers.viewing import Viewing
from viewers.window import Desk

ROOT = Path(__file__).resolve().parents[2]


def track(eye: tuple[float, float, float] = (0.0, 1.0, 4.0)) -> CameraTrack:
    return CameraTrack(np.array([eye]), np.array([[0.0, 1.0, 0.0]]), 0.6, 0.1, 50.0)


def test_an_untouched_camera_stays() -> None:
    for eye in ((0.0, 1.0, 4.0), (3.0, 2.0, -1.0), (0.0, 5.0, 0.0)):
        moved = Steering().moved(track(eye))
        assert np.allclose(moved.eye, [eye]) and np.allclose(moved.target, [[0, 1, 0]])


def test_a_drag_turns_by_its_angle_and_keeps_the_distance() -> None:
    hand = Steering()
    hand.turn(-0.5, 0.0)
    moved = hand.moved(track())
    assert np.allclose(moved.eye, [[4.0, 1.0, 0.0]]), "half the height is a quarter turn, the scene goes with the mouse"
    hand.turn(0.0, 9.0)
    moved = hand.moved(track())
    assert np.linalg.norm(moved.eye - moved.target) == pytest.approx(4.0)
    assert 3.9 < moved.eye[0, 1] - 1.0 < 4.0, "never over the top"


def test_shifting_follows_the_mouse_and_the_wheel_goes_nearer() -> None:
    hand = Steering()
    hand.pan(0.25, 0.0)
    moved = hand.moved(track())
    height = 2 * np.tan(0.3) * 4.0
    assert np.allclose(moved.target, [[-0.25 * height, 1.0, 0.0]]) and np.allclose(
        moved.eye - moved.target, [[0, 0, 4]]
    )
    hand.reset()
    hand.wheel(2.0)
    assert np.linalg.norm(hand.moved(track()).eye - [[0, 1, 0]]) == pytest.approx(4 * 0.81)
    hand.wheel(-999)
    assert hand.zoom == 20.0


def desk(**options) -> Desk:
    made = Desk(Viewing(poses.stride(40), **options))
    made.changed = False
    return made


def test_mouse_moves_count_only_with_a_button() -> None:
    one = desk()
    one.move(0.3, 0.3)
    assert not one.changed and one.steering == Steering()
    one.press("left", 0.3, 0.3)
    one.move(0.4, 0.3)
    assert one.changed and one.steering.yaw == pytest.approx(-np.pi / 10)
    one.press(None, 0.4, 0.3)
    one.move(0.9, 0.9)
    assert one.steering.yaw == pytest.approx(-np.pi / 10)
    one.press("right", 0.0, 0.0)
    one.move(0.1, 0.2)
    assert one.steering.shift == pytest.approx((-0.1, 0.2))


def test_keys_reach_the_scene_and_a_preset_takes_the_camera_back() -> None:
    one = desk()
    one.wheel(1.0)
    one.key("s")
    assert one.viewing.scene.actors[0].show == "skeleton" and one.steering.zoom < 1
    one.key("1")
    assert one.viewing.scene.camera == Camera("front") and one.steering == Steering()
    one.key("?")
    assert ("Space", "play or pause") in one.words()
    one.key("?")
    assert len(one.words()) == 2
    one.key("p")
    one.key("escape")
    assert one.wants_picture and one.closing


def test_only_what_is_new_is_drawn() -> None:
    one = desk()
    one.key("x")
    one.tick(1.0)
    assert not one.changed, "paused, and no such key"
    one.key(" ")
    one.changed = False
    one.tick(0.5)
    assert one.changed and one.viewing.playback.frame == 10


def test_the_desk_sees_what_the_scene_frames() -> None:
    one = desk(camera=Camera("follow"))
    for frame in (0, 17, 39):
        one.viewing.playback.seek(frame)
        wanted = one.viewing.scene.track(np.array([frame / 20.0]), 1.5)
        seen = one.track(1.5)
        assert np.allclose(seen.eye, wanted.eye) and np.allclose(seen.target, wanted.target)
    before = one.track(1.5)
    one.key("1")
    assert not np.allclose(one.track(1.5).eye, before.eye)


def test_without_glfw_or_a_screen_it_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setitem(sys.modules, "glfw", None)
    with pytest.raises(MissingDependencyError, match=r"pip install 'motionloom\[window\]'"):
        window.show(poses.stand())
    monkeypatch.setattr(window, "_glfw", object)
    with pytest.raises(NoDisplayError, match="motionloom render"):
        window.show(poses.stand())


SCRIPT = """
import sys
sys.path.insert(0, {root!r})
import numpy as np
from tests.viewers import poses
from viewers.viewing import Viewing
from viewers.window import Window
from viewers.moderngl_renderer import Renderer
one = Window(Viewing(poses.stride(40)), 200, 150)
one.step()
gl = one.graphics.gl
one.draw()
gl.finish()
shown = one._renderer.targets.read_rgb()
with Renderer(200, 150) as other:
    wanted = other.frame(one.desk.viewing.scene, 0.0)
apart = np.abs(shown.astype(int) - wanted)[40:].max()
one._glfw.make_context_current(one._window)
for key in ("arrowright", "s", "1", "escape"):
    one.desk.key(key)
one.step()
one.run()
print(one.desk.viewing.playback.frame, one.desk.viewing.scene.actors[0].show, apart < 14)
"""


@pytest.mark.skipif(shutil.which("Xvfb") is None, reason="no Xvfb: a window needs some screen")
def test_a_window_on_a_virtual_screen_shows_the_picture() -> None:
    pytest.importorskip("glfw")
    read, write = os.pipe()
    screen = subprocess.Popen(
        ["Xvfb", "-displayfd", str(write), "-screen", "0", "640x480x24", "-nolisten", "tcp"],
        pass_fds=[write], stderr=subprocess.DEVNULL,
    )  # fmt: skip
    try:
        os.close(write)
        with os.fdopen(read) as told:
            number = told.readline().strip()
        done = subprocess.run(
            [sys.executable, "-c", SCRIPT.format(root=str(ROOT))], env={**os.environ, "DISPLAY": f":{number}"},
            capture_output=True, text=True, timeout=200, check=False,
        )  # fmt: skip
    finally:
        screen.terminate()
        screen.wait()
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == ["1", "skeleton", "True"]
