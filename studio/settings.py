"""The one settings file: what to generate and how to export it, the same for the app, the command line and Python.

    {"version": 1,
     "generate": {"engine": "action2motion", "action": "walk", "frames": 60, "seed": 7, "count": 4, "take": 2},
     "export": {"formats": ["bvh", "mp4"], "width": 1280, "height": 720, "camera": "follow",
                "body": "anny", "shape": {"weight": 0.7}}}

Every key is optional; a key or value that is not understood is refused with the nearest one that is. What is pinned
(`constraints`) is described in `studio.pinned`, whole motions (`given`, `like`) in `studio.given`.
"""

from __future__ import annotations

import json
import os
import re
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

import engines
from engines.errors import FormatError, MotionloomError, OutOfRangeError, UnknownLabelError
from studio.given import Given
from studio.pinned import NOTHING, Pinned
from studio.sequence import EMPTY, Sequence

VERSION = 1
DEFAULT_ENGINE = "loom"
"""The engine a newcomer meets first; where its weights are missing, the first that has some."""
MAX_SEED = 2**31 - 1
MAX_COUNT = 32
MAX_FRAMES = 12000
USUAL_FRAMES = 60
"""Length of a motion where nobody says one and the engine finds none."""
MAX_GUIDANCE = 10.0
MAX_BEST_OF = 16
MAX_PROMPT = 1000
MAX_THEN = 32
MAX_STRENGTH = 1.5
A_SURPRISE = "a surprise"
"""A manner by chance, in words."""
BLEND_STEPS = 21
"""So many motions from one end of a blend to the other, both included."""
VIDEO_FORMATS = ("mp4", "gif", "webm")
FORMATS = (*VIDEO_FORMATS, "png", "bvh", "glb", "csv", "npz", "amass")
"""What can be exported: videos, a pose strip, BVH, skinned binary glTF, a table, the project's own lossless .npz,
AMASS .npz."""
EDITS = ("smooth", "feet", "loop", "mirror", "in_place")
"""What may be done to a motion before it is written, in that order; see `studio.edits`."""
CAMERAS = ("follow", "orbit", "front", "back", "left", "right")
VIEWS = ("one", "four", "around")


def usual_engine() -> str:
    """`DEFAULT_ENGINE`, or the first engine with weights where it has none."""
    known = engines.available()
    return DEFAULT_ENGINE if DEFAULT_ENGINE in known else next(iter(known), DEFAULT_ENGINE)


@dataclass(frozen=True)
class GenerateSettings:
    """Everything an engine is told: the same settings give the same motions.

    What an engine can be told beyond action, length, seed and count says its `capabilities`.
    """

    engine: str = field(default_factory=usual_engine)
    """Name of the engine; `motionloom info` lists them."""
    variant: str = ""
    """Variant of the engine; empty for its usual one."""
    action: str = "walk"
    """What the person does; may be empty where there is a prompt."""
    style: str = ""
    """In which manner; empty: any."""
    prompt: str = ""
    """A sentence on what is to be seen, up to 1,000 characters."""
    frames: int | None = USUAL_FRAMES
    """Length of each motion, frames at the engine's rate; null for as long as it takes, where the engine finds that."""
    seed: int = 7
    """Seed of the draw, 0 to 2147483647."""
    count: int = 4
    """How many motions are drawn in one pass, 1 to 32."""
    take: int | None = None
    """Keep only this one of them, counted from 1; null keeps all."""
    bone_scale: Mapping[str, float] = field(default_factory=dict)
    """Joint name -> factor (0.5 to 2) on the bone that leads to it; "*" for all others."""
    guidance: float = 3.0
    """How strongly action, style and words are followed, 0 to 10."""
    best_of: int = 1
    """So many are drawn for each that is kept, the one that moves best; 1 to 16."""
    constraints: Pinned = NOTHING
    """What is pinned: poses and frames to keep, a path, joints, a loop."""
    then: tuple[tuple[str, int], ...] = ()
    """What follows the action, in the same motion: (action, frames), ...; draw i has the seed `seed` + i."""
    blend: Mapping[str, Any] = field(default_factory=dict)
    """On the way to another draw, `{"seed": 9, "take": 1, "share": 0.35}`: its seed, which of that draw, and how far
    (0 to 1, in steps of 0.05). `take` says where it begins. Of a motion given, its `style` besides."""
    given: Given | None = None
    """A motion that is put in another manner: in a style, like another motion, or, where neither is said, by chance.
    `action` and `prompt` then say what it shows."""
    like: Given | None = None
    """The motion whose manner it takes."""
    strength: float = 1.0
    """How much of the manner: 0 leaves the motion as it is, 1 is as it was learned, up to 1.5."""
    tempo: bool = False
    """Whether it also becomes as fast as the style is."""
    sequence: Sequence = EMPTY
    """Blocks one after the other, in place of action and prompt; see `studio.sequence`."""

    @property
    def subject(self) -> str:
        """What the motion shows, in a line."""
        shown = self.sequence.subject or self.action or self.prompt
        if self.given is None:
            return shown or "motion"
        return f"{shown or self.given.source or 'motion'}, {self.manner}"

    @property
    def manner(self) -> str:
        """In which manner a given motion is put, in words: "old", "as in take 3"."""
        to = self.blend.get("style", "")
        if self.like is not None:
            return f"as in {self.like.source or 'another motion'}"
        return f"{self.style} to {to}" if to not in ("", self.style) else self.style or A_SURPRISE

    def __post_init__(self) -> None:
        _within("guidance", self.guidance, 0.0, MAX_GUIDANCE)
        _within("best_of", self.best_of, 1, MAX_BEST_OF)
        if len(self.prompt) > MAX_PROMPT:
            raise OutOfRangeError("length of the prompt", len(self.prompt), f"up to {MAX_PROMPT:,} characters")
        if self.frames is not None:
            _within("frames", self.frames, 2, MAX_FRAMES)
        _within("seed", self.seed, 0, MAX_SEED)
        _within("count", self.count, 1, MAX_COUNT)
        if self.take is not None:
            _within("take", self.take, 1, self.count)
        for joint, factor in self.bone_scale.items():
            _within(f"bone_scale[{joint!r}]", factor, 0.5, 2.0)
        _within("strength", self.strength, 0.0, MAX_STRENGTH)
        self._check_then()
        self._check_blend()
        if self.sequence:
            object.__setattr__(self, "action", "")
            object.__setattr__(self, "prompt", "")
        if self.sequence and (self.then or self.blend or self.constraints or self.given):
            raise MotionloomError(
                "a sequence says all by its blocks; then, blend, constraints and given do not go with it."
            )

    def _check_then(self) -> None:
        object.__setattr__(self, "then", tuple((str(action), int(frames)) for action, frames in self.then))
        _within("number of actions that follow", len(self.then), 0, MAX_THEN)
        for _action, frames in self.then:
            _within("frames of an action that follows", frames, 1, MAX_FRAMES)

    def _check_blend(self) -> None:
        if not self.blend:
            return
        if set(self.blend) - ({"style"} if self.given else set()) != {"seed", "take", "share"}:
            raise OutOfRangeError("blend", dict(self.blend), '{"seed": 9, "take": 1, "share": 0.35}')
        _within("seed of the blend", self.blend["seed"], 0, MAX_SEED)
        _within("take of the blend", self.blend["take"], 1, MAX_COUNT)
        _within("share of the blend", self.blend["share"], 0.0, 1.0)
        if abs(self.blend_step - self.blend["share"] * (BLEND_STEPS - 1)) > 1e-6:
            raise OutOfRangeError("share of the blend", self.blend["share"], "0 to 1 in steps of 0.05")
        if self.take is None:
            raise OutOfRangeError("take", None, "which of the draw the blend begins with")

    @property
    def blend_step(self) -> int:
        """Which of the `BLEND_STEPS` motions from end to end it is."""
        return round(self.blend["share"] * (BLEND_STEPS - 1)) if self.blend else 0


@dataclass(frozen=True)
class ExportSettings:
    """How motions are written."""

    formats: tuple[str, ...] = ("bvh",)
    """Any of mp4, gif, webm (videos), png (poses side by side), bvh, glb (a skinned body), csv (a table), npz
    (motionloom's own, lossless), amass (SMPL poses)."""
    width: int | None = None
    """Video width in pixels, even; null: by the height, or usual for the kind of file."""
    height: int | None = None
    """Video height in pixels, even; null: by the width, or usual for the kind of file."""
    fps: float | None = None
    """Frames a second of the file; null: the motion's own, for videos what is usual for their kind."""
    camera: str = "follow"
    """Video: follow, orbit, front, back, left or right."""
    views: str = "one"
    """Video: one; four (front, side, top and orbit) or around (all sides) in one picture, without `camera`."""
    edits: tuple[str, ...] = ()
    """Done to the motion first: smooth, feet (held where they stand), loop, mirror, in_place."""
    body: str = ""
    """Of videos, strips and .glb: anny, mannequin, stick, smpl, smplh, smplx, character:NAME or a SMPL model
    file; empty: the usual."""
    shape: Mapping[str, float] = field(default_factory=dict)
    """Sliders of the body and their values, those that are not as usual."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "formats", tuple(self.formats))
        for name in self.edits:
            if name not in EDITS:
                raise UnknownLabelError("edit", name, EDITS)
        object.__setattr__(self, "edits", tuple(name for name in EDITS if name in self.edits))
        if not self.formats:
            raise OutOfRangeError("formats", [], "one or more of " + ", ".join(FORMATS))
        for name in self.formats:
            if name not in FORMATS:
                raise UnknownLabelError("export format", name, FORMATS)
        if self.camera not in CAMERAS:
            raise UnknownLabelError("camera", self.camera, CAMERAS)
        if self.views not in VIEWS:
            raise UnknownLabelError("views", self.views, VIEWS)
        for name in ("width", "height"):
            value = getattr(self, name)
            if value is not None and (not 64 <= value <= 4096 or value % 2):
                raise OutOfRangeError(name, value, "an even number of pixels, 64 to 4096")
        if self.fps is not None:
            _within("fps", self.fps, 1, 240)


@dataclass(frozen=True)
class Settings:
    """One settings file."""

    generate: GenerateSettings = field(default_factory=GenerateSettings)
    """What to generate."""
    export: ExportSettings = field(default_factory=ExportSettings)
    """How to write it."""

    def changed(self, **changes: Any) -> Settings:
        """A copy with some keys of either section changed, found by name; None leaves a key as it is."""
        given = {key: value for key, value in changes.items() if value is not None}
        sections = {}
        for section in ("generate", "export"):
            current = getattr(self, section)
            own = {f.name for f in fields(current)}
            sections[section] = replace(current, **{key: given.pop(key) for key in list(given) if key in own})
        if given:
            raise UnknownLabelError("setting", next(iter(given)), setting_names())
        return Settings(**sections)

    def to_json(self) -> str:
        """The text of the settings file."""
        own = self.generate
        generate = {f.name: getattr(own, f.name) for f in fields(own)}
        generate |= {"bone_scale": dict(own.bone_scale), "constraints": own.constraints.to_json()}
        generate |= {"then": [list(part) for part in own.then], "blend": dict(own.blend)}
        generate |= {"sequence": own.sequence.to_json()}
        generate |= {name: motion and motion.to_json() for name, motion in (("given", own.given), ("like", own.like))}
        export = {f.name: getattr(self.export, f.name) for f in fields(self.export)}
        export |= {"formats": list(self.export.formats), "edits": list(self.export.edits)}
        export |= {"shape": dict(self.export.shape)}
        text = json.dumps({"version": VERSION, "generate": generate, "export": export}, indent=2)
        # a row of numbers stays on one line; line breaks inside a string are escaped, so no string is touched
        return re.sub(r"\[\n\s*([-\d.e,\s]+?)\n\s*\]", lambda row: "[" + " ".join(row[1].split()) + "]", text) + "\n"


def setting_names() -> list[str]:
    """Every key a settings file may hold, both sections."""
    return [f.name for section in (GenerateSettings, ExportSettings) for f in fields(section)]


def parse_settings(text: str, source: str | Path = "settings") -> Settings:
    """The settings a text holds.

    Args:
        text: JSON as in the module's example.
        source: name for messages.

    Raises:
        FormatError: not JSON, another version, an unknown key, or a value of the wrong type or out of range.
    """
    try:
        tree = json.loads(text)
    except json.JSONDecodeError as problem:
        raise FormatError(source, f"not JSON: {problem.msg}; accepted: a settings file", problem.lineno) from None
    if not isinstance(tree, dict):
        raise FormatError(source, f"holds {_kind(tree)}; accepted: an object with version, generate, export")
    _known_keys(tree, ("version", "generate", "export"), source)
    if tree.get("version", VERSION) != VERSION:
        raise FormatError(source, f"settings version {tree['version']!r}; accepted: {VERSION}")
    try:
        return Settings(
            _section(GenerateSettings, tree.get("generate", {}), source, "generate"),
            _section(ExportSettings, tree.get("export", {}), source, "export"),
        )
    except FormatError:
        raise
    except MotionloomError as problem:
        raise FormatError(source, str(problem)) from None


def ending(format: str) -> str:
    """What the name of a file of a format ends with."""
    return ".amass.npz" if format == "amass" else f".{format}"


def format_of(path: str | Path) -> str | None:
    """The export format a file's name says, or None."""
    name = Path(path).name.lower()
    return next((f for f in reversed(FORMATS) if name.endswith(ending(f))), None)


def read_settings(path: str | Path) -> Settings:
    """Read a settings file; errors as in `parse_settings`, and FormatError where there is no readable file."""
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as problem:
        raise FormatError(path, f"cannot be read ({problem}); accepted: a JSON settings file") from None
    return parse_settings(text, path)


def write_settings(settings: Settings, path: str | Path) -> Path:
    """Write a settings file, beside and renamed. Returns the path."""
    path = Path(path)
    handle, beside = tempfile.mkstemp(dir=path.parent, prefix=path.name, suffix=".part")
    with os.fdopen(handle, "w", encoding="utf-8") as file:
        file.write(settings.to_json())
    Path(beside).replace(path)
    return path


# ---- checks -----------------------------------------------------------------------------------------------

_TYPES: dict[str, tuple[type, ...]] = {
    "engine": (str,), "variant": (str,), "action": (str,), "frames": (int, type(None)), "seed": (int,), "count": (int,),
    "take": (int, type(None)), "bone_scale": (dict,), "formats": (list,), "edits": (list,), "camera": (str,),
    "views": (str,),
    "style": (str,), "prompt": (str,), "guidance": (int, float), "best_of": (int,), "constraints": (dict,),
    "then": (list,), "blend": (dict,), "sequence": (dict,), "width": (int, type(None)), "height": (int, type(None)),
    "fps": (int, float, type(None)), "body": (str,), "shape": (dict,), "given": (dict, type(None)),
    "like": (dict, type(None)), "strength": (int, float), "tempo": (bool,),
}  # fmt: skip


_READERS: dict[str, Any] = {
    "constraints": Pinned.from_json, "given": Given.from_json, "like": Given.from_json,
    "sequence": Sequence.from_json,
}  # fmt: skip
"""Keys whose value is more than a JSON value."""


def _section(kind: type, tree: object, source: str | Path, name: str) -> Any:
    if not isinstance(tree, dict):
        raise FormatError(source, f"{name} holds {_kind(tree)}; accepted: an object")
    _known_keys(tree, [f.name for f in fields(kind)], source)
    for key, value in tree.items():
        if not _fits(key, value):
            wanted = " or ".join("null" if t is type(None) else t.__name__ for t in _TYPES[key])
            raise FormatError(source, f"{name}.{key} holds {json.dumps(value)}; accepted: {wanted}")
    return kind(**{key: _READERS[key](value) if key in _READERS else value for key, value in tree.items()})


def _fits(key: str, value: Any) -> bool:
    """Has a value the type of its key (a boolean is no number here)."""
    if isinstance(value, bool):
        return bool in _TYPES[key]
    if not isinstance(value, _TYPES[key]):
        return False
    if key == "then":
        parts = [part for part in value if isinstance(part, list) and len(part) == 2]
        return len(parts) == len(value) and all(isinstance(a, str) and type(n) is int for a, n in parts)
    if key in ("bone_scale", "blend", "shape"):
        named = key == "blend" and isinstance(value.get("style"), str)
        numbers = [v for name, v in value.items() if not (named and name == "style")]
        return all(isinstance(v, int | float) and not isinstance(v, bool) for v in numbers)
    return key not in ("formats", "edits") or all(isinstance(v, str) for v in value)


def _known_keys(tree: Mapping[str, Any], known: Any, source: str | Path) -> None:
    for key in tree:
        if key not in known:
            raise FormatError(source, str(UnknownLabelError("setting", key, known)))


def _within(name: str, value: float, low: float, high: float) -> None:
    if not low <= value <= high:
        raise OutOfRangeError(name, value, f"{low:g} to {high:,.0f}" if high > 10 else f"{low:g} to {high:g}")


def _kind(value: object) -> str:
    return {list: "a list", str: "a text", type(None): "null"}.get(type(value), "a number")
