"""What is seen of a person in a picture: time a step, and how near the truth it comes.

    python benchmarks/sighting.py

The default body is rendered before photographs (of scikit-learn) and looked at. Medians of wall and of processor time,
the steadier one on a machine that others use; beside them the silhouette's overlap and the landmarks' distance.
"""

from __future__ import annotations

import io
import statistics
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from PIL import Image

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from engines import SMPL22
from engines.character import landmarks, mask, models
from engines.character.picture import Picture, open_picture
from engines.character.sighting import look
from engines.evaluation.characters import overlap
from tests.engines.character.people import Person, arms_down, photographed

REPEATS = 5


def medians(step: Callable[[], object]) -> tuple[float, float]:
    """Wall and processor milliseconds, after one round to warm up."""
    spent = []
    for _ in range(REPEATS + 1):
        wall, busy = time.perf_counter(), time.process_time()
        step()
        spent.append((time.perf_counter() - wall, time.process_time() - busy))
    return tuple(1e3 * statistics.median(column) for column in zip(*spent[1:], strict=True))


def steps(person: Person) -> None:
    """Time a step of looking at one picture."""
    buffer = io.BytesIO()
    Image.fromarray(person.pixels).resize((4032, 6048)).save(buffer, "JPEG", quality=90)
    crop = models.detect(person.pixels)[0]
    body = models.examine(person.pixels, crop)
    large = open_picture(buffer.getvalue())
    rows = {
        "open a JPEG of 24 megapixels": lambda: open_picture(buffer.getvalue()),
        "detect": lambda: models.detect(person.pixels),
        "examine a crop": lambda: models.examine(person.pixels, crop),
        "silhouette, 480 x 720": lambda: mask.silhouette(person.pixels, [body]),
        "look, 480 x 720": lambda: look(Picture(person.pixels)),
        "look, 2048 x 3072": lambda: look(large),
    }
    print(f"{'step':32s} {'wall ms':>8s} {'cpu ms':>8s}")
    for name, step in rows.items():
        wall, busy = medians(step)
        print(f"{name:32s} {wall:8.0f} {busy:8.0f}")


def accuracy(behind: str) -> None:
    """How near the truth one picture comes."""
    person = photographed(arms_down(), behind=behind)
    seen = look(Picture(person.pixels))
    scale = np.ptp(person.joints[:, 1]) / np.ptp(person.motion.positions[0, :, 1])
    off = [
        np.hypot(*(seen.points[landmarks.index(name)] - person.joints[SMPL22.index(joint)])) / scale
        for name, joint in landmarks.JOINTS.items()
    ]
    shared, mean, worst = overlap(seen.mask > 0.5, person.mask > 0.5), 100 * np.mean(off), 100 * max(off)
    print(f"before {behind:12s} silhouette {shared:.3f}   landmarks {mean:.1f} cm, worst {worst:.1f}")


def main() -> None:
    steps(photographed(arms_down()))
    for behind in ("china.jpg", "flower.jpg"):
        accuracy(behind)


if __name__ == "__main__":
    main()
