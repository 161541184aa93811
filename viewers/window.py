"""Motions in a window of their own, drawn by OpenGL at the screen's rate: `show(motion)`.

The keys are those of the browser player (`viewing.KEYS`, shown by ?), a drag turns, with the right button it shifts,
the wheel zooms. Windows are made with GLFW, an optional extra; what the input does is tested without one.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import moderngl
import numpy as np
from PIL import Image

from engines.errors import MissingDependencyError, MotionloomError
from engines.motion import Motion
from viewers.camera import CameraTrack
from viewers.display import NoDisplayError, has_display
from viewers.gl.context import GraphicsContext, put
from viewers.gl.marks import text_block
from viewers.moderngl_renderer import Renderer
from viewers.scene import Scene, hex_to_rgb
from viewers.steering import Steering
from viewers.viewing import Viewing, keys_in_words

SPECIAL = {
    "LEFT": "arrowleft", "RIGHT": "arrowright", "HOME": "home", "END": "end", "ESCAPE": "escape",
}  # fmt: skip
"""GLFW's names of the keys that make no character -> the browsers'."""
RATE = 60.0
"""Looks at the clock a second, while playing; else the window waits for the person."""
_LOG = logging.getLogger(__name__)


def show(what: Motion | Scene | Sequence[Motion], width: int = 1280, height: int = 720, **options) -> None:
    """Open a window on motions and come back when it is closed.

    Args:
        what: a Scene; or motions, shown as `Scene.of` shows them.
        width: of the window, pixels.
        height: likewise.
        options: for motions, further arguments of `Scene.of` (layout, camera, body, show, trail, contacts, ...).

    Raises:
        MissingDependencyError: glfw is not installed.
        NoDisplayError: there is no screen here; the message says what to use instead.
        MotionloomError: the screen's driver has no OpenGL 3.3.
    """
    Window(Viewing(what, **options), width, height).run()


class Desk:
    """What a person does to a window: keys, mouse, wheel; and what is to be seen then. No window in it."""

    def __init__(self, viewing: Viewing) -> None:
        self.viewing, self.steering = viewing, Steering()
        self.helping = self.closing = self.wants_picture = False
        self.changed = True
        """Is there something new to see?"""
        self._button: str | None = None
        self._mouse = (0.0, 0.0)
        self._tracks: tuple[Any, CameraTrack] | None = None

    def key(self, name: str, shift: bool = False, aspect: float = 16 / 9) -> None:
        """A key was pressed, by its browser name."""
        camera = self.viewing.scene.camera
        done = self.viewing.press(name, shift, aspect)
        if done is None:
            return
        self.closing = self.closing or done == "close"
        self.wants_picture = self.wants_picture or done == "screenshot"
        self.helping ^= done == "help"
        if self.viewing.scene.camera is not camera and done not in ("nearer", "farther"):
            self.steering.reset()
        self.changed = True

    def press(self, button: str | None, x: float, y: float) -> None:
        """A mouse button went down ("left" or "right"), or up (None), at a place in heights of the window."""
        self._button, self._mouse = button, (x, y)

    def move(self, x: float, y: float) -> None:
        """The mouse moved to a place in heights of the window."""
        across, down = x - self._mouse[0], y - self._mouse[1]
        self._mouse = (x, y)
        if self._button is not None:
            (self.steering.turn if self._button == "left" else self.steering.pan)(across, down)
            self.changed = True

    def wheel(self, notches: float) -> None:
        """The wheel was turned."""
        self.steering.wheel(notches)
        self.changed = True

    def tick(self, elapsed: float) -> None:
        """So many seconds have gone by."""
        self.changed |= self.viewing.playback.advance(elapsed)

    def track(self, aspect: float) -> CameraTrack:
        """The camera now, (1) moment, as it was moved by hand."""
        viewing = self.viewing
        scene, rate = viewing.scene, viewing.playback.fps
        key = (scene.camera, tuple(id(actor.motion) for actor in scene.actors), aspect)
        if self._tracks is None or self._tracks[0] != key:  # framing looks at the whole motion: once, not each time
            self._tracks = (key, scene.track(np.arange(viewing.playback.frames) / rate, aspect))
        whole = self._tracks[1]
        known = np.arange(len(whole.eye)) / rate
        eye, target = (
            np.array([[np.interp(viewing.playback.seconds, known, place[:, axis]) for axis in range(3)]])
            for place in (whole.eye, whole.target)
        )
        return self.steering.moved(CameraTrack(eye, target, whole.fov, whole.near, whole.far))

    def words(self) -> tuple[tuple[str, str], ...]:
        """The lines over the picture, in two columns."""
        playback = self.viewing.playback
        speed = "" if playback.speed == 1 else f"   {playback.speed:g}x"
        now = f"frame {playback.frame + 1} of {playback.frames}   {playback.seconds:.2f} s{speed}"
        return ((now, ""), *(keys_in_words() if self.helping else [("? for the keys", "")]))


class Window:
    """A GLFW window around a Desk.

    Raises:
        MissingDependencyError: glfw is not installed.
        NoDisplayError: there is no screen.
        MotionloomError: no OpenGL 3.3 on this screen.
    """

    def __init__(self, viewing: Viewing, width: int, height: int, folder: Path | None = None) -> None:
        self.desk, self.folder = Desk(viewing), folder or Path.cwd()
        self._glfw = _glfw()
        if not has_display():
            raise NoDisplayError
        self._window = self._open(width, height)
        self.graphics = GraphicsContext(moderngl.create_context(require=330))
        self._renderer: Renderer | None = None
        self._clock = time.perf_counter()
        self._listen()

    def run(self) -> None:
        """Show the window until it is closed."""
        glfw = self._glfw
        try:
            while not glfw.window_should_close(self._window) and not self.desk.closing:
                self.step()
        finally:
            self.close()

    def step(self) -> None:
        """Wait a little for the person or the clock, and draw if there is something new."""
        glfw, playing = self._glfw, self.desk.viewing.playback.playing
        glfw.wait_events_timeout(1 / RATE if playing else 0.2)
        now = time.perf_counter()
        elapsed, self._clock = now - self._clock, now
        if playing:
            self.desk.tick(elapsed)
        if self.desk.changed:
            self.desk.changed = False
            self.draw()

    def draw(self) -> None:
        """The picture as it is now."""
        glfw, desk = self._glfw, self.desk
        glfw.make_context_current(self._window)
        width, height = glfw.get_framebuffer_size(self._window)
        if min(width, height) < 1:
            return  # minimised
        renderer = self._sized(width, height)
        times = np.array([desk.viewing.playback.seconds])
        with renderer.staged(desk.viewing.scene, times, desk.track(width / height)) as stage:
            renderer.draw(stage, 0)
            if desk.wants_picture:
                self._save(renderer.targets.read_rgb())
            self._write(renderer, desk.words())
        self._to_screen(renderer)
        glfw.swap_buffers(self._window)

    def close(self) -> None:
        """Close the window."""
        if self._window is not None:
            self._glfw.make_context_current(self._window)
            if self._renderer is not None:
                self._renderer.close()
            self._glfw.destroy_window(self._window)
            self._glfw.terminate()
            self._window = None

    def _open(self, width: int, height: int) -> Any:
        glfw = self._glfw
        window = None
        if glfw.init():
            for hint, value in (
                (glfw.CONTEXT_VERSION_MAJOR, 3), (glfw.CONTEXT_VERSION_MINOR, 3), (glfw.OPENGL_FORWARD_COMPAT, True),
                (glfw.OPENGL_PROFILE, glfw.OPENGL_CORE_PROFILE), (glfw.DEPTH_BITS, 0),
            ):  # fmt: skip
                glfw.window_hint(hint, value)
            window = glfw.create_window(width, height, "motionloom", None, None)
        if not window:
            code, said = glfw.get_error()
            raise MotionloomError(
                f"no window could be opened ({said.decode() if said else code}); it needs a screen with OpenGL 3.3. "
                "`motionloom render` makes videos without."
            )
        glfw.make_context_current(window)
        glfw.swap_interval(1)
        return window

    def _listen(self) -> None:
        glfw, window, desk = self._glfw, self._window, self.desk
        special = {getattr(glfw, f"KEY_{name}"): key for name, key in SPECIAL.items()}
        buttons = {glfw.MOUSE_BUTTON_LEFT: "left", glfw.MOUSE_BUTTON_RIGHT: "right", glfw.MOUSE_BUTTON_MIDDLE: "right"}

        def heights(x: float, y: float) -> tuple[float, float]:
            tall = max(glfw.get_window_size(window)[1], 1)
            return x / tall, y / tall

        def on_key(_: Any, key: int, scan: int, action: int, mods: int) -> None:
            if action != glfw.RELEASE and key in special:
                desk.key(special[key], bool(mods & glfw.MOD_SHIFT), self._aspect())

        def on_button(_: Any, button: int, action: int, mods: int) -> None:
            desk.press(buttons.get(button) if action == glfw.PRESS else None, *heights(*glfw.get_cursor_pos(window)))

        def redraw(*_: object) -> None:
            desk.changed = True

        glfw.set_key_callback(window, on_key)
        glfw.set_char_callback(window, lambda _, code: desk.key(chr(code).lower(), aspect=self._aspect()))
        glfw.set_mouse_button_callback(window, on_button)
        glfw.set_cursor_pos_callback(window, lambda _, x, y: desk.move(*heights(x, y)))
        glfw.set_scroll_callback(window, lambda _, x, y: desk.wheel(y))
        glfw.set_framebuffer_size_callback(window, redraw)
        glfw.set_window_refresh_callback(window, redraw)

    def _aspect(self) -> float:
        width, height = self._glfw.get_framebuffer_size(self._window)
        return width / max(height, 1)

    def _sized(self, width: int, height: int) -> Renderer:
        """A renderer for pictures of the window's size."""
        if self._renderer is None or (self._renderer.width, self._renderer.height) != (width, height):
            if self._renderer is not None:
                self._renderer.close()
            self._renderer = Renderer(width, height, graphics=self.graphics)
        return self._renderer

    def _write(self, renderer: Renderer, lines: tuple[tuple[str, str], ...]) -> None:
        """Lines of text over the picture, from its upper left corner."""
        gl, program = self.graphics.gl, self.graphics.program("label", "label")
        letters = text_block(lines, max(11, renderer.height // 50))
        texture = gl.texture(letters.shape[::-1], 1, letters.tobytes(), alignment=1)
        texture.use(0)
        size = np.array([renderer.width, renderer.height])
        corner, extent = 2 * np.array([12, 10]) / size - 1, 2 * np.array(letters.shape[::-1]) / size
        put(program, colour=hex_to_rgb(self.desk.viewing.scene.colours.ink), box=(*corner, *extent))
        gl.enable(gl.BLEND)
        gl.blend_func = gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA
        renderer.targets.quad(program)
        texture.release()

    def _to_screen(self, renderer: Renderer) -> None:
        """The picture, whose first row is its top, onto the screen, whose first row is its bottom."""
        gl, screen = self.graphics.gl, self.graphics.gl.screen
        screen.use()
        gl.viewport = (0, 0, renderer.width, renderer.height)
        gl.disable(gl.BLEND | gl.DEPTH_TEST | gl.CULL_FACE)
        renderer.targets.show_picture()

    def _save(self, picture: np.ndarray) -> None:
        self.desk.wants_picture = False
        path = self.folder / f"frame-{self.desk.viewing.playback.frame + 1:05d}.png"
        Image.fromarray(picture).save(path)
        _LOG.info("wrote %s", path)


def _glfw() -> Any:
    try:
        import glfw
    except ImportError as problem:
        raise MissingDependencyError("glfw", "window", "a window") from problem
    return glfw
