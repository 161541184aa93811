"""Binary glTF (.glb) in and out: an animated skeleton to a Motion, a Motion to a skinned or bare animated skeleton.

What the reader makes of a file:

- **Joints** are those of the skin that has most, or of the animation where there is no skin, and the nodes between
  them; what stands above the topmost (an armature with a scale, a turned parent) is reckoned in and is no joint.
- **Rest pose.** The nodes as they stand in the file; rotations are told from there, so that joints whose axes lie
  along their bones come out like any other. Positions are the file's exactly.
- **Rate.** That of the keys where they are even, else 30 frames a second; linear, step and cubic keys are understood.
- **Root.** As in BVH, a root whose one child travels is merged into that child.
- **Other joints that move along their bones** keep their mean place; where a joint of the body would be off by more
  than `bvh.STRETCH_LIMIT` the file is refused unless `stretch="mean"` is passed.

Metres, Y up and facing +Z are glTF's conventions and ours. Meshes, cameras and materials are passed over.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from engines.errors import FormatError, MotionloomError, OutOfRangeError
from engines.formats.bvh import STILL, STRETCH_LIMIT, as_house
from engines.formats.files import read_bytes
from engines.formats.glb_nodes import joint_nodes, node_names, node_parents
from engines.formats.glb_tracks import Tracks
from engines.formats.glb_writer import write
from engines.formats.gltf import MAGIC, Gltf
from engines.formats.registry import Format
from engines.geometry import rotations
from engines.motion import Motion, Provenance
from engines.skeletons import roles
from engines.skeletons.skeleton import Skeleton

UNEVEN = 0.01
"""Share by which the scale of a node may differ between axes, or change in time, and still count as one number."""

log = logging.getLogger(__name__)


def read(path: str | Path, animation: int | str = 0, stretch: Literal["refuse", "mean"] = "refuse") -> Motion:
    """Read the animation of a .glb's skeleton.

    Args:
        path: the file.
        animation: number or name of the animation, where there are several.
        stretch: what to do with a body joint that moves along its bone by more than `bvh.STRETCH_LIMIT`.

    Returns:
        A Motion on the file's own skeleton (on `smpl22` where the file is one of ours), metres, Y up.

    Raises:
        FormatError: the file is missing, damaged, no .glb, or has no animated skeleton.
        OutOfRangeError: an option that is none of these.
    """
    path = Path(path)
    if stretch not in ("refuse", "mean"):
        raise OutOfRangeError("stretch", stretch, "'refuse', 'mean'")
    gltf = Gltf(path, read_bytes(path))
    try:
        with np.errstate(all="ignore"):  # what is not a number is found and refused by Motion
            return _motion(gltf, Tracks(gltf, animation), stretch)
    except FormatError:
        raise
    except (MotionloomError, KeyError, TypeError, ValueError, IndexError, AttributeError, OverflowError) as error:
        raise FormatError(path, f"is damaged: {str(error)[:300]}") from error


def sniff(path: Path, head: bytes) -> bool:
    """Does the file begin as binary glTF?"""
    return head[:4] == MAGIC


# ---- poses ------------------------------------------------------------------------------------------------


@dataclass
class _Pose:
    """Nodes of a chain of command, parents first, in the local frames of their parents."""

    parents: list[int]
    """Index of each one's parent among them; -1 for the first."""
    places: list[np.ndarray]
    """(T or 1, 3) of each."""
    turns: list[np.ndarray]
    """(T or 1, 4) of each, wxyz."""
    scales: list[float]
    """One number of each."""

    def world(self) -> tuple[list[np.ndarray], list[np.ndarray], list[float]]:
        """Positions (T or 1, 3), rotations (T or 1, 4) and scale of each in the world."""
        places, turns, scales = [], [], []
        for j, parent in enumerate(self.parents):
            if parent < 0:
                places.append(self.places[j])
                turns.append(self.turns[j])
                scales.append(self.scales[j])
                continue
            places.append(places[parent] + rotations.rotate(turns[parent], self.places[j] * scales[parent]))
            turns.append(rotations.multiply(turns[parent], self.turns[j]))
            scales.append(scales[parent] * self.scales[j])
        return places, turns, scales


def _resting(gltf: Gltf, node: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Translation (3,), rotation (4,) wxyz and scale (3,) of a node as it stands in the file."""
    stated = gltf.item("nodes", node)
    if "matrix" in stated:
        matrix = np.array(stated["matrix"], dtype=np.float64).reshape(4, 4).T
        scale = np.linalg.norm(matrix[:3, :3], axis=0)
        if not np.linalg.det(matrix[:3, :3]) > 0:
            raise FormatError(gltf.path, f"node {node} is mirrored or flat; accepted: joints that turn and move.")
        return matrix[:3, 3], rotations.matrix_to_quaternion(matrix[:3, :3] / scale), scale
    place = np.array(stated.get("translation", (0.0, 0.0, 0.0)), dtype=np.float64).reshape(3)
    turn = np.array(stated.get("rotation", (0.0, 0.0, 0.0, 1.0)), dtype=np.float64).reshape(4)[[3, 0, 1, 2]]
    scale = np.array(stated.get("scale", (1.0, 1.0, 1.0)), dtype=np.float64).reshape(3)
    if not 0.5 < float(np.linalg.norm(turn)) < 2.0:
        raise FormatError(gltf.path, f"node {node} has a rotation that is no unit quaternion.")
    return place, rotations.normalise(turn), scale


def _poses(gltf: Gltf, tracks: Tracks, nodes: list[int], above: list[int], at: np.ndarray) -> tuple[_Pose, _Pose]:
    """These nodes at rest and in motion."""
    index = {node: i for i, node in enumerate(nodes)}
    rest, moving = _Pose(above, [], [], []), _Pose(above, [], [], [])
    for node in index:
        place, turn, scale = _resting(gltf, node)
        sampled = [tracks.sampled(node, what, at) for what in ("translation", "rotation", "scale")]
        rest.places.append(place[None])
        rest.turns.append(turn[None])
        rest.scales.append(_one_scale(gltf.path, node, scale[None]))
        moving.places.append(place[None] if sampled[0] is None else sampled[0])
        moving.turns.append(turn[None] if sampled[1] is None else sampled[1])
        moving.scales.append(rest.scales[-1] if sampled[2] is None else _one_scale(gltf.path, node, sampled[2]))
    return rest, moving


def _one_scale(path: Path, node: int, scales: np.ndarray) -> float:
    """The one number that (T, 3) scales are."""
    mean = float(scales.mean())
    if not (mean > 0 and np.abs(scales - mean).max() <= UNEVEN * mean):
        raise FormatError(path, f"node {node} is stretched unevenly or more and less in time; accepted: one scale.")
    return mean


def _motion(gltf: Gltf, tracks: Tracks, stretch: str) -> Motion:
    """The animation as a Motion."""
    parents = node_parents(gltf)
    carriers, joints = joint_nodes(gltf, sorted(tracks.nodes), parents)
    nodes = carriers + joints
    index = {node: i for i, node in enumerate(nodes)}
    times, fps = tracks.frames(nodes)
    above = [index.get(parents[node], -1) if i else -1 for i, node in enumerate(nodes)]
    rest, moving = _poses(gltf, tracks, nodes, above, times)
    places, turns, scales = moving.world()
    rest_turns = rest.world()[1]
    kept = _below_carriers(moving, len(carriers))
    names = node_names(gltf, [nodes[j] for j in kept])
    order = {j: i for i, j in enumerate(kept)}
    count = len(times)
    # turned from the rest pose: G R^-1 in the world, then relative to the parent's
    world = np.stack(
        [np.broadcast_to(rotations.multiply(turns[j], rotations.invert(rest_turns[j])), (count, 4)) for j in kept]
    )
    local = [world[0]]
    offsets = np.zeros((len(kept), 3))
    for i, j in enumerate(kept[1:], start=1):
        parent = above[j]
        local.append(rotations.multiply(rotations.invert(world[order[parent]]), world[i]))
        offsets[i] = rotations.rotate(rest_turns[parent][0], moving.places[j].mean(axis=0) * scales[parent])
    skeleton = roles.with_roles(
        Skeleton(
            gltf.path.stem, names, tuple(order.get(above[j], -1) if i else -1 for i, j in enumerate(kept)), offsets
        )
    )
    parameters: dict[str, Any] = {"format": "glb", "animation": tracks.name}
    swings = {name: _travel(moving.places[j]) * scales[above[j]] for name, j in list(zip(names, kept, strict=True))[1:]}
    if averaged := _averaged(gltf.path, skeleton, swings, stretch):
        parameters["averaged_positions"] = averaged
    path = np.broadcast_to(places[kept[0]], (count, 3))
    made = Motion(skeleton, np.stack(local, axis=1), path, fps)
    return as_house(made).replaced(provenance=Provenance(source=gltf.path.name, parameters=parameters))


def _below_carriers(pose: _Pose, root: int) -> list[int]:
    """The joints from the root down; a root whose one child travels leaves its place to that child."""
    children: dict[int, list[int]] = {}
    for j, parent in enumerate(pose.parents):
        children.setdefault(parent, []).append(j)
    lengths = np.array([np.linalg.norm(place[0]) for place in pose.places])
    while len(below := children.get(root, [])) == 1:
        if _travel(pose.places[below[0]]) <= max(STILL * float(lengths[root + 1 :].max()), 1e-9):
            break
        root = below[0]
    kept = {root}
    for j, parent in enumerate(pose.parents):
        if parent in kept:
            kept.add(j)
    return sorted(kept)


def _travel(places: np.ndarray) -> float:
    """Largest distance of places (T, 3) from their mean."""
    return float(np.linalg.norm(places - places.mean(axis=0), axis=-1).max())


def _averaged(path: Path, skeleton: Skeleton, swings: dict[str, float], stretch: str) -> dict[str, float]:
    """Metres by which joints that move along their bones leave their mean; a body's joint by too much is refused."""
    still = STILL * float(skeleton.bone_lengths.max())
    off = {name: round(swing, 6) for name, swing in swings.items() if swing > max(still, 1e-6)}
    body = [name for name in off if name in roles.recognise(skeleton.joints).values()]
    worst = max(body, key=off.__getitem__, default=None)
    if worst and off[worst] > STRETCH_LIMIT and stretch != "mean":
        raise FormatError(
            path,
            f"joint {worst!r:.80} moves {off[worst]:.2f} m along its bone; accepted: bones of fixed length (pass "
            "stretch='mean' to read it with the mean length).",
        )
    if off:
        log.warning("%s: %d joints move along their bones; their mean place is used", path, len(off))
    return off


FORMAT = Format(
    "glb", (".glb",), "binary glTF, animated skeletons for engines, Blender and the web", sniff, read, write
)
