"""The bodies of the papers' other data sets, with the house skeleton's proportions and joint names.

Names are those of `smpl22` wherever a joint plays the same part, so that `Motion.retarget` carries motions over.
"""

from __future__ import annotations

import numpy as np

from engines.skeletons import SMPL22, Skeleton

_TIPS = {"toe_end": "foot", "hand": "wrist"}
"""Joints the house skeleton lacks, and the joint whose end they are."""


def _place(joint: str) -> np.ndarray:
    """Where a joint stands in the house rest pose (3,), metres."""
    for tip, near in _TIPS.items():
        if joint.endswith(tip):
            holder = joint.replace(tip, near)
            return SMPL22.rest_positions[SMPL22.index(holder)] + SMPL22.end_offsets[holder]
    return SMPL22.rest_positions[SMPL22.index(joint)]


def _chosen(name: str, *chains: str) -> Skeleton:
    """A skeleton of chains of joint names, each chain's first joint being the one it hangs from."""
    joints: list[str] = [chains[0].split()[0]]
    parents = [-1]
    for chain in chains:
        above, *rest = chain.split()
        for joint in rest:
            parents.append(joints.index(above))
            joints.append(joint)
            above = joint
    offsets = [_place(j) - (_place(joints[p]) if p >= 0 else 0.0) for j, p in zip(joints, parents, strict=True)]
    held = set(joints)
    return Skeleton(
        name=name,
        joints=tuple(joints),
        parents=tuple(parents),
        offsets=np.array(offsets),
        end_offsets={j: v for j, v in SMPL22.end_offsets.items() if j in held and parents.count(joints.index(j)) == 0},
        feet=SMPL22.feet,
        hinges={joint: axis for joint, axis in SMPL22.hinges.items() if joint in held},
        mirror_pairs=tuple((j, j.replace("left_", "right_")) for j in joints if j.startswith("left_")),
    )


KIT21 = _chosen(
    "kit21",
    "pelvis spine1 spine3 neck head",
    "neck right_shoulder right_elbow right_wrist",
    "neck left_shoulder left_elbow left_wrist",
    "pelvis right_hip right_knee right_ankle right_foot right_toe_end",
    "pelvis left_hip left_knee left_ankle left_foot left_toe_end",
)
"""KIT-ML's 21 joints in KIT-ML's order: no collar bones, arms hang from the neck, feet end in a toe tip."""

STYLE21 = _chosen(
    "style21",
    "pelvis left_hip left_knee left_ankle left_foot",
    "pelvis right_hip right_knee right_ankle right_foot",
    "pelvis spine1 spine3 neck head",
    "spine3 left_shoulder left_elbow left_wrist left_hand",
    "spine3 right_shoulder right_elbow right_wrist right_hand",
)
"""The 21 joints that the stylization data sets keep of CMU's 31: arms hang from the upper spine and end in a hand."""

_FINGERS = tuple(f"{finger}{i}" for finger in ("index", "middle", "pinky", "ring", "thumb") for i in (1, 2, 3))

SMPLH52 = (*SMPL22.joints, *(f"{side}_{joint}" for side in ("left", "right") for joint in _FINGERS))
"""Joint names of SMPL-H in its order: the 22 of `smpl22`, then 15 of each hand (Romero et al. 2017)."""
