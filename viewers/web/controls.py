"""What can be set on a player, and the part of it that Jupyter and Panel share.

`Controls` is the one table: `jupyter.py` makes traits of it, `panel_player.py` parameters, and the tests check that
`src/options.js` knows the same names.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from engines.errors import MotionloomError, OutOfRangeError, UnknownLabelError
from engines.motion import Motion
from viewers import bodies
from viewers.bodies.body import Body
from viewers.scene import PALETTE
from viewers.web import payload
from viewers.web.payload import Actor

BUNDLE = Path(__file__).parent / "player.bundle.js"
"""The one ESM file, three.js included; `npm run build` makes it from `src/`."""

Motions = Motion | Actor | Sequence[Motion | Actor]
"""What a player can be given to show."""


@dataclass(frozen=True)
class Option:
    """One thing that can be set: what it is and what it accepts."""

    default: Any
    doc: str
    choices: tuple[str, ...] = ()
    bounds: tuple[float | None, float | None] | None = None


def option(
    default: Any, doc: str, choices: tuple[str, ...] = (), bounds: tuple[float | None, float | None] | None = None
) -> Any:
    """An `Option`; typed Any so that `frame: int = option(0, ...)` reads as the attribute it becomes."""
    return Option(default, doc, choices, bounds)


class Controls:
    """Everything about a player that can be set and watched, from Python and from the browser."""

    frame: int = option(
        0,
        "Frame shown, counted at the first motion's fps. Comes back a few times a second while playing.",
        (),
        (0, None),
    )
    playing: bool = option(False, "Is it playing.")
    speed: float = option(1.0, "How fast, as a factor.", (), (0.1, 4.0))
    loop: str = option("all", "What happens at the end.", ("off", "all", "selection"))
    selection: list[int] = option([], "Frames [start, end) that `loop = 'selection'` repeats; empty: all.")
    show: str = option("body", "What is drawn of a figure.", ("body", "skeleton", "both"))
    camera: str = option(
        "orbit",
        "Where it is seen from. 'follow' goes along with the picked figure, and keeps doing so in the fixed views "
        "chosen after it, until 'orbit'. A view turned by hand becomes 'orbit' or 'follow'.",
        ("orbit", "follow", "front", "back", "left", "right"),
    )
    theme: str = option("dark", "Colours; 'auto' follows the system.", ("dark", "light", "auto"))
    ghosts: int = option(0, "Onion skin: a ghost every so many frames behind the playhead; 0 for none.", (), (0, 1000))
    trail: bool = option(False, "Show the root's way on the floor, one dot a frame.")
    contacts: bool = option(False, "Mark the feet that are on the ground.")
    floor: bool = option(True, "Show the floor.")
    names: bool = option(True, "Show the names under the figures.")
    in_place: bool = option(False, "Show the figures walking on the spot; the motions stay as they are.")
    mirror: bool = option(False, "Show left for right; the motions stay as they are.")
    editable: str = option(
        "",
        "Changes offered beside the transport in place of In place and Mirror, `name=Words` with commas between; they "
        "are for whoever watches `edits` to carry out.",
    )
    edits: str = option("", "Those of them that are pressed, by name, commas between.")
    arrangement: str = option("side", "Several figures side by side or in one place.", ("side", "overlay"))
    spacing: float = option(1.2, "Metres between figures that stand side by side.", (), (0.0, 20.0))
    selected: int = option(0, "Index of the picked figure; -1 for none.", (), (-1, payload.MAX_ACTORS - 1))
    tool: str = option(
        "none",
        "What the mouse draws on the stage: a path on the floor, or the place of a joint of the picked figure; the "
        "outcome comes in `drawn`. A path puts the tool down, Escape does too.",
        ("none", "path", "joint"),
    )
    block: str = option("", "Id of the picked block of `sequence`.")
    open_strips: str = option("words", "Those of `strips` that are open, by name, commas between; `all`: every token.")
    controls: str = option("full", "How much there is around the stage.", ("full", "minimal", "none"))
    sync_url: bool = option(False, "Keep the frame in the page's address (#frame=52), and start from it.")
    global_keys: bool = option(False, "Keys work anywhere on the page, not only while the player has the focus.")
    ready: bool = option(False, "Set by the browser once the player is up.")
    error: str = option("", "Set by the browser: why it could not show the motion.")
    drawn: dict[str, Any] = option(
        {},
        "Set by the browser: what the tool drew last, metres in the picked motion's own place. "
        "`{'kind': 'path', 'points': [[x, z], ...]}` or "
        "`{'kind': 'joint', 'joint': name, 'place': [x, y, z], 'frame': frame, 'fps': rate}`.",
    )
    pinned: dict[str, Any] = option(
        {},
        "Shown beside the picked figure and on the ruler: `path` [[x, z]], `poses` [{frame, rotations (J * 4 wxyz), "
        "root}], `joints` [{joint, frame, place}], `stretches` [[start, end)]; frames at the rate `fps`.",
    )
    strips: dict[str, Any] = option(
        {},
        "What stands under the timeline of the picked figure. `words` {text, weights (steps x words), seconds a step}: "
        "which words each moment came from; `tokens` {codes, seconds of one, all (how many there are), figures "
        "{parents, head, points {code: frames of [x, y, ...], 0 to 100}}}. Without its fields one is offered, to be "
        "filled once it is open (`open_strips`).",
    )
    sequence: dict[str, Any] = option(
        {},
        "Blocks to arrange, in place of the timeline: `blocks` [{id, kind, what, seconds, style, seed, transition, "
        "locked, engine, made}], what they may be (`actions`, `styles`, `engines`, `words`), `error`, and `heard`, a "
        "number that grows with everything that `arranged` brought. Empty: the plain timeline.",
    )
    arranged: dict[str, Any] = option(
        {},
        "Set by the browser: what was done to the blocks last. `{'do': 'add' | 'move' | 'change' | 'split' | 'remove' "
        "| 'duplicate' | 'lock' | 'renew', 'id': block, ...}`; whoever watches it changes `sequence`.",
    )
    body_data: bytes = option(b"", "The body, encoded; see `payload`.")
    take_data: bytes = option(b"", "The motions, encoded; see `payload`.")


OPTIONS: dict[str, Option] = {name: value for name, value in vars(Controls).items() if isinstance(value, Option)}
FROM_BROWSER = ("ready", "error", "drawn", "arranged")
PAYLOADS = ("body_data", "take_data", "pinned", "strips", "sequence")


class Player(Controls):
    """The half of a player that does not care which framework carries it."""

    _actors: tuple[Actor, ...] = ()
    _body: str | Body | None = bodies.DEFAULT

    @property
    def motions(self) -> tuple[Motion, ...]:
        """The motions shown. Setting one or several sends them, and only them, to the browser."""
        return tuple(actor.motion for actor in self._actors)

    @motions.setter
    def motions(self, motions: Motions) -> None:
        self.show_motions(motions)

    def show_motions(self, motions: Motions, labels: Sequence[str] | None = None) -> None:
        """Shows other motions; the body is sent again only if it has to be another one.

        Args:
            motions: one, or up to 16, on any skeleton; an `Actor` also brings its colour and its place.
            labels: a name for each; by default "Take 1", "Take 2", ... for several and none for one.

        Raises:
            OutOfRangeError: no motion, too many, or a number of labels that is not theirs.
        """
        cast = actors_of(motions, labels)
        body_data, take_data = encode(cast, self._body)
        self._actors = cast
        if body_data != self.body_data:
            self.body_data = body_data
        self.take_data = take_data

    def wear(self, body: str | Body | None) -> None:
        """Shows the same motions with another body.

        Args:
            body: name of a body, or one; None shows skeletons only.

        Raises:
            UnknownLabelError: no body of that name.
            SkeletonError: that body cannot wear one of the motions; everything stays as it was.
        """
        before, self._body = self._body, body
        try:
            self.show_motions(self._actors)
        except MotionloomError:
            self._body = before
            raise

    @property
    def payload_bytes(self) -> tuple[int, int]:
        """Bytes that travelled for the body and for the motions."""
        return len(self.body_data), len(self.take_data)

    def play(self) -> None:
        """Starts playing; at the end it starts over."""
        self.playing = True

    def pause(self) -> None:
        """Stops at the current frame."""
        self.playing = False

    def step(self, frames: int = 1) -> None:
        """Stops and moves by some frames, within the clip."""
        self.playing = False
        longest = max(motion.duration for motion in self.motions)
        last = max(round(longest * self.motions[0].fps) - 1, 0)
        self.frame = min(max(self.frame + frames, 0), last)


def actors_of(motions: Motions, labels: Sequence[str] | None = None) -> tuple[Actor, ...]:
    """Motions, named and coloured where they do not bring that themselves.

    Raises:
        OutOfRangeError: a number of labels that is not that of the motions.
    """
    given = (motions,) if isinstance(motions, Motion | Actor) else tuple(motions)
    if labels is not None and len(labels) != len(given):
        raise OutOfRangeError("number of labels", len(labels), f"one for each of the {len(given)} motions")
    names = labels or ([f"Take {i + 1}" for i in range(len(given))] if len(given) > 1 else [""] * len(given))
    cast = []
    for i, (item, name) in enumerate(zip(given, names, strict=True)):
        actor = item if isinstance(item, Actor) else Actor(item)
        colour = actor.colour or PALETTE[i % len(PALETTE)]
        cast.append(replace(actor, name=name if labels else actor.name or name, colour=colour))
    return tuple(cast)


def encode(actors: Sequence[Actor], body: str | Body | None) -> tuple[bytes, bytes]:
    """Payloads of the body and of the motions, which are brought onto the body's joints where they have others.

    Raises:
        OutOfRangeError: no motion, or more than 16.
        UnknownLabelError: no body of that name.
    """
    worn, played = dress([actor.motion for actor in actors], body)
    cast = [replace(actor, motion=motion) for actor, motion in zip(actors, played, strict=True)]
    return encode_body(worn), payload.encode_takes(cast)


@lru_cache(maxsize=8)
def encode_body(body: Body | None) -> bytes:
    """`payload.encode_body`, once per body."""
    return payload.encode_body(body)


def dress(motions: Sequence[Motion], body: str | Body | None) -> tuple[Body | None, list[Motion]]:
    """One body for all motions, and the motions as it plays them.

    The browser stretches the body to other bone lengths itself, so motions that only differ in these share it.
    Without a body every motion keeps its own skeleton.
    """
    if body is None or not motions:
        return None, list(motions)
    worn = body if isinstance(body, Body) else bodies.get(body)
    if worn.name == "stick" and not isinstance(body, Body):
        worn = bodies.get("stick", motions[0].skeleton)
    return worn, [_onto(motion, worn) for motion in motions]


def _onto(motion: Motion, body: Body) -> Motion:
    if body.own_bones:
        return bodies.body_for(motion, body)[1]
    same = motion.skeleton.joints == body.skeleton.joints and motion.skeleton.parents == body.skeleton.parents
    return motion if same else motion.retarget(body.skeleton)


def check_option(name: str, value: Any, also: Collection[str] = ()) -> Any:
    """The value, if there is an option of that name and it takes it.

    Args:
        name: of the option.
        value: wanted for it.
        also: names that are not the player's but its framework's; their values are not looked at.

    Raises:
        UnknownLabelError: no such option, or a word that is not one of its choices.
        OutOfRangeError: a number out of its bounds.
    """
    settable = [known for known in OPTIONS if known not in (*FROM_BROWSER, *PAYLOADS)]
    if name not in settable:
        if name in also:
            return value
        raise UnknownLabelError("player option", name, settable)
    choices, (low, high) = OPTIONS[name].choices, OPTIONS[name].bounds or (None, None)
    if choices and value not in choices:
        raise UnknownLabelError(f"value of {name}", value, choices)
    if (low is not None and value < low) or (high is not None and value > high):
        raise OutOfRangeError(name, value, f"{low} or more" if high is None else f"{low} to {high}")
    return value
