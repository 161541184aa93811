"""The studio with quick stand-ins for an engine that takes styles, words and pins and describes motions, for one that
puts takes in other manners, and for what makes a character of a picture: `motionloom`'s own arguments.

What the engine is told goes, a line of JSON a draw, to the file that $MOTIONLOOM_TEST_TOLD names.
"""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from engines import Motion, registry
from engines.character import landmarks, making
from engines.character.character import Character
from engines.character.mesh import Surface
from engines.character.sighting import Sighting
from engines.loom.constraints import Constraints
from engines.tm2t.engine import Caption
from studio import cli, settings
from tests.studio.fakes import ConstrainedEngine, FakeStyliser
from viewers.bodies import Body

NAME = "stand-in"


class Telling(ConstrainedEngine):
    """Writes down what it is told, and says the same of every motion."""

    def caption_many(self, motions: Sequence[Motion], **_told: Any) -> list[list[Caption]]:
        return [[Caption("A person sways.", -0.5)] for _ in motions]

    def generate_many(self, action: str | None, **told: Any) -> list[Motion]:  # type: ignore[override]
        made = super().generate_many(action, **told)
        known = {key: value for key, value in told.items() if key not in ("progress", "cancel")}
        line = {"action": action, **known, "constraints": in_json(told.get("constraints"))}
        with Path(os.environ["MOTIONLOOM_TEST_TOLD"]).open("a", encoding="utf-8") as file:
            file.write(json.dumps(line) + "\n")
        return made


def in_json(constraints: Constraints | None) -> dict[str, Any]:
    """What was pinned, as far as the tests look at it."""
    if constraints is None:
        return {}
    return {
        "kept": [
            [keep.at, len(keep.motion), keep.motion.positions[0, 0].round(4).tolist()] for keep in constraints.kept
        ],
        "path": [] if constraints.path is None else np.asarray(constraints.path.points).tolist(),
        "pins": [[pin.joint, pin.frame, list(pin.position)] for pin in constraints.pins],
        "loop": constraints.loop,
    }


def build(seen: Sighting, template: Body, *, name: str, progress: Any, **_told: Any) -> Character:
    """The template itself, as wide as the hands are apart in the picture."""
    progress(0.5, "Fitting a body")
    across = abs(np.subtract(*seen.points[[landmarks.index(f"{side}_wrist") for side in ("left", "right")], 0]))
    return Character(
        name=name,
        surface=Surface(template.vertices * (across / seen.picture.size[0], 1, 1), template.faces.astype(np.int64)),
        skin_indices=template.skin_indices.astype(np.uint16),
        skin_weights=template.skin_weights.astype(np.float32),
        hold=np.ones(len(template.vertices), np.float32),
        skeleton=template.skeleton,
    )


def main() -> None:
    """Register the stand-ins, one as the engine a newcomer meets, and start."""
    known = registry.available
    registry._ENGINES[NAME] = ("a stand-in", lambda **_options: Telling())
    registry.available = lambda: {NAME: "a stand-in", **known()}  # type: ignore[method-assign]
    registry.captioners = lambda: {NAME: "a stand-in"}  # type: ignore[method-assign]
    registry._STYLISERS = {"restyler": ("a stand-in", lambda **_options: FakeStyliser())}
    registry.stylisers = lambda: {"restyler": "a stand-in"}
    making.build = build  # type: ignore[assignment]
    settings.DEFAULT_ENGINE = NAME
    cli.main()


if __name__ == "__main__":
    main()
