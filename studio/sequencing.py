"""A sequence made: each block by its engine, a transition to the next, all set down one behind the other.

A block depends on nothing but itself, and a transition on the end of one block and the start of the next. Both are kept
for a while, so that after a change only what depends on it is made again. `pieces` holds two blocks at a time.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from engines import SMPL22, Motion, Provenance, Segment
from engines.errors import Cancelled, MotionloomError, UnknownLabelError
from engines.geometry.seams import join
from studio.jobs import Cancel, Progress
from studio.library.motions import Cache
from studio.sequence import EMPTY, RATE, Block
from studio.settings import GenerateSettings, usual_engine

SEEN = 20
"""Frames of both blocks that a transition is made between."""
_STEADY = 0.4
"""Seconds over which heading and speed at an end are averaged: a step sways."""
_FLOOR = np.array([1.0, 0.0, 1.0])
"""Times a place is that place on the floor."""

at_hand = Cache(64 * 2**20)
"""Blocks and transitions made last, by what they depend on."""


def make(settings: GenerateSettings, progress: Progress | None = None, cancel: Cancel | None = None) -> list[Motion]:
    """The motions of settings with a sequence; of draw i the seed of every block that is not locked is i higher.

    Raises:
        MotionloomError: a block asks for what its engine does not know or cannot do; the message says which.
        Cancelled: `cancel()` said so.
    """
    demand(settings)
    wanted = range(settings.count) if settings.take is None else (settings.take - 1,)
    total, done = len(wanted) * len(settings.sequence.blocks), 0
    made: list[Motion] = []
    for draw in wanted:
        varied = replace(settings, sequence=settings.sequence.reseeded(lambda block, by=draw: block.seed + by))
        parts: list[Motion] = []
        for part in pieces(varied):
            if cancel is not None and cancel():
                raise Cancelled("the sequence was cancelled; nothing of it was kept.")
            parts.append(part)
            done += part.labels[0].kind != "transition"
            if progress is not None:
                progress(done, total)
        made.append(_whole(parts, settings, draw))
    return made


def demand(settings: GenerateSettings) -> None:
    """Check all blocks before any is made.

    Raises:
        MotionloomError: see `make`.
    """
    from studio import tasks

    for number, block in enumerate(settings.sequence.blocks, 1):
        if block.clip is not None:
            continue
        engine = tasks.load_engine(*_engine(block, settings))
        try:
            known = [action.name for action in engine.actions]
            if block.kind == "action" and block.what not in known:
                raise UnknownLabelError("action", block.what, known)
            tasks.told(_asked(block, settings), engine)
        except MotionloomError as problem:
            raise MotionloomError(f"block {number}: {problem}") from None


def pieces(settings: GenerateSettings) -> Iterator[Motion]:
    """Blocks and transitions one after the other, each where it belongs in the world; begins at the origin, facing +Z.

    Transitions of no length are left out. No more than two blocks are held at a time.
    """
    yaw, place = 0.0, np.zeros(3)
    before: Motion | None = None
    named = ""
    for block in settings.sequence.blocks:
        motion = _block(block, settings)
        if before is not None:
            gap = round(block.transition * RATE)
            turn, shift = _led(before, motion, gap)
            led = _placed(motion, turn, shift)
            if gap:
                label = Segment(0, gap, "transition", f"{named} > {block.what}")
                between = _transition(before, led, gap, block.seed, settings)
                yield _placed(between.replaced(labels=(label,)), yaw, place)
            else:
                led = join(before[-2:], led)[min(2, len(before)) :]
                motion = led.moved(tuple(-shift)).moved(yaw=-turn)
            # from the frame of the block before to that of this one
            yaw, place = yaw + turn, _turned(shift, yaw) + place
        yield _placed(motion, yaw, place)
        before, named = motion, block.what


def _whole(parts: list[Motion], settings: GenerateSettings, draw: int) -> Motion:
    """One motion of all parts, with what made it."""
    from studio import tasks

    engine = tasks.load_engine(settings.engine, settings.variant)
    whole = parts[0].concat(*parts[1:])
    told = {"blocks": [[block.what, block.frames(whole.fps)] for block in settings.sequence.blocks]}
    origin = Provenance(engine.name, engine.weights_hash, settings.subject, settings.seed, draw, told)
    made = whole.replaced(provenance=origin)
    return made.scale_bones(settings.bone_scale) if settings.bone_scale else made


# ---- blocks -----------------------------------------------------------------------------------------------


def _once(key: str, make: Callable[[], Motion]) -> Motion:
    """What was made under that key, or is made now."""
    motion = at_hand.get(key)
    if motion is None:
        motion = make()
        at_hand.put(key, motion)
    return motion


def _engine(block: Block, settings: GenerateSettings) -> tuple[str, str]:
    """Name and variant of the engine that makes a block."""
    return (block.engine, "") if block.engine else (settings.engine, settings.variant)


def _asked(block: Block, settings: GenerateSettings) -> GenerateSettings:
    """What an engine is told of a block: what a take of it alone would be made by."""
    from studio import tasks

    name, variant = _engine(block, settings)
    return replace(
        settings, engine=name, variant=variant, sequence=EMPTY, action=block.what if block.kind == "action" else "",
        prompt=block.what if block.kind == "prompt" else "", style=block.style or settings.style,
        frames=block.frames(tasks.load_engine(name, variant).fps), seed=block.seed, count=1, take=None, bone_scale={},
    )  # fmt: skip


def _block(block: Block, settings: GenerateSettings) -> Motion:
    """A block's motion: on smpl22 at `RATE`, from the origin on, facing +Z, under its own labels."""
    from studio import tasks

    if block.clip is not None:
        motion = _fronted(block.clip.motion)
    else:
        asked = _asked(block, settings)
        motion = _once(repr(asked), lambda: _fronted(tasks.generate(asked)[0]))
    labels = [Segment(0, len(motion), "text" if block.kind == "prompt" else "action", block.what)]
    labels += [Segment(0, len(motion), "style", block.style)] if block.style else []
    return motion.replaced(labels=tuple(labels))


def _fronted(motion: Motion) -> Motion:
    """On smpl22 at `RATE`, from the origin on, facing +Z."""
    house = motion.retarget(SMPL22).resample(RATE)
    turned = house.moved(yaw=-_yaw(house, first=True))
    return turned.moved(tuple(-turned.positions[0, 0] * _FLOOR))


def _placed(motion: Motion, yaw: float, place: np.ndarray) -> Motion:
    return motion.moved(tuple(place), yaw)


def _turned(vector: np.ndarray, yaw: float) -> np.ndarray:
    """(3,) about the vertical."""
    cos, sin = np.cos(yaw), np.sin(yaw)
    return np.array([cos * vector[0] + sin * vector[2], vector[1], cos * vector[2] - sin * vector[0]])


def _yaw(motion: Motion, first: bool) -> float:
    """Where the body faces at its first or last frames."""
    count = max(1, round(_STEADY * motion.fps))
    part = motion[:count] if first else motion[-count:]
    return float(np.unwrap(part.heading).mean())


def _speed(motion: Motion, first: bool) -> np.ndarray:
    """(3,) metres a frame over the floor at the first or last frames."""
    count = max(1, min(round(_STEADY * motion.fps), len(motion) - 1))
    roots = motion.positions[:, 0] * _FLOOR
    if len(motion) == 1:
        return np.zeros(3)
    return (roots[count] - roots[0] if first else roots[-1] - roots[-1 - count]) / count


# ---- transitions ------------------------------------------------------------------------------------------


def _led(before: Motion, after: Motion, gap: int) -> tuple[float, np.ndarray]:
    """Yaw and (3,) shift that bring `after` where `before` leads in so many frames: it faces as that does, and stands
    as far on as both go meanwhile.
    """
    turn = _yaw(before, first=False) - _yaw(after, first=True)
    way = (_speed(before, first=False) + _turned(_speed(after, first=True), turn)) / 2 * (gap + 1)
    return turn, before.positions[-1, 0] * _FLOOR + way - _turned(after.positions[0, 0] * _FLOOR, turn)


def _transition(before: Motion, after: Motion, gap: int, seed: int, settings: GenerateSettings) -> Motion:
    """What lies between two blocks: `gap` frames by an engine that makes a motion between what is pinned."""
    tail, head = before[-SEEN:].replaced(labels=()), after[:SEEN].replaced(labels=())
    held = [tail.rotations, tail.translation, head.rotations, head.translation]
    seen = hashlib.sha256(b"".join(np.round(array, 6).tobytes() for array in held)).hexdigest()
    key = f"{settings.engine} {settings.variant} {seed} {gap} {seen}"
    return _once(key, lambda: _joined(tail, head, gap, seed, settings))


def _joined(tail: Motion, head: Motion, gap: int, seed: int, settings: GenerateSettings) -> Motion:
    """What lies between two stretches, without a jump at either."""
    engine = _between_engine(settings)
    made = _eased(tail, head, gap) if engine is None else _invented(engine, tail, head, gap, seed)
    # at either end it takes over the pose and the speed there, exactly
    made = _backward(join(_backward(head), _backward(made))[len(head) :])
    return join(tail, made)[len(tail) :]


def _between_engine(settings: GenerateSettings) -> Any | None:
    """Who makes transitions: the engine of the sequence if it can be told what lies around, else the usual one."""
    from studio import tasks

    for name, variant in ((settings.engine, settings.variant), (usual_engine(), "")):
        engine = tasks.load_engine(name, variant)
        if "constraints" in engine.capabilities:
            return engine
    return None


def _invented(engine: Any, tail: Motion, head: Motion, gap: int, seed: int) -> Motion:
    """Frames an engine makes between two stretches it is told."""
    from engines.loom.constraints import Constraints, Keep

    around = Constraints(kept=(Keep(tail), Keep(head, len(tail) + gap)))
    frames = len(tail) + gap + len(head)
    # told nothing of what is done, so there is nothing to be guided to
    free = {"guidance": 1.0} if "guidance" in engine.capabilities else {}
    (made,) = engine.generate_many(None, count=1, frames=frames, seed=seed, constraints=around, **free)
    return made[len(tail) : len(tail) + gap].replaced(labels=())


def _eased(tail: Motion, head: Motion, gap: int) -> Motion:
    """The first pose of what comes, moved there: what is apart dies away at the seam."""
    share = ((np.arange(gap) + 1) / (gap + 1))[:, None]
    path = tail.translation[-1] * (1 - share) + head.translation[0] * share
    return head.replaced(rotations=np.repeat(head.rotations[:1], gap, axis=0), translation=path)


def _backward(motion: Motion) -> Motion:
    return motion.replaced(rotations=motion.rotations[::-1], translation=motion.translation[::-1], labels=())
