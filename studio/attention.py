"""Under the timeline of the picked take: which words each moment came from, and its motion tokens with their figures.

Engines that attend to words say what a motion of theirs looked at (`attention(motion)`); an engine with motion tokens
takes any motion apart (`tokens(motion)`) and shows each token by itself (`gallery(codes)`).
"""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from engines import SMPL22, Motion
from engines.errors import MotionloomError
from studio import captions, tasks
from studio.jobs import Job

if TYPE_CHECKING:
    from studio.session import Session
    from studio.takes import Take

AT_HAND = 32
"""Strips of takes that are kept."""
LONGEST = 60.0
"""Seconds of a motion that are taken apart; more would be too narrow to see."""
TALL = 2.2
"""Metres that a figure's box is high."""
TURN = math.radians(35)
"""How far figures are turned to show their depth."""


class Attention:
    """What stands under the timeline of one session, worked out off the page's thread.

    Args:
        session: `state.strips` follows its picked take; of `state.open_strips` only what is open is worked out.
        motion: a take's motion as it is shown; None where it cannot be.
    """

    def __init__(self, session: Session, motion: Callable[[Take], Motion | None]) -> None:
        self.session, self._motion = session, motion
        self._done: OrderedDict[tuple[Any, ...], dict[str, Any]] = OrderedDict()
        self._busy = False
        session.state.param.watch(self._look, ["selected", "edited", "takes", "open_strips", "generating"])

    def _look(self, *_: Any) -> None:
        state = self.session.state
        take = state.take()
        if take is None:
            state.strips = {}
            return
        opened = state.open_strips.split(",")
        key = (take.held, take.edits, "tokens" in opened, "all" in opened)
        if key in self._done:
            self._done.move_to_end(key)
            state.strips = self._done[key]
            return
        if self._busy or state.generating:
            return
        shown = self._motion(take)
        if shown is None:
            return
        self._busy = True
        if not any(other[:2] == key[:2] for other in self._done):
            state.strips = {}  # those of another take

        def show(job: Job) -> None:
            if not job.finished:
                return
            self._busy = False
            self._done[key] = job.result or {}
            while len(self._done) > AT_HAND:
                self._done.popitem(last=False)
            self._look()  # another take was picked meanwhile, or this one

        self.session.submit("strips", lambda *_: strips(take, shown, *key[2:]), show, lane="caption")


def strips(take: Take, shown: Motion, tokens: bool, every: bool) -> dict[str, Any]:
    """What a player's `strips` shows of a take.

    Args:
        take: which take.
        shown: its motion, edits and all.
        tokens: whether they are looked at; else they are only offered, where an engine has them.
        every: whether the figures are of all tokens there are, not only of those of this motion.
    """
    made = {}
    if take.settings is not None and take.motion.provenance.prompt and not take.settings.sequence:
        engine = tasks.load_engine(take.settings.engine, take.settings.variant)
        if "word_attention" in engine.capabilities:
            made["words"] = word_heat(engine, take.motion)
    engine = captions.captioner()
    if engine is not None and "tokens" in engine.capabilities:
        made["tokens"] = token_strip(engine, shown, every) if tokens else {}
    return {name: value for name, value in made.items() if value is not None}


def word_heat(engine: Any, motion: Motion) -> dict[str, Any] | None:
    """Words and how much each step of a motion looked at them; None where the engine does not know that of it."""
    try:
        found = engine.attention(motion)
    except MotionloomError:  # made with other weights, or by a network that attends otherwise
        return None
    text, columns = whole_words(found.words)
    weights = np.stack([found.weights[:, list(pieces)].sum(axis=1) for pieces in columns], axis=1)
    return {"text": text, "weights": weights.round(3).tolist(), "seconds": found.frames / engine.fps}


def whole_words(pieces: Sequence[str]) -> tuple[list[str], list[list[int]]]:
    """Words of pieces of words ("##" begins what belongs to the piece before), and which pieces each is made of.

    Marks of start and end, which are empty, and full stops and commas are left out.
    """
    words: list[str] = []
    places: list[list[int]] = []
    for place, piece in enumerate(pieces):
        if piece.startswith("##") and words:
            words[-1] += piece[2:]
            places[-1].append(place)
        elif any(letter.isalnum() for letter in piece):
            words.append(piece)
            places.append([place])
    return words, places


def token_strip(engine: Any, motion: Motion, every: bool = False) -> dict[str, Any]:
    """Motion tokens of a motion, and figures of them, or of all tokens there are."""
    codes = engine.tokens(motion[: round(LONGEST * motion.fps)]).tolist()
    known = engine.gallery(None if every else list(dict.fromkeys(codes)))
    points = dict(zip(map(str, known.codes.tolist()), flat(known.positions).tolist(), strict=True))
    figures = {"parents": list(SMPL22.parents), "head": SMPL22.index("head"), "points": points}
    return {
        "codes": codes,
        "seconds": known.positions.shape[1] / engine.fps,
        "all": engine.config.codes,
        "figures": figures,
    }


def flat(positions: np.ndarray) -> np.ndarray:
    """Joints (K, F, J, 3), metres, seen a little from the side: (K, F, 2 J) int, x and y in turn, 0 to 100 of a box."""
    x = positions[..., 0] * math.cos(TURN) + positions[..., 2] * math.sin(TURN)
    middle = x[:, :, :1].mean(axis=1, keepdims=True)
    seen = np.stack([50 + (x - middle) * 100 / TALL, 4 + positions[..., 1] * 100 / TALL], axis=-1)
    return np.clip(seen.round(), 0, 100).astype(int).reshape(*seen.shape[:2], -1)
