"""Builds the moving pictures of the gallery of styles: `python -m studio.style_pictures [folder]`.

One walk, in each style, as the pictures of actions are (see `studio.action_pictures`). Run it again after the weights
change.
"""

from __future__ import annotations

import logging
import sys
from pathlib import Path

from engines import registry
from studio import edits, tasks
from studio.action_pictures import SIZE, strip
from studio.given import Given
from studio.settings import GenerateSettings
from studio.styling import CLEAN

log = logging.getLogger(__name__)

FOLDER = Path(__file__).resolve().parent / "assets" / "styles"
_WALK = GenerateSettings(action="walk", style="normal", frames=60, count=1)


def main() -> None:
    """Draw a walk of the usual engine in every style of the first engine that has some."""
    from viewers.moderngl_renderer import Renderer

    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER
    folder.mkdir(parents=True, exist_ok=True)
    renderer = Renderer(3 * SIZE, 3 * SIZE)
    (walk,) = tasks.generate(_WALK)
    name = next(iter(registry.stylisers()))
    engine = tasks.load_engine(name)
    given = Given.of(walk, "a walk", engine.fps)
    for style in engine.styles:
        asked = GenerateSettings(engine=name, action="walk", style=style, frames=given.frames, given=given, count=1)
        data = strip(edits.apply(tasks.generate(asked)[0], CLEAN), renderer)
        (folder / f"{tasks.slug(style)}.webp").write_bytes(data)
        log.info("%s: %d bytes", style, len(data))


if __name__ == "__main__":
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    main()
