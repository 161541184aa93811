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

SHIFTS: dict[str, tuple[float, float]] = {
    "left_shoulder": (-0.008, 0.011),
    "left_elbow": (-0.013, 0.005),
    "left_wrist": (-0.006, 0.002),
    "left_hip": (-0.015, -0.009),
    "left_knee": (-0.006, -0.008),
    "left_ankle": (0.007, 0.028),
}
"""Landmark of the left side -> metres outward and up of the joint, in the joint's axes; of seven rendered bodies."""
TRUST = {"nose": 0.5, "eye": 0.2, "ear": 0.4, "mouth": 0.2, "pinky": 0.3, "index": 0.3, "thumb": 0.1, "heel": 0.6}
"""How much a landmark counts beside the large joints: ten lie on the face alone."""
FACE = {
    "eye_inner": (0.10, 0.34, 0.0),
    "eye_middle": (0.20, 0.34, 0.0),
    "eye_outer": (0.28, 0.34, -0.1),
    "mouth": (0.17, -0.06, 0.0),
    "ear": (0.36, 0.22, -0.8),
}
"""Left, above and before the tip of the nose, in its height below the crown."""
NOSE = 0.15
"""Above the tip of the nose, likewise, where its landmark lies."""
FOOT = {"heel": (-0.01, 0.036), "toe": (0.015, -0.013)}
"""Outward of the ankle and above the rearmost or foremost point, metres."""
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
        out, up = SHIFTS[name.replace("right_", "left_")]
        bones[landmarks.index(name)] = skeleton.index(joint), (out if name.startswith("left") else -out, up, 0.0)
    skin = {landmarks.index(name): vertex for name, vertex in {**_head(template), **_ends(template)}.items()}
    return Marks(bones, skin)


def _head(template: Template) -> dict[str, int]:
    """Nose, eyes, mouth and ears."""
    head = np.flatnonzero(strongest_joints(template) == template.skeleton.index("head"))
    places = template.vertices[head].astype(np.float64)
    tip = places[places[:, 2].argmax()] * (0, 1, 1)
    unit = places[:, 1].max() - tip[1]

    def nearest(x: float, y: float, z: float) -> int:
        return int(head[np.linalg.norm(places - tip - np.array([x, y, z]) * unit, axis=1).argmin()])

    found = {"nose": nearest(0.0, NOSE, 0.0)}
    for side, sign in (("left", 1), ("right", -1)):
        found.update({f"{side}_{name}": nearest(sign * x, y, z) for name, (x, y, z) in FACE.items()})
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
        for name, end in (("heel", places[:, 2].argmin()), ("toe", places[:, 2].argmax())):
            out, up = FOOT[name]
            target = np.array([skeleton.rest_positions[ankle][0] + sign * out, places[end, 1] + up, places[end, 2]])
            found[f"{side}_{name}"] = int(shoe[np.linalg.norm(places - target, axis=1).argmin()])
    return found
