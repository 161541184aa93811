"""What engines make of takes: what lies between two, an action after another, other ways to go on, another manner.

`tasks.generate` comes here for settings that have `then`, `blend` or `given`, or that keep the start of a motion where
the engine knows that only as going on.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from engines import Motion
from engines.errors import Cancelled, MotionloomError
from studio.jobs import Cancel, Progress
from studio.settings import BLEND_STEPS, GenerateSettings


def goes_on(settings: GenerateSettings, engine: Any) -> bool:
    """Whether the settings keep the start of a motion and nothing else, for an engine that takes no other pins."""
    pinned = settings.constraints
    alone = len(pinned.kept) == 1 and not (pinned.path or pinned.pins or pinned.loop)
    able = "outpaint" in engine.capabilities and "constraints" not in engine.capabilities
    return able and alone and pinned.kept[0].at == 0 and not pinned.kept[0].parts


def make(
    settings: GenerateSettings, engine: Any, progress: Progress | None = None, cancel: Cancel | None = None
) -> list[Motion]:
    """The motions of settings with `then`, `blend` or `given`, or that go on from a start.

    Raises:
        MotionloomError: the engine cannot do that, or two such things are asked at once.
    """
    if settings.then and settings.blend:
        raise MotionloomError("a blend and a sequence of actions cannot be asked at once.")
    if settings.blend:
        return [between(settings, engine)[settings.blend_step]]
    if settings.given:
        return _restyled(settings, engine)
    if settings.then:
        return _in_turn(settings, engine, progress, cancel)
    return _onwards(settings, engine)


def between(settings: GenerateSettings, engine: Any) -> list[Motion]:
    """All `BLEND_STEPS` motions from one end of a blend to the other.

    Raises:
        MotionloomError: the engine cannot blend, or something is pinned, or each is the best of several.
    """
    if settings.given:
        return _between_styles(settings, engine)
    _demand(engine, "interpolate", "go over from one draw to another")
    if settings.constraints:
        raise MotionloomError("what is pinned cannot be blended.")
    if settings.best_of > 1:
        raise MotionloomError(f"the best of {settings.best_of} draws cannot be blended; generate with best of 1.")
    told = _told(settings, engine)
    place = (settings.take or 1) - 1
    a = engine.latents(settings.action, settings.seed, settings.frames, place)
    b = engine.latents(settings.action, int(settings.blend["seed"]), settings.frames, int(settings.blend["take"]) - 1)
    return _scaled(engine.interpolate(settings.action or None, a, b, steps=BLEND_STEPS, **told), settings)


def _in_turn(settings: GenerateSettings, engine: Any, progress: Progress | None, cancel: Cancel | None) -> list[Motion]:
    _demand(engine, "transition", "change its action on the way")
    if settings.constraints:
        raise MotionloomError("what is pinned and a sequence of actions cannot be asked at once.")
    told = _told(settings, engine)
    parts = [(settings.action, settings.frames), *settings.then]
    made: list[Motion] = []
    for number in range(settings.count):
        if cancel is not None and cancel():
            raise Cancelled(f"cancelled after {number} of {settings.count} motions; none was kept")
        made.append(engine.transition(parts, seed=settings.seed + number, **told))
        if progress is not None:
            progress(number + 1, settings.count)
    return _scaled(made, settings)


def _onwards(settings: GenerateSettings, engine: Any) -> list[Motion]:
    told = _told(settings, engine)
    (start,) = settings.constraints.kept
    given = start.motion(engine.fps).labelled(start.source or "given")
    made = engine.outpaint(
        given, settings.action or None, keep=len(start), frames=settings.frames, count=settings.count,
        seed=settings.seed, **told,
    )  # fmt: skip
    return _scaled(made, settings)


def _restyled(settings: GenerateSettings, engine: Any) -> list[Motion]:
    """The motion given, in another manner."""
    from studio import tasks

    _demand(engine, "stylise", "put a motion in another manner")
    assert settings.given is not None
    told = tasks.told(settings, engine, without=("prompt",))
    made = engine.stylise(settings.given.motion, count=settings.count, seed=settings.seed, **told)
    shown = settings.action or settings.prompt
    return [motion.replaced(provenance=replace(motion.provenance, prompt=shown)) for motion in made]


def _between_styles(settings: GenerateSettings, engine: Any) -> list[Motion]:
    """The motion given, in all manners from that of one draw to that of another."""
    _demand(engine, "stylise", "put a motion in another manner")
    assert settings.given is not None
    if settings.like or settings.tempo or settings.strength != 1.0:
        raise MotionloomError("between two styles there is no other reference, strength or tempo.")
    to = settings.blend
    second = replace(settings, style=to.get("style", ""), seed=int(to["seed"]), take=int(to["take"]), blend={})
    ends = [replace(settings, blend={}), second]
    draws = [_restyled(end, engine)[(end.take or 1) - 1] for end in ends]
    codes = [engine.style_code(draw) for draw in draws]
    styles = [end.style for end in ends if end.style]
    made = engine.interpolate_styles(settings.given.motion, *codes, steps=BLEND_STEPS, style=styles)
    return [draws[0], *made[1:-1], draws[1]]


def _told(settings: GenerateSettings, engine: Any) -> dict[str, Any]:
    from studio import tasks

    return tasks.told(settings, engine, without=("bone_scale", "best_of", "constraints"))


def _demand(engine: Any, capability: str, words: str) -> None:
    if capability not in engine.capabilities:
        raise MotionloomError(f"{engine.name} cannot {words}; `motionloom info {engine.name}` shows what it can do.")


def _scaled(motions: list[Motion], settings: GenerateSettings) -> list[Motion]:
    return [motion.scale_bones(settings.bone_scale) for motion in motions] if settings.bone_scale else motions
