"""The text of a BVH file: its HIERARCHY as a list of joints, its MOTION as an array. No meaning yet; see `bvh`."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from engines.errors import FormatError
from engines.formats.files import MAX_JOINTS, check_size

MAX_HIERARCHY_BYTES = 2 * 2**20
"""A HIERARCHY longer than this is refused: 2,000 joints need about a quarter of it."""
MAX_DEPTH = 200
"""How deep joints may be nested."""
FPS_RANGE = (0.01, 100_000.0)
"""Frame rates that a `Frame Time` may mean."""

_LARGEST = 1e12
"""Numbers from here on are taken for damage."""
_LONG_LINE = 2**16
"""Bytes of a line whose surplus numbers are no longer counted for a message."""
_AXES = {"x": 0, "y": 1, "z": 2}
_CHANNEL = re.compile(r"([xyz])(position|rotation)", re.IGNORECASE)
_TOKEN = re.compile(r"\n|[{}]|[^\s{}]+")
_MOTION = re.compile(rb"^[ \t]*MOTION[ \t]*$", re.MULTILINE | re.IGNORECASE)
_BLANK_LINES = re.compile(rb"\n[ \t]*(?=\n)")
_KEYWORDS = {"OFFSET", "CHANNELS", "JOINT", "ROOT", "END", "MOTION", "HIERARCHY"}


@dataclass
class Node:
    """One joint as the file states it, in the file's units."""

    name: str
    line: int
    parent: int
    offset: tuple[float, float, float] | None = None
    end: tuple[float, float, float] | None = None
    channels: list[tuple[str, int]] | None = None
    """("position" or "rotation", axis 0-2) in the order of the columns; None until CHANNELS is read."""

    @property
    def order(self) -> tuple[int, ...]:
        """Axes of its rotation channels, in the order they are applied."""
        return tuple(axis for kind, axis in self.channels or () if kind == "rotation")


@dataclass
class BvhText:
    """A parsed file: joints parents first, and one row of channel values a frame."""

    nodes: list[Node]
    values: np.ndarray
    """(T, channels) as in the file: file units and degrees."""
    frame_time: float
    """Seconds."""
    fps: float
    """1 / frame_time, freed from the rounding of the text."""


def parse(path: Path, data: bytes) -> BvhText:
    """Parse the bytes of a BVH file.

    Raises:
        FormatError: anything that is not a complete, finite BVH; the message says the line and what is accepted.
    """
    data = data.removeprefix(b"\xef\xbb\xbf")
    if b"\r" in data:
        data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    motion = _MOTION.search(data)
    end = motion.start() if motion else len(data)
    if end > MAX_HIERARCHY_BYTES:
        raise FormatError(path, f"its HIERARCHY is longer than {MAX_HIERARCHY_BYTES:,} bytes, or MOTION is missing.", 1)
    nodes = _Hierarchy(path, data[:end].decode("utf-8", errors="replace")).parse()
    line = data.count(b"\n", 0, end) + 1
    if motion is None:
        raise FormatError(path, "the file ends after the HIERARCHY; accepted next: MOTION and its frames.", line)
    return _parse_motion(path, nodes, data[motion.end() + 1 :], line + 1)


@dataclass
class _Hierarchy:
    """Reads HIERARCHY token by token, without recursion, so that no nesting can overflow the stack."""

    path: Path
    text: str
    line: int = 1
    nodes: list[Node] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._tokens = self._scan()

    def _scan(self) -> Iterator[str]:
        for match in _TOKEN.finditer(self.text):
            if match[0] == "\n":
                self.line += 1
            else:
                yield match[0]

    def fail(self, problem: str, line: int | None = None) -> FormatError:
        return FormatError(self.path, problem, line or self.line)

    def next(self, accepted: str) -> str:
        token = next(self._tokens, None)
        if token is None:
            raise self.fail(f"the file ends inside the HIERARCHY; accepted next: {accepted}.")
        return token

    def expect(self, word: str) -> None:
        token = self.next(word)
        if token.upper() != word:
            raise self.fail(f"{_shown(token)} where {word} is expected.")

    def parse(self) -> list[Node]:
        self.expect("HIERARCHY")
        self.expect("ROOT")
        stack = [self.open_joint(-1)]
        while stack:
            token = self.next("OFFSET, CHANNELS, JOINT, End Site or }").upper()
            if token == "}":
                self.close_joint(self.nodes[stack.pop()])
            elif token == "JOINT":
                stack.append(self.open_joint(stack[-1]))
                if len(stack) > MAX_DEPTH:
                    raise self.fail(f"joints are nested more than {MAX_DEPTH} deep.")
            else:
                self.read_field(token, self.nodes[stack[-1]])
        extra = next(self._tokens, None)
        if extra is not None:
            only = "only one ROOT is accepted" if extra.upper() == "ROOT" else "expected MOTION"
            raise self.fail(f"{_shown(extra)} after the last joint; {only}.")
        return self.nodes

    def open_joint(self, parent: int) -> int:
        words, line = [], self.line
        while (token := self.next("the joint's name and {")) != "{":
            line = line if words else self.line
            if token == "}" or (words and token.upper() in _KEYWORDS):
                raise self.fail(f"{_shown(token)} where the {{ of joint {_shown(' '.join(words))} is expected.")
            words.append(token)
        name = " ".join(words)
        if not name:
            raise self.fail("a joint without a name.")
        twin = next((node for node in self.nodes if node.name == name), None)
        if twin:
            raise self.fail(f"a second joint is named {_shown(name)} (the first is on line {twin.line}).", line)
        if len(self.nodes) >= MAX_JOINTS:
            raise self.fail(f"more than {MAX_JOINTS:,} joints.")
        self.nodes.append(Node(name, line, parent))
        return len(self.nodes) - 1

    def close_joint(self, node: Node) -> None:
        if node.offset is None or node.channels is None:
            missing = "OFFSET" if node.offset is None else "CHANNELS"
            raise self.fail(f"joint {_shown(node.name)} ends without {missing}.")

    def read_field(self, token: str, node: Node) -> None:
        if token == "OFFSET":
            if node.offset is not None:
                raise self.fail(f"a second OFFSET in joint {_shown(node.name)}.")
            node.offset = self.vector()
        elif token == "CHANNELS":
            if node.channels is not None:
                raise self.fail(f"a second CHANNELS in joint {_shown(node.name)}.")
            node.channels = self.channels()
        elif token in ("END", "ENDSITE"):
            self.end_site(node)
        else:
            raise self.fail(f"{_shown(token)} where OFFSET, CHANNELS, JOINT, End Site or }} is expected.")

    def end_site(self, node: Node) -> None:
        while (token := self.next("{")) != "{":
            if token == "}" or token.upper() in _KEYWORDS:
                raise self.fail(f"{_shown(token)} where the {{ of the End Site is expected.")
        self.expect("OFFSET")
        end = self.vector()
        node.end = node.end or end
        self.expect("}")

    def vector(self) -> tuple[float, float, float]:
        return (self.number(), self.number(), self.number())

    def number(self) -> float:
        token = self.next("a number")
        value = _number(token)
        if value is None:
            raise self.fail(f"{_shown(token)} where a number of an OFFSET is expected.")
        return value

    def channels(self) -> list[tuple[str, int]]:
        token = self.next("the number of channels")
        if not token.isascii() or not token.isdigit() or len(token) > 2 or int(token) > 6:
            raise self.fail(f"{_shown(token)} where the number of channels, 0 to 6, is expected.")
        found: list[tuple[str, int]] = []
        for _ in range(int(token)):
            word = self.next("a channel")
            match = _CHANNEL.fullmatch(word)
            if not match:
                raise self.fail(
                    f"{_shown(word)} is no channel; accepted: {token} of Xposition, Yposition, Zposition, Xrotation, "
                    "Yrotation, Zrotation."
                )
            found.append((match[2].lower(), _AXES[match[1].lower()]))
        places = [axis for kind, axis in found if kind == "position"]
        if len(set(places)) < len(places) or len(found) - len(places) > 3:
            raise self.fail("the same position channel twice, or more than three rotation channels.")
        return found


def _number(token: str) -> float | None:
    """A finite decimal number, or None: Python's own `float` would also take 1_000, nan and infinity."""
    if "_" in token:
        return None
    try:
        value = float(token)
    except ValueError:
        return None
    return value if abs(value) < _LARGEST else None


def _shown(token: str) -> str:
    """A piece of the file, short and printable enough for a message."""
    short = token if len(token) <= 40 else token[:37] + "..."
    return repr(short)


def _parse_motion(path: Path, nodes: list[Node], data: bytes, line: int) -> BvhText:
    """The two header lines and the block of numbers that begin on `line`, after MOTION."""
    token, at, line = _header_line(path, data, 0, line, "Frames: N")
    frames = _frame_count(path, token, line - 1)
    check_size(path, frames, len(nodes), line - 1)
    token, at, line = _header_line(path, data, at, line, "Frame Time: seconds")
    seconds, fps = _frame_rate(path, token, line - 1)
    columns = sum(len(node.channels or ()) for node in nodes)
    if columns == 0:
        raise FormatError(path, "no joint has CHANNELS, so there is no motion in it.", nodes[0].line)
    return BvhText(nodes, _parse_frames(path, data[at:], frames, columns, line), seconds, fps)


def _header_line(path: Path, data: bytes, at: int, line: int, accepted: str) -> tuple[str, int, int]:
    """The value of the next `name: value` line from byte `at`, and the byte and the line that follow it."""
    name = accepted.partition(":")[0].replace(" ", r"\s*")
    while at < len(data):
        end = data.find(b"\n", at)
        end = len(data) if end < 0 else end
        text = data[at : min(end, at + 1000)].decode("utf-8", errors="replace").strip()
        at, line = end + 1, line + 1
        if match := re.fullmatch(name + r"\s*:\s*(\S+)", text, re.IGNORECASE):
            return match[1], at, line
        if text:
            raise FormatError(path, f"{_shown(text)} where '{accepted}' is expected.", line - 1)
    raise FormatError(path, f"the file ends after MOTION; accepted next: '{accepted}'.", line)


def _frame_count(path: Path, token: str, line: int) -> int:
    if not token.isascii() or not token.isdigit() or len(token) > 12 or int(token) < 1:
        raise FormatError(path, f"Frames is {_shown(token)}; accepted: a whole number, 1 or more.", line)
    return int(token)


def _frame_rate(path: Path, token: str, line: int) -> tuple[float, float]:
    """Frame time and frame rate; a rate that is whole but for the rounding of the text is made whole."""
    seconds = _number(token)
    low, high = FPS_RANGE
    if seconds is None or not 1 / high <= seconds <= 1 / low:
        raise FormatError(
            path, f"Frame Time is {_shown(token)}; accepted: seconds, from {1 / high:g} to {1 / low:g}.", line
        )
    mantissa, _, exponent = token.lower().partition("e")
    decimals = len(mantissa.partition(".")[2])
    digits = len(mantissa.replace(".", "").lstrip("+-0"))
    unit = 10.0 ** (int(exponent or 0) - decimals)
    for places in (0, 2, 3):
        candidate = round(1 / seconds, places)
        if digits >= 3 and candidate > 0 and abs(1 / candidate - seconds) <= unit:
            return seconds, candidate
    return seconds, 1 / seconds


def _parse_frames(path: Path, block: bytes, frames: int, columns: int, line: int) -> np.ndarray:
    """(frames, columns) numbers, one row a line; blank lines are passed over."""
    rows = _BLANK_LINES.sub(b"", block).strip()
    first = rows.partition(b"\n")[0]
    # the shape is known from the text before anything is allocated for it
    if rows.count(b"\n") + 1 != frames or len(first.split(maxsplit=columns)) != columns or not rows:
        raise _bad_frames(path, block, frames, columns, line)
    try:
        values = np.loadtxt(io.BytesIO(rows), dtype=np.float64, comments=None, ndmin=2, encoding="latin-1")
    except ValueError as error:
        raise _bad_frames(path, block, frames, columns, line) from error
    if values.shape != (frames, columns) or not (np.abs(values) < _LARGEST).all():
        raise _bad_frames(path, block, frames, columns, line)
    return values


def _bad_frames(path: Path, block: bytes, frames: int, columns: int, line: int) -> FormatError:
    """What is wrong with a block of frames, found line by line."""
    seen, last = 0, line
    for at, text in enumerate(io.BytesIO(block), start=line):
        words = text.split(maxsplit=columns)
        if not words:
            continue
        seen, last = seen + 1, at
        if seen > frames:
            return FormatError(path, f"more lines of numbers than the {frames:,} that Frames states.", at)
        bad = next((w for w in words[:columns] if _number(w.decode("latin-1")) is None), None)
        if bad is not None:
            shown = _shown(bad.decode("latin-1"))
            return FormatError(path, f"{shown} in frame {seen - 1}; accepted: finite numbers.", at)
        if len(words) != columns:
            count = len(text.split()) if len(text) < _LONG_LINE else f"more than {columns}"
            return FormatError(path, f"frame {seen - 1} has {count} numbers; accepted: {columns}.", at)
    if seen < frames:
        return FormatError(path, f"the file ends after {seen:,} frames; Frames states {frames:,}.", last)
    return FormatError(path, f"the frames are not {frames:,} lines of {columns} plain numbers.", line)
