"""Builds the moving pictures of the action browser: `python -m studio.action_pictures [folder]`.

Each action gets one WebP, `FRAMES` square pictures side by side on a transparent ground; the page shows one of them
and, under the pointer, all in turn. Run it again after the weights change.
"""

from __future__ import annotations

import io
import logging
import sys
from pathlib import Path
from typing import Any

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


def strip(motion: Motion, renderer: Any) -> bytes:
    """One motion as a strip of pictures, walking on the spot, seen three quarters from its front.

    The most telling moment comes first, since that is the one shown while nothing moves.
    """
    from PIL import Image

    from viewers.camera import Camera
    from viewers.scene import Actor, Scene, telling_frame

    still = motion.in_place().replaced(labels=())
    scene = Scene((Actor(still, colour="#86a9c9"),), Camera("orbit", yaw=float(still.heading[0]) + 0.5, pitch=0.12))
    start = telling_frame(still) / still.fps
    times = (start + np.linspace(0.0, still.duration, FRAMES, endpoint=False)) % still.duration
    pictures = filled(np.stack([cut_out(renderer, scene, float(t)) for t in times]))
    small = [Image.fromarray(picture).resize((SIZE, SIZE), Image.Resampling.LANCZOS) for picture in pictures]
    file = io.BytesIO()
    Image.fromarray(np.concatenate([np.asarray(picture) for picture in small], axis=1)).save(
        file, format="WEBP", quality=62, alpha_quality=70, method=6
    )
    return file.getvalue()


def filled(pictures: np.ndarray) -> np.ndarray:
    """Pictures (N, H, W, 4) cut to the smallest square in which the body stays all the time, with a little air."""
    seen = pictures[..., 3].max(axis=0) > 8
    rows, columns = np.flatnonzero(seen.any(1)), np.flatnonzero(seen.any(0))
    side = min(int(1.06 * max(np.ptp(rows), np.ptp(columns))) + 2, *seen.shape)
    top, left = (
        int(np.clip((line[0] + line[-1] - side) // 2, 0, size - side))
        for line, size in ((rows, seen.shape[0]), (columns, seen.shape[1]))
    )
    return pictures[:, top : top + side, left : left + side]


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
    renderer = Renderer(3 * SIZE, 3 * SIZE)
    usual = GenerateSettings()
    for action in tasks.load_engine(usual.engine).actions:
        asked = GenerateSettings(action=action.name, frames=50, seed=usual.seed, count=_DRAWS)
        data = strip(liveliest(tasks.generate(asked)), renderer)
        (folder / f"{tasks.slug(action.name)}.webp").write_bytes(data)
        log.info("%s: %d bytes", action.name, len(data))


if __name__ == "__main__":
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    main()
