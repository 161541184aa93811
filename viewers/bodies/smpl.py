"""Bodies from a person's own SMPL, SMPL-H or SMPL-X model files, which their licence lets nobody else hand out.

The files come from smpl.is.tue.mpg.de, mano.is.tue.mpg.de and smpl-x.is.tue.mpg.de. Only `.npz` files are read: a
`.pkl` can run any program when it is opened. `SMPLX_NEUTRAL.npz` and the SMPL-H `model.npz` are such already; a
`.pkl` of SMPL is turned into one once, in the environment its makers describe (numpy, scipy, chumpy):

    import numpy as np, pickle
    model = pickle.load(open("SMPL_NEUTRAL.pkl", "rb"), encoding="latin1")
    keys = ("v_template", "f", "weights", "kintree_table", "shapedirs")
    arrays = {key: np.array(model[key]) for key in keys}
    np.savez("SMPL_NEUTRAL.npz", J_regressor=model["J_regressor"].toarray(), **arrays)

Where the file is, is said by its path (`bodies.get("models/SMPLX_NEUTRAL.npz")`, `--body models/SMPLX_NEUTRAL.npz`), or
by the environment: `MOTIONLOOM_SMPL`, `MOTIONLOOM_SMPLH`, `MOTIONLOOM_SMPLX` make "smpl", "smplh", "smplx" known.

Shape is `beta1`, `beta2`, ... as in the model. The models' small corrections by pose are left out: viewers skin
linearly, so elbows and knees are a little thinner than in the original.
"""

from __future__ import annotations

import os
import zipfile
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path

import numpy as np

from engines.errors import FormatError
from engines.formats.files import existing_file
from engines.geometry.skins import vertex_normals
from viewers.bodies.body import Body, Slider
from viewers.bodies.shaping import Blend, BlendShapes
from viewers.bodies.smpl_joints import COUNT, folded, house_skeleton

VARIABLES = {"smpl": "MOTIONLOOM_SMPL", "smplh": "MOTIONLOOM_SMPLH", "smplx": "MOTIONLOOM_SMPLX"}
"""Name of a body -> environment variable with the path of its file."""
JOINTS = {24: "smpl", 52: "smplh", 55: "smplx"}
"""Number of joints -> model."""
BETAS = 10
"""Shape coefficients offered, of the 10 to 400 that files hold."""
LIMIT = 5.0
"""Betas are standard deviations; beyond so many bodies fall apart."""
MAX_BYTES = 2**30
"""No larger file is opened (SMPL-X has 170 MB)."""
MAX_VERTICES = 100_000
GREY = (178, 178, 184)
LICENCE = "From your own model file; its licence (non-commercial) holds for pictures and exports too."
_NEEDED = ("v_template", "f", "weights", "kintree_table", "J_regressor", "shapedirs")


def from_environment(name: str) -> Body:
    """The body "smpl", "smplh" or "smplx" from where its environment variable says.

    Raises:
        FormatError: the variable is not set, or there is no readable model.
    """
    variable = VARIABLES[name]
    place = os.environ.get(variable)
    if not place:
        raise FormatError(
            f"${variable}", f"is not set: {name} bodies come from your own licensed model file (.npz). Set it to the "
            f"file's path, or give the path itself in place of {name!r}.",
        )  # fmt: skip
    return load(place)


def load(path: str | Path) -> Body:
    """The body in a model file.

    Raises:
        FormatError: no such file, no .npz, not a model of the SMPL family, or damaged.
    """
    path = Path(path).expanduser()
    if path.suffix.lower() == ".pkl":
        raise FormatError(
            path, "pickle files are not opened, since they can run any program; accepted: .npz. The page of "
            "`viewers.bodies.smpl` (help) shows the five lines that make one.",
        )  # fmt: skip
    existing_file(path, MAX_BYTES)
    return _load(path.resolve(), path.stat().st_mtime_ns)


@lru_cache(maxsize=4)
def _load(path: Path, changed: int) -> Body:
    del changed  # part of the key: a file that was replaced is read again
    arrays = _arrays(path)
    vertices, faces, weights, parents, regressor, directions = (arrays[name] for name in _NEEDED)
    places = regressor @ vertices
    moved = np.einsum("jv,vcs->sjc", regressor, directions)
    index, strongest = folded(weights, parents.tolist())
    skeleton = house_skeleton(JOINTS[len(parents)], places[:COUNT])
    body = Body(
        name=JOINTS[len(parents)], skeleton=skeleton, vertices=vertices - places[0], faces=faces,
        normals=vertex_normals(vertices, faces), skin_indices=index, skin_weights=strongest,
        colours=np.tile(np.array(GREY, np.uint8), (len(vertices), 1)), tint=np.ones(len(vertices)), licence=LICENCE,
        own_bones=True,
    )  # fmt: skip
    sliders, blends = [], []
    home = np.array(skeleton.parents)
    for number in range(directions.shape[2]):
        name = f"beta{number + 1}"
        sliders.append(Slider(name, -LIMIT, LIMIT, 0.0, f"shape coefficient {number + 1}"))
        joints = moved[number, :COUNT]
        offsets = joints - np.where(home[:, None] >= 0, joints[home], joints[:1])
        shift = directions[:, :, number] - joints[0]
        blends += [Blend(name, end, end * shift, end * offsets) for end in (-1.0, 1.0)]
    return BlendShapes(body, sliders, blends).base


def _arrays(path: Path) -> dict[str, np.ndarray]:
    """The arrays of a model, of the shapes and kinds that belong together.

    Raises:
        FormatError: something is missing, of another shape, or not numbers.
    """
    try:
        with np.load(path, allow_pickle=False) as stored:
            missing = [name for name in _NEEDED if name not in stored.files]
            if missing:
                raise FormatError(path, f"has no {missing[0]!r}; accepted: a SMPL, SMPL-H or SMPL-X model as .npz.")
            found = {name: stored[name] for name in _NEEDED}
    except FormatError:
        raise
    except (OSError, ValueError, EOFError, zipfile.BadZipFile, MemoryError) as problem:
        raise FormatError(path, f"is no readable .npz of plain arrays ({problem}).") from problem
    return _checked(path, found)


def _checked(path: Path, found: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    count, joints = len(np.atleast_1d(found["v_template"])), found["kintree_table"].shape[-1:]
    number = joints[0] if joints else 0
    shapes = {
        "v_template": (count, 3), "f": (len(np.atleast_1d(found["f"])), 3), "weights": (count, number),
        "kintree_table": (2, number), "J_regressor": (number, count), "shapedirs": (count, 3, None),
    }  # fmt: skip
    if number not in JOINTS or not 1 <= count <= MAX_VERTICES:
        raise FormatError(path, f"has {number} joints and {count:,} vertices; accepted: {_models()}.")
    for name, shape in shapes.items():
        array = found[name]
        fits = array.ndim == len(shape) and all(w is None or w == n for w, n in zip(shape, array.shape, strict=True))
        if not fits or array.dtype.kind not in "fiu":
            raise FormatError(path, f"{name!r} is {array.dtype} of shape {array.shape}; accepted: numbers, {shape}.")
    made: dict[str, np.ndarray] = {
        name: np.asarray(found[name], np.float64) for name in ("v_template", "weights", "J_regressor")
    }
    made["shapedirs"] = np.asarray(found["shapedirs"][:, :, :BETAS], np.float64)
    made["f"] = np.asarray(found["f"], np.int64)
    parents = found["kintree_table"][0].astype(np.int64)  # the root's is -1, stored as 4294967295
    made["kintree_table"] = np.where(np.arange(number) == 0, -1, parents)
    finite = all(np.isfinite(made[name]).all() for name in ("v_template", "weights", "J_regressor", "shapedirs"))
    tree = all(0 <= parent < joint for joint, parent in enumerate(made["kintree_table"]) if joint)
    inside = made["f"].size == 0 or 0 <= made["f"].min() <= made["f"].max() < count
    total = made["weights"].sum(axis=1)
    if not (finite and tree and inside and (np.abs(total - 1) < 0.05).all()):
        raise FormatError(path, "holds numbers that make no body (tree, faces or weights do not fit).")
    return made


def _models() -> str:
    return ", ".join(f"{name} with {joints}" for joints, name in JOINTS.items()) + " joints"
