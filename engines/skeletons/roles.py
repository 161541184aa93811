"""Which joint plays which part in the body, told from its name.

The parts, here *roles*, are the joints of `smpl22`. The names understood are those of CMU (BVH and ASF), Mixamo,
MotionBuilder, Bandai-Namco, SMPL, HumanML3D, 3ds Max Biped, Blender Rigify, Unreal, VRM, Poser and DAZ (as in the
cgspeed files), Xsens and Kinect; any name made of a side and a common word for the joint works.

Two conventions are settled by what else is there: "shoulder" is the collar bone where the arm has a joint of its own
(`LeftShoulder`, `LeftArm`) and the shoulder where not (`left_collar`, `left_shoulder`; Kinect); "foot" is the toe
joint where there is an ankle and the ankle where not.

**The spine.** All joints between pelvis and neck count, lowest first. One plays `spine1` (what it turns is the whole
trunk), two play `spine1` and `spine3`, three play one each; of more, the first, the middle and the last.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

import numpy as np

from engines.errors import SkeletonError
from engines.skeletons.skeleton import Skeleton
from engines.skeletons.smpl22 import SMPL22

Side = str
"""left, right or the empty string."""

ROLES = SMPL22.joints
"""All roles, in the order of `smpl22`."""

_NAMESPACE = re.compile(r"^.*[:|]")
_PREFIX = re.compile(
    r"^(mixamorig\d*[\s_.\-]*|(bip\d*|valvebiped|character\d*|j_bip|def|org|mch|ctrl|[mf]_avg|joint|bone|bn|jnt)[\s_.\-]+)",
    re.IGNORECASE,
)
_WORDS = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+")
_SIDES = {"left": "left", "l": "left", "lft": "left", "right": "right", "r": "right", "rt": "right", "rgt": "right"}
_CENTRE = {"c", "mid"}

_LIMBS: dict[str, tuple[str, ...]] = {
    # role without its side -> words that name it, the surest first
    "hip": ("upleg", "upperleg", "thigh", "thighbend", "legupper", "femur", "hip", "buttock"),
    "knee": ("knee", "lowerleg", "lowleg", "leglower", "calf", "shin", "tibia", "leg"),
    "ankle": ("ankle", "foot"),
    "foot": ("toebase", "toes", "toe", "toe0", "ball"),
    "collar": ("collar", "clavicle", "shoulder"),
    "shoulder": ("upperarm", "uparm", "armupper", "humerus", "shldr", "shldrbend", "arm", "shoulder"),
    "elbow": ("elbow", "lowerarm", "lowarm", "armlower", "forearm", "forearmbend", "radius"),
    "wrist": ("wrist", "hand"),
}
_PELVIS = ("pelvis", "hips", "hip", "hipcenter", "hipcentre", "spinebase", "root")
_SPINE = re.compile(
    r"(spine|chest|chestlower|chestupper|upperchest|abdomen|abdomenlower|abdomenupper|torso|thorax|lowerback|upperback"
    r"|back|waist)\d*"
)
_NECK = re.compile(r"(neck|lowerneck|upperneck|necklower|neckupper|shouldercenter|shouldercentre|spineshoulder)\d*")
_HEAD = ("head",)
_SMALL_SIDED = {*(word for words in _LIMBS.values() for word in words), "hipjoint", "thumb", "fingers"}
"""What may follow a small l or r without a break: lfemur, rfingers."""


def split_name(joint: str) -> tuple[Side, str]:
    """A joint's side ("left", "right" or "") and the rest of its name, lower case and bare: "LeftUpLeg" -> upleg."""
    bare = _NAMESPACE.sub("", joint.strip())
    while (shorter := _PREFIX.sub("", bare)) != bare and shorter:
        bare = shorter
    words = [word.lower() for word in _WORDS.findall(bare)]
    sides = [_SIDES[word] for word in words if word in _SIDES]
    rest = [word for word in words if word not in _SIDES and word not in _CENTRE]
    key = "".join(rest)
    if sides:
        return sides[0], key
    for letter, side in (("l", "left"), ("r", "right")):  # lfemur, lThigh written small
        if key.startswith(letter) and key[1:] in _SMALL_SIDED:
            return side, key[1:]
    return "", key


def recognise(joints: Iterable[str]) -> dict[str, str]:
    """Which of these joints plays which role: smpl22 joint name -> joint name, for the roles found.

    Args:
        joints: joint names, parents before children.
    """
    joints = list(joints)
    named: dict[tuple[Side, str], str] = {}
    for joint in joints:
        named.setdefault(split_name(joint), joint)
    found = _trunk(joints, named)
    for side in ("left", "right"):
        taken = set(found.values())
        for part, words in _LIMBS.items():
            choice = next((named[side, word] for word in words if (side, word) in named), None)
            if part == "foot" and (side, "ankle") in named:
                choice = named.get((side, "foot"), choice)
            if choice is not None and choice not in taken:
                found[f"{side}_{part}"] = choice
        _settle_shoulder(found, named, side)
    return {role: found[role] for role in ROLES if role in found}


def _settle_shoulder(found: dict[str, str], named: Mapping[tuple[Side, str], str], side: Side) -> None:
    """One joint cannot be collar and shoulder: a "shoulder" alone is the shoulder."""
    collar, shoulder = found.get(f"{side}_collar"), found.get(f"{side}_shoulder")
    if collar is not None and collar == shoulder:
        del found[f"{side}_collar"]


def _trunk(joints: list[str], named: Mapping[tuple[Side, str], str]) -> dict[str, str]:
    """Pelvis, spine, neck and head."""
    keys = [(split_name(joint), joint) for joint in joints]
    middle = [(key, joint) for (side, key), joint in keys if not side]
    pelvis = next((named["", word] for word in _PELVIS if ("", word) in named), None)
    head = next((named["", word] for word in _HEAD if ("", word) in named), None)
    spine = [joint for key, joint in middle if _SPINE.fullmatch(key) and joint != pelvis]
    neck = [joint for key, joint in middle if _NECK.fullmatch(key)]
    if pelvis is None and head is None and len(spine) >= 5:  # Rigify numbers one chain from pelvis to head
        pelvis, *spine, head = spine
        neck = neck or spine[3:]
        spine = spine[:3]
    found = {}
    if pelvis is not None:
        found["pelvis"] = pelvis
    for role, joint in zip(_spine_roles(len(spine)), _spread(spine), strict=True):
        found[role] = joint
    if neck:
        found["neck"] = neck[-1] if ("", "lowerback") in named and ("", "neck1") in named else neck[0]
    if head is not None:
        found["head"] = head
    return found


def _spine_roles(count: int) -> tuple[str, ...]:
    """The roles that a spine of `count` joints plays."""
    return ((), ("spine1",), ("spine1", "spine3"))[count] if count < 3 else ("spine1", "spine2", "spine3")


def _spread(spine: list[str]) -> list[str]:
    """At most three of the spine's joints: the first, the middle one, the last."""
    return spine if len(spine) <= 3 else [spine[0], spine[len(spine) // 2], spine[-1]]


def path_length(skeleton: Skeleton, above: str, below: str) -> float:
    """Length of the bones from joint `above` down to its descendant `below`.

    Raises:
        SkeletonError: `below` does not hang from `above`.
    """
    joint, top, total = skeleton.index(below), skeleton.index(above), 0.0
    while joint != top:
        if joint < 0 or skeleton.parents[joint] < 0:
            raise SkeletonError(f"joint {below!r} of skeleton {skeleton.name!r} does not hang from {above!r}.")
        total += float(skeleton.bone_lengths[joint])
        joint = skeleton.parents[joint]
    return total


LEG_TO_HEIGHT = 2.08
"""Height of a body over the length of hip to ankle, in `smpl22`."""


def body_height(skeleton: Skeleton, known: Mapping[str, str]) -> float:
    """Height of the body from its leg bones, whatever the rest pose; 0 where no leg is recognised."""
    lengths = []
    for side in ("left", "right"):
        hip, ankle = known.get(f"{side}_hip"), known.get(f"{side}_ankle")
        if hip and ankle:
            try:
                lengths.append(path_length(skeleton, hip, ankle))
            except SkeletonError:
                continue
    return LEG_TO_HEIGHT * float(np.mean(lengths)) if lengths else 0.0


def standing_direction(positions: np.ndarray, skeleton: Skeleton, known: Mapping[str, str]) -> np.ndarray | None:
    """(T, 3) unit vectors from between the ankles (or hips) to head (or neck); None where those are not recognised."""
    top = next((known[role] for role in ("head", "neck") if role in known), None)
    low = next((pair for pair in _PAIRS_BELOW if all(role in known for role in pair)), None)
    if top is None or low is None:
        return None
    below = positions[:, [skeleton.index(known[role]) for role in low]].mean(axis=1)
    up = positions[:, skeleton.index(top)] - below
    return up / np.maximum(np.linalg.norm(up, axis=-1, keepdims=True), 1e-12)


_PAIRS_BELOW = (("left_ankle", "right_ankle"), ("left_knee", "right_knee"), ("left_hip", "right_hip"))


def with_roles(skeleton: Skeleton) -> Skeleton:
    """The skeleton with `feet`, `mirror_pairs` and `hinges` filled in from its joints' names where recognised.

    Hinges are named only where the rest pose stands upright with straight legs and arms (a T- or A-pose): elsewhere
    the axis cannot be known.
    """
    known = recognise(skeleton.joints)
    feet = tuple(
        (known[f"{side}_ankle"], known[f"{side}_foot"])
        for side in ("left", "right")
        if f"{side}_ankle" in known and f"{side}_foot" in known
    )
    return skeleton.replaced(
        feet=feet if len(feet) == 2 else (),
        mirror_pairs=mirror_pairs(skeleton.joints),
        hinges=_hinges(skeleton, known),
    )


def mirror_pairs(joints: Iterable[str]) -> tuple[tuple[str, str], ...]:
    """(left, right) joints whose names differ in nothing but the side."""
    sides: dict[str, dict[Side, list[str]]] = {}
    for joint in joints:
        side, key = split_name(joint)
        if side:
            sides.setdefault(key, {}).setdefault(side, []).append(joint)
    return tuple(
        (pair["left"][0], pair["right"][0])
        for pair in sides.values()
        if len(pair.get("left", ())) == len(pair.get("right", ())) == 1
    )


def _hinges(skeleton: Skeleton, known: Mapping[str, str]) -> dict[str, np.ndarray]:
    """Axis of each knee and elbow, or nothing if the rest pose does not stand upright."""
    rest = skeleton.rest_positions
    needed = [f"{side}_{part}" for side in ("left", "right") for part in ("hip", "knee", "ankle")]
    if not all(role in known for role in [*needed, "head"]):
        return {}

    def bone(start: str, end: str) -> np.ndarray:
        way = rest[skeleton.index(known[end])] - rest[skeleton.index(known[start])]
        return way / max(float(np.linalg.norm(way)), 1e-12)

    up = np.array([0.0, 1.0, 0.0])
    upright = bone("left_hip", "head")[1] > 0.8
    legs = [bone(f"{s}_{a}", f"{s}_{b}") for s in ("left", "right") for a, b in (("hip", "knee"), ("knee", "ankle"))]
    if not upright or any(leg[1] > -0.8 for leg in legs):
        return {}
    left = bone("right_hip", "left_hip")
    forward = np.cross(left, up)
    forward /= max(float(np.linalg.norm(forward)), 1e-12)
    axes = {}
    for side, out in (("left", left), ("right", -left)):
        axes[known[f"{side}_knee"]] = np.cross(bone(f"{side}_hip", f"{side}_knee"), -forward)
        arm = [f"{side}_{part}" for part in ("shoulder", "elbow", "wrist")]
        if all(role in known for role in arm):
            upper, lower = bone(arm[0], arm[1]), bone(arm[1], arm[2])
            if min(upper @ out, lower @ out) > 0.35 and max(abs(upper @ forward), abs(lower @ forward)) < 0.6:
                axes[known[arm[1]]] = np.cross(upper, forward)
    return {joint: axis / np.linalg.norm(axis) for joint, axis in axes.items()}
