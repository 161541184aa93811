"""The wooden mannequin of the package mannequin-x (Apache-2.0), driven by SMPL's rotations as they are."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache

import numpy as np

from engines.errors import MissingDependencyError, MotionloomError
from engines.geometry.skins import vertex_normals
from viewers.bodies.body import Body, Slider
from viewers.bodies.smpl_joints import COUNT, folded, house_skeleton

BETAS = 10
"""Shape coefficients of SMPL-X that it follows."""
WOOD = (181, 113, 54)
"""sRGB."""
_LICENCE = "mannequin-x by Andrea Boscolo Camiletto, Apache License 2.0."


def sliders() -> tuple[Slider, ...]:
    """beta1 ... beta10, as SMPL-X's model files name body shape."""
    return tuple(Slider(f"beta{i + 1}", -5.0, 5.0, 0.0, "SMPL-X shape coefficient") for i in range(BETAS))


@lru_cache(maxsize=16)
def load(betas: tuple[float, ...] = (0.0,) * BETAS) -> Body:
    """The mannequin in its rest pose.

    Raises:
        MissingDependencyError: the package is not installed.
        MotionloomError: it is of a version whose insides are others.
    """
    try:
        from mannequin import Mannequin
    except ImportError as problem:
        raise MissingDependencyError("mannequin-x", "mannequin", "the mannequin") from problem
    model = Mannequin("wooden", shape=np.array(betas, np.float32))
    pose = model.rest_pose()
    places = model.joint_transforms(pose)[:, :3, 3]
    try:  # the weights have no public name; its own skinning reads these
        indices, weights = model._skin_joint_indices, model._skin_weights
    except AttributeError as problem:
        raise MotionloomError(
            "this version of mannequin-x keeps its skin weights elsewhere; accepted: mannequin-x 0.3."
        ) from problem
    full = np.zeros((model.num_vertices, len(model.parents)))
    np.add.at(full, (np.arange(len(full))[:, None], np.asarray(indices)), np.asarray(weights))
    index, strongest = folded(full, model.parents)
    skeleton = house_skeleton("mannequin", places[:COUNT])
    vertices = np.asarray(model.vertices(pose)) - places[0]
    return Body(
        name="mannequin",
        skeleton=skeleton,
        vertices=vertices,
        faces=model.faces,
        normals=vertex_normals(vertices, np.asarray(model.faces)),
        skin_indices=index,
        skin_weights=strongest,
        colours=np.tile(np.array(WOOD, np.uint8), (len(vertices), 1)),
        tint=np.ones(len(vertices)),
        licence=_LICENCE,
        own_bones=True,
        sliders=sliders(),
        reshape=_reshape,
    )


def _reshape(values: Mapping[str, float]) -> Body:
    return load(tuple(values.get(f"beta{i + 1}", 0.0) for i in range(BETAS)))
