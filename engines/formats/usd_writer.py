"""What a USD layer of a motion holds. Imported only where usd-core is."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
import pxr.Gf
import pxr.Sdf
import pxr.Tf
import pxr.Usd
import pxr.UsdGeom
import pxr.UsdSkel
import pxr.Vt

from engines.formats.glb_writer import Skin
from engines.motion import Motion
from engines.skeletons.skeleton import Skeleton

# the package's modules fill themselves when they load, which no type checker sees
Gf, Sdf, Tf, Vt = (cast(Any, module) for module in (pxr.Gf, pxr.Sdf, pxr.Tf, pxr.Vt))
Usd, UsdGeom, UsdSkel = (cast(Any, module) for module in (pxr.Usd, pxr.UsdGeom, pxr.UsdSkel))


def fill(layer: Any, motion: Motion, skin: Skin | None) -> None:
    """Put a motion, and a skin over its skeleton, into an empty layer."""
    stage = Usd.Stage.Open(layer)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    stage.SetTimeCodesPerSecond(motion.fps)
    stage.SetFramesPerSecond(motion.fps)
    stage.SetStartTimeCode(0)
    stage.SetEndTimeCode(len(motion) - 1)
    root = UsdSkel.Root.Define(stage, "/motion")
    stage.SetDefaultPrim(root.GetPrim())
    joints = joint_paths(motion.skeleton)
    skeleton = _skeleton(stage, motion.skeleton, joints, _floor(motion.skeleton, skin))
    animation = _animation(stage, motion, joints)
    UsdSkel.BindingAPI.Apply(skeleton.GetPrim()).CreateAnimationSourceRel().SetTargets([animation.GetPath()])
    if skin is not None:
        _mesh(stage, skin, skeleton, _floor(motion.skeleton, skin))


def joint_paths(skeleton: Skeleton) -> list[str]:
    """UsdSkel's names of joints: the way from the root, of names that USD allows, no two alike."""
    plain: list[str] = []
    for name in skeleton.joints:
        bare, count = Tf.MakeValidIdentifier(name), 2
        while bare in plain:
            bare, count = f"{Tf.MakeValidIdentifier(name)}_{count}", count + 1
        plain.append(bare)
    paths: list[str] = []
    for joint, parent in enumerate(skeleton.parents):
        paths.append(plain[joint] if parent < 0 else f"{paths[parent]}/{plain[joint]}")
    return paths


def _floor(skeleton: Skeleton, skin: Skin | None) -> float:
    points = skeleton.rest_positions if skin is None or not len(skin.vertices) else skin.vertices
    return float(points[:, 1].min())


def _at(place: np.ndarray) -> Any:
    return Gf.Matrix4d(1.0).SetTranslate(Gf.Vec3d(*map(float, place)))


def _skeleton(stage: Any, skeleton: Skeleton, joints: list[str], floor: float) -> Any:
    made = UsdSkel.Skeleton.Define(stage, "/motion/skeleton")
    made.CreateJointsAttr(joints)
    made.GetPrim().SetCustomDataByKey("motionloom:joints", Vt.StringArray(list(skeleton.joints)))
    lift = np.array([0.0, -floor, 0.0])
    made.CreateBindTransformsAttr([_at(place + lift) for place in skeleton.rest_positions])
    offsets = np.array(skeleton.offsets)
    offsets[0] += lift
    made.CreateRestTransformsAttr([_at(offset) for offset in offsets])
    return made


def _animation(stage: Any, motion: Motion, joints: list[str]) -> Any:
    """A key a frame: the way of the root, and all rotations."""
    made = UsdSkel.Animation.Define(stage, "/motion/animation")
    made.CreateJointsAttr(joints)
    made.CreateScalesAttr([Gf.Vec3h(1.0)] * len(joints))
    places, turns = made.CreateTranslationsAttr(), made.CreateRotationsAttr()
    still = motion.skeleton.offsets.astype(np.float32)
    for frame in range(len(motion)):
        now = np.array(still)
        now[0] = motion.translation[frame] + motion.skeleton.offsets[0]
        places.Set(Vt.Vec3fArray.FromNumpy(now), frame)
        turns.Set(Vt.QuatfArray([Gf.Quatf(*map(float, q)) for q in motion.rotations[frame]]), frame)
    return made


def _mesh(stage: Any, skin: Skin, skeleton: Any, floor: float) -> None:
    mesh = UsdGeom.Mesh.Define(stage, "/motion/" + Tf.MakeValidIdentifier(skin.name or "body"))
    lifted = np.asarray(skin.vertices, np.float32) - np.array([0.0, floor, 0.0], np.float32)
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(lifted)))
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(len(skin.faces), 3, np.int32)))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(np.ascontiguousarray(skin.faces, np.int32).reshape(-1)))
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    mesh.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(skin.normals, np.float32)))
    mesh.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
    colour = np.ascontiguousarray(_linear(skin.colours), np.float32)
    mesh.CreateDisplayColorPrimvar(UsdGeom.Tokens.vertex).Set(Vt.Vec3fArray.FromNumpy(colour))
    mesh.CreateExtentAttr([Gf.Vec3f(*map(float, lifted.min(0))), Gf.Vec3f(*map(float, lifted.max(0)))])
    binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
    indices = np.ascontiguousarray(skin.skin_indices, np.int32)
    weights = np.asarray(skin.skin_weights, np.float64)
    weights = np.ascontiguousarray(weights / weights.sum(axis=1, keepdims=True), np.float32)
    width = indices.shape[1]
    binding.CreateJointIndicesPrimvar(False, width).Set(Vt.IntArray.FromNumpy(indices.reshape(-1)))
    binding.CreateJointWeightsPrimvar(False, width).Set(Vt.FloatArray.FromNumpy(weights.reshape(-1)))
    binding.CreateGeomBindTransformAttr(Gf.Matrix4d(1.0))
    binding.CreateSkeletonRel().SetTargets([Sdf.Path(skeleton.GetPath())])


def _linear(colours: np.ndarray) -> np.ndarray:
    """(V, 3) sRGB bytes -> linear light, as USD has display colours."""
    srgb = np.asarray(colours, np.float64) / 255.0
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
