"""A sequence: blocks one after the other, which become one motion; the model behind the timeline.

    {"blocks": [{"what": "walk", "seconds": 3.0, "seed": 4},
                {"what": "a person waves, proudly", "kind": "prompt", "seconds": 2.5, "transition": 0.8},
                {"what": "take 2", "kind": "clip", "clip": {"values": "eJxs...", "frames": 60, "fps": 20.0}}],
     "engine": "multiact"}

Every block is made on its own and a transition leads from one to the next, so a block can be changed, moved or locked
without the others becoming other ones; unless `engine` names one that goes on from what stands before
(`studio.sequencing`). Pure values: each operation gives a new `Sequence`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, Literal

from engines import SMPL22, Motion
from engines.errors import MotionloomError, OutOfRangeError, UnknownLabelError, demand_whole
from studio.given import Given

Kind = Literal["action", "prompt", "clip"]
KINDS: tuple[Kind, ...] = ("action", "prompt", "clip")
RATE = 20.0
"""Frames a second of clips."""
MOST_BLOCKS = 500
SHORTEST, LONGEST = 0.2, 600.0
"""Seconds of a block, and of the whole."""
LONGEST_TRANSITION = 5.0
"""Seconds."""
LONGEST_CLIP = 30.0
"""Seconds; a clip travels in the settings file as numbers."""
LONGEST_WORDS = 1000
_MAX_SEED = 2**31 - 1
_IN_NAME = 3


@dataclass(frozen=True)
class Block:
    """One thing that happens."""

    what: str
    """The action's name, what is to be seen in words, or the clip's name."""
    kind: Kind = "action"
    """Made of an action or of a prompt by an engine, or a clip that is there."""
    seconds: float = 3.0
    """How long, transitions aside; a clip is as long as it is."""
    style: str = ""
    """In which manner; empty: any."""
    seed: int = 7
    """Of the draw."""
    transition: float = 0.6
    """Seconds from the end of the block before to the start of this one; of no account in the first."""
    locked: bool = False
    """It stays as it is: new seeds and edits leave it alone."""
    engine: str = ""
    """Which makes it; empty: that of the sequence."""
    clip: Given | None = None
    """The frames of a clip."""
    begins: float = 0.0
    """Seconds into the draw, or the clip, that it was cut out of."""
    whole: float = 0.0
    """Seconds of that; 0: it is all of it."""
    id: str = ""
    """Tells blocks of one sequence apart; given by the sequence where it is empty."""

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise UnknownLabelError("kind of block", self.kind, KINDS)
        named = self.what.lower() if self.kind == "action" else self.what
        object.__setattr__(self, "what", " ".join(named.split()))
        if (self.clip is None) == (self.kind == "clip"):
            raise MotionloomError("a block of the kind clip, and no other, holds a clip.")
        if self.clip is not None and self.seconds >= SHORTEST:
            object.__setattr__(self, "seconds", round(self.clip.frames / self.clip.fps, 2))
        if not self.what:
            raise OutOfRangeError("what a block shows", self.what, "an action or a description")
        if len(self.what) > LONGEST_WORDS:
            raise OutOfRangeError("length of the description", len(self.what), f"up to {LONGEST_WORDS:,} characters")
        longest = LONGEST if self.clip is None else LONGEST_CLIP
        if not SHORTEST <= self.seconds <= longest:
            raise OutOfRangeError("seconds", self.seconds, f"{SHORTEST:g} to {longest:g}")
        if not 0 <= self.transition <= LONGEST_TRANSITION:
            raise OutOfRangeError("transition", self.transition, f"0 to {LONGEST_TRANSITION:g} seconds")
        demand_whole("seed", self.seed, 0, _MAX_SEED)
        if not 0 <= self.whole <= LONGEST:
            raise OutOfRangeError("whole", self.whole, f"0 to {LONGEST:g} seconds")
        last = max(self.whole - self.seconds, 0.0)
        if not 0 <= self.begins <= last + 1e-6:
            raise OutOfRangeError("begins", self.begins, f"0 to {last:g}: a part of its draw, whose length is `whole`")

    @property
    def draw(self) -> tuple[Any, ...]:
        """What it is cut out of; the same of all parts of one draw."""
        return self.kind, self.what, self.style, self.seed, self.engine, self.whole or self.seconds

    def continues(self, before: Block) -> bool:
        """Is it the next part of the same draw?"""
        on = abs(before.begins + before.seconds - self.begins) < 1e-6
        return bool(self.begins) and not self.transition and on and self.draw == before.draw

    def frames(self, fps: float) -> int:
        """Its length at a rate."""
        return max(2, round(self.seconds * fps))

    @classmethod
    def of(cls, motion: Motion, name: str) -> Block:
        """A clip of a motion, of any skeleton and rate."""
        if motion.duration > LONGEST_CLIP:
            length, most = f"{motion.duration:.1f} s", f"up to {LONGEST_CLIP:g} s in a clip"
            raise OutOfRangeError(f"length of {name}", length, most)
        return cls(name, "clip", clip=Given.of(motion.retarget(SMPL22).face_front(), name, RATE))


@dataclass(frozen=True)
class Sequence:
    """Blocks, first to last."""

    blocks: tuple[Block, ...] = ()
    engine: str = ""
    """Which makes the actions that name none; empty: that of the settings."""

    def __post_init__(self) -> None:
        if len(self.blocks) > MOST_BLOCKS:
            raise OutOfRangeError("number of blocks", len(self.blocks), f"up to {MOST_BLOCKS}")
        object.__setattr__(self, "blocks", _named(self.blocks))
        if self.seconds > LONGEST + 1e-6:
            raise OutOfRangeError("length of the sequence", f"{self.seconds:.1f} s", f"up to {LONGEST:g} s")

    def __bool__(self) -> bool:
        return bool(self.blocks)

    @property
    def seconds(self) -> float:
        """How long it lasts, transitions included."""
        return sum(block.seconds for block in self.blocks) + sum(block.transition for block in self.blocks[1:])

    def frames(self, fps: float) -> int:
        """The same at a rate, block by block."""
        whole = sum(block.frames(fps) for block in self.blocks)
        return whole + sum(round(block.transition * fps) for block in self.blocks[1:])

    @property
    def subject(self) -> str:
        """What it shows, in a line."""
        said = ", then ".join(block.what for block in self.blocks[:_IN_NAME])
        more = len(self.blocks) - _IN_NAME
        return f"{said} and {more} more" if more > 0 else said

    def index(self, key: str) -> int:
        """Place of the block of that id.

        Raises:
            UnknownLabelError: there is none.
        """
        for place, block in enumerate(self.blocks):
            if block.id == key:
                return place
        raise UnknownLabelError("block", key, [block.id for block in self.blocks])

    def block(self, key: str) -> Block:
        """The block of that id; errors as `index`."""
        return self.blocks[self.index(key)]

    # ---- operations, each giving a new Sequence ------------------------------------------------------------

    def inserted(self, block: Block, at: int | None = None) -> Sequence:
        """With one more block, at a place or at the end; it gets an id of its own."""
        place = len(self.blocks) if at is None else min(max(at, 0), len(self.blocks))
        return self._of((*self.blocks[:place], replace(block, id=self._free_id()), *self.blocks[place:]))

    def removed(self, key: str) -> Sequence:
        """Without a block.

        Raises:
            MotionloomError: it is locked.
        """
        self._demand_open(key)
        return self._of(block for block in self.blocks if block.id != key)

    def moved(self, key: str, to: int) -> Sequence:
        """With a block at another place, counted without it."""
        block = self.block(key)
        rest = [other for other in self.blocks if other.id != key]
        rest.insert(min(max(to, 0), len(rest)), block)
        return self._of(rest)

    def duplicated(self, key: str) -> Sequence:
        """With a block twice, the second behind it and open to changes."""
        return self.inserted(replace(self.block(key), locked=False), self.index(key) + 1)

    def changed(self, key: str, **values: Any) -> Sequence:
        """With other values of a block; `locked` and `transition` of a locked one as well.

        What was cut out of a draw and becomes another is a draw of its own, with a transition into it.

        Raises:
            MotionloomError: it is locked, or a value is not accepted.
        """
        if set(values) - {"locked", "transition"}:
            self._demand_open(key)
        block = self.block(key)
        if block.clip is not None and values.get("seconds", 0) >= SHORTEST:
            values = {**values, "clip": _cut(block.clip, 0.0, values["seconds"])}
        elif block.whole and values.keys() & {"what", "kind", "style", "seed", "engine"}:
            again = {"transition": Block.transition} if block.begins and not block.transition else {}
            values = {**again, "begins": 0.0, "whole": 0.0, **values}
        elif block.whole and "seconds" in values:
            values = {**values, "whole": max(block.whole, round(block.begins + values["seconds"], 2))}
        return self._with(key, lambda block: (replace(block, **values),))

    def split(self, key: str, after: float) -> Sequence:
        """With a block in two: the same motion, until one of them becomes another.

        Args:
            key: of the block.
            after: seconds into it; to the frame.

        Raises:
            MotionloomError: it is locked, or a part would be too short.
        """
        self._demand_open(key)
        block = self.block(key)
        after = round(round(after * RATE) / RATE, 2)
        rest = round(block.seconds - after, 2)
        if after < SHORTEST or rest < SHORTEST:
            accepted = f"{SHORTEST:g} to {block.seconds - SHORTEST:.1f} s into the block"
            raise OutOfRangeError("place to split at", f"{after:.1f} s", accepted)
        clips = (None, None)
        if block.clip is not None:
            clips = (_cut(block.clip, 0.0, after), _cut(block.clip, after, block.seconds))
        part = replace(block, seconds=after, whole=block.whole or block.seconds, clip=clips[0])
        begins = round(block.begins + after, 2)
        other = replace(part, seconds=rest, begins=begins, clip=clips[1], transition=0.0, id=self._free_id())
        return self._with(key, lambda _: (part, other))

    def reseeded(self, seed: Callable[[Block], int]) -> Sequence:
        """With another seed for each block that an engine makes and that is not locked; parts of a draw stay one."""
        made: list[Block] = []
        for place, block in enumerate(self.blocks):
            on = place > 0 and block.continues(self.blocks[place - 1])
            fixed = block.locked or block.clip is not None
            made.append(block if fixed else replace(block, seed=made[-1].seed if on else seed(block) % _MAX_SEED))
        return self._of(made)

    def _of(self, blocks: Iterable[Block]) -> Sequence:
        """Other blocks, all else as it is."""
        return replace(self, blocks=tuple(blocks))

    def _with(self, key: str, change: Callable[[Block], tuple[Block, ...]]) -> Sequence:
        """With what becomes of one block."""
        place = self.index(key)
        return self._of((*self.blocks[:place], *change(self.blocks[place]), *self.blocks[place + 1 :]))

    def _demand_open(self, key: str) -> None:
        place = self.index(key)
        if self.blocks[place].locked:
            raise MotionloomError(f"block {place + 1} ({self.blocks[place].what}) is locked; unlock it first.")

    def _free_id(self) -> str:
        return str(1 + max((int(block.id) for block in self.blocks if block.id.isdigit()), default=0))

    # ---- as JSON --------------------------------------------------------------------------------------------

    def to_json(self) -> dict[str, Any]:
        """JSON values; what is as usual is left out."""
        blocks = {"blocks": [_tree(block) for block in self.blocks]} if self.blocks else {}
        return blocks | ({"engine": self.engine} if self.engine else {})

    @classmethod
    def from_json(cls, tree: object) -> Sequence:
        """What `to_json` gave.

        Raises:
            MotionloomError: an unknown key, or a value that is not accepted; the message says of which block.
        """
        if not isinstance(tree, Mapping) or not isinstance(tree.get("blocks", []), list):
            raise OutOfRangeError("sequence", type(tree).__name__, 'an object with a list of "blocks"')
        for key in tree:
            if key not in ("blocks", "engine"):
                raise UnknownLabelError("key of sequence", key, ["blocks", "engine"])
        entries, engine = tree.get("blocks", []), tree.get("engine", "")
        if not isinstance(engine, str):
            raise OutOfRangeError("engine of sequence", engine, 'a name, as in "multiact"')
        if "blocks" in tree and not 1 <= len(entries) <= MOST_BLOCKS:
            raise OutOfRangeError("number of blocks", len(entries), f"1 to {MOST_BLOCKS}")
        return cls(tuple(_block(number, entry) for number, entry in enumerate(entries, 1)), engine)


_KINDS_OF: dict[str, tuple[type, ...]] = {
    "seconds": (int, float), "transition": (int, float), "seed": (int,), "locked": (bool,), "clip": (dict,),
    "begins": (int, float), "whole": (int, float),
}  # fmt: skip
"""What kind of value a key of a block takes, where it is no text."""
_USUAL = {f.name: f.default for f in fields(Block)}


def _block(number: int, tree: object) -> Block:
    if not isinstance(tree, Mapping):
        raise OutOfRangeError(f"block {number}", tree, "an object")
    for key, value in tree.items():
        if key not in _USUAL:
            raise UnknownLabelError(f"key of block {number}", key, _USUAL)
        wanted = _KINDS_OF.get(key, (str,))
        if not isinstance(value, wanted) or (isinstance(value, bool) and bool not in wanted):
            raise OutOfRangeError(f"{key} of block {number}", value, " or ".join(kind.__name__ for kind in wanted))
    if "what" not in tree:
        raise OutOfRangeError(f"what block {number} shows", "", 'an action or a description, as in {"what": "walk"}')
    try:
        clip = Given.from_json(tree["clip"]) if "clip" in tree else None
        return Block(**{**tree, "clip": clip})
    except MotionloomError as problem:
        raise MotionloomError(f"block {number}: {problem}") from None


def _tree(block: Block) -> dict[str, Any]:
    """The fields of a block that are not as usual."""
    held = {name: getattr(block, name) for name, usual in _USUAL.items() if getattr(block, name) != usual}
    if block.clip is not None:
        held.pop("seconds", None)
        held["clip"] = block.clip.to_json()
    return held


def _named(blocks: tuple[Block, ...]) -> tuple[Block, ...]:
    """Each with an id of its own."""
    taken: set[str] = set()
    made = []
    highest = max((int(block.id) for block in blocks if block.id.isdigit()), default=0)
    for block in blocks:
        if not block.id or block.id in taken:
            highest += 1
            block = replace(block, id=str(highest))  # noqa: PLW2901
        taken.add(block.id)
        made.append(block)
    return tuple(made)


def _cut(clip: Given, start: float, stop: float) -> Given:
    """A clip from one second to another."""
    frames = clip.motion[round(start * clip.fps) : round(stop * clip.fps)]
    return Given.of(frames, clip.source, clip.fps)


EMPTY = Sequence()
"""No blocks."""
