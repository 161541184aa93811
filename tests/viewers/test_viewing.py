"""Looking at motions without any graphics: the clock, what can be switched, and the keys."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engines.errors import OutOfRangeError, UnknownLabelError
from tests.viewers import poses
from viewers.camera import Camera
from viewers.scene import Scene
from viewers.viewing import KEYS, SPEEDS, Playback, Viewing, keys_in_words


def test_playing_goes_on_by_real_time_and_speed() -> None:
    clock = Playback(100, 20.0, playing=True)
    assert clock.advance(0.5) and clock.at == pytest.approx(10.0)
    clock.set_speed(0.25)
    clock.advance(0.4)
    assert clock.at == pytest.approx(12.0) and clock.seconds == pytest.approx(0.6)
    clock.toggle()
    assert not clock.advance(1.0) and clock.frame == 12


@given(st.integers(1, 50), st.lists(st.floats(0.001, 0.3), min_size=40, max_size=60))
def test_a_loop_never_leaves_the_clip_and_never_sticks(frames: int, steps: list[float]) -> None:
    clock, seen = Playback(frames, 20.0, playing=True), set()
    for elapsed in steps * 4:
        clock.advance(elapsed)
        assert 0 <= clock.frame < frames and clock.playing
        seen.add(clock.frame)
    if 20 * sum(steps) * 4 > 2 * frames and max(steps) * 20 < 1:
        assert seen == set(range(frames))


def test_without_a_loop_it_stops_at_the_end_and_starts_over_when_asked() -> None:
    clock = Playback(10, 20.0, playing=True, loop="off")
    clock.advance(5.0)
    assert clock.frame == 9 and not clock.playing
    clock.toggle()
    assert clock.playing and clock.frame == 0


def test_steps_stop_the_clock_and_stay_within_the_clip() -> None:
    clock = Playback(10, 20.0, at=3.4, playing=True)
    clock.step(1)
    assert clock.frame == 4 and not clock.playing
    clock.step(-99)
    assert clock.frame == 0
    clock.step(99)
    assert clock.frame == 9
    with pytest.raises(OutOfRangeError, match="speed is 9"):
        clock.set_speed(9)


def test_keys_do_what_their_words_say() -> None:
    view = Viewing(poses.stride(40))
    clock = view.playback
    presses = [
        ("arrowright", False, 1),
        ("arrowright", True, 11),
        (",", False, 10),
        ("end", False, 39),
        ("home", False, 0),
    ]
    for key, shift, frame in presses:
        view.press(key, shift)
        assert clock.frame == frame, key
    view.press(" ")
    assert clock.playing
    for _ in range(20):
        view.press("[")
    assert clock.speed == SPEEDS[0]
    for _ in range(20):
        view.press("]")
    assert clock.speed == SPEEDS[-1]
    view.press("l")
    assert clock.loop == "off"


def test_what_is_switched_is_in_the_scene() -> None:
    view = Viewing([poses.stride(10), poses.stride(20)], trail=True)
    shown = []
    for _ in range(3):
        view.press("s")
        shown.append({actor.show for actor in view.scene.actors})
    assert shown == [{"skeleton"}, {"both"}, {"body"}]
    for key, field, value in (("t", "trail", False), ("c", "contacts", True), ("g", "ghosts", 8)):
        version = view.version
        view.press(key)
        assert all(getattr(actor, field) == value for actor in view.scene.actors)
        assert view.version > version
    view.press("b")
    assert view.scene.backdrop == "light"
    assert view.playback.frames == 20


def test_every_key_is_for_something_and_said() -> None:
    said = " ".join(words for _, words in keys_in_words())
    for key, (name, words) in KEYS.items():
        view = Viewing(poses.stride(30))
        view.playback.seek(15)
        before = (view.version, view.playback.__dict__ | {})
        assert view.press(key) == name
        own = name in ("screenshot", "help", "close")
        assert own == (before == (view.version, view.playback.__dict__)), key
        assert own or words in said
    assert Viewing(poses.stride(5)).press("x") is None


def test_the_sides_are_looked_at_and_the_first_view_comes_back() -> None:
    camera = Camera("orbit", yaw=0.3, distance=5.0)
    view = Viewing(Scene.of(poses.stride(10), camera=camera))
    for key, mode in (("1", "front"), ("2", "back"), ("3", "left"), ("4", "right"), ("f", "follow")):
        view.press(key)
        assert view.scene.camera == Camera(mode)
    view.press("0")
    assert view.scene.camera == camera


def test_turning_and_zooming_move_the_eye_as_far_as_asked() -> None:
    view = Viewing(poses.stride(10), camera=Camera("left"))
    before = view.scene.track(np.zeros(1), 1.5)
    view.zoom(0.5, 1.5)
    view.orbit(np.pi / 2, 0.0)
    after = view.scene.track(np.zeros(1), 1.5)
    one, other = before.eye[0] - before.target[0], after.eye[0] - after.target[0]
    assert np.linalg.norm(other) == pytest.approx(np.linalg.norm(one) / 2)
    assert np.degrees(np.arctan2(other[0], other[2]) - np.arctan2(one[0], one[2])) % 360 == pytest.approx(90)
    view.orbit(0.0, 9.0)
    assert view.scene.camera.angles[1] < np.pi / 2, "never over the top"


def test_what_cannot_be_is_told() -> None:
    view = Viewing(poses.stride(5))
    with pytest.raises(UnknownLabelError, match="unknown camera 'frnt'; did you mean 'front'"):
        view.look("frnt")
    with pytest.raises(UnknownLabelError, match="a Scene says it all"):
        Viewing(Scene.of(poses.stride(5)), trail=True)
