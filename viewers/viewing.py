"""What a person looks at and how, with no graphics API in it: a clock, a scene that can be changed, and the keys.

Windows and notebooks draw what `Viewing.scene` says at `Viewing.playback.seconds`; the keys are the browser player's.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from engines.errors import OutOfRangeError, UnknownLabelError
from engines.motion import Motion
from viewers.camera import MODES, Camera
from viewers.scene import BACKDROPS, SHOWS, Backdrop, Scene, Show

Loop = Literal["off", "all"]
LOOPS: tuple[Loop, ...] = ("all", "off")
SLOWEST, FASTEST = 0.1, 4.0
SPEEDS = (0.1, 0.25, 0.5, 1.0, 1.5, 2.0, 4.0)
"""Steps of the keys that change speed."""
GHOSTS = (0, 8)
"""Intervals of ghosts, frames, that the key goes through."""
JUMP = 10
"""Frames of a step with the shift key."""
STEEPEST = 1.5
"""Radians above or below the horizon that turning the camera by hand may reach."""


@dataclass
class Playback:
    """Where a clip is played and how fast."""

    frames: int
    """How many there are."""
    fps: float
    """Of the clip."""
    at: float = 0.0
    """Frames from the start; between two while playing."""
    playing: bool = False
    speed: float = 1.0
    """Times real time."""
    loop: Loop = "all"
    """all: over and over; off: stop at the end."""

    @property
    def frame(self) -> int:
        """The frame shown, counted from 0."""
        return min(round(self.at), self.frames - 1)

    @property
    def seconds(self) -> float:
        """Since the start."""
        return self.at / self.fps

    def seek(self, frame: float) -> None:
        """Go to a frame; the nearest there is."""
        self.at = float(np.clip(frame, 0, self.frames - 1))

    def step(self, count: int) -> None:
        """Stop, and go on by so many whole frames."""
        self.playing = False
        self.seek(self.frame + count)

    def toggle(self) -> None:
        """Play or pause; at the end playing starts over."""
        self.playing = not self.playing
        if self.playing and self.at >= self.frames - 1:
            self.at = 0.0

    def advance(self, elapsed: float) -> bool:
        """Move on by so many real seconds if playing; True if there is something new to see."""
        if not self.playing or elapsed <= 0:
            return False
        before, end = self.at, self.frames - 1
        self.at += elapsed * self.speed * self.fps
        if self.at > end:
            # from the last frame to the first takes as long as any other step; the last is held meanwhile
            self.at = float(np.fmod(self.at, self.frames)) if self.loop == "all" else float(end)
            self.playing = self.loop == "all"
        return self.at != before

    def set_speed(self, speed: float) -> None:
        """Play at so many times real time.

        Raises:
            OutOfRangeError: slower or faster than can be.
        """
        if not SLOWEST <= speed <= FASTEST:
            raise OutOfRangeError("speed", speed, f"{SLOWEST:g} to {FASTEST:g} times real time")
        self.speed = float(speed)

    def change_speed(self, steps: int) -> None:
        """To the next faster (+1) or slower (-1) of SPEEDS."""
        nearest = int(np.abs(np.array(SPEEDS) - self.speed).argmin())
        self.speed = SPEEDS[int(np.clip(nearest + steps, 0, len(SPEEDS) - 1))]


class Viewing:
    """A scene as a person looks at it: a clock, and what they have switched on and off.

    Args:
        what: a Scene; or motions, shown as `Scene.of` shows them.
        options: for motions, further arguments of `Scene.of` (layout, camera, body, show, trail, ...).
    """

    def __init__(self, what: Motion | Scene | Sequence[Motion], **options) -> None:
        if isinstance(what, Scene) and options:
            raise UnknownLabelError("option beside a Scene", next(iter(options)), ("none: a Scene says it all",))
        self.scene: Scene = what if isinstance(what, Scene) else Scene.of(what, **options)
        self.usual_camera = self.scene.camera
        rate = max(actor.motion.fps for actor in self.scene.actors)
        self.playback = Playback(len(self.scene.times(rate)), rate)
        self.version = 0
        """Counts up when the scene is another; the time alone does not count."""

    # ---- what is shown --------------------------------------------------------------------------------------------

    def change(self, **fields) -> None:
        """Change fields of every actor: show, trail, contacts, ghosts, ..."""
        self._put(actors=tuple(actor.replaced(**fields) for actor in self.scene.actors))

    def look(self, camera: str | Camera) -> None:
        """Look through a camera, or through the one of that name.

        Raises:
            UnknownLabelError: no such camera.
        """
        if isinstance(camera, str) and camera not in MODES:
            raise UnknownLabelError("camera", camera, MODES)
        self._put(camera=camera if isinstance(camera, Camera) else Camera(camera))  # type: ignore[arg-type]

    def dress(self, backdrop: str | Backdrop) -> None:
        """Change the colours of everything that is not a body.

        Raises:
            UnknownLabelError: no backdrop of that name.
        """
        self._put(backdrop=backdrop)

    def orbit(self, yaw: float, pitch: float) -> None:
        """Turn the camera about what it looks at, radians."""
        now = self.scene.camera
        mode = now.mode if now.mode == "follow" else "orbit"
        angles = now.angles
        steep = float(np.clip(angles[1] + pitch, -STEEPEST, STEEPEST))
        self._put(camera=now.replaced(mode=mode, yaw=angles[0] + yaw, pitch=steep))

    def zoom(self, factor: float, aspect: float) -> None:
        """Stand so many times as far away.

        Args:
            factor: below 1 goes nearer.
            aspect: width / height of the picture, by which a camera finds its distance.
        """
        track = self.scene.track(np.zeros(1), aspect)
        distance = float(np.linalg.norm(track.eye[0] - track.target[0]))
        self._put(camera=self.scene.camera.replaced(distance=float(np.clip(distance * factor, 0.2, 200.0))))

    def _put(self, **fields) -> None:
        self.scene = self.scene.replaced(**fields)
        self.version += 1

    # ---- the keyboard ---------------------------------------------------------------------------------------------

    def press(self, key: str, shift: bool = False, aspect: float = 16 / 9) -> str | None:
        """Do what a key says.

        Args:
            key: as the browsers name keys, in lower case: " ", "arrowleft", "home", "g", ...
            shift: whether the shift key is held.
            aspect: width / height of the picture.

        Returns:
            What the key is for, in a word (see KEYS); None where it is for nothing. "screenshot", "help" and "close"
            are the window's own to do.
        """
        if key not in KEYS:
            return None
        name, _ = KEYS[key]
        many = JUMP if shift else 1
        actions: dict[str, Callable[[], None]] = {
            "play": self.playback.toggle,
            "back": lambda: self.playback.step(-many),
            "forward": lambda: self.playback.step(many),
            "first": lambda: self.playback.step(-self.playback.frames),
            "last": lambda: self.playback.step(self.playback.frames),
            "slower": lambda: self.playback.change_speed(-1),
            "faster": lambda: self.playback.change_speed(1),
            "loop": self._next_loop,
            "show": self._next_show,
            "ghosts": lambda: self.change(ghosts=_after(GHOSTS, self.scene.actors[0].ghosts)),
            "trail": lambda: self.change(trail=not self.scene.actors[0].trail),
            "contacts": lambda: self.change(contacts=not self.scene.actors[0].contacts),
            "backdrop": self._next_backdrop,
            "follow": lambda: self.look("follow" if self.scene.camera.mode != "follow" else "orbit"),
            "view": lambda: self._put(camera=self.usual_camera),
            "nearer": lambda: self.zoom(0.85, aspect),
            "farther": lambda: self.zoom(1.18, aspect),
        }
        actions |= {f"{side} view": lambda side=side: self.look(side) for side in ("front", "back", "left", "right")}
        if name in actions:
            actions[name]()
        return name

    def _next_loop(self) -> None:
        self.playback.loop = _after(LOOPS, self.playback.loop)

    def _next_show(self) -> None:
        following: Show = _after(SHOWS, self.scene.actors[0].show)
        self.change(show=following)

    def _next_backdrop(self) -> None:
        names = tuple(BACKDROPS)
        now = self.scene.backdrop if isinstance(self.scene.backdrop, str) else names[-1]
        self._put(backdrop=_after(names, now))


KEYS: dict[str, tuple[str, str]] = {
    " ": ("play", "play or pause"),
    "arrowleft": ("back", "one frame back (Shift: ten)"),
    "arrowright": ("forward", "one frame on (Shift: ten)"),
    ",": ("back", "one frame back"),
    ".": ("forward", "one frame on"),
    "home": ("first", "first frame"),
    "end": ("last", "last frame"),
    "[": ("slower", "slower"),
    "]": ("faster", "faster"),
    "l": ("loop", "over and over, or once"),
    "s": ("show", "body, skeleton, both"),
    "g": ("ghosts", "ghosts of earlier poses"),
    "t": ("trail", "dots under the root"),
    "c": ("contacts", "marks where feet stand"),
    "b": ("backdrop", "dark or light"),
    "f": ("follow", "camera goes along or stands still"),
    "1": ("front view", "from the front"),
    "2": ("back view", "from behind"),
    "3": ("left view", "from the left"),
    "4": ("right view", "from the right"),
    "0": ("view", "the first view again"),
    "+": ("nearer", "nearer"),
    "=": ("nearer", "nearer"),
    "-": ("farther", "farther away"),
    "p": ("screenshot", "save a picture"),
    "?": ("help", "show or hide the keys"),
    "h": ("help", "show or hide the keys"),
    "escape": ("close", "close"),
    "q": ("close", "close"),
}
"""Key -> (what it is for, in words for a person)."""


def keys_in_words() -> list[tuple[str, str]]:
    """(keys, what they are for) for a help text; keys that do the same stand together."""
    named = {" ": "Space", "arrowleft": "Left", "arrowright": "Right", "home": "Home", "end": "End", "escape": "Esc"}
    lines: dict[str, tuple[list[str], str]] = {}
    for key, (name, words) in KEYS.items():
        lines.setdefault(name, ([], words))[0].append(named.get(key, key.upper()))
    return [("  ".join(keys), words) for keys, words in lines.values()]


def _after(values, now):
    """The value after `now`, the first after the last or after one that is none of them."""
    return values[(values.index(now) + 1) % len(values)] if now in values else values[0]
