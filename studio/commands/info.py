"""`motionloom info`: what a file or an engine holds."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from engines.errors import UnknownLabelError


def info(
    what: Annotated[str | None, typer.Argument(metavar="FILE|ENGINE", help="Nothing: list the engines.")] = None,
) -> None:
    """Tell about a motion file, about an engine, or which engines there are.

    [bold]Examples[/bold]

    motionloom info

    motionloom info action2motion

    motionloom info walk.bvh
    """
    import engines
    from engines import registry

    known = {**engines.available(), **registry.captioners(), **registry.stylisers()}
    if what is None:
        for name, line in known.items():
            typer.echo(f"{name:<16}{line}")
    elif what in known:
        _engine(what)
    elif Path(what).suffix or Path(what).exists():
        _file(Path(what))
    else:
        raise UnknownLabelError("engine or file", what, known)


def _table(rows: dict[str, object]) -> None:
    for name, value in rows.items():
        typer.echo(f"{name:<20}{value}")


def _engine(name: str) -> None:
    from studio import tasks

    engine = tasks.load_engine(name)
    actions, styles = ([*getattr(engine, name, ())] for name in ("actions", "styles"))
    longest = f", up to {engine.max_frames:,} frames" if hasattr(engine, "max_frames") else ""
    _table(
        {
            "engine": engine.name,
            "variant": engine.variant,
            "description": engine.description,
            "capabilities": ", ".join(sorted(engine.capabilities)),
            **({"actions": f"{len(actions)}: {', '.join(a.name for a in actions)}"} if actions else {}),
            **({"styles": f"{len(styles)}: {', '.join(styles)}"} if styles else {}),
            "rate": f"{engine.fps:g} frames a second{longest}",
            "weights": engine.weights_hash,
            "licence": engine.licence,
        }
    )


def _file(path: Path) -> None:
    import engines
    from studio import tasks
    from studio.quality import measures

    motion = engines.read(path)
    rows: dict[str, object] = {
        "file": path,
        "skeleton": f"{motion.skeleton.name}, {len(motion.skeleton)} joints",
        "length": f"{motion.frames:,} frames at {motion.fps:g} a second, {motion.duration:.2f} s",
        "labels": ", ".join(dict.fromkeys(s.value for s in motion.labels)) or "none",
    }
    made = motion.provenance
    if made.source:
        rows["made by"] = made.source + (f", seed {made.seed}" if made.seed is not None else "")
    for sentence in tasks.unmet(motion):
        rows["not met"] = f"{rows['not met']} {sentence}" if "not met" in rows else sentence
    for measure in measures(tasks.measure(motion)):
        rows[measure.name.lower()] = measure.text
    _table(rows)
