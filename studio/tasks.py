"""What the app and the command line both do, written once: generate by settings, measure, export by settings.

The same settings therefore give the identical motion and file from either.
"""

from __future__ import annotations

import re
import threading
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import engines
from engines import Motion
from studio.jobs import Cancel, Progress
from studio.settings import VIDEO_FORMATS, ExportSettings, GenerateSettings, format_of

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
        UnknownLabelError: the engine or the action is not known.
        OutOfRangeError: more frames than the engine can do.
        Cancelled: `cancel()` said so.
    """
    engine = load_engine(settings.engine, settings.variant)
    extra: dict[str, Any] = {"bone_scale": dict(settings.bone_scale)} if settings.bone_scale else {}
    motions = engine.generate_many(
        settings.action,
        count=settings.count,
        frames=settings.frames,
        seed=settings.seed,
        progress=progress,
        cancel=cancel,
        **extra,
    )
    return list(motions) if settings.take is None else [motions[settings.take - 1]]


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
    if format_of(path) not in VIDEO_FORMATS:
        return (motion.resample(settings.fps) if settings.fps else motion).write(path)
    import viewers

    return viewers.render(
        motion,
        path,
        width=settings.width,
        height=settings.height,
        fps=settings.fps,
        camera=settings.camera,
        progress=progress,
        cancel=cancel,
    )


def slug(text: str) -> str:
    """A text as part of a file name: "wave left hand" -> "wave-left-hand"."""
    return re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-") or "motion"
