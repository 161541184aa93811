"""What a perfect eye, or one that errs by a centimetre or two, sees of a known body."""

from __future__ import annotations

import numpy as np
import torch

from engines.character import landmarks
from engines.character.depth import rasterised
from engines.character.marks import marks
from engines.character.sighting import Sighting
from engines.evaluation.characters import Known
from engines.geometry.kinematics import forward_kinematics


def joints_of(known: Known) -> tuple[np.ndarray, np.ndarray]:
    """(J, 3) joints, metres, and (J, 3, 3) their rotations against the world."""
    skeleton = known.template.skeleton
    return forward_kinematics(known.pose, known.root, skeleton.offsets, skeleton.parents)


def places_of(known: Known) -> np.ndarray:
    """(33, 3) landmarks, metres."""
    found = marks(known.template)
    skin = known.surface.vertices[found.vertices]
    return found.placed(*(torch.from_numpy(array) for array in (skin, *joints_of(known)))).numpy()


def sighting_of(known: Known, dress: float = 0.0, error: float = 0.0) -> Sighting:
    """The body in loose clothes that stand off `dress` metres, its landmarks off by `error` metres."""
    places, random = places_of(known), np.random.default_rng(0)
    hips = places[[landmarks.index("left_hip"), landmarks.index("right_hip")]].mean(0)
    points = known.view.project(places + error * random.normal(size=places.shape))
    deep = places - hips + 2 * error * random.normal(size=places.shape)
    mask = rasterised(dressed(known, dress), known.surface.faces, known.view, known.size).mask
    return Sighting(known.front[0], points, np.ones(33), deep, mask.astype(np.float32))


def dressed(known: Known, dress: float) -> np.ndarray:
    """(V, 3) vertices of the body with trunk, upper arms and thighs so many metres thicker, evenly faded in."""
    names = known.template.skeleton.joints
    loose = [j for j, name in enumerate(names) if name.endswith(("spine1", "spine2", "spine3", "shoulder", "hip"))]
    weights = np.where(np.isin(known.template.skin_indices, loose), known.template.skin_weights, 0).sum(1)
    return known.surface.vertices + dress * weights[:, None] * known.surface.normals
