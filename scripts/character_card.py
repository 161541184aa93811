"""The table of docs/character.md: characters made from pictures of bodies of which everything is known.

    python scripts/character_card.py [--people 8]

Bodies of several shapes, clothes and poses are drawn from the front, before a plain wall; characters are made of these
pictures alone and compared with the truth. Seconds are those of the processor (all cores together), which other
programs do not change.
"""

from __future__ import annotations

import argparse
import logging
import time
from itertools import pairwise

import numpy as np

from engines.character.character import Way
from engines.character.making import build
from engines.character.sighting import look
from engines.character.template import posed_vertices
from engines.evaluation.characters import Known, framed, measured, standing
from engines.geometry.rotations import matrix_to_quaternion
from engines.motion import Motion
from viewers import bodies

log = logging.getLogger("character_card")

PEOPLE = (
    # shape, shirt, arms lowered, elbows bent, turned (radians), pixels high
    ({}, (0.2, 0.4, 0.3), 1.1, 0.2, 0.0, 900),
    ({"gender": 1.0, "weight": 0.3}, (0.75, 0.7, 0.2), 1.2, 0.1, 0.1, 900),
    ({"gender": 0.0, "weight": 0.75}, (0.2, 0.25, 0.5), 1.0, 0.4, -0.1, 1200),
    ({"muscle": 0.9, "height": 0.6}, (0.6, 0.6, 0.62), 0.9, 0.1, 0.0, 600),
    ({"gender": 1.0, "height": 0.25}, (0.5, 0.15, 0.3), 1.25, 0.3, 0.2, 900),
    ({"weight": 0.6, "age": 1.0}, (0.12, 0.12, 0.14), 1.15, 0.2, -0.2, 900),
    ({"gender": 0.2, "muscle": 0.2}, (0.9, 0.9, 0.88), 0.6, 0.0, 0.0, 900),
    ({"gender": 0.8, "weight": 0.8}, (0.3, 0.6, 0.6), 1.2, 0.6, 0.0, 700),
)
ROWS = {
    "mask": ("overlap of the mask with the true silhouette", "{:.3f}"),
    "body": ("overlap of the fitted body's silhouette", "{:.3f}"),
    "clothed": ("overlap of the clothed surface's silhouette", "{:.3f}"),
    "joints": ("distance of the joints, mm", "{:.0f}"),
    "chamfer": ("chamfer distance of the surface, mm", "{:.1f}"),
    "back": ("colour error from behind (0 to 255), ours", "{:.1f}"),
    "mirrored": ("the same, the front mirrored", "{:.1f}"),
    "nearest": ("the same, nearest seen colour copied", "{:.1f}"),
}


def person(number: int) -> Known:
    """One of `PEOPLE` before the camera."""
    shape, shirt, arms, bend, turn, height = PEOPLE[number]
    body = bodies.get("anny").shaped(**shape)
    pose = standing(body, arms, bend, turn)
    view, size = framed(posed_vertices(body, pose, np.zeros(3)), height)
    return Known(body, body.painted(shirt), pose, np.zeros(3), view, size)


def steps(known: Known) -> list[tuple[str, float]]:
    """What making a character does, and the processor's seconds for each; then a pose each way."""
    marks: list[tuple[str, float]] = []
    template = bodies.get("anny")
    made = build(known.front[0], template, progress=lambda _, words: marks.append((words, time.process_time())))
    spent = [(words, until - since) for (words, since), (_, until) in pairwise(marks)]
    motion = Motion(made.skeleton, matrix_to_quaternion(known.pose)[None], np.zeros((1, 3)), 20.0)
    made.posed(motion, way="rigid")  # factors its matrix
    count = f"{len(np.unique(made.surface.groups)):,} vertices"
    ways: dict[str, Way] = {"A pose by skinning": "skin", "A pose as rigid as possible": "rigid"}
    for words, way in ways.items():
        begun = time.process_time()
        made.posed(motion, way=way)
        spent.append((f"{words}, {count}", time.process_time() - begun))
    return spent


def main() -> None:
    """Measure and log the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--people", type=int, default=len(PEOPLE), choices=range(1, len(PEOPLE) + 1))
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    found = []
    for number in range(parser.parse_args().people):
        known = person(number)
        found.append(measured(known, bodies.get("anny"), look(known.front[0])))
        log.info("%d %s", number, {name: round(value, 3) for name, value in found[-1].items()})
    log.info("\n| of %d people | mean | worst |\n|---|---|---|", len(found))
    for name, (words, form) in ROWS.items():
        values = [one[name] for one in found]
        worst = min(values) if name in {"mask", "body", "clothed"} else max(values)
        log.info("| %s | %s | %s |", words, form.format(np.mean(values)), form.format(worst))
    log.info("\n| step | seconds |\n|---|---|")
    for words, seconds in steps(person(0)):
        log.info("| %s | %.2f |", words, seconds)


if __name__ == "__main__":
    main()
