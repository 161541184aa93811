"""The inspector's panel in a notebook: ipywidgets for the controls, a picture the kernel draws."""

from __future__ import annotations

import asyncio
import io
import math
import time
from typing import TYPE_CHECKING, Any

import ipywidgets as widgets
from PIL import Image

from engines.errors import MotionloomError
from viewers.camera import MODES
from viewers.scene import BACKDROPS, SHOWS
from viewers.viewing import SPEEDS

if TYPE_CHECKING:
    from viewers.pyvista_viewer import Inspector

QUALITY = 88
"""Of the pictures sent to the browser, as JPEG."""


class Panel:
    """Controls around a picture. `box` is the widget; the controls and the inspector follow each other."""

    def __init__(self, inspector: Inspector) -> None:
        self.inspector = inspector
        self._following = False
        self._task: asyncio.Task | None = None
        viewing = inspector.viewing
        first, playback = viewing.scene.actors[0], viewing.playback
        self.picture = widgets.Image(format="jpeg", width=inspector.width, height=inspector.height)
        self.picture.layout.max_width = "100%"
        self.play = widgets.ToggleButton(False, description="Play", icon="play", tooltip="Play or pause")
        self.back = widgets.Button(icon="step-backward", tooltip="One frame back")
        self.on = widgets.Button(icon="step-forward", tooltip="One frame on")
        for button in (self.back, self.on):
            button.layout.width = "40px"
        self.play.layout.width = "90px"
        last = max(playback.frames - 1, 1)
        self.frame = widgets.IntSlider(playback.frame, max=last, description="Frame", disabled=playback.frames < 2)
        self.frame.layout.width = "46%"
        self.speed = widgets.SelectionSlider(
            options=[(f"{s:g}x", s) for s in SPEEDS], value=playback.speed, description="Speed"
        )
        self.camera = widgets.Dropdown(options=MODES, value=viewing.scene.camera.mode, description="Camera")
        self.turn = widgets.FloatSlider(0, min=-180, max=180, step=5, description="Turn", readout_format=".0f")
        self.show = widgets.ToggleButtons(options=SHOWS, value=first.show)
        self.show.style.button_width = "80px"
        self.trail = widgets.Checkbox(first.trail, description="Trail", indent=False)
        self.contacts = widgets.Checkbox(first.contacts, description="Contacts", indent=False)
        self.ghosts = widgets.BoundedIntText(first.ghosts, min=0, max=1000, description="Ghosts every")
        backdrop = viewing.scene.backdrop if isinstance(viewing.scene.backdrop, str) else "dark"
        self.backdrop = widgets.Dropdown(options=tuple(BACKDROPS), value=backdrop, description="Backdrop")
        for small in (self.trail, self.contacts, self.ghosts, self.backdrop, self.camera, self.turn, self.speed):
            small.layout.width = "auto"
        self.said = widgets.HTML("")
        self._listen()
        self.box = widgets.VBox(
            [
                self.picture,
                widgets.HBox([self.play, self.back, self.on, self.frame, self.speed]),
                widgets.HBox([self.show, self.camera, self.turn]),
                widgets.HBox([self.trail, self.contacts, self.ghosts, self.backdrop]),
                self.said,
            ]
        )
        self.draw()

    def draw(self) -> None:
        """Bring picture and controls up to the inspector."""
        viewing, playback = self.inspector.viewing, self.inspector.playback
        self._following = True  # so that the controls set here do not set the inspector in turn
        try:
            self.frame.value = playback.frame
            self.show.value = viewing.scene.actors[0].show
            self.camera.value = viewing.scene.camera.mode
            self.play.value = playback.playing
        finally:
            self._following = False
        buffer = io.BytesIO()
        Image.fromarray(self.inspector.image()).save(buffer, "JPEG", quality=QUALITY)
        self.picture.value = buffer.getvalue()
        self.said.value = f"frame {playback.frame + 1} of {playback.frames}, {playback.seconds:.2f} s"

    async def run(self) -> None:
        """Play until someone pauses; frames that cannot be drawn in time are left out."""
        playback, before = self.inspector.playback, time.perf_counter()
        while playback.playing:
            await asyncio.sleep(0.5 / playback.fps)
            now = time.perf_counter()
            if playback.advance(now - before):
                self.draw()
            before = now
        self.draw()

    def _listen(self) -> None:
        viewing, playback = self.inspector.viewing, self.inspector.playback
        self.back.on_click(lambda _: self.inspector.step(-1))
        self.on.on_click(lambda _: self.inspector.step(1))
        self._on(self.frame, playback.seek)
        self._on(self.speed, playback.set_speed, redraw=False)
        self._on(self.camera, self._looked)
        self._on(self.show, lambda value: viewing.change(show=value))
        self._on(self.trail, lambda value: viewing.change(trail=value))
        self._on(self.contacts, lambda value: viewing.change(contacts=value))
        self._on(self.ghosts, lambda value: viewing.change(ghosts=value))
        self._on(self.backdrop, viewing.dress)
        self.turn.observe(self._turned, "value")
        self.play.observe(self._played, "value")

    def _on(self, control: Any, act: Any, redraw: bool = True) -> None:
        """Let a control act on the inspector."""

        def changed(change: Any) -> None:
            if self._following:
                return
            try:
                act(change["new"])
            except MotionloomError as problem:
                self.said.value = str(problem)
                return
            if redraw:
                self.draw()

        control.observe(changed, "value")

    def _looked(self, camera: str) -> None:
        self.inspector.viewing.look(camera)
        self._following = True
        self.turn.value = 0.0
        self._following = False

    def _turned(self, change: Any) -> None:
        if self._following:
            return
        self.inspector.viewing.orbit(math.radians(change["new"] - change["old"]), 0.0)
        self.draw()

    def _played(self, change: Any) -> None:
        if self._following or change["new"] == self.inspector.playback.playing:
            return
        self.inspector.playback.toggle()
        if self.inspector.playback.playing:
            self._task = asyncio.get_running_loop().create_task(self.run())
