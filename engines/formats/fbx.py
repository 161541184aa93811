"""FBX out, by Blender's module `bpy` (extra `fbx`), which is the one free writer that other programs understand.

The motion, and a skin if one is given, goes as .glb into a Blender of its own process, and from there into .fbx:
metres, Y up, a key a frame, no leaf bones. Where `bpy` lives in another environment (it comes for one version of
Python only), `MOTIONLOOM_BPY_PYTHON` names that environment's Python.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path

from engines.errors import FormatError, MissingDependencyError
from engines.formats import glb_writer
from engines.formats.files import atomic_path
from engines.formats.glb_writer import Skin
from engines.formats.registry import Format
from engines.motion import Motion

VARIABLE = "MOTIONLOOM_BPY_PYTHON"
PATIENCE = 600.0
"""Seconds that Blender may take."""
MAGIC = b"Kaydara FBX Binary"

SCRIPT = """
import sys
import bpy
source, target, fps, frames = sys.argv[1], sys.argv[2], float(sys.argv[3]), int(sys.argv[4])
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.render.fps = max(1, round(fps))
scene.render.fps_base = scene.render.fps / fps
bpy.ops.import_scene.gltf(filepath=source, bone_heuristic="TEMPERANCE")
scene.frame_start, scene.frame_end = 0, frames - 1
bpy.ops.export_scene.fbx(
    filepath=target, object_types={"ARMATURE", "MESH"}, add_leaf_bones=False, bake_anim=True, bake_anim_step=1.0,
    bake_anim_simplify_factor=0.0, bake_anim_use_nla_strips=False, bake_anim_use_all_actions=False,
    bake_anim_force_startend_keying=True, apply_scale_options="FBX_SCALE_ALL", colors_type="SRGB",
)
"""


def write(motion: Motion, path: str | Path, skin: Skin | None = None) -> Path:
    """Write a motion as .fbx.

    Args:
        motion: any motion.
        path: the file.
        skin: a mesh fitted to the motion's own skeleton; without one the file holds joints and their animation.

    Returns:
        The path. Labels and provenance have no place in it.

    Raises:
        MissingDependencyError: there is no `bpy`; the message says how to get it.
        FormatError: Blender failed, or the file cannot be written.
        SkeletonError: the skin is of another skeleton.
    """
    path = Path(path)
    python = blender_python()
    with tempfile.TemporaryDirectory(prefix="motionloom-fbx-") as folder, atomic_path(path) as temporary:
        source = glb_writer.write(motion, Path(folder) / "motion.glb", skin)
        command = [python, "-c", SCRIPT, str(source), str(temporary), repr(motion.fps), str(len(motion))]
        try:
            done = subprocess.run(
                command, capture_output=True, text=True, timeout=PATIENCE, check=False, stdin=subprocess.DEVNULL,
                cwd=folder, errors="replace",
            )  # fmt: skip
        except subprocess.TimeoutExpired:
            raise FormatError(path, f"Blender did not finish within {PATIENCE:g} seconds.") from None
        except OSError as problem:
            raise FormatError(path, f"{python} cannot be run ({problem.strerror}); see ${VARIABLE}.") from problem
        with temporary.open("rb") as written:
            whole = written.read(len(MAGIC)) == MAGIC
        if done.returncode or not whole:
            said = [line for line in (done.stderr or done.stdout).splitlines() if line.strip()]
            raise FormatError(path, f"Blender could not write it: {said[-1].strip() if said else 'it said nothing'}")
    return path


def blender_python() -> str:
    """The Python that has `bpy`.

    Raises:
        MissingDependencyError: there is none; the message says how to get it.
    """
    named = os.environ.get(VARIABLE)
    if named:
        return named
    if find_spec("bpy") is None:
        raise MissingDependencyError("bpy", "fbx", f"FBX (or ${VARIABLE}, the Python of an environment that has it)")
    return sys.executable


def sniff(path: Path, head: bytes) -> bool:
    """Does the file begin as binary FBX?"""
    return head.startswith(MAGIC)


FORMAT = Format("fbx", (".fbx",), "FBX for Unity, Unreal and Maya, with the extra 'fbx'", sniff, None, write)
