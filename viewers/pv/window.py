"""A window on the desktop: PyVista's own, with the keys of the browser player and a slider to scrub."""

from __future__ import annotations

import logging
import time
from pathlib import Path
from typing import Any

import numpy as np

from viewers.pv.pictures import aim
from viewers.pv.plotter import make_plotter
from viewers.pv.stage import Stage
from viewers.viewing import Viewing, keys_in_words

TICK = 15
"""Milliseconds between looks at the clock; a frame that takes longer delays the next look, not the motion."""
VTK_KEYS = {
    "space": " ", "left": "arrowleft", "right": "arrowright", "comma": ",", "period": ".", "plus": "+", "equal": "=",
    "minus": "-", "question": "?", "bracketleft": "[", "bracketright": "]",
}  # fmt: skip
"""VTK's names of keys -> the browsers'."""
HINT = "? keys   Space play   Left Right frame   1-4 sides   S skeleton   drag to turn"
_LOG = logging.getLogger(__name__)


class Window:
    """One window. The mouse turns, shifts and zooms as in every VTK program; what the keys do says `viewing.KEYS`.

    Raises:
        NoDisplayError: there is no screen.
        MissingDependencyError: pyvista is not installed.
    """

    def __init__(self, viewing: Viewing, width: int, height: int, folder: Path | None = None) -> None:
        self.viewing, self.folder = viewing, folder or Path.cwd()
        self.plotter: Any = make_plotter(width, height, window=True)
        self._version = -1
        self._shown = -1.0
        self._clock = time.perf_counter()
        self._target = np.zeros(3)
        self._helping = self._sliding = False
        self._slider: Any = None
        self._stage: Stage | None = None

    def run(self) -> None:
        """Show the window until it is closed."""
        plotter = self.plotter
        self.draw()
        plotter.enable_terrain_style(mouse_wheel_zooms=True, shift_pans=True)
        interactor = plotter.iren
        interactor.clear_key_event_callbacks()
        interactor.add_observer("KeyPressEvent", self._key)
        # with an observer of its own VTK's style leaves letters alone, which else switch to wireframe, pick, quit
        interactor.interactor.GetInteractorStyle().AddObserver("CharEvent", lambda *_: None)
        interactor.add_observer("TimerEvent", self._tick)
        interactor.initialize()
        interactor.create_timer(TICK, repeating=True)
        plotter.show(auto_close=False)
        plotter.close()

    def draw(self) -> None:
        """Bring the picture up to what is to be seen now."""
        viewing = self.viewing
        if self._version != viewing.version or self._stage is None:
            self._restage()
        at = viewing.playback.at
        if at != self._shown and self._stage is not None:
            self._shown = at
            self._stage.show(viewing.playback.seconds, fine=not viewing.playback.playing)
            self._go_along()
            self._say()
        self.plotter.render()

    def close(self) -> None:
        """Close the window; `run` returns."""
        if self.plotter.iren is not None:
            self.plotter.iren.terminate_app()

    def _restage(self) -> None:
        """Put the scene as it is now in place of the one before."""
        plotter, viewing = self.plotter, self.viewing
        before = None if self._stage is None else self._stage.scene
        plotter.suppress_rendering = True  # else every mesh that is added is a picture of its own
        plotter.clear()
        plotter.clear_slider_widgets()
        self._stage = Stage(plotter, viewing.scene)
        self._version, self._shown = viewing.version, -1.0
        if viewing.playback.frames > 1:
            self._slider = plotter.add_slider_widget(
                self._slid, (1, viewing.playback.frames), value=viewing.playback.frame + 1, fmt="%.0f", style="modern",
                pointa=(0.06, 0.07), pointb=(0.94, 0.07), color=viewing.scene.colours.ink, interaction_event="always",
                slider_width=0.018, tube_width=0.004,
            )  # fmt: skip
        if before is None or before.camera != viewing.scene.camera:
            track = self._track()
            aim(plotter, track, 0)
            self._target = track.target[0]
        plotter.suppress_rendering = False

    def _track(self):
        width, height = self.plotter.window_size
        return self.viewing.scene.track(np.array([self.viewing.playback.seconds]), width / height)

    def _go_along(self) -> None:
        """Shift the camera by what a following one has moved, so that it keeps the side the mouse chose."""
        if self.viewing.scene.camera.mode != "follow":
            return
        target = self._track().target[0]
        moved, self._target = target - self._target, target
        camera = self.plotter.camera
        camera.position = tuple(np.array(camera.position) + moved)
        camera.focal_point = tuple(np.array(camera.focal_point) + moved)

    def _say(self) -> None:
        """Frame, time and hint in the corners; all keys if asked for."""
        playback, ink = self.viewing.playback, self.viewing.scene.colours.ink
        speed = "" if playback.speed == 1 else f"   {playback.speed:g}x"
        now = f"frame {playback.frame + 1} of {playback.frames}   {playback.seconds:.2f} s{speed}"
        plotter = self.plotter
        plotter.add_text(now, position="upper_left", font_size=9, color=ink, name="now", render=False)
        lines = [f"{keys:<10} {words}" for keys, words in keys_in_words()] if self._helping else [HINT]
        words = "\n".join(line.ljust(max(map(len, lines))) for line in lines)  # the corner sets lines flush right
        plotter.add_text(
            words, position="upper_right", font_size=8, color=ink, name="hint", font="courier", render=False
        )
        if self._slider is not None and not self._sliding:
            self._slider.GetRepresentation().SetValue(playback.frame + 1)

    def _slid(self, value: float) -> None:
        if self._stage is not None and round(value) - 1 != self.viewing.playback.frame:
            self.viewing.playback.seek(round(value) - 1)
            self._sliding = True
            self.draw()
            self._sliding = False

    def _tick(self, *_: object) -> None:
        now = time.perf_counter()
        elapsed, self._clock = now - self._clock, now
        if self.viewing.playback.advance(elapsed):
            self.draw()

    def _key(self, source: Any, *_: object) -> None:
        name = str(source.GetKeySym()).lower()
        width, height = self.plotter.window_size
        done = self.viewing.press(VTK_KEYS.get(name) or name, bool(source.GetShiftKey()), width / height)
        if done == "close":
            self.close()
            return
        if done == "screenshot":
            path = self.folder / f"frame-{self.viewing.playback.frame + 1:05d}.png"
            self.plotter.screenshot(str(path))
            _LOG.info("wrote %s", path)
        if done == "help":
            self._helping = not self._helping
        self._clock = time.perf_counter()
        self._shown = -1.0
        self.draw()
