"""Biovision BVH in and out.

What the reader makes of a file:

- **Root.** Position channels of the root replace its OFFSET, as in Blender and bvhio; without them it stays at it.
- **Positions on other joints** replace their OFFSET too. Where they stand still, as in the Bandai-Namco sets, they
  become the skeleton's offset. A root with one child that travels (Bandai-Namco's `joint_Root` above `Hips`) is
  merged into that child exactly, and is no joint of the motion. Any other joint that moves along its bone keeps its
  mean, and `provenance.parameters["averaged_positions"]` says by how many metres it was off; where that would show
  (a joint of the body by more than `STRETCH_LIMIT`) the file is refused unless `stretch="mean"` is passed.
- **Units.** BVH names none. "auto" takes that of metres, centimetres, millimetres, inches, feet and CMU units
  (1/0.45 inch) which makes the body nearest to 1.7 m tall.
- **Up.** "auto" is Y unless nearly all poses stand along +Z.
- **Rotations** are those of the file, whatever the order of the channels, as quaternions.
"""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Literal

import numpy as np

from engines.errors import FormatError, OutOfRangeError
from engines.formats import bvh_text
from engines.formats.bvh_text import BvhText, Node
from engines.formats.bvh_writer import write
from engines.formats.files import read_bytes
from engines.formats.registry import Format
from engines.geometry import kinematics, rotations
from engines.motion import Motion, Provenance
from engines.skeletons import SMPL22, roles
from engines.skeletons.skeleton import Skeleton

STILL = 1e-4
"""Positions that vary by less than this, relative to the longest offset, stand still: the rounding of the text."""
STRETCH_LIMIT = 0.10
"""Metres by which a joint of the body may move along its bone before its mean is no longer good enough."""
UNITS = {"m": 1.0, "ft": 0.3048, "cmu": 0.0254 / 0.45, "in": 0.0254, "cm": 0.01, "mm": 0.001}
"""Metres in each unit that `scale="auto"` chooses from."""
BODY_HEIGHT = 1.7
"""Metres: the height "auto" looks for."""

log = logging.getLogger(__name__)


def read(
    path: str | Path,
    scale: float | str = "auto",
    up: Literal["auto", "y", "z"] = "auto",
    stretch: Literal["refuse", "mean"] = "refuse",
) -> Motion:
    """Read a BVH file.

    Args:
        path: the file.
        scale: metres in one unit of the file, one of the names in `UNITS`, or "auto".
        up: the file's vertical axis; a Z-up file is turned so that Y is up.
        stretch: what to do with a body joint that moves along its bone by more than `STRETCH_LIMIT`.

    Returns:
        A Motion on the file's own skeleton (on `smpl22` where the file is one of ours), metres, Y up.

    Raises:
        FormatError: the file is missing, damaged or no BVH; the message names the line.
        OutOfRangeError: an option that is none of these.
    """
    path, given = Path(path), _given_unit(scale)
    _check_choice("up", up, ("auto", "y", "z"))
    _check_choice("stretch", stretch, ("refuse", "mean"))
    text = bvh_text.parse(path, read_bytes(path))
    motion, places, merged = _in_file_units(path.stem, text)
    parameters: dict = {"format": "bvh", "frame_time": text.frame_time}
    if merged:
        parameters["merged_into_root"] = merged
    known = roles.recognise(motion.skeleton.joints)
    factor, parameters["unit"] = given or unit(motion, known)
    parameters["scale"] = factor
    parameters["up"] = _upright_axis(motion, known) if up == "auto" else up
    if averaged := _averaged(motion.skeleton, places, factor):
        parameters["averaged_positions"] = averaged
        _check_stretch(path, averaged, known, stretch)
    if parameters["up"] == "z":
        motion = _z_up_to_y_up(motion, known)
    motion = scaled(motion, factor)
    return as_house(motion).replaced(provenance=Provenance(source=path.name, parameters=parameters))


def _in_file_units(name: str, text: BvhText) -> tuple[Motion, np.ndarray, list[str]]:
    """The motion as the file has it, each joint's places relative to its parent (T, J, 3), and joints merged away."""
    turns, places = _decode(text)
    root = _merge_carriers(text.nodes, turns, places)
    nodes, turns, places = text.nodes[root:], turns[:, root:], places[:, root:]
    skeleton = Skeleton(
        name=name,
        joints=tuple(node.name for node in nodes),
        parents=tuple(node.parent - root if j else -1 for j, node in enumerate(nodes)),
        offsets=_fixed_offsets(places),
        end_offsets={node.name: np.array(node.end) for node in nodes if node.end and any(node.end)},
    )
    return Motion(skeleton, turns, places[:, 0], text.fps), places, [node.name for node in text.nodes[:root]]


def _given_unit(scale: float | str) -> tuple[float, str] | None:
    """Metres in one unit and its name, from the option `scale`; None for "auto"."""
    if scale == "auto":
        return None
    if isinstance(scale, str) and scale in UNITS:
        return UNITS[scale], scale
    if isinstance(scale, str) or not (np.isfinite(scale) and scale > 0):
        raise OutOfRangeError("scale", scale, f"'auto', a positive number of metres, or one of {', '.join(UNITS)}")
    return float(scale), "given"


def _check_choice(name: str, value: str, accepted: tuple[str, ...]) -> None:
    if value not in accepted:
        raise OutOfRangeError(name, value, ", ".join(map(repr, accepted)))


def _decode(text: BvhText) -> tuple[np.ndarray, np.ndarray]:
    """Quaternions (T, J, 4) and places relative to the parent (T, J, 3), file units, from the channel values."""
    frames, joints = len(text.values), len(text.nodes)
    turns = np.zeros((frames, joints, 4))
    places = np.empty((frames, joints, 3))
    by_order: dict[tuple[int, ...], list[tuple[int, list[int]]]] = {}
    column = 0
    for j, node in enumerate(text.nodes):
        places[:, j] = node.offset
        angles = []
        for kind, axis in node.channels or ():
            if kind == "position":
                places[:, j, axis] = text.values[:, column]
            else:
                angles.append(column)
            column += 1
        by_order.setdefault(node.order, []).append((j, angles))
    for order, group in by_order.items():
        columns = np.array([angles for _, angles in group], dtype=int)
        turns[:, [j for j, _ in group]] = _turn(text.values[:, columns], order)
    return turns, places


def _turn(degrees: np.ndarray, order: tuple[int, ...]) -> np.ndarray:
    """(..., n) angles about the axes `order`, each in the frame that those before it made -> (..., 4) wxyz.

    Written out because scipy wants three different neighbouring axes, and BVH files do not.
    """
    half = np.radians(degrees) / 2
    cos, sin = np.cos(half), np.sin(half)
    quaternion = np.zeros((*degrees.shape[:-1], 4))
    quaternion[..., 0] = 1.0
    for place, axis in enumerate(order):
        w, v = quaternion[..., 0], quaternion[..., 1:]
        c, s = cos[..., place], sin[..., place]
        along, left, right = axis, (axis + 1) % 3, (axis + 2) % 3
        product = np.empty_like(quaternion)
        product[..., 0] = w * c - v[..., along] * s
        product[..., 1 + along] = v[..., along] * c + w * s
        product[..., 1 + left] = v[..., left] * c + v[..., right] * s
        product[..., 1 + right] = v[..., right] * c - v[..., left] * s
        quaternion = product
    return quaternion


def _merge_carriers(nodes: list[Node], turns: np.ndarray, places: np.ndarray) -> int:
    """Index of the joint that becomes the root: below roots whose one child travels, composed with them in place."""
    root = 0
    while True:
        children = [j for j, node in enumerate(nodes) if node.parent == root]
        if len(children) != 1 or _travel(places[:, children[0]]) <= _still(places):
            return root
        child = children[0]
        places[:, child] = places[:, root] + rotations.rotate(turns[:, root], places[:, child])
        turns[:, child] = rotations.multiply(turns[:, root], turns[:, child])
        root = child


def _travel(places: np.ndarray) -> float:
    """Largest distance of places (T, 3) from their mean."""
    return float(np.linalg.norm(places - places.mean(axis=0), axis=-1).max())


def _still(places: np.ndarray) -> float:
    """Distance below which a place stands still; the longest bone says what is small."""
    return STILL * float(np.linalg.norm(places[0, 1:], axis=-1).max(initial=0.0))


def _fixed_offsets(places: np.ndarray) -> np.ndarray:
    """(J, 3) mean place of each joint, exactly the first where it never changes; zero for the root, which travels."""
    offsets = np.where((places == places[0]).all(axis=0), places[0], places.mean(axis=0))
    offsets[0] = 0.0
    return offsets


def _averaged(skeleton: Skeleton, places: np.ndarray, factor: float) -> dict[str, float]:
    """Metres by which each joint that moves along its bone leaves its mean."""
    still = _still(places)
    off = {name: _travel(places[:, j]) for j, name in enumerate(skeleton.joints) if j}
    return {name: round(travel * factor, 6) for name, travel in off.items() if travel > still}


def _check_stretch(path: Path, averaged: dict[str, float], known: dict[str, str], stretch: str) -> None:
    """Refuse a file in which a joint of the body leaves its mean by more than `STRETCH_LIMIT`."""
    body = [name for name in averaged if name in known.values()]
    worst = max(body, key=averaged.__getitem__, default=None)
    if worst and averaged[worst] > STRETCH_LIMIT and stretch != "mean":
        raise FormatError(
            path,
            f"joint {worst!r} moves {averaged[worst]:.2f} m along its bone; accepted: bones of fixed length (pass "
            "stretch='mean' to read it with the mean length).",
        )
    log.warning("%s: %d joints move along their bones; their mean place is used", path, len(averaged))


# ---- units and axes -----------------------------------------------------------------------------------


def _sample(motion: Motion) -> np.ndarray:
    """(at most 64, J, 3) positions of poses spread over the motion."""
    frames = np.unique(np.linspace(0, len(motion) - 1, 64).astype(int))
    return kinematics.forward_kinematics(
        rotations.quaternion_to_matrix(motion.rotations[frames]),
        motion.translation[frames],
        motion.skeleton.offsets,
        motion.skeleton.parents,
    )[0]


def unit(motion: Motion, known: dict[str, str]) -> tuple[float, str]:
    """Metres in the file's unit and its name: the unit in which the body is nearest to `BODY_HEIGHT`."""
    height = roles.body_height(motion.skeleton, known)
    if height <= 0:
        spread = np.ptp(_sample(motion), axis=1).max(axis=-1)
        height = float(np.median(spread))
    if height <= 0:
        return 1.0, "m"
    unit = min(UNITS, key=lambda name: abs(np.log(height * UNITS[name] / BODY_HEIGHT)))
    if 0.8 < height * UNITS[unit] < 2.8:
        return UNITS[unit], unit
    return BODY_HEIGHT / height, "fitted"


def _upright_axis(motion: Motion, known: dict[str, str]) -> Literal["y", "z"]:
    """The vertical axis: Z if nine poses in ten stand along +Z, else Y."""
    standing = roles.standing_direction(_sample(motion), motion.skeleton, known)
    return "z" if standing is not None and (standing[:, 2] > 0.8).mean() > 0.9 else "y"


def _z_up_to_y_up(motion: Motion, known: dict[str, str]) -> Motion:
    """The motion turned from Z up to Y up, rest pose included if that lies along Z too."""
    turn = np.array([np.sqrt(0.5), -np.sqrt(0.5), 0.0, 0.0])
    skeleton, turns = motion.skeleton, rotations.multiply(turn, motion.rotations)
    rest = roles.standing_direction(skeleton.rest_positions[None], skeleton, known)
    if rest is not None and abs(rest[0, 2]) < 0.8:  # the rest pose does not lie along Z: leave it as it is
        turns[:, 1:] = motion.rotations[:, 1:]
    else:
        turns = rotations.multiply(turns, rotations.invert(turn))
        ends = {name: rotations.rotate(turn, end) for name, end in skeleton.end_offsets.items()}
        skeleton = skeleton.replaced(offsets=rotations.rotate(turn, skeleton.offsets), end_offsets=ends)
    return motion.replaced(skeleton=skeleton, rotations=turns, translation=rotations.rotate(turn, motion.translation))


def scaled(motion: Motion, factor: float) -> Motion:
    """Lengths in metres, and feet, pairs and hinges named from the joints."""
    skeleton = motion.skeleton.replaced(
        offsets=motion.skeleton.offsets * factor,
        end_offsets={name: end * factor for name, end in motion.skeleton.end_offsets.items()},
    )
    return motion.replaced(skeleton=roles.with_roles(skeleton), translation=motion.translation * factor)


def as_house(motion: Motion) -> Motion:
    """The motion on `smpl22` itself, if its skeleton is that but for joint order and the rounding of a file."""
    mine = motion.skeleton
    if set(mine.joints) != set(SMPL22.joints):
        return motion
    order = [mine.index(name) for name in SMPL22.joints]
    above = [mine.joints[mine.parents[j]] if mine.parents[j] >= 0 else None for j in order]
    expected = [SMPL22.joints[p] if p >= 0 else None for p in SMPL22.parents]
    if above != expected or np.abs(mine.offsets[order] - SMPL22.offsets).max() > 1e-5:
        return motion
    return motion.replaced(skeleton=SMPL22, rotations=motion.rotations[:, order])


def sniff(path: Path, head: bytes) -> bool:
    """Does the file begin with HIERARCHY?"""
    return head.removeprefix(b"\xef\xbb\xbf").lstrip()[:9].upper() == b"HIERARCHY"


FORMAT = Format("bvh", (".bvh",), "Biovision BVH, Blender and motion capture programs", sniff, read, write)
