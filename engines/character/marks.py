"""Where the 33 landmarks of a picture lie on the template, which has joints and a skin but no such marks.

Eyes, heels, knuckles and the like are vertices, looked for by where they lie in the T-pose, so that any body on the
house skeleton has them. Shoulders, hips and the other large joints are the skeleton's, moved to where BlazePose sees
them (`SHIFTS`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Float, Integer
from torch import Tensor

from engines.character import landmarks
from engines.character.template import Template, strongest_joints

SHIFTS: dict[str, tuple[float, float, float]] = {}
"""Landmark of the left side -> metres from the joint, in the joint's own axes (x out, y up, z forward at rest)."""
TRUST = {"nose": 0.5, "eye": 0.2, "ear": 0.4, "mouth": 0.2, "pinky": 0.3, "index": 0.3, "thumb": 0.2}
"""How much a landmark counts beside the large joints: ten lie on the face alone."""
FACE = {
    "eye_inner": (0.09, 0.24),
    "eye_middle": (0.18, 0.24),
    "eye_outer": (0.28, 0.24),
    "mouth": (0.15, -0.19),
}
"""Left of and above the tip of the nose, in its height below the crown."""
HAND = {"pinky": (0.40, -0.22), "index": (0.47, 0.15), "thumb": (0.42, 0.36)}
"""Out and forward of the wrist, in the length of the hand."""


@dataclass(frozen=True, eq=False)
class Marks:
    """How the landmarks follow from joints and vertices: of `bones` a point in a joint's axes, of `skin` a vertex."""

    bones: dict[int, tuple[int, tuple[float, float, float]]]
    """Landmark -> joint and the point (3,) in its axes, metres."""
    skin: dict[int, int]
    """Landmark -> vertex of the template."""

    @property
    def vertices(self) -> Integer[np.ndarray, " M"]:
        """(M,) the vertices needed, to be posed ahead of others."""
        return np.array(list(self.skin.values()))

    def placed(
        self, vertices: Float[Tensor, "M 3"], joints: Float[Tensor, "J 3"], turns: Float[Tensor, "J 3 3"]
    ) -> Float[Tensor, "33 3"]:
        """(33, 3) landmarks, of the posed `self.vertices` (M, 3), joints (J, 3) and their world rotations."""
        held = [joint for joint, _ in self.bones.values()]
        shifts = torch.tensor([shift for _, shift in self.bones.values()], dtype=vertices.dtype)
        points = joints[held] + torch.einsum("nab,nb->na", turns[held], shifts)
        order = np.argsort([*self.bones, *self.skin])
        return torch.cat([points, vertices])[order]


def trust() -> Float[np.ndarray, " 33"]:
    """(33,) how much each landmark counts, the large joints 1."""
    return np.array([next((v for k, v in TRUST.items() if k in name), 1.0) for name in landmarks.NAMES])


def marks(template: Template) -> Marks:
    """The landmarks of a template in its T-pose."""
    skeleton = template.skeleton
    bones = {}
    for name, joint in landmarks.JOINTS.items():
        if name.endswith("_toe"):
            continue  # of the toe's tip; the joint is where the toes bend
        x, y, z = SHIFTS.get(name.replace("right_", "left_"), (0.0, 0.0, 0.0))
        bones[landmarks.index(name)] = skeleton.index(joint), (x if name.startswith("left") else -x, y, z)
    skin = {landmarks.index(name): vertex for name, vertex in {**_head(template), **_ends(template)}.items()}
    return Marks(bones, skin)


def _head(template: Template) -> dict[str, int]:
    """Nose, eyes, mouth and ears."""
    head = np.flatnonzero(strongest_joints(template) == template.skeleton.index("head"))
    places = template.vertices[head].astype(np.float64)
    tip = places[places[:, 2].argmax()] * (0, 1, 1)
    unit = places[:, 1].max() - tip[1]
    front = places[:, 2] > tip[2] - 0.6 * unit
    level = np.abs(places[:, 1] - tip[1]) < 0.3 * unit
    found = {"nose": int(head[np.linalg.norm(places - tip, axis=1).argmin()])}
    for side, sign in (("left", 1), ("right", -1)):
        for name, (x, y) in FACE.items():
            away = np.linalg.norm(places[:, :2] - tip[:2] - np.array([sign * x, y]) * unit, axis=1)
            found[f"{side}_{name}"] = int(head[np.where(front, away, np.inf).argmin()])
        found[f"{side}_ear"] = int(head[np.where(level, sign * places[:, 0], -np.inf).argmax()])
    return found


def _ends(template: Template) -> dict[str, int]:
    """Knuckles, heels and tips of the toes."""
    skeleton, part = template.skeleton, strongest_joints(template)
    found = {}
    for side, sign in (("left", 1), ("right", -1)):
        wrist, ankle, foot = (skeleton.index(f"{side}_{joint}") for joint in ("wrist", "ankle", "foot"))
        hand = np.flatnonzero(part == wrist)
        places = template.vertices[hand] - skeleton.rest_positions[wrist]
        length = np.abs(places[:, 0]).max()
        for name, (out, forward) in HAND.items():
            away = np.linalg.norm(places[:, [0, 2]] - np.array([sign * out, forward]) * length, axis=1)
            found[f"{side}_{name}"] = int(hand[away.argmin()])
        shoe = np.flatnonzero((part == ankle) | (part == foot))
        places = template.vertices[shoe]
        low = places[:, 1] < skeleton.rest_positions[foot][1]
        found[f"{side}_heel"] = int(shoe[np.where(low, places[:, 2], np.inf).argmin()])
        found[f"{side}_toe"] = int(shoe[places[:, 2].argmax()])
    return found
