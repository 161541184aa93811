"""Small stand-ins for an engine, so that the studio's own logic is tested without weights and within milliseconds."""

from __future__ import annotations

import math
import time
from dataclasses import replace
from typing import Any

import numpy as np

from engines import SMPL22, Motion, Provenance, Segment
from engines.actions import VOCABULARY
from engines.errors import Cancelled, OutOfRangeError, UnknownLabelError


def sway(action: str = "walk", frames: int = 60, seed: int = 0, index: int = 0, fps: float = 20.0) -> Motion:
    """A body that walks forward with swinging legs and arms; `seed` and `index` change step and swing."""
    draw = np.random.default_rng([seed, index])
    time_ = np.arange(frames) / fps
    phase = 2 * math.pi * (0.8 + 0.4 * draw.random()) * time_ + draw.random() * 6
    turns = np.zeros((frames, len(SMPL22), 4))
    turns[..., 0] = 1.0
    swing = 0.3 + 0.4 * draw.random()

    def about(joint: str, axis: int, angle: np.ndarray) -> None:
        turns[:, SMPL22.index(joint), 0] = np.cos(angle / 2)
        turns[:, SMPL22.index(joint), 1 + axis] = np.sin(angle / 2)

    about("left_hip", 0, -swing * np.sin(phase))
    about("right_hip", 0, swing * np.sin(phase))
    about("left_knee", 0, 0.3 + 0.3 * np.cos(phase))
    about("right_knee", 0, 0.3 - 0.3 * np.cos(phase))
    about("left_shoulder", 2, np.full(frames, -1.2))
    about("right_shoulder", 2, np.full(frames, 1.2))
    path = np.stack([np.zeros(frames), np.full(frames, 0.93), 1.1 * time_], axis=-1)
    labels = (Segment(0, frames, "action", action),)
    made = Provenance("fake", "0" * 64, action, seed, index, {"frames": frames})
    return Motion(SMPL22, turns, path, fps, labels, made)


class FakeEngine:
    """Knows the vocabulary's first twenty actions; `slow` seconds pass for each motion of a draw."""

    name, variant, description = "fake", "plain", "A stand-in."
    variants = ("plain", "other")
    weights_hash, licence = "f" * 64, "CC0"
    capabilities = frozenset({"actions", "scale_bones", "variants"})
    fps, max_frames = 20.0, 400

    def __init__(self, variant: str = "plain", slow: float = 0.0) -> None:
        self.variant, self.slow = variant, slow
        self.actions = VOCABULARY[:20]
        self.calls: list[dict] = []

    def generate_many(self, action, count=4, frames=60, seed=0, progress=None, cancel=None, **extra):  # noqa: PLR0917
        known = [a.name for a in self.actions]
        if action not in known:
            raise UnknownLabelError("action", action, known)
        self.calls.append({"action": action, "count": count, "frames": frames, "seed": seed, **extra})
        made = []
        for index in range(count):
            if cancel is not None and cancel():
                raise Cancelled(f"generating {action} was cancelled")
            time.sleep(self.slow)
            made.append(sway(action, frames, seed, index))
            if progress is not None:
                progress(index + 1, count)
        return made


METRICS = {"foot_skate": 0.05, "jitter": 40.0, "ground_penetration": 0.001}


class ConstrainedEngine(FakeEngine):
    """Takes styles, words and pins too; says of a path that is longer than 5 m that it is followed for 5 m.

    A prompt takes 10 frames a word, a jump 30, everything else 60, unless it is told how many.
    """

    name = "stand-in"
    variants = ()
    styles = ("happy", "old", "tired")
    capabilities = frozenset({
        "actions", "styles", "text", "constraints", "guidance", "best_of", "scale_bones", "lengths",
    })  # fmt: skip

    def generate_many(self, action, count=4, frames=60, seed=0, progress=None, cancel=None, **told):  # noqa: PLR0917
        found = frames or self.expected_frames(action, told.get("prompt"))
        made = super().generate_many(action or "walk", count, found, seed, progress, cancel, **told)
        self.calls[-1] |= {"action": action, "frames": frames}
        return [self._with(motion, told) for motion in made]

    def expected_frames(self, action, prompt=None):
        return 10 * len(prompt.split()) if prompt else 30 if action == "jump" else 60

    def _with(self, motion: Motion, told: dict) -> Motion:
        labels = [Segment(0, len(motion), kind, told[key]) for kind, key in KINDS if told.get(key)]
        more = {key: told[key] for key in ("style", "prompt", "guidance", "best_of") if key in told}
        pinned = told.get("constraints")
        if pinned is not None and pinned.path is not None:
            points = np.asarray(pinned.path.points)
            length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
            motion = motion.moved((float(points[0, 0]), 0.0, float(points[0, 1])))
            if length > 5.0:
                more["unmet"] = [f"The path is {length:.1f} m long; it is followed for 5.0 m."]
        made = motion.provenance
        return motion.replaced(
            labels=(*labels,) or motion.labels, provenance=replace(made, parameters={**made.parameters, **more})
        )


KINDS: tuple[tuple[Any, str], ...] = (("style", "style"), ("text", "prompt"))


class FakeStyliser:
    """Raises the arms by the style's place among `styles`, a little more for each of a draw, as the strength says."""

    name, variant, description = "restyler", "plain", "A stand-in."
    variants = ("plain",)
    weights_hash, licence, fps = "e" * 64, "CC0", 30.0
    styles = ("happy", "old", "tired")
    capabilities = frozenset({"stylise", "references", "styles", "variants"})

    def __init__(self) -> None:
        self.calls: list[dict] = []

    def stylise(self, motion, style=None, *, like=None, strength=1.0, count=1, seed=0):
        self.calls.append({"frames": len(motion), "style": style, "like": like and len(like), "strength": strength,
                           "count": count, "seed": seed})  # fmt: skip
        if style is not None and style not in self.styles:
            raise UnknownLabelError("style", style, self.styles)
        if len(motion) < 8:
            raise OutOfRangeError("frames of the motion at 30 fps", len(motion), "8 to 18,000")
        place = self.styles.index(style) + 1 if style else 4
        return [self._raised(motion, style, strength * (0.3 * place + 0.02 * i), seed, i) for i in range(count)]

    def style_code(self, motion, style=None):
        """How far the left arm is raised, twice; the second as it depends on the seed."""
        shown = style or motion.label_at(0, "style")
        if shown not in (None, *self.styles):
            raise UnknownLabelError("style", shown, self.styles)
        turn = float(motion.rotations[0, SMPL22.index("left_collar"), 3])
        return np.array([turn, turn**2 + 0.1 * ((motion.provenance.seed or 0) % 3), 0.0])

    def interpolate_styles(self, motion, a, b, steps=5, style=()):
        angles = 2 * np.arcsin(a[0] + (b[0] - a[0]) * np.linspace(0, 1, steps))
        between = " > ".join(style) or None
        return [self._raised(motion, between, float(angle), 0, i) for i, angle in enumerate(angles)]

    def _raised(self, motion: Motion, style: str | None, angle: float, seed: int, index: int) -> Motion:
        house = motion.retarget(SMPL22).resample(self.fps)
        turns = house.rotations.copy()
        for joint, side in (("left_collar", 1), ("right_collar", -1)):
            turns[:, SMPL22.index(joint)] = [math.cos(angle / 2), 0, 0, side * math.sin(angle / 2)]
        labels = (*house.labels, *([Segment(0, len(house), "style", style)] if style else []))
        made = Provenance(self.name, self.weights_hash, "", seed, index)
        return house.replaced(rotations=turns, labels=labels, provenance=made)
