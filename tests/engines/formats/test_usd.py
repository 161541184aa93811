"""USD: what is written skins as the body does and reads back; what others write reads as they mean it."""

from __future__ import annotations

import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engines import formats
from engines.errors import FormatError, MissingDependencyError, SkeletonError
from engines.formats import usd
from engines.skeletons import SMPL22
from tests.engines.formats.conftest import random_motion
from tests.engines.formats.test_glb import tetrahedron

pytest.importorskip("pxr", reason="pip install 'motionloom[usd]'")
Usd, UsdGeom, UsdSkel, Vt = (import_module(f"pxr.{name}") for name in ("Usd", "UsdGeom", "UsdSkel", "Vt"))


def stage_of(path: Path) -> Any:
    return Usd.Stage.Open(str(path))


@pytest.mark.parametrize("end", ["usda", "usdc", "usd"])
def test_it_comes_back_as_it_was(tmp_path, motion, end):
    path = formats.write(motion, tmp_path / f"walk.{end}")
    again = formats.read(path)
    assert again.skeleton == SMPL22 and again.fps == motion.fps and len(again) == len(motion)
    np.testing.assert_allclose(again.positions, motion.positions, atol=2e-6)
    assert again.provenance.parameters["format"] == "usd"
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


def test_it_states_its_units_and_obeys_usdskel(tmp_path, motion):
    stage = stage_of(formats.write(motion, tmp_path / "walk.usdc", skin=tetrahedron()))
    assert UsdGeom.GetStageUpAxis(stage) == "Y" and UsdGeom.GetStageMetersPerUnit(stage) == 1.0
    assert stage.GetTimeCodesPerSecond() == motion.fps and stage.GetEndTimeCode() == len(motion) - 1
    root = stage.GetDefaultPrim()
    assert root.IsA(UsdSkel.Root) and [c.GetTypeName() for c in root.GetChildren()] == [
        "Skeleton",
        "SkelAnimation",
        "Mesh",
    ]
    skeleton = UsdSkel.Skeleton(root.GetChildren()[0])
    topology = UsdSkel.Topology(skeleton.GetJointsAttr().Get())
    assert topology.Validate()[0] and list(topology.GetParentIndices()) == list(SMPL22.parents)
    weights = UsdSkel.BindingAPI(root.GetChildren()[2]).GetJointWeightsPrimvar().Get()
    np.testing.assert_allclose(np.array(weights).reshape(-1, 4).sum(1), 1, atol=1e-6)


def test_usdskel_moves_vertices_as_the_body_does(tmp_path):
    from viewers.bodies import body_for

    body, motion = body_for(random_motion(3))
    stage = stage_of(formats.write(motion, tmp_path / "walk.usdc", skin=body))
    root, cache = UsdSkel.Root(stage.GetDefaultPrim()), UsdSkel.Cache()
    cache.Populate(root, Usd.PrimDefaultPredicate)
    mesh = next(prim for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh))
    skin = cache.GetSkinningQuery(mesh)
    pose = cache.GetSkelQuery(UsdSkel.Skeleton(stage.GetPrimAtPath("/motion/skeleton"))).ComputeSkinningTransforms(2)
    points = Vt.Vec3fArray(UsdGeom.Mesh(mesh).GetPointsAttr().Get())
    assert skin.ComputeSkinnedPoints(pose, points, 2)
    np.testing.assert_allclose(np.array(points), body.posed(motion, 2), atol=2e-5)
    assert len(UsdGeom.Mesh(mesh).GetFaceVertexCountsAttr().Get()) == len(body.faces)


FOREIGN = """#usda 1.0
(
    upAxis = "Z"
    metersPerUnit = 0.01
    timeCodesPerSecond = 25
)
def Xform "scene" {
    double3 xformOp:translate = (100, 0, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    def SkelRoot "figure" {
        def Skeleton "rig" (prepend apiSchemas = ["SkelBindingAPI"]) {
            uniform token[] joints = ["hip", "hip/knee"]
            uniform matrix4d[] bindTransforms = [
                ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 90, 1)),
                ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 50, 1))]
            uniform matrix4d[] restTransforms = [
                ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 90, 1)),
                ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, -40, 1))]
            rel skel:animationSource = <../moves>
        }
        def SkelAnimation "moves" {
            uniform token[] joints = ["hip", "hip/knee"]
            float3[] translations = [(0, 0, 90), (0, 0, -40)]
            quatf[] rotations.timeSamples = {
                10: [(1, 0, 0, 0), (1, 0, 0, 0)],
                12: [(0.70710678, 0.70710678, 0, 0), (1, 0, 0, 0)],
            }
            half3[] scales = [(1, 1, 1), (1, 1, 1)]
        }
    }
}
"""


def test_other_units_and_axes_are_brought_to_ours(tmp_path):
    path = tmp_path / "foreign.usda"
    path.write_text(FOREIGN)
    motion = formats.read(path)
    assert motion.skeleton.joints == ("hip", "knee") and motion.fps == 25.0 and len(motion) == 3
    np.testing.assert_allclose(motion.positions[0], [[1, 0.9, 0], [1, 0.5, 0]], atol=1e-6)
    # a quarter about X takes the shin from -Z to +Y, which with Y up is to -Z
    np.testing.assert_allclose(motion.positions[2], [[1, 0.9, 0], [1, 0.9, -0.4]], atol=1e-6)
    np.testing.assert_allclose(motion.positions[1, 1], [1, 0.9 - 0.4 * np.sqrt(0.5), -0.4 * np.sqrt(0.5)], atol=1e-6)


def swap(old: str, new: str) -> Callable[[str], str]:
    assert old in FOREIGN
    return lambda text: text.replace(old, new)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (swap('"figure" {', '"figure" (references = @/etc/other.usda@) {'), "draws in other files"),
        (swap("rel skel:animationSource = <../moves>", ""), "no animated skeleton"),
        (swap('["hip", "hip/knee"]', '["hip", "knee"]'), "several roots"),
        (swap("12: [", "1e9: ["), "far apart"),
        (lambda text: text[:900], "is no USD file|no animated"),
        (swap("translations = [(0, 0, 90)", "translations = [(0, 0, nan)"), "not numbers|no USD file"),
        (swap("scales = [(1, 1, 1)", "scales = [(0, 1, 1)"), "scaled to nothing"),
    ],
)  # fmt: skip
def test_files_that_cannot_be_read_say_why(tmp_path, change, said):
    path = tmp_path / "foreign.usda"
    path.write_text(change(FOREIGN))
    with pytest.raises(FormatError, match=said):
        formats.read(path)


def test_damaged_binaries_do_no_harm(tmp_path, motion):
    """The library may die of them: that happens in another process."""
    data = bytearray(formats.write(motion[:3], tmp_path / "walk.usdc").read_bytes())
    rng = np.random.default_rng(1)
    for number in range(3):
        hurt = bytearray(data)
        for at in rng.integers(88, len(hurt), 40):
            hurt[at] = rng.integers(256)
        path = tmp_path / f"hurt{number}.usdc"
        path.write_bytes(hurt)
        try:
            assert len(formats.read(path)) >= 1
        except FormatError as problem:
            assert str(path) in str(problem)


def test_a_reader_that_hangs_is_ended(tmp_path, motion, monkeypatch):
    path = formats.write(motion[:2], tmp_path / "walk.usdc")
    monkeypatch.setattr(usd, "PATIENCE", 0.05)
    with pytest.raises(FormatError, match=r"not read within 0\.05 seconds"):
        formats.read(path)


def test_a_skin_of_another_skeleton_is_refused(tmp_path, motion):
    with pytest.raises(SkeletonError, match="skin 'wedge'"):
        formats.write(motion, tmp_path / "a.usdc", skin=tetrahedron(SMPL22.scaled({"*": 2.0})))
    assert not list(tmp_path.iterdir())


def test_without_the_package_the_extra_is_named(tmp_path, motion, monkeypatch):
    monkeypatch.setattr(usd, "find_spec", lambda name: None)
    with pytest.raises(MissingDependencyError, match=r"pip install 'motionloom\[usd\]'"):
        formats.write(motion, tmp_path / "a.usdc")
    assert "pxr" in sys.modules and not list(tmp_path.iterdir())
