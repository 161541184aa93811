"""Builds the moving pictures of the action browser: `python -m studio.action_pictures [folder]`.

Each action gets one WebP, `FRAMES` square pictures side by side on a transparent ground; the page shows one of them
and, under the pointer, all in turn. Run it again after the weights change.
"""

from __future__ import annotations

import io
import logging
import sys
from pathlib import Path

import numpy as np

from engines import Motion
from studio import tasks
from studio.settings import GenerateSettings
from studio.thumbnails import cut_out

log = logging.getLogger(__name__)

FRAMES = 16
SIZE = 112
"""Pixels a side; shown at half of that, for dense screens."""
FOLDER = Path(__file__).resolve().parent / "assets" / "actions"
_DRAWS = 8


def strip(motion: Motion, renderer) -> bytes:
    """One motion as a strip of pictures, walking on the spot, seen three quarters from its front."""
    from PIL import Image

    from viewers.camera import Camera
    from viewers.scene import Actor, Scene

    still = motion.in_place().replaced(labels=())
    camera = Camera("orbit", yaw=float(still.heading[0]) + 0.5, pitch=0.12, fill=0.94)
    scene = Scene((Actor(still, colour="#86a9c9"),), camera)
    times = np.linspace(0.0, still.duration, FRAMES, endpoint=False)
    pictures = np.concatenate([cut_out(renderer, scene, float(t)) for t in times], axis=1)
    file = io.BytesIO()
    Image.fromarray(pictures).save(file, format="WEBP", quality=70, alpha_quality=80, method=6)
    return file.getvalue()


def liveliest(motions: list[Motion]) -> Motion:
    """The one that moves most of those that neither jitter nor slide more than usual among them."""
    scores = [tasks.measure(motion) for motion in motions]
    limit = {key: float(np.median([score[key] for score in scores])) for key in ("jitter", "foot_skate")}
    calm = [m for m, score in zip(motions, scores, strict=True) if all(score[k] <= limit[k] * 1.1 for k in limit)]
    return max(calm or motions, key=lambda motion: float(np.ptp(motion.in_place().positions, axis=0).mean()))


def main() -> None:
    """Draw every action of the usual engine."""
    from viewers.moderngl_renderer import Renderer

    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER
    folder.mkdir(parents=True, exist_ok=True)
    renderer = Renderer(SIZE, SIZE)
    usual = GenerateSettings()
    for action in tasks.load_engine(usual.engine).actions:
        asked = GenerateSettings(action=action.name, frames=50, seed=usual.seed, count=_DRAWS)
        data = strip(liveliest(tasks.generate(asked)), renderer)
        (folder / f"{tasks.slug(action.name)}.webp").write_bytes(data)
        log.info("%s: %d bytes", action.name, len(data))


if __name__ == "__main__":
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    main()
