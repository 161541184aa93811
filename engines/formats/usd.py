"""USD in and out through the package usd-core (extra `usd`): joints, their animation, and a skin if one is given.

Writing: a `SkelRoot` with a `Skeleton` in its rest pose on the floor, a `SkelAnimation` with a key a frame, and a
`Mesh` bound to it. Metres, Y up, facing +Z, stated in the file. `.usdc` is binary, `.usda` text, `.usd` binary.

Reading: the joints of the first skeleton that is animated, their rest pose as the file has it, brought to metres and
Y up by what the file states. USD is read by a large library that was made for files one trusts; so it runs in a process
of its own, with a limit of time and memory, and files that draw in others are refused.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from engines.errors import FormatError, MissingDependencyError, MotionloomError, SkeletonError
from engines.formats.bvh import STILL, as_house
from engines.formats.files import MAX_JOINT_FRAMES, atomic_path, check_size, existing_file
from engines.formats.glb_writer import Skin
from engines.formats.registry import Format
from engines.geometry import rotations
from engines.motion import Motion, Provenance
from engines.skeletons import roles
from engines.skeletons.skeleton import Skeleton

MAX_BYTES = 64 * 2**20
"""No larger file is read."""
PATIENCE, ROOM = 60.0, 4 * 2**30
"""Seconds and bytes of address space that reading may take."""
_LAYER = {".usda": "usda", ".usdc": "usdc", ".usd": "usdc"}
ROOT = "/motion"


def write(motion: Motion, path: str | Path, skin: Skin | None = None) -> Path:
    """Write a motion as USD.

    Args:
        motion: any motion.
        path: the file, .usdc, .usda or .usd.
        skin: a mesh fitted to the motion's own skeleton; without one the file holds joints and their animation.

    Returns:
        The path. Labels and provenance have no place in it.

    Raises:
        FormatError: the file cannot be written.
        MissingDependencyError: usd-core is not installed.
        SkeletonError: the skin is of another skeleton.
    """
    path = Path(path)
    _require(path)
    if skin is not None and skin.skeleton != motion.skeleton:
        raise SkeletonError(
            f"skin {skin.name!r} is of skeleton {skin.skeleton.name!r}, the motion of {motion.skeleton.name!r}; "
            "accepted: a skin of the motion's own skeleton (viewers.bodies.body_for gives both)."
        )
    Sdf, Tf = import_module("pxr.Sdf"), import_module("pxr.Tf")
    from engines.formats.usd_writer import fill

    kind = Sdf.FileFormat.FindById(_LAYER.get(path.suffix.lower(), "usdc"))
    with atomic_path(path) as temporary:
        layer = Sdf.Layer.CreateAnonymous(".usdc")
        fill(layer, motion, skin)
        try:
            done = layer.Export(str(temporary), args={"format": kind.formatId})
        except Tf.ErrorException as problem:
            raise FormatError(path, f"cannot be written: {str(problem)[:300]}.") from problem
        if not done:
            raise FormatError(path, "cannot be written by usd-core.")
    return path


def read(path: str | Path) -> Motion:
    """Read the first animated skeleton of a USD file.

    Returns:
        A Motion on the file's own skeleton (on `smpl22` where the file is one of ours), metres, Y up.

    Raises:
        FormatError: missing, damaged, without an animated skeleton, drawing in other files, or too much of it.
        MissingDependencyError: usd-core is not installed.
    """
    path = existing_file(path, MAX_BYTES)
    _require(path)
    with tempfile.TemporaryDirectory(prefix="motionloom-usd-") as folder:
        out = Path(folder) / "joints.npz"
        command = [sys.executable, "-m", "engines.formats.usd_child", str(path.resolve()), str(out), str(ROOM)]
        try:
            done = subprocess.run(
                [*command, str(MAX_JOINT_FRAMES)], capture_output=True, text=True, timeout=PATIENCE, check=False,
                cwd=Path(__file__).resolve().parents[2], stdin=subprocess.DEVNULL,
            )  # fmt: skip
        except subprocess.TimeoutExpired:
            raise FormatError(path, f"was not read within {PATIENCE:g} seconds.") from None
        if not out.exists():
            said = [line for line in done.stdout.splitlines() if line.startswith("usd: ")]
            raise FormatError(path, said[-1][5:] if said else "is damaged: the reader of usd-core gave up.")
        with np.load(out, allow_pickle=False) as stored:
            arrays = {name: stored[name] for name in stored.files}
    try:
        return _motion(path, arrays)
    except FormatError:
        raise
    except (MotionloomError, ValueError, IndexError) as problem:
        raise FormatError(path, f"is damaged: {str(problem)[:300]}") from problem


def sniff(path: Path, head: bytes) -> bool:
    """Does the file begin as USD does, binary or text?"""
    return head.startswith((b"PXR-USDC", b"#usda "))


def _require(path: Path) -> None:
    if find_spec("pxr") is None:
        raise MissingDependencyError("usd-core", "usd", f"USD ({path.name})")


def _motion(path: Path, arrays: dict[str, np.ndarray]) -> Motion:
    """The Motion of joints with world transforms in the rest pose and at every frame."""
    names = tuple(str(name) for name in arrays["names"])
    parents, fps = tuple(arrays["parents"].tolist()), float(arrays["fps"])
    places, turns = arrays["places"], rotations.normalise(arrays["turns"])
    rest_turns = rotations.normalise(arrays["rest_turns"])
    check_size(path, len(places), len(names))
    world = rotations.multiply(turns, rotations.invert(rest_turns)[None])
    local = np.array(world)
    offsets = np.zeros((len(names), 3))
    for joint, parent in enumerate(parents):
        if parent >= 0:
            local[:, joint] = rotations.multiply(rotations.invert(world[:, parent]), world[:, joint])
            bones = rotations.rotate(rotations.invert(world[:, parent]), places[:, joint] - places[:, parent])
            offsets[joint] = bones.mean(axis=0)
            if np.abs(bones - offsets[joint]).max() > max(STILL * np.abs(offsets).max(), 0.05):
                raise FormatError(
                    path, f"joint {names[joint]!r:.80} moves along its bone; accepted: bones of one length."
                )
    skeleton = roles.with_roles(Skeleton(path.stem, names, parents, offsets))
    made = Motion(skeleton, local, places[:, 0], fps)
    parameters: dict[str, Any] = {"format": "usd"}
    return as_house(made).replaced(provenance=Provenance(source=path.name, parameters=parameters))


FORMAT = Format("usd", (".usdc", ".usda", ".usd"), "USD (UsdSkel), with the extra 'usd'", sniff, read, write)
