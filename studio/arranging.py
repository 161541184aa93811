"""What happens when a person arranges blocks on the timeline."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from engines.errors import MotionloomError, OutOfRangeError
from studio.sequence import EMPTY, Block, Sequence
from studio.sequencing import depends
from studio.settings import GenerateSettings

if TYPE_CHECKING:
    from studio.session import Session

SEEDS = 10_000
_EDITABLE = {
    "what": str, "kind": str, "style": str, "engine": str, "seconds": float, "transition": float, "seed": int,
}  # fmt: skip
"""What the timeline may change of a block, and as what it is read."""


class Arranging:
    """The timeline of one session.

    What the project holds comes through `follow`; what a person does goes to the project as a step and comes back the
    same way, so that undo needs nothing of its own. A take that was made of a sequence shows its blocks when it is
    picked; the project's own come back with another take, and the first change makes those of the take its own.

    Args:
        session: whose state is changed; why something cannot be done is said in `state.sequence_error`.
    """

    def __init__(self, session: Session) -> None:
        self.session = session
        self._said: Mapping[str, Any] = {}
        """What the project held last."""
        self._own = EMPTY
        """The same, read."""
        self._asked = EMPTY
        """What is being made, or was last."""
        session.state.param.watch(self._picked, "selected")
        session.state.param.watch(self._making, "generating")

    # ---- what a person does -------------------------------------------------------------------------------

    def act(self, message: Mapping[str, Any]) -> None:
        """Do what the timeline reports: `{"do": "split", "id": "3", "after": 1.5}`."""
        acts: dict[str, Callable[[Mapping[str, Any]], None]] = {
            "add": self.add, "move": self.move, "change": self.change, "split": self.split, "remove": self.remove,
            "duplicate": self.duplicate, "renew": self.renew, "lock": self.lock,
        }  # fmt: skip
        act = acts.get(str(message.get("do")))
        if act is not None:
            act(message)
        self.session.state.heard += 1

    def add(self, message: Mapping[str, Any]) -> None:
        """A block `what` of a `kind`; `at` a place, or behind the picked block. Of a clip, `take` is the take's id."""
        state = self.session.state

        def put(now: Sequence) -> Sequence:
            behind = now.index(state.block) + 1 if self._there(state.block) else len(now.blocks)
            at = int(message["at"]) if message.get("at") is not None else behind
            return now.inserted(self._new(message), at)

        before = {block.id for block in state.sequence.blocks}
        self._change(f"add {str(message.get('what') or 'a clip')[:40]}", put)
        made = [block.id for block in state.sequence.blocks if block.id not in before]
        if made:
            state.block = made[0]

    def move(self, message: Mapping[str, Any]) -> None:
        """A block to another place, `to`."""
        self._on(message, "move", lambda now, key: now.moved(key, int(message["to"])))

    def change(self, message: Mapping[str, Any]) -> None:
        """Other `values` of a block."""

        def put(now: Sequence, key: str) -> Sequence:
            return now.changed(key, **{name: _read(name, value) for name, value in message["values"].items()})

        self._on(message, "change", put)

    def split(self, message: Mapping[str, Any]) -> None:
        """A block in two, `after` so many seconds."""
        self._on(message, "split", lambda now, key: now.split(key, float(message["after"])))

    def remove(self, message: Mapping[str, Any]) -> None:
        """A block away; the next one is picked."""
        state = self.session.state
        place = state.sequence.index(str(message["id"])) if self._there(str(message["id"])) else 0
        self._on(message, "delete", lambda now, key: now.removed(key))
        left = state.sequence.blocks
        if state.block not in {block.id for block in left}:
            state.block = left[min(place, len(left) - 1)].id if left else ""

    def duplicate(self, message: Mapping[str, Any]) -> None:
        """A block once more, behind itself."""
        self._on(message, "duplicate", lambda now, key: now.duplicated(key))

    def lock(self, message: Mapping[str, Any]) -> None:
        """Lock a block, or unlock it."""
        locked = self._there(str(message["id"])) and self.session.state.sequence.block(str(message["id"])).locked
        self._on(message, "unlock" if locked else "lock", lambda now, key: now.changed(key, locked=not locked))

    def renew(self, message: Mapping[str, Any]) -> None:
        """Another seed for a block, or for all that are not locked where no `id` is said; and the sequence made."""
        if message.get("id"):
            done = self._on(message, "regenerate", lambda now, key: now.changed(key, seed=random.randrange(SEEDS)))
        else:
            done = self._change("new seeds", lambda now: now.reseeded(lambda _: random.randrange(SEEDS)))
        if done:
            self.make()

    def clear(self) -> None:
        """All blocks away."""
        self._change("clear the timeline", lambda now: replace(now, blocks=()))

    def by(self, engine: str) -> None:
        """Another engine for the actions that name none; empty: that of the other tabs."""
        if engine != self.session.state.sequence.engine:
            self._change(f"actions by {engine or self.session.state.engine}", lambda now: replace(now, engine=engine))

    def make(self) -> None:
        """Make the sequence."""
        self.session.state.compose_tab = "sequence"
        self.session.generate()

    def again(self, made: GenerateSettings) -> GenerateSettings:
        """The settings of a take with other seeds for its blocks, but for those locked."""
        return replace(made, sequence=made.sequence.reseeded(lambda _: random.randrange(SEEDS)), take=None)

    def _new(self, message: Mapping[str, Any]) -> Block:
        """The block that is to be added."""
        if message.get("kind") == "clip":
            take = self.session.state.take(str(message.get("take", "")))
            motion = self.session.editing.motion(take) if take else None
            if take is None or motion is None:
                raise MotionloomError("pick a take first; a clip is made of it.")
            return Block.of(motion, take.title.lower())
        told = {name: _read(name, message[name]) for name in _EDITABLE if message.get(name) is not None}
        return Block(**{"seed": random.randrange(SEEDS), "what": "", **told})

    def _there(self, key: str) -> bool:
        return any(block.id == key for block in self.session.state.sequence.blocks)

    def _on(self, message: Mapping[str, Any], verb: str, change: Callable[[Sequence, str], Sequence]) -> bool:
        """Change one block, named in the step by what it shows."""
        key = str(message.get("id", ""))
        shown = self.session.state.sequence.block(key).what if self._there(key) else "a block"
        return self._change(f"{verb} {shown[:40]}", lambda now: change(now, key))

    def _change(self, what: str, change: Callable[[Sequence], Sequence]) -> bool:
        """Put other blocks on the timeline, as one step; whether that could be done."""
        state = self.session.state
        try:
            made = change(state.sequence)
        except MotionloomError as problem:
            text = str(problem)
            state.sequence_error = text[:1].upper() + text[1:]
            return False
        self._said, self._own = made.to_json(), made
        self._show(made)
        self.session.takes.arrange(self._said, what)
        return True

    # ---- what is there to be shown ------------------------------------------------------------------------

    def enter(self) -> None:
        """A project was opened: the blocks it holds were worked on last, whichever take is picked."""
        take = self.session.state.take()
        if self._own:
            self._asked = take.settings.sequence if take and take.settings else EMPTY
            self._show(self._own)

    def follow(self) -> None:
        """Show the blocks that the project holds, if they are others than before."""
        said = self.session.takes.store.sequence
        if said == self._said:
            return
        self._said = said
        try:
            self._own = Sequence.from_json(said)
        except MotionloomError as problem:  # a later version wrote it
            self._own = EMPTY
            self.session.state.message = f"The timeline cannot be read: {problem}"
        self._show(self._own)

    def _picked(self, *_: Any) -> None:
        """A take was picked: its blocks are shown, unless they are those that were worked on since."""
        take = self.session.state.take()
        made = take.settings.sequence if take and take.settings else EMPTY
        self._show(made if made and made != self._asked else self._own)

    def _making(self, event: Any) -> None:
        if event.new and self.session.state.request == "sequence":
            self._asked = self.session.state.sequence

    def _show(self, sequence: Sequence) -> None:
        self.session.state.param.update(sequence=sequence, sequence_error="")


def _read(name: str, value: Any) -> Any:
    """What was typed for a field of a block.

    Raises:
        OutOfRangeError: no number where one is wanted.
    """
    kind = _EDITABLE.get(name)
    if kind is None:
        raise OutOfRangeError("field of a block", name, ", ".join(_EDITABLE))
    try:
        return kind(value)
    except (TypeError, ValueError):
        raise OutOfRangeError(name, value, "a number") from None


def as_shown(session: Session) -> dict[str, Any]:
    """What the timeline of the player shows; empty where there is nothing to arrange."""
    state = session.state
    take = state.take()
    made = take.settings.sequence.blocks if take and take.settings else ()
    if state.compose_tab != "sequence" and not made:
        return {}
    there = {cut for cuts in _cuts(take.settings) for cut in cuts} if take and take.settings and made else set()
    asked = replace(GenerateSettings(engine=state.engine, variant=state.variant), sequence=state.sequence)
    return {
        "blocks": [
            {
                "id": block.id, "kind": block.kind, "what": block.what, "seconds": block.seconds, "style": block.style,
                "seed": block.seed, "transition": block.transition, "locked": block.locked, "engine": block.engine,
                "made": not there.isdisjoint(cuts),
            }
            for block, cuts in zip(state.sequence.blocks, _cuts(asked), strict=True)
        ],
        "actions": [action.name for action in state.actions],
        "styles": list(state.styles),
        "engines": list(state.engines),
        "words": "text" in state.capabilities,
        "error": state.sequence_error,
        "heard": state.heard,
    }  # fmt: skip


def _cuts(settings: GenerateSettings) -> list[set[tuple[float, ...]]]:
    """Of each block its draw, as a number, with what it is of it: the part from one second to another, or all."""
    found = []
    for block, draw in zip(settings.sequence.blocks, depends(settings), strict=True):
        found.append({(draw, block.begins, block.seconds), (draw, 0.0, block.whole or block.seconds)})
    return found
