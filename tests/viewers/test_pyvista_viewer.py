"""The inspector: its pictures show what moderngl's show, its controls do what they say, without a screen."""

from __future__ import annotations

import asyncio
import os
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from engines.errors import FormatError, MissingDependencyError, OutOfRangeError, UnknownLabelError
from tests.viewers import poses
from viewers.camera import Camera
from viewers.display import NoDisplayError
from viewers.moderngl_renderer import Renderer
from viewers.pyvista_viewer import Inspector
from viewers.scene import Actor, Scene

pytest.importorskip("pyvista", reason="pip install 'motionloom[viewers]'")
SIZE = (200, 150)
ROOT = Path(__file__).resolve().parents[2]


def look(*motions, **options) -> Inspector:
    return Inspector(motions[0] if len(motions) == 1 else list(motions), *SIZE, **options)


def apart(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """(H, W) how much two pictures differ."""
    return np.abs(one.astype(int) - other).max(-1)


@pytest.mark.parametrize("what", ["body", "skeleton"])
@pytest.mark.parametrize("camera", ["left", "front", "orbit"])
def test_the_figure_stands_where_moderngl_draws_it(what: str, camera: str) -> None:
    motion = poses.squat()
    scene = Scene((Actor(motion, show=what),), Camera(camera), floor=False)
    nothing = scene.replaced(actors=(Actor(motion.moved((500.0, 0, 0)), show=what),))
    far = scene.track(np.zeros(1), SIZE[0] / SIZE[1])
    still = Camera("orbit", target=tuple(far.target[0]), distance=float(np.linalg.norm((far.eye - far.target)[0])))
    nothing = nothing.replaced(camera=still)
    with Inspector(scene, *SIZE) as one, Inspector(nothing, *SIZE) as empty, Renderer(*SIZE) as other:
        here = apart(one.image(), empty.image()) > 9
        there = apart(other.frame(scene), other.frame(nothing)) > 9
    assert here.sum() > 300
    assert (here & there).sum() / (here | there).sum() > 0.86


def test_scrubbing_moves_it_and_one_plotter_serves_all() -> None:
    with look(poses.stride(40), camera=Camera("left")) as one:
        first, used = one.image(), one.plotter
        one.frame = 20
        second = one.image()
        one.step(-20)
        assert one.frame == 0 and (apart(one.image(), first) == 0).all()
        assert (apart(first, second) > 60).sum() > 100
        one.show = "skeleton"
        assert (apart(one.image(), first) > 60).sum() > 100
        assert one.plotter is used
        with pytest.raises(OutOfRangeError, match="0 to 39"):
            one.frame = 40


@pytest.mark.parametrize(
    "options", [{"trail": True}, {"contacts": True}, {"ghosts": 8}, {"show": "both"}, {"label": "Zoë"}]
)
def test_what_is_switched_on_is_seen(options: dict) -> None:
    motion = poses.stride(40)
    with look(motion, camera=Camera("orbit", pitch=0.6)) as one:
        one.frame = 30
        plain = one.image()
        one.change(**options)
        assert (apart(one.image(), plain) > 20).sum() > 15


def test_contact_marks_are_where_feet_stand_and_when() -> None:
    """Seen from above, each mark is strong while its foot stands, faint after, and not there before."""
    motion = poses.stride(40)
    camera = Camera("orbit", pitch=1.5, yaw=0.0)
    gold = []
    with look(motion, camera=camera, show="skeleton", contacts=True) as one:
        for frame in range(0, 40, 3):
            one.frame = frame
            picture = one.image().astype(int)
            gold.append(((picture[..., 0] > 150) & (picture[..., 2] < 0.75 * picture[..., 0])).sum())
        one.change(contacts=False)
        bare = one.image().astype(int)
        base = ((bare[..., 0] > 150) & (bare[..., 2] < 0.75 * bare[..., 0])).sum()
    assert max(gold) > base + 3


def test_playing_leaves_frames_out_rather_than_slowing_down() -> None:
    """The notebook's loop goes by the clock on the wall, whatever drawing takes."""
    pytest.importorskip("ipywidgets")

    async def watch(one: Inspector) -> None:
        panel = panel_of(one)
        panel.play.value = True
        while one.frame == 0:
            await asyncio.sleep(0.02)
        panel.play.value = False
        await asyncio.sleep(0.1)
        held = one.frame
        await asyncio.sleep(0.1)
        assert one.frame == held and not one.playback.playing

    def notebook() -> None:
        with look(poses.stride(40)) as one:
            panel_of(one).play.value = False
            asyncio.run(asyncio.wait_for(watch(one), 60))

    # all of it in a thread of its own: the browser's tests leave a loop running here, and OpenGL is of one thread
    with ThreadPoolExecutor(1) as thread:
        thread.submit(notebook).result()


def panel_of(one: Inspector):
    one.notebook()
    return one._panel


def test_the_notebook_and_the_inspector_follow_each_other() -> None:
    pytest.importorskip("ipywidgets")
    with look(poses.stride(40)) as one:
        panel = panel_of(one)
        assert "application/vnd.jupyter.widget-view+json" in one._repr_mimebundle_()
        before = panel.picture.value
        panel.frame.value = 12
        assert one.frame == 12 and panel.picture.value != before and "13 of 40" in panel.said.value
        panel.on.click()
        assert one.frame == panel.frame.value == 13
        one.frame = 20
        assert panel.frame.value == 20
        panel.show.value = "both"
        panel.contacts.value = True
        assert one.show == "both" and one.scene.actors[0].contacts
        panel.camera.value = "left"
        panel.turn.value = 30
        assert one.scene.camera.angles[0] == pytest.approx(np.pi / 2 + np.radians(30))
        panel.camera.value = "front"
        assert one.scene.camera == Camera("front") and panel.turn.value == 0
        panel.backdrop.value = "light"
        assert one.scene.backdrop == "light"
        assert one.notebook() is one.notebook()
        with Image.open(__import__("io").BytesIO(panel.picture.value)) as shown:
            assert shown.size == SIZE


def test_strips_and_screenshots_are_png_files(tmp_path: Path) -> None:
    with look(poses.stride(40)) as one:
        path = one.save_strip(tmp_path / "strip.png", every=26, height=96)
        with Image.open(path) as strip:
            assert strip.size == (2 * 72, 96)
            left, right = np.split(np.asarray(strip.convert("RGB")), 2, axis=1)
        assert (apart(left, right) > 40).sum() > 30
        with Image.open(one.screenshot(tmp_path / "now.png")) as now:
            assert now.size == SIZE
        with pytest.raises(FormatError, match=r"end in \.png"):
            one.screenshot(tmp_path / "now.jpg")
        with pytest.raises(OutOfRangeError, match="step of frames"):
            one.strip(every=0)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["now.png", "strip.png"]


def test_a_page_holds_the_player_and_what_is_shown(tmp_path: Path) -> None:
    with look(poses.stride(10), show="both", trail=True) as one:
        one.look("left")
        text = one.save_html(tmp_path / "a.html", title="A walk").read_text(encoding="utf-8")
    assert "<title>A walk</title>" in text and '"show": "both"' in text and '"camera": "left"' in text
    assert '"trail": true' in text and "https://unpkg" not in text


def test_several_motions_stand_beside_each_other() -> None:
    with look(poses.stand(), poses.arms_up()) as pair, look(poses.stand()) as single:
        columns = [
            (apart(one.image(), np.median(one.image(), axis=(0, 1)).astype(int)) > 70).any(0).sum()
            for one in (pair, single)
        ]
    assert columns[0] > columns[1] + 10


def test_wrong_words_are_told() -> None:
    with look(poses.stand()) as one:
        with pytest.raises(UnknownLabelError, match="unknown camera"):
            one.look("top")
        with pytest.raises(UnknownLabelError, match="unknown show"):
            one.change(show="bones")
    with pytest.raises(OutOfRangeError, match="width is 0"):
        Inspector(poses.stand(), 0, 10).image()


def test_without_a_screen_a_window_says_what_to_use_instead(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    with look(poses.stand()) as one, pytest.raises(NoDisplayError, match=r"motionloom render.*save_html"):
        one.window()


def test_without_pyvista_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pyvista", None)
    with pytest.raises(MissingDependencyError, match=r"pip install 'motionloom\[viewers\]'"):
        look(poses.stand()).image()


SCRIPT = """
import sys
from concurrent.futures import ThreadPoolExecutor
sys.path.insert(0, {root!r})
from tests.viewers import poses
from viewers.pyvista_viewer import Inspector
from viewers.pv.window import Window
one = Inspector(poses.stride(40), 200, 150)
window = Window(one.viewing, 200, 150)
keys = ["Right", "Right", "s", "c", "1", "l", "bracketleft", "q"]
def press(*_):
    interactor = window.plotter.iren.interactor
    if keys:
        interactor.SetKeySym(keys.pop(0))
        interactor.InvokeEvent("KeyPressEvent")
        interactor.InvokeEvent("CharEvent")
tick = window._tick
window._tick = lambda *event: (tick(*event), press())
window.run()
first = one.scene.actors[0]
print(one.frame, first.show, first.contacts, one.scene.camera.mode, one.playback.loop, one.playback.speed, len(keys))
"""


@pytest.mark.skipif(shutil.which("Xvfb") is None, reason="no Xvfb: a window needs some screen")
def test_a_window_on_a_virtual_screen_obeys_the_keys() -> None:
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
    assert done.stdout.split() == ["2", "skeleton", "True", "front", "off", "0.5", "0"]
