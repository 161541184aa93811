"""Scene: what is shown, with no graphics API in it. Every viewer, browser and video alike, is told the same things."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from engines.errors import OutOfRangeError, UnknownLabelError
from engines.geometry import rotations
from engines.motion import Motion
from viewers.bodies.body import Body
from viewers.camera import Camera, CameraTrack, Subject, camera_track

Show = Literal["body", "skeleton", "both"]
Layout = Literal["side_by_side", "overlaid", "grid"]
SHOWS: tuple[Show, ...] = ("body", "skeleton", "both")
LAYOUTS: tuple[Layout, ...] = ("side_by_side", "overlaid", "grid")

PALETTE = (
    "#d9b38c", "#86a9c9", "#8fbf9f", "#b99ad6", "#dc8f85", "#7fc0c4", "#d6c27a", "#d692b4",
    "#a8b0bd", "#9fb86a", "#8d92d8", "#cf9a63", "#6fb3a0", "#c77f9b", "#91a7e0", "#bfa58f",
)  # fmt: skip
"""Actor colours, in order, of pictures and player alike; clothes rather than signals: names tell actors apart too."""
GAP = 0.5
"""Metres between the floor areas of motions laid out beside each other."""
MARGIN = 0.085
"""A skin reaches so far beyond its joints, as a share of the skeleton's height or span; used for framing."""


@dataclass(frozen=True)
class Backdrop:
    """Colours of everything that is not a body, sRGB hex."""

    centre: str = "#3a4350"
    """Of the gradient, where the light falls."""
    edge: str = "#1b1f26"
    """Of the gradient, in the corners."""
    floor: str = "#262c35"
    """Of the floor near the bodies; it fades into the gradient with distance."""
    grid: str = "#56616f"
    """Of the lines on the floor, one a metre."""
    ink: str = "#e8ebf0"
    """Of text."""


DARK = Backdrop()
LIGHT = Backdrop(centre="#ffffff", edge="#cfd5dd", floor="#e9ecf0", grid="#b4bdc9", ink="#20262e")
BACKDROPS = {"dark": DARK, "light": LIGHT}


@dataclass(frozen=True)
class Light:
    """One key light far away, and light from the sky all around."""

    azimuth: float = 0.75
    """Radians; 0 shines from +Z (from the front), positive from +X."""
    elevation: float = 0.95
    """Radians above the horizon."""
    key: float = 1.0
    """Strength of the key light."""
    sky: float = 1.0
    """Strength of the light from around."""

    @property
    def direction(self) -> np.ndarray:
        """(3,) unit vector towards the light."""
        flat = np.cos(self.elevation)
        return np.array([np.sin(self.azimuth) * flat, np.sin(self.elevation), np.cos(self.azimuth) * flat])


@dataclass(frozen=True)
class Actor:
    """A motion, the body that plays it, and what is drawn with it.

    Raises:
        UnknownLabelError: `show` is none of SHOWS.
        OutOfRangeError: `ghosts` is negative, or the colour no colour.
    """

    motion: Motion
    body: str | Body = "anny"
    """A name for `bodies.get`, or a Body."""
    colour: str | None = None
    """sRGB hex for clothes and marks; default: the body's own."""
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Shift in the scene, metres."""
    ghosts: int = 0
    """A fainter copy every so many frames of the motion; 0 for none."""
    ghost_count: int | None = 6
    """How many of the latest ghosts are seen; None for those of the whole motion, also to come."""
    trail: bool = False
    """Dots on the floor under the root, one a frame."""
    contacts: bool = False
    """Marks where feet are on the ground."""
    label: str | None = None
    """Text by the feet."""
    show: Show = "body"
    """Skin, stick figure, or both."""

    def __post_init__(self) -> None:
        if self.show not in SHOWS:
            raise UnknownLabelError("show", self.show, SHOWS)
        if self.ghosts < 0:
            raise OutOfRangeError("ghosts", self.ghosts, "0 (none) or a number of frames")
        if self.colour is not None:
            hex_to_rgb(self.colour)
        object.__setattr__(self, "offset", tuple(float(x) for x in self.offset))

    def replaced(self, **changes) -> Actor:
        """A copy with some fields changed."""
        return replace(self, **changes)


@dataclass(frozen=True)
class Scene:
    """Everything a viewer needs to know.

    Raises:
        OutOfRangeError: no actors.
        UnknownLabelError: no backdrop of that name.
    """

    actors: tuple[Actor, ...]
    camera: Camera = field(default_factory=Camera)
    backdrop: str | Backdrop = "dark"
    """A name in BACKDROPS, or one's own colours."""
    light: Light = field(default_factory=Light)
    floor: bool = True
    """Grid and shadows at height 0."""
    transparent: bool = False
    """Nothing behind bodies, shadows, marks and text: pictures can be laid over others."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "actors", tuple(self.actors))
        if not self.actors:
            raise OutOfRangeError("number of actors", 0, "1 or more")
        if isinstance(self.backdrop, str) and self.backdrop not in BACKDROPS:
            raise UnknownLabelError("backdrop", self.backdrop, BACKDROPS)

    @classmethod
    def of(
        cls,
        motions: Motion | Sequence[Motion],
        layout: Layout = "side_by_side",
        camera: Camera | None = None,
        **options,
    ) -> Scene:
        """A scene of one or several motions, each in its own colour if there are several.

        Args:
            motions: one Motion or several.
            layout: side_by_side: in a row, the first on the left as seen from the front; grid: in rows; overlaid:
                all starting on one spot. A single motion stays where it is.
            camera: default: goes along with the bodies; several are seen from nearer the front.
            options: further fields of every Actor (body, ghosts, trail, ...).

        Raises:
            OutOfRangeError: no motions.
            UnknownLabelError: no such layout.
        """
        motions = (motions,) if isinstance(motions, Motion) else tuple(motions)
        if layout not in LAYOUTS:
            raise UnknownLabelError("layout", layout, LAYOUTS)
        if not motions:
            raise OutOfRangeError("number of actors", 0, "1 or more")
        offsets = np.zeros((1, 3)) if len(motions) == 1 else _layout(motions, layout)
        colours = [None] if len(motions) == 1 else [PALETTE[i % len(PALETTE)] for i in range(len(motions))]
        actors = [
            Actor(motion, **{"colour": colour, "offset": tuple(map(float, offset)), **options})
            for motion, colour, offset in zip(motions, colours, offsets, strict=False)
        ]
        from_the_front = Camera("follow", yaw=0.22, pitch=0.16)  # so that a row does not stand one behind the other
        return cls(tuple(actors), camera or (Camera("follow") if len(motions) == 1 else from_the_front))

    @property
    def duration(self) -> float:
        """Seconds of the longest motion; the others hold their last pose."""
        return max(actor.motion.duration for actor in self.actors)

    @property
    def colours(self) -> Backdrop:
        """The backdrop itself, looked up if it was named."""
        return BACKDROPS[self.backdrop] if isinstance(self.backdrop, str) else self.backdrop

    def replaced(self, **changes) -> Scene:
        """A copy with some fields changed."""
        return replace(self, **changes)

    def times(self, fps: float) -> np.ndarray:
        """(N,) seconds of the frames of a video at `fps`: one at least, as long as the longest motion.

        Raises:
            OutOfRangeError: fps is not a positive number.
        """
        if not np.isfinite(fps) or fps <= 0:
            raise OutOfRangeError("fps", fps, "a positive number")
        return np.arange(max(1, round(self.duration * fps))) / fps

    def track(self, times: np.ndarray, aspect: float) -> CameraTrack:
        """The camera at `times` (N,) seconds for a picture of `aspect` width / height.

        Framing looks at the whole motion, so that a single frame is framed as it is in the video.
        """
        from viewers.played import at_home  # it builds on this module

        actors = at_home(self).actors
        rate = max(actor.motion.fps for actor in actors)
        steps = self.times(rate)
        points = np.concatenate([_reach(actor, steps) for actor in actors], axis=1)
        roots = np.mean([sample(actor.motion, steps)[1] + actor.offset for actor in actors], axis=0)
        whole = camera_track(self.camera, Subject(points, roots, rate), aspect)
        moved = [
            np.stack([np.interp(times, steps, track[:, axis]) for axis in range(3)], axis=-1)
            for track in (whole.eye, whole.target)
        ]
        return replace(whole, eye=moved[0], target=moved[1])


def sample(motion: Motion, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rotations (N, J, 4) and root path (N, 3) of a motion at `times` (N,) seconds: slerp, held at both ends."""
    times = np.asarray(times, np.float64)
    if len(motion) == 1:
        return np.repeat(motion.rotations, len(times), 0), np.repeat(motion.translation, len(times), 0)
    known = np.arange(len(motion)) / motion.fps
    wanted = np.clip(times, 0.0, known[-1])
    path = np.stack([np.interp(wanted, known, motion.translation[:, axis]) for axis in range(3)], axis=-1)
    frames = wanted * motion.fps
    near = np.round(frames)
    if np.abs(frames - near).max(initial=0.0) < 1e-6:
        return motion.rotations[near.astype(int)], path
    return rotations.slerp(known, motion.rotations, wanted), path


def thumbnail(
    motion: Motion, body: str | Body = "anny", colour: str | None = None, backdrop: str | Backdrop = "dark"
) -> Scene:
    """A still of a motion's most telling frame, seen three quarters from the body's own front."""
    frame = telling_frame(motion)
    still = motion[frame : frame + 1].replaced(labels=())
    yaw = float(motion.heading[frame]) + 0.5
    camera = Camera("orbit", yaw=yaw, pitch=0.12, fill=0.9)
    return Scene((Actor(still, body, colour),), camera, backdrop)


def telling_frame(motion: Motion) -> int:
    """Index of the frame whose pose is least like the motion's average pose and its start."""
    turn = rotations.yaw_quaternion(-motion.heading)[:, None]
    poses = rotations.rotate(turn, motion.positions - motion.positions[:, :1])
    usual = np.median(poses, axis=0)
    unusual = 0.5 * np.linalg.norm(poses - usual, axis=-1).mean(-1) + np.linalg.norm(poses - poses[0], axis=-1).mean(-1)
    return int(unusual.argmax())


def hex_to_rgb(colour: str) -> tuple[float, float, float]:
    """ "#rrggbb" or "#rgb" -> sRGB, each 0..1.

    Raises:
        OutOfRangeError: not such a text.
    """
    digits = colour.removeprefix("#")
    if len(digits) == 3:
        digits = "".join(2 * digit for digit in digits)
    try:
        if len(digits) != 6:
            raise ValueError
        return int(digits[:2], 16) / 255, int(digits[2:4], 16) / 255, int(digits[4:], 16) / 255
    except ValueError:
        raise OutOfRangeError("colour", colour, "six hexadecimal digits, as in '#56b4e9'") from None


def _margin(motion: Motion) -> float:
    """How far a skin reaches beyond its joints, metres, by the size of the skeleton."""
    return MARGIN * float(np.ptp(motion.skeleton.rest_positions, axis=0).max()) + 0.01


def _reach(actor: Actor, times: np.ndarray) -> np.ndarray:
    """(N, P, 3) points around the joints of an actor that framing must keep in view."""
    frames = np.clip(np.round(times * actor.motion.fps).astype(int), 0, len(actor.motion) - 1)
    positions, margin = actor.motion.positions[frames] + actor.offset, _margin(actor.motion)
    above, below = positions + np.array([0, margin, 0]), positions - np.array([0, 0.4 * margin, 0])
    middle = positions.mean(1)
    floor = np.minimum(positions[..., 1].min(1) - 0.4 * margin, 0.0)
    crown = positions[..., 1].max(1) + 1.5 * margin  # the top of the head lies above its joint
    ends = [np.stack([middle[:, 0], height, middle[:, 2]], axis=-1)[:, None] for height in (floor, crown)]
    return np.concatenate([positions, above, below, *ends], axis=1)


def _layout(motions: Sequence[Motion], layout: Layout) -> np.ndarray:
    """(N, 3) offsets; every motion's start is brought to its place, heights are kept."""
    starts = np.array([motion.positions[0, 0] * [1, 0, 1] for motion in motions])
    if layout == "overlaid":
        return -starts
    columns = len(motions) if layout == "side_by_side" else int(np.ceil(np.sqrt(len(motions))))
    places = np.zeros((len(motions), 3))
    back = 0.0
    for first in range(0, len(motions), columns):
        row = range(first, min(first + columns, len(motions)))
        boxes = [_box(motions[i], starts[i]) for i in row]
        edge = -sum(high[0] - low[0] + GAP for low, high in boxes) / 2
        depth = max(high[2] for _, high in boxes)
        for i, (low, high) in zip(row, boxes, strict=True):
            places[i] = (edge + GAP / 2 - low[0], 0.0, back - depth)
            edge += high[0] - low[0] + GAP
        back -= depth - min(low[2] for low, _ in boxes) + GAP
    places[:, 2] -= places[:, 2].mean()
    return places - starts


def _box(motion: Motion, start: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Corners of the space a motion sweeps, relative to its start."""
    points = motion.positions.reshape(-1, 3) - start
    return points.min(0) - _margin(motion), points.max(0) + _margin(motion)
