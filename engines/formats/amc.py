"""Acclaim motions (.amc with their skeleton .asf) in, as the CMU and HDM05 motion capture sets have them.

What the reader makes of a pair:

- **Joints.** Each bone turns about its start, so a joint stands there under the bone's name; what a bone leads to is
  the offset of its children. Bones that end a limb keep their length as end offsets.
- **Rotations.** A bone's channels turn it in a frame of its own, C (its `axis`): by C M C^-1 against its parent, M
  turning about the channels' axes one after another, each fixed. In the rest pose all are the identity.
- **Units.** As in BVH, that of which the body comes nearest to 1.7 m tall (CMU's is 1/0.45 inch).
- **Rate.** The file has none; CMU's is 120 frames a second, which is the default.
"""

from __future__ import annotations

from array import array
from pathlib import Path

import numpy as np

from engines.errors import FormatError, MotionloomError, OutOfRangeError
from engines.formats import asf, bvh
from engines.formats.asf import ROOT, Acclaim, Bone
from engines.formats.bvh_text import FPS_RANGE
from engines.formats.files import check_size, read_bytes
from engines.formats.registry import Format
from engines.geometry import rotations
from engines.motion import Motion, Provenance
from engines.skeletons import roles
from engines.skeletons.skeleton import Skeleton

MAX_BYTES = 64 * 2**20
"""No longer motion is read: over half an hour of CMU's 29 bones at 120 fps."""
USUAL_FPS = 120.0
"""CMU's rate."""


def read(path: str | Path, skeleton: str | Path | None = None, fps: float = USUAL_FPS) -> Motion:
    """Read an .amc and its skeleton.

    Args:
        path: the .amc.
        skeleton: its .asf; default: the one beside it of the same name, or named by what stands before the first "_"
            (38.asf for 38_01.amc), or the only one.
        fps: frames a second, which the file does not say.

    Returns:
        A Motion on the file's own skeleton, metres, Y up.

    Raises:
        FormatError: a file is missing, damaged or of another kind, or the two do not fit; the message names the line.
        OutOfRangeError: a rate that is no use.
    """
    path = Path(path)
    if not FPS_RANGE[0] <= fps <= FPS_RANGE[1]:
        raise OutOfRangeError("fps", fps, f"from {FPS_RANGE[0]} to {FPS_RANGE[1]:g}")
    if path.suffix.lower() == ".asf":
        raise FormatError(path, "is a skeleton without motion; accepted: an .amc, with this file beside it.")
    data = read_bytes(path, MAX_BYTES)
    found = Path(skeleton) if skeleton is not None else _beside(path)
    body = asf.parse(found)
    values, radians = _parse(path, data, body)
    try:
        motion = _motion(path.stem, body, values, radians, fps)
        known = roles.recognise(motion.skeleton.joints)
        factor, unit = bvh.unit(motion, known)
        motion = bvh.scaled(motion, factor)
    except FormatError:
        raise
    except (MotionloomError, ValueError, OverflowError) as error:
        raise FormatError(path, f"is damaged, or its skeleton {found.name} is: {str(error)[:300]}") from error
    parameters = {"format": "amc", "skeleton": found.name, "unit": unit, "scale": factor}
    return motion.replaced(provenance=Provenance(source=path.name, parameters=parameters))


def sniff(path: Path, head: bytes) -> bool:
    """Does the file begin as an .amc or an .asf?"""
    lines = [line.strip().lower() for line in head.splitlines()]
    first = next((line for line in lines if line and not line.startswith(b"#")), b"")
    return first.startswith((b":fully-specified", b":degrees", b":radians", b":version")) or head.startswith(
        b"#!OML:ASF"
    )


def _beside(path: Path) -> Path:
    """The skeleton of a motion, in its folder."""
    try:
        there = sorted(file for file in path.parent.iterdir() if file.suffix.lower() == ".asf")
    except OSError:
        there = []
    for stem in (path.stem, path.stem.split("_")[0]):
        named = next((file for file in there if file.stem.lower() == stem.lower()), None)
        if named is not None:
            return named
    if len(there) == 1:
        return there[0]
    raise FormatError(
        path,
        "needs its skeleton: an .asf beside it, of its name or of what stands before the first '_' (38.asf for "
        "38_01.amc), or read(..., skeleton=...). Where one file is taken alone, convert it first: motionloom convert.",
    )


# ---- the text -----------------------------------------------------------------------------------------------


def _parse(path: Path, data: bytes, body: Acclaim) -> tuple[np.ndarray, bool]:
    """(T, channels) values, the channels of all bones in their order, and whether angles are in radians."""
    slots, width = {}, 0
    for bone in body.bones.values():
        slots[bone.name] = (width, len(bone.channels))
        width += len(bone.channels)
    moving = sum(count > 0 for _, count in slots.values())
    radians, held, seen = body.radians, array("d"), set()
    row: list[float] = []

    def close(line: int) -> None:
        if not row:
            return
        if len(seen) != moving:
            missing = next(name for name, (_, count) in slots.items() if count and name not in seen)
            raise FormatError(path, f"the frame before this line lacks bone {missing!r:.80}.", line)
        held.extend(row)
        check_size(path, len(held) // width, len(body.bones), line)

    number = 0
    for number, line in enumerate(data.decode("utf-8", "replace").splitlines(), start=1):
        words = line.split()
        if not words or words[0][0] == "#":
            continue
        if words[0][0] == ":":
            radians = {":radians": True, ":degrees": False}.get(words[0].lower(), radians)
        elif len(words) == 1:
            close(number)
            row, seen = _new_frame(path, words[0], number, width)
        else:
            if not row:
                raise FormatError(path, "values before the first frame's number; is this an .amc?", number)
            start, count = _slot(path, number, words[0], slots, seen)
            row[start : start + count] = _values(path, number, words, count)
    close(number)
    if not held:
        raise FormatError(path, "holds no frames; accepted: an Acclaim motion with one frame or more.")
    return np.frombuffer(held, dtype=np.float64).reshape(-1, width), radians


def _new_frame(path: Path, word: str, line: int, width: int) -> tuple[list[float], set[str]]:
    """An empty row and the names seen in it."""
    if not word.isdecimal():
        raise FormatError(path, f"{word!r:.80} is no frame number and no bone with its values.", line)
    if width == 0:
        raise FormatError(path, "its skeleton has no channels at all, so that nothing can move.", line)
    return [0.0] * width, set()


def _slot(path: Path, line: int, name: str, slots: dict[str, tuple[int, int]], seen: set[str]) -> tuple[int, int]:
    """Where a bone's values go, and how many they are; it is noted as seen."""
    if name not in slots or name in seen:
        what = "twice in one frame" if name in slots else "no bone of its skeleton"
        raise FormatError(path, f"bone {name!r:.80} is {what}.", line)
    if slots[name][1]:
        seen.add(name)
    return slots[name]


def _values(path: Path, line: int, words: list[str], count: int) -> list[float]:
    """The numbers of a bone's line."""
    try:
        values = [float(word) for word in words[1:]]
    except ValueError:
        values = []
    if len(values) != count or not all(abs(value) < 1e12 for value in values):
        said = f"bone {words[0]!r:.80} has {' '.join(words[1:])!r:.80}; accepted: {count} numbers."
        raise FormatError(path, said, line)
    return values


# ---- the motion ---------------------------------------------------------------------------------------------


def _motion(name: str, body: Acclaim, values: np.ndarray, radians: bool, fps: float) -> Motion:
    """The motion in the file's units."""
    bones = list(body.bones.values())
    index = {bone.name: j for j, bone in enumerate(bones)}
    ends = [np.array(bone.direction) * bone.length for bone in bones]
    offsets, turns, at = np.zeros((len(bones), 3)), np.zeros((len(values), len(bones), 4)), 0
    path = np.tile(np.array(body.place), (len(values), 1))
    for j, bone in enumerate(bones):
        given = dict(zip(bone.channels, values[:, at : at + len(bone.channels)].T, strict=True))
        at += len(bone.channels)
        turns[:, j] = _turn(bone, given, radians, body.radians)
        if bone.name == ROOT:
            path = path + np.stack([given.get(f"t{axis}", np.zeros(len(values))) for axis in "xyz"], axis=-1)
        elif bone.parent != ROOT:
            offsets[j] = ends[index[bone.parent]]
    parents = tuple(index.get(bone.parent, -1) for bone in bones)
    leaves = {bone.name: ends[j] for j, bone in enumerate(bones) if j not in parents and ends[j].any()}
    return Motion(Skeleton(name, tuple(index), parents, offsets, end_offsets=leaves), turns, path, fps)


def _turn(bone: Bone, given: dict[str, np.ndarray], radians: bool, axis_radians: bool) -> np.ndarray:
    """(T, 4) C M C^-1 of a bone's channels."""
    axis = np.array(bone.axis) if axis_radians else np.radians(bone.axis)
    frame = _fixed(dict(zip(bone.axis_order, axis, strict=True)))
    angles = {name[1].upper(): value for name, value in given.items() if name[0] == "r"}
    moved = _fixed(angles if radians else {name: np.radians(value) for name, value in angles.items()})
    return rotations.multiply(rotations.multiply(frame, moved), rotations.invert(frame))


def _fixed(angles: dict[str, np.ndarray]) -> np.ndarray:
    """(..., 4) turns about fixed axes one after another, radians, in the mapping's order."""
    made = np.array([1.0, 0.0, 0.0, 0.0])
    for axis, angle in angles.items():
        about = np.eye(3)["XYZ".index(axis)]
        made = rotations.multiply(rotations.rotvec_to_quaternion(np.asarray(angle)[..., None] * about), made)
    return made


FORMAT = Format("amc", (".amc", ".asf"), "Acclaim motion (with its .asf beside it)", sniff, read)
