"""NTU RGB+D (Liu et al. 2019) as estimated from its videos by VIBE (Kocabas et al. 2020): 13 actions, 30 fps.

Download: rose1.ntu.edu.sg/dataset/actionRecognition (videos, on request); VIBE is at github.com/mkocabas/VIBE. Put
one file a clip, named as the video, into the source folder:

    NTU-RGBD-VIBE/
      S001C001P001R001A007.npy     (T, 18, 3): the 18 joints the Action2Motion paper keeps of VIBE's, root first
                                   (T, 49, 3): all of VIBE's `joints3d`;  (T, 24, 3): SMPL's joints
      S001C001P001R001A007.npz     or VIBE's own arrays: `joints3d` (T, 49, 3)

VIBE itself writes pickled files, which may run code when opened and are not read; to convert one:
`numpy.savez(name, joints3d=joblib.load("vibe_output.pkl")[person]["joints3d"])`.

VIBE's clips stand still in the world: it does not estimate the way a person goes. Axes are a camera's, y down; bodies
are turned upright here.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from engines.datasets.corpus import ClipInfo, labelled, to_house
from engines.datasets.folders import files_below
from engines.datasets.joints import SMPL24, from_joints, load_npy
from engines.errors import FormatError
from engines.formats import arrays
from engines.motion import Motion

_FILE = re.compile(r"S(\d{3})C(\d{3})P(\d{3})R(\d{3})A(\d{3})")

ACTIONS: dict[int, tuple[str, str | None]] = {
    # the data set's own number -> label, the action of `engines.actions` it is
    6: ("pick up", None), 7: ("throw", "throw"), 8: ("sitting down", "sit down"), 9: ("standing up", "stand up"),
    22: ("cheer up", None), 23: ("hand waving", None), 24: ("kicking something", "kick"), 38: ("salute", None),
    80: ("squat down", "squat"), 93: ("shake fist", None), 99: ("running on the spot", "jog in place"),
    100: ("butt kicks", None), 102: ("side kick", "kick"),
}  # fmt: skip
"""The 13 actions of the Action2Motion paper (table 4)."""

VIBE18 = {
    "pelvis": 0, "neck": 1, "right_shoulder": 2, "right_elbow": 3, "right_wrist": 4, "left_shoulder": 5,
    "left_elbow": 6, "left_wrist": 7, "right_hip": 9, "right_knee": 10, "right_ankle": 11, "left_hip": 12,
    "left_knee": 13, "left_ankle": 14, "head": 17,
}  # fmt: skip
"""The 18 joints kept: 8 is the nose, 15 and 16 are the heels."""
VIBE49 = {**VIBE18, "pelvis": 8, "left_foot": 19, "right_foot": 22, "head": 38}
"""Of VIBE's 49 joints (OpenPose's 25, then others): its nose is 0 and its root 8."""
_BODIES = {18: VIBE18, 24: SMPL24, 49: VIBE49}


class NTURGBD:
    """Clips named by the video they come from."""

    name = "ntu-rgbd"
    archive = "NTU-RGBD-VIBE/ (folder)"
    licence = "research use, on request; cite Liu et al. 2019 and Kocabas et al. 2020"
    download = "https://rose1.ntu.edu.sg/dataset/actionRecognition/"
    layout = "NTU-RGBD-VIBE/ with S...C...P...R...A....npy, (T, 18, 24 or 49, 3)"

    fps = 30.0

    def clips(self, folder: Path) -> Iterator[ClipInfo]:
        """Every file named as a video of one of the 13 actions."""
        for path in files_below(folder, "S*A*.np[yz]"):
            match = _FILE.match(path.stem)
            if match and int(match[5]) in ACTIONS:
                label, action = ACTIONS[int(match[5])]
                yield ClipInfo(self.name, path.stem, path, action, subject=match[3], label=label)

    def read(self, clip: ClipInfo) -> Motion:
        """A clip on `smpl22`, upright."""
        joints = load_npy(clip.path) if clip.path.suffix == ".npy" else _vibe_arrays(clip.path)
        count = joints.shape[1] if joints.ndim == 3 else 0
        if count not in _BODIES:
            raise FormatError(clip.path, f"has shape {joints.shape}; accepted: (frames, 18, 24 or 49, 3).")
        return to_house(labelled(from_joints(clip.path, joints, _BODIES[count], self.fps, turned=True), clip))


def _vibe_arrays(path: Path) -> np.ndarray:
    """`joints3d` of an .npz."""
    held = arrays.load(path, ("joints3d",))
    if "joints3d" not in held or held["joints3d"].dtype.kind != "f":
        raise FormatError(path, "array 'joints3d' is missing; accepted: VIBE's joints3d, (frames, 49, 3).")
    return held["joints3d"]
