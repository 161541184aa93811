"""Reads USD in a process of its own: `python -m engines.formats.usd_child IN OUT.npz BYTES JOINT_FRAMES`.

What is wrong with the file is told on standard output after "usd: "; if the library itself dies, nothing is.
"""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np


class _Refused(Exception):
    """What is wrong, in words for a person."""


def main(source: str, target: str, room: int, most: int) -> int:
    """Read one file; returns the exit code."""
    _limit(room)
    try:
        arrays = _joints(source, most)
    except _Refused as problem:
        sys.stdout.write(f"usd: {problem}\n")
        return 1
    part = Path(target).with_suffix(".part.npz")
    np.savez(part, **arrays)
    part.replace(target)
    return 0


def _limit(room: int) -> None:
    try:
        import resource
    except ImportError:  # not on Windows
        return
    resource.setrlimit(resource.RLIMIT_AS, (room, room))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def _joints(source: str, most: int) -> dict[str, Any]:
    """World transforms of the joints, at rest and at every frame."""
    Sdf, Tf, Usd, UsdGeom, UsdSkel = (
        import_module(f"pxr.{name}") for name in ("Sdf", "Tf", "Usd", "UsdGeom", "UsdSkel")
    )
    try:
        layer = Sdf.Layer.FindOrOpen(source)
    except Tf.ErrorException as problem:
        raise _Refused(f"is no USD file that can be read ({str(problem).splitlines()[-1].strip()[:200]}).") from problem
    if layer is None:
        raise _Refused("is no USD file that can be read.")
    if layer.GetCompositionAssetDependencies():
        raise _Refused("draws in other files; accepted: one file that holds all (flatten it: usdcat --flatten).")
    stage = Usd.Stage.Open(layer)
    found = _animated(stage, UsdSkel.Cache(), UsdSkel, Usd.PrimDefaultPredicate)
    times = found.GetAnimQuery().GetJointTransformTimeSamples()
    rate, scale = float(stage.GetTimeCodesPerSecond()), float(UsdGeom.GetStageMetersPerUnit(stage))
    names = [str(name) for name in found.GetJointOrder()]
    frames = _frames(times)
    if len(frames) * len(names) > most:
        raise _Refused(f"holds {len(frames):,} frames of {len(names)} joints, which is too much.")
    turn = _upright(str(UsdGeom.GetStageUpAxis(stage)))
    place = UsdGeom.XformCache()
    rest = _world(found.ComputeJointSkelTransforms(Usd.TimeCode.Default(), True), turn, scale)
    worlds = []
    for time in frames:
        place.SetTime(time)
        above = np.array(place.GetLocalToWorldTransform(found.GetPrim()))
        worlds.append(_world(found.ComputeJointSkelTransforms(time, False), turn, scale, above))
    parents = list(found.GetTopology().GetParentIndices())
    if not parents or parents[0] != -1 or -1 in parents[1:]:
        raise _Refused("has a skeleton with several roots; accepted: one.")
    return {
        "names": np.array(_short(found, names)), "parents": np.array(parents, np.int64), "fps": rate,
        "places": np.stack([world[0] for world in worlds]), "turns": np.stack([world[1] for world in worlds]),
        "rest_turns": rest[1],
    }  # fmt: skip


def _animated(stage: Any, cache: Any, skel: Any, predicate: Any) -> Any:
    """The query of the first skeleton whose animation has more than one time."""
    best = None
    for prim in stage.Traverse():
        if prim.IsA(skel.Root):
            cache.Populate(skel.Root(prim), predicate)
        if not prim.IsA(skel.Skeleton):
            continue
        query = cache.GetSkelQuery(skel.Skeleton(prim))
        animation = query.GetAnimQuery() if query else None
        if animation and animation.GetJointTransformTimeSamples() and query.GetJointOrder():
            best = best or query
    if best is None:
        raise _Refused("has no animated skeleton (UsdSkel).")
    return best


def _frames(times: list[float]) -> np.ndarray:
    """A whole time code a frame, from the first to the last."""
    first, last = times[0], times[-1]
    if not (np.isfinite([first, last]).all() and last - first < 1e6):
        raise _Refused("has times that are no numbers, or far apart.")
    return np.arange(first, last + 1e-6)


def _upright(axis: str) -> np.ndarray:
    """(3, 3) that turns row vectors to Y up."""
    if axis == "Z":
        return np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])
    return np.eye(3)


def _world(transforms: Any, turn: np.ndarray, scale: float, above: np.ndarray | None = None) -> tuple:
    """Places (J, 3), metres, and unit quaternions (J, 4) wxyz of matrices for row vectors."""
    from scipy.spatial.transform import Rotation

    if transforms is None or not len(transforms):
        raise _Refused("has joints without transforms.")
    matrices = np.array(transforms, np.float64).reshape(-1, 4, 4)
    if above is not None:
        matrices = matrices @ above
    if not np.isfinite(matrices).all():
        raise _Refused("has transforms that are not numbers.")
    axes = matrices[:, :3, :3] @ turn
    lengths = np.linalg.norm(axes, axis=2, keepdims=True)
    if lengths.min() < 1e-9 or (np.linalg.det(axes) <= 0).any():
        raise _Refused("has joints scaled to nothing, or mirrored.")
    quaternions = Rotation.from_matrix((axes / lengths).transpose(0, 2, 1)).as_quat()[:, [3, 0, 1, 2]]
    return scale * matrices[:, 3, :3] @ turn, quaternions


def _short(query: Any, paths: list[str]) -> list[str]:
    """Names of joints: those we wrote, else the last part of each path where no two are alike."""
    stated = query.GetPrim().GetCustomDataByKey("motionloom:joints")
    if stated is not None and len(stated) == len(paths) == len(set(stated)):
        return [str(name)[:200] for name in stated]
    short = [path.split("/")[-1][:200] for path in paths]
    return short if len(set(short)) == len(short) else [path.replace("/", "_")[:400] for path in paths]


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4])))
