"""What happens when a person pins something of the motion to come: poses, frames, a path, joints."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from engines.errors import MotionloomError, OutOfRangeError
from studio.pinned import MOST_POINTS, NOTHING, JointPin, Kept, Pinned

if TYPE_CHECKING:
    from studio.session import Session
    from studio.takes import Take


class Pinning:
    """The pins of one session. What cannot be pinned is said in `state.pin_error`.

    Args:
        session: whose state is changed.
    """

    def __init__(self, session: Session) -> None:
        self.session = session

    def pose(self) -> None:
        """The pose of the selected take at the playhead, at that same time of the motion to come."""

        def add(now: Pinned) -> Pinned:
            take, at = self._here()
            return now.with_kept(Kept.of(take.motion, at, at + 1, at, take.title.lower(), self._fps))

        self._change(add)

    def frames(self) -> None:
        """The selected take from its start up to the playhead; the motion goes on from there."""

        def add(now: Pinned) -> Pinned:
            take, at = self._here()
            return now.with_kept(Kept.of(take.motion, 0, at + 1, 0, take.title.lower(), self._fps))

        self._change(add)

    def path(self, points: Sequence[Sequence[float]]) -> None:
        """A line on the floor, (x, z) in metres; it takes the place of the one before."""
        self._change(lambda now: replace(now, path=tuple(map(tuple, _thinned(points)))))

    def path_text(self, text: str) -> None:
        """A line on the floor as typed: "0,0 1,2 2,2"."""
        self._change(lambda now: replace(now, path=parse_path(text)))

    def joint(self, joint: str, position: Sequence[float], seconds: float | None = None) -> None:
        """A joint at a place, metres, at a time of the motion to come; at the playhead unless told."""

        def add(now: Pinned) -> Pinned:
            at = self.session.state.playhead if seconds is None else seconds
            if at < 0:
                raise OutOfRangeError("time of the pin", f"{at:g} s", "0 s or later")
            x, y, z = position
            return now.with_pin(JointPin(joint, round(at * self._fps), (x, y, z)))

        self._change(add)

    def joint_text(self, joint: str, text: str) -> None:
        """A joint at a place as typed: "0.3, 1.2, 0.4", at the playhead."""
        try:
            place = [float(part) for part in text.replace(",", " ").split()]
        except ValueError:
            place = []
        if len(place) != 3:
            self.session.state.pin_error = f"“{text}” is no place; type three numbers x, y, z in metres: 0.3, 1.2, 0.4"
            return
        self.joint(joint, place)

    def loop(self, on: bool) -> None:
        """Whether the motion ends as it began."""
        self._change(lambda now: replace(now, loop=bool(on)))

    def remove(self, key: str) -> None:
        """Take away what is listed under a key."""
        self._change(lambda now: now.without(key))

    def clear(self) -> None:
        """Take everything away."""
        self._change(lambda _now: NOTHING)

    @property
    def _fps(self) -> float:
        return self.session.state.fps

    def _here(self) -> tuple[Take, int]:
        """The selected take and the frame of it at the playhead, at the engine's rate."""
        state = self.session.state
        take = state.take()
        if take is None:
            raise MotionloomError("Pick a take first; its pose at the playhead is what is pinned.")
        last = max(0, round(take.motion.duration * state.fps) - 1)
        return take, min(round(state.playhead * state.fps), last)

    def _change(self, change: Callable[[Pinned], Pinned]) -> None:
        state = self.session.state
        try:
            state.param.update(pinned=change(state.pinned), pin_error="")
        except MotionloomError as problem:
            state.pin_error = _sentence(str(problem))


def parse_path(text: str) -> tuple[tuple[float, float], ...]:
    """`"0,0 1,2 2,2"` -> points (x, z), metres.

    Raises:
        OutOfRangeError: not written so.
    """
    points = []
    for part in text.replace(";", " ").split():
        x, comma, z = part.partition(",")
        try:
            points.append((float(x), float(z)))
        except ValueError:
            comma = ""
        if not comma:
            raise OutOfRangeError("point of the path", part, "x,z in metres, with a blank between points: 0,0 1,2 2,2")
    if len(points) < 2:
        raise OutOfRangeError("path", text, "two or more points x,z in metres: 0,0 1,2 2,2")
    return tuple(points)


def _thinned(points: Sequence[Sequence[float]]) -> list[list[float]]:
    """At most so many points as a path may have, millimetres."""
    step = -(-len(points) // (MOST_POINTS - 1)) or 1
    kept = [*points[:-1:step], points[-1]] if len(points) > 1 else list(points)
    return [[round(float(value), 3) for value in point] for point in kept]


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:]


def as_shown(pinned: Pinned, fps: float) -> dict[str, Any]:
    """What the player shows of the pins: a line, poses, places of joints."""
    poses = []
    for kept in pinned.kept:
        chosen = sorted({*range(0, len(kept), max(1, round(fps))), len(kept) - 1}) if len(kept) > 1 else [0]
        poses += [
            {"frame": kept.at + i, "rotations": [x for q in kept.rotations[i] for x in q], "root": kept.translation[i]}
            for i in chosen[-6:]
        ]
    return {
        "fps": fps,
        "path": pinned.path,
        "poses": poses,
        "stretches": [[kept.at, kept.at + len(kept)] for kept in pinned.kept if len(kept) > 1],
        "joints": [{"joint": pin.joint, "frame": pin.frame, "place": pin.position} for pin in pinned.pins],
    }
