"""What the app and the command line both do, written once: generate by settings, measure, export by settings.

The same settings therefore give the identical motion and file from either.
"""

from __future__ import annotations

import re
import threading
from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import engines
from engines import Motion
from engines.errors import Cancelled, MotionloomError
from studio import variations
from studio.jobs import Cancel, Progress
from studio.settings import USUAL_FRAMES, VIDEO_FORMATS, ExportSettings, GenerateSettings, format_of

ASKED = {
    "scale_bones": ("bone_scale", "lengths of bones"),
    "styles": ("style", "style"),
    "text": ("prompt", "prompt"),
    "guidance": ("guidance", "strength of guidance"),
    "best_of": ("best_of", "choice of the best of several"),
    "constraints": ("constraints", "pins (poses, frames, a path, joints, a loop)"),
    "references": ("like", "motion whose manner to take"),
    "stylise": ("strength", "strength of a style"),
    "tempo": ("tempo", "tempo of a style"),
}
"""Capability -> setting that needs it, and what that is in words."""
_ALWAYS = ("guidance", "best_of")  # numbers that make the motion, whatever an engine's own defaults are

_engines: dict[tuple[str, str], Any] = {}
_loading = threading.Lock()


def load_engine(name: str, variant: str = "") -> Any:
    """An engine with its weights, loaded once a process and shared by all sessions."""
    with _loading:
        if (name, variant) not in _engines:
            options = {"variant": variant} if variant else {}
            engine = engines.load(name, **options)
            # the usual variant is asked for with and without its name
            _engines[name, variant] = _engines.setdefault((name, engine.variant), engine)
        return _engines[name, variant]


def generate(
    settings: GenerateSettings, progress: Progress | None = None, cancel: Cancel | None = None
) -> list[Motion]:
    """The motions the settings describe, in one batched pass.

    With `settings.take` only that one is returned; the whole draw is still made, since a motion of a batch of
    another size would differ in its last bits.

    Raises:
        UnknownLabelError: the engine, the action or the style is not known.
        OutOfRangeError: more frames than the engine can do.
        MotionloomError: something is asked that the engine cannot do, or that contradicts itself.
        Cancelled: `cancel()` said so.
    """
    if settings.sequence:
        from studio import sequencing

        return sequencing.make(settings, progress, cancel)
    return generate_with(load_engine(settings.engine, settings.variant), settings, progress, cancel)


def generate_with(
    engine: Any, settings: GenerateSettings, progress: Progress | None = None, cancel: Cancel | None = None
) -> list[Motion]:
    """The same of an engine that is there; errors as `generate`."""
    settings = _with_length(settings, engine)
    if settings.then or settings.blend or settings.given or variations.goes_on(settings, engine):
        motions = variations.make(settings, engine, progress, cancel)
        return motions if settings.take is None or settings.blend else [motions[settings.take - 1]]
    if not hasattr(engine, "generate_many"):
        raise MotionloomError(f"{engine.name} only changes motions; give it one, as `motionloom stylize` does.")
    extra = told(settings, engine)
    motions = engine.generate_many(
        settings.action or None,
        count=settings.count,
        frames=settings.frames,
        seed=settings.seed,
        progress=progress,
        cancel=cancel,
        **extra,
    )
    return list(motions) if settings.take is None else [motions[settings.take - 1]]


def expected_frames(settings: GenerateSettings, engine: Any) -> int:
    """Frames that each motion of the settings will have, before what follows; 0 where only its making tells.

    Raises:
        MotionloomError: the engine does not know the action or cannot read the prompt.
    """
    if settings.frames is not None:
        return settings.frames
    if "lengths" not in engine.capabilities:
        return USUAL_FRAMES
    find = getattr(engine, "expected_frames", None)
    return find(settings.action or None, settings.prompt or None) if find else 0


def _with_length(settings: GenerateSettings, engine: Any) -> GenerateSettings:
    """The settings, with a length where the engine finds none itself, or not of what is asked."""
    parts = settings.then or settings.blend or settings.constraints
    if "lengths" in engine.capabilities and not parts:
        return settings
    return replace(settings, frames=expected_frames(settings, engine) or USUAL_FRAMES)


def between(settings: GenerateSettings) -> list[Motion]:
    """All motions from one end of the settings' blend to the other; errors as `generate`."""
    engine = load_engine(settings.engine, settings.variant)
    return variations.between(_with_length(settings, engine), engine)


def told(settings: GenerateSettings, engine: Any, without: Collection[str] = ()) -> dict[str, Any]:
    """What an engine is told beyond action, count, frames and seed: only what its capabilities have.

    Args:
        settings: what is asked.
        engine: who is asked.
        without: settings that are told in another way, or not at all.

    Raises:
        MotionloomError: something else was asked for.
    """
    usual = GenerateSettings(engine=settings.engine)
    extra: dict[str, Any] = {}
    for capability, (name, words) in ASKED.items():
        if name in without:
            continue
        value = getattr(settings, name)
        if capability in engine.capabilities:
            if value != getattr(usual, name) or name in _ALWAYS:
                extra[name] = value
        elif value != getattr(usual, name):
            raise MotionloomError(
                f"{engine.name} takes no {words}; `motionloom info {engine.name}` shows what it can do."
            )
    if "bone_scale" in extra:
        extra["bone_scale"] = dict(settings.bone_scale)
    if "constraints" in extra:
        extra["constraints"] = settings.constraints.to_engine(engine.fps)
    if "like" in extra:
        extra["like"] = settings.like and settings.like.motion
    return extra


def unmet(motion: Motion) -> list[str]:
    """What of the things pinned could not be met, in sentences."""
    said = motion.provenance.parameters.get("unmet", ())
    return [str(sentence) for sentence in said] if isinstance(said, list | tuple) else [str(said)]


def measure(motion: Motion) -> Mapping[str, float]:
    """The quality measures shown beside a take: foot skate (m/s), jitter (m/s³), ground penetration (m), ...

    Measured at 20 frames a second, as those of real clips are (jitter grows with the rate). None where the skeleton
    names no feet, which these measures look at.
    """
    from engines.metrics import physical

    return physical.summary(motion.resample(20.0)) if motion.skeleton.feet else {}


def export(
    motion: Motion,
    path: Path,
    settings: ExportSettings,
    progress: Progress | None = None,
    cancel: Cancel | None = None,
) -> Path:
    """Write one file, its format told by its name, by the settings. Returns the path."""
    motion, kind = edited(motion, settings), format_of(path)
    if kind not in VIDEO_FORMATS:
        if cancel is not None and cancel():
            raise Cancelled("the export was cancelled; no file was left.")
        played = motion.resample(settings.fps) if settings.fps else motion
        return _DRAWN[kind](played, path, _body(settings)) if kind in _DRAWN else played.write(path)
    import viewers

    return viewers.render(_scene(motion, settings), path, progress=progress, cancel=cancel, **_video(settings))


def export_pictures(
    motion: Motion,
    folder: Path,
    settings: ExportSettings,
    progress: Progress | None = None,
    cancel: Cancel | None = None,
) -> Path:
    """Write the frames of a video as numbered .png into a new folder, by the settings. Returns the folder."""
    from viewers import video

    scene = _scene(edited(motion, settings), settings)
    return video.render_pngs(scene, folder, progress=progress, cancel=cancel, **_video(settings))


def edited(motion: Motion, settings: ExportSettings) -> Motion:
    """The motion with the edits that the settings ask for."""
    from studio import edits

    return edits.apply(motion, settings.edits) if settings.edits else motion


def _video(settings: ExportSettings) -> dict[str, Any]:
    """What a renderer of videos is told."""
    return {name: getattr(settings, name) for name in ("width", "height", "fps", "camera", "views")}


def _body(settings: ExportSettings) -> Any:
    """The body that a file shows; errors as `viewers.bodies.wanted`."""
    from viewers import bodies

    return bodies.wanted(settings.body or None, settings.shape)


def _scene(motion: Motion, settings: ExportSettings) -> Any:
    """What a video shows."""
    from viewers import Scene

    return Scene.of(motion, body=_body(settings))


def write_skinned(motion: Motion, path: Path, body: Any = None) -> Path:
    """Write a motion as .glb with a body over it (the stick figure where the default body cannot wear it).

    Raises:
        FormatError: the file cannot be written.
        SkeletonError: that body cannot wear the motion.
    """
    from viewers import bodies

    worn, played = bodies.body_for(motion, body or bodies.DEFAULT)
    return played.write(path, skin=worn)


def write_strip(motion: Motion, path: Path, body: Any = None) -> Path:
    """Write poses of a motion side by side as .png, spread from its first frame to its last.

    Raises:
        FormatError: the file cannot be written.
        NoGraphicsError: no OpenGL here.
        SkeletonError: that body cannot wear the motion.
    """
    from viewers import bodies, strips

    return strips.write_strip(motion, path, body=body or bodies.DEFAULT)


_DRAWN: dict[str | None, Callable[[Motion, Path, Any], Path]] = {"glb": write_skinned, "png": write_strip}
"""Formats for which a viewer has to help, and that show a body."""


def slug(text: str) -> str:
    """A text as part of a file name: "wave left hand" -> "wave-left-hand"; a long one is cut."""
    return re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-")[:60].rstrip("-") or "motion"
