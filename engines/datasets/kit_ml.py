"""KIT Motion-Language (Plappert et al. 2016) in HumanML3D's layout: 3,911 motions of 21 joints at 12.5 fps.

Download: motion-annotation.humanoids.kit.edu/dataset for the original; the joints and features are those the
text-to-motion papers prepared (linked from github.com/EricGuo5513/HumanML3D). Put the folder into the source folder:

    KIT-ML/
      new_joints/00001.npy         (T, 21, 3) joint positions, Y up, not in metres (bodies are scaled here)
      new_joint_vecs/00001.npy     (T - 1, 251) features
      texts/00001.txt              as HumanML3D's
      train.txt  val.txt  test.txt

Mirrored clips have names that begin with M.
"""

from __future__ import annotations

from typing import ClassVar

from engines.datasets.humanml3d import HumanML3D

KIT21 = {
    "pelvis": 0, "spine1": 1, "spine3": 2, "neck": 3, "head": 4,
    "right_shoulder": 5, "right_elbow": 6, "right_wrist": 7, "left_shoulder": 8, "left_elbow": 9, "left_wrist": 10,
    "right_hip": 11, "right_knee": 12, "right_ankle": 13, "right_foot": 14,
    "left_hip": 16, "left_knee": 17, "left_ankle": 18, "left_foot": 19,
}  # fmt: skip
"""KIT's 21 joints; 15 and 20 are the tips of the toes."""


class KITML(HumanML3D):
    """Motions as joints or 251-d features, with texts, official splits and mirrored clips."""

    name = "kit-ml"
    archive = "KIT-ML/ (folder)"
    licence = "research use; cite Plappert et al. 2016"
    download = "https://motion-annotation.humanoids.kit.edu/dataset/"
    layout = "KIT-ML/ with new_joints/ (or new_joint_vecs/), texts/, train.txt, val.txt, test.txt"

    fps = 12.5
    joints = 21
    codec = "kit-official"
    roles: ClassVar = KIT21
