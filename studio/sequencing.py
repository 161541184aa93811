"""A sequence made: each block by its engine, a transition to the next, all set down one behind the other.

A block depends on nothing but itself, and a transition on the end of one block and the start of the next. A block of an
engine that goes on (`registry.SEQUENCERS`) depends on the end of what stands before it, and brings the transition
along. Each is kept for a while, so that after a change only what depends on it is made again. Parts of one draw are
made as one. `pieces` holds two draws at a time.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from engines import SMPL22, Motion, Provenance, Segment, registry
from engines.errors import Cancelled, MotionloomError, OutOfRangeError, UnknownLabelError
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
            if number > 1 and goes_on(block, settings) and block.transition > engine.longest_transition:
                accepted = f"0 to {engine.longest_transition:g} seconds into an action by {engine.name}"
                raise OutOfRangeError("transition", block.transition, accepted)
        except MotionloomError as problem:
            raise MotionloomError(f"block {number}: {problem}") from None


def pieces(settings: GenerateSettings) -> Iterator[Motion]:
    """Blocks and transitions one after the other, each where it belongs in the world; begins at the origin, facing +Z.

    Transitions of no length are left out. No more than two draws are held at a time.
    """
    yaw, place = 0.0, np.zeros(3)
    before: Motion | None = None
    named = ""
    for draw in draws(settings.sequence.blocks):
        gap = round(draw[0].transition * RATE)
        between: Motion | None = None
        if before is None:
            before = motion = _draw(draw, settings)
        elif goes_on(draw[0], settings):  # in the frame of what stands before
            made = _followed(before, draw, gap, settings)
            between, motion = made[:gap] if gap else None, made[gap:]
            before = before[-SEEN:].concat(made)
        else:
            alone = _draw(draw, settings)
            turn, shift = _led(before, alone, gap)
            led = _placed(alone, turn, shift)
            if gap:
                between = _back(_transition(before, led, gap, draw[0].seed, settings), turn, shift)
                motion = alone
            else:
                motion = _back(join(before[-2:], led)[min(2, len(before)) :], turn, shift)
            before = motion
            # from the frame of the draw before to that of this one
            yaw, place = yaw + turn, _turned(shift, yaw) + place
        if between is not None:
            label = Segment(0, gap, "transition", f"{named} > {draw[0].what}")
            yield _placed(between.replaced(labels=(label,)), yaw, place)
        start = 0
        for block in draw:
            stop = start + block.frames(RATE) if block is not draw[-1] else len(motion)
            yield _placed(motion[start:stop].replaced(labels=_labels(block, stop - start)), yaw, place)
            start, named = stop, block.what


def draws(blocks: Sequence[Block]) -> Iterator[list[Block]]:
    """Blocks, those together that are parts of one draw one behind the other."""
    together: list[Block] = []
    for block in blocks:
        if together and not block.continues(together[-1]):
            yield together
            together = []
        together.append(block)
    if together:
        yield together


def depends(settings: GenerateSettings) -> list[int]:
    """A number for each block that changes with whatever its draw depends on; cheap, no engine is asked."""
    found: list[int] = []
    blocks = settings.sequence.blocks
    for place, block in enumerate(blocks):
        before = blocks[place - 1] if place else None
        own = (block.draw, block.clip if block.clip and not block.whole else None, _engine(block, settings))
        if before is not None and block.continues(before):
            found.append(found[-1])
        elif before is not None and goes_on(block, settings):
            found.append(hash((own, block.transition, found[-1], before.begins + before.seconds)))
        else:
            found.append(hash(own))
    return found


def _whole(parts: list[Motion], settings: GenerateSettings, draw: int) -> Motion:
    """One motion of all parts, with what made it."""
    from studio import tasks

    engine = tasks.load_engine(*_usual(settings))
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


def _usual(settings: GenerateSettings) -> tuple[str, str]:
    """Name and variant of the engine that makes the actions of a sequence."""
    named = settings.sequence.engine
    return (named, "") if named not in ("", settings.engine) else (settings.engine, settings.variant)


def _engine(block: Block, settings: GenerateSettings) -> tuple[str, str]:
    """Name and variant of the engine that makes a block. One that goes on knows actions: words and styles are left to
    another.
    """
    usual = (block.engine, "") if block.engine else _usual(settings)
    told = block.kind == "prompt" or block.style or settings.style
    if block.engine or not told or usual[0] not in registry.SEQUENCERS:
        return usual
    own = (settings.engine, settings.variant)
    return (usual_engine(), "") if own[0] in registry.SEQUENCERS else own


def goes_on(block: Block, settings: GenerateSettings) -> bool:
    """Is a block made out of what stands before it?"""
    return block.clip is None and _engine(block, settings)[0] in registry.SEQUENCERS


def _asked(block: Block, settings: GenerateSettings) -> GenerateSettings:
    """What an engine is told of a block: what a take of all its draw would be made by."""
    from studio import tasks

    name, variant = _engine(block, settings)
    whole = replace(block, seconds=block.whole or block.seconds, begins=0.0)
    asked = replace(
        settings, engine=name, variant=variant, sequence=EMPTY, action=block.what if block.kind == "action" else "",
        prompt=block.what if block.kind == "prompt" else "", style=block.style or settings.style,
        frames=whole.frames(tasks.load_engine(name, variant).fps), seed=block.seed, count=1, take=None, bone_scale={},
    )  # fmt: skip
    if name == settings.engine:
        return asked
    usual = GenerateSettings(engine=name)  # how closely the sequence's own engine follows is nothing to another
    return replace(asked, guidance=usual.guidance, best_of=usual.best_of)


def _draw(blocks: Sequence[Block], settings: GenerateSettings) -> Motion:
    """Parts of one draw, or a block that is all of one, without labels: on smpl22 at `RATE`, from the origin on, facing
    +Z.
    """
    from studio import tasks

    clips = [block.clip.motion for block in blocks if block.clip is not None]
    if clips:
        return _fronted(clips[0].concat(*clips[1:])).replaced(labels=())
    asked = _asked(blocks[0], settings)
    motion = _once(repr(asked), lambda: _fronted(tasks.generate(asked)[0])).replaced(labels=())
    start = round(blocks[0].begins * RATE)
    return _fronted(motion[start : start + _frames(blocks)]) if blocks[0].whole else motion


def _followed(before: Motion, blocks: Sequence[Block], gap: int, settings: GenerateSettings) -> Motion:
    """Parts of one draw as they go on from what stands before, in its frame: `gap` frames of transition, the draw."""
    from studio import tasks

    # however far it has come, the same is asked of the same pose
    yaw, place = float(before.heading[-1]), before.positions[-1, 0] * _FLOOR
    seen = _back(before[-SEEN:].replaced(labels=()), yaw, place)
    name, variant = _engine(blocks[0], settings)
    whole, frames = blocks[0].whole if not blocks[0].begins else 0.0, _frames(blocks)
    asked = gap + max(frames, round(whole * RATE))

    def make() -> Motion:
        engine = tasks.load_engine(name, variant)
        told = {"seconds": asked / RATE, "seed": blocks[0].seed, "transition": max(gap, 1) / RATE}
        return engine.continue_from(seen, blocks[0].what, **told)[len(seen) :]

    made = _once(f"{name} {variant} {blocks[0].what} {blocks[0].seed} {gap} {asked} {_digest(seen)}", make)
    return _placed(made[: gap + frames], yaw, place)


def _frames(blocks: Sequence[Block]) -> int:
    return sum(block.frames(RATE) for block in blocks)


def _labels(block: Block, frames: int) -> tuple[Segment, ...]:
    labels = [Segment(0, frames, "text" if block.kind == "prompt" else "action", block.what)]
    return (*labels, *([Segment(0, frames, "style", block.style)] if block.style else []))


def _fronted(motion: Motion) -> Motion:
    """On smpl22 at `RATE`, from the origin on, facing +Z."""
    house = motion.retarget(SMPL22).resample(RATE)
    turned = house.moved(yaw=-_yaw(house, first=True))
    return turned.moved(tuple(-turned.positions[0, 0] * _FLOOR))


def _placed(motion: Motion, yaw: float, place: np.ndarray) -> Motion:
    return motion.moved(tuple(place), yaw)


def _back(motion: Motion, yaw: float, place: np.ndarray) -> Motion:
    """Out of where `_placed` set it."""
    return motion.moved(tuple(-place)).moved(yaw=-yaw)


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
    key = f"{settings.engine} {settings.variant} {seed} {gap} {_digest(tail, head)}"
    return _once(key, lambda: _joined(tail, head, gap, seed, settings))


def _digest(*motions: Motion) -> str:
    """Changes with poses and places."""
    held = [array for motion in motions for array in (motion.rotations, motion.translation)]
    return hashlib.sha256(b"".join((np.round(array, 6) + 0.0).tobytes() for array in held)).hexdigest()


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
