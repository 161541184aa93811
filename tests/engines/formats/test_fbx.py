"""FBX goes through Blender, where there is one; where there is none it is said how to get it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from importlib.util import find_spec

import numpy as np
import pytest

from engines import formats
from engines.errors import FormatError, MissingDependencyError
from engines.formats import fbx
from tests.viewers import poses

needs_blender = pytest.mark.skipif(
    find_spec("bpy") is None and not os.environ.get(fbx.VARIABLE),
    reason=f"no Blender: pip install 'motionloom[fbx]', or ${fbx.VARIABLE}",
)
LOOK = """
import json, sys, bpy
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.import_scene.fbx(filepath=sys.argv[1])
rig = next(o for o in bpy.data.objects if o.type == "ARMATURE")
first, last = map(int, rig.animation_data.action.frame_range)
places = {}
for frame in (first, last):
    bpy.context.scene.frame_set(frame)
    places[frame - first] = {b.name: list(rig.matrix_world @ b.head) for b in rig.pose.bones}
meshes = [len(o.data.vertices) for o in bpy.data.objects if o.type == "MESH"]
print("LOOK" + json.dumps({"places": places, "meshes": meshes, "fps": bpy.context.scene.render.fps}))
"""


def test_without_blender_it_is_said_how_to_get_one(tmp_path, motion, monkeypatch):
    monkeypatch.delenv(fbx.VARIABLE, raising=False)
    monkeypatch.setattr(fbx, "find_spec", lambda name: None)
    with pytest.raises(MissingDependencyError, match=r"MOTIONLOOM_BPY_PYTHON.*pip install 'motionloom\[fbx\]'"):
        formats.write(motion, tmp_path / "a.fbx")
    assert not list(tmp_path.iterdir())


def test_a_python_without_blender_leaves_nothing(tmp_path, motion, monkeypatch):
    bare = tmp_path / "bare"
    bare.write_text(f"#!/bin/sh\nexec {sys.executable} -c 'raise SystemExit(\"no bpy in here\")'\n")
    bare.chmod(0o755)
    monkeypatch.setenv(fbx.VARIABLE, str(bare))
    with pytest.raises(FormatError, match="Blender could not write it: no bpy in here"):
        formats.write(motion, tmp_path / "a.fbx")
    monkeypatch.setenv(fbx.VARIABLE, str(tmp_path / "nowhere"))
    with pytest.raises(FormatError, match=r"nowhere cannot be run.*MOTIONLOOM_BPY_PYTHON"):
        formats.write(motion, tmp_path / "a.fbx")
    assert [p.name for p in tmp_path.iterdir()] == ["bare"]


def test_fbx_is_written_only(tmp_path):
    path = tmp_path / "a.fbx"
    path.write_bytes(fbx.MAGIC + b"  \x00\x1a\x00")
    with pytest.raises(FormatError):
        formats.read(path)


@needs_blender
def test_blender_finds_every_joint_where_it_was(tmp_path):
    from viewers.bodies import body_for

    body, motion = body_for(poses.stride(12))
    path = formats.write(motion, tmp_path / "walk.fbx", skin=body)
    assert [p.name for p in tmp_path.iterdir()] == ["walk.fbx"]
    done = subprocess.run([fbx.blender_python(), "-c", LOOK, str(path)], capture_output=True, text=True, check=True)
    seen = json.loads(next(line for line in done.stdout.splitlines() if line.startswith("LOOK"))[4:])
    assert seen["fps"] == 20 and set(seen["places"]) == {"0", "11"}
    assert len(seen["meshes"]) == 1 and seen["meshes"][0] >= 0.95 * len(body.vertices)
    for frame, places in seen["places"].items():
        wanted = motion.positions[int(frame)]
        turned = np.array([places[name] for name in motion.skeleton.joints]) @ np.array(
            [[1, 0, 0], [0, 0, -1], [0, 1, 0]]
        )
        np.testing.assert_allclose(turned, wanted, atol=2e-3)
