"""HumanAct12 (Guo et al. 2020): 1,191 clips of 12 coarse and 34 fine actions, SMPL's 24 joints.

Download: ericguo5513.github.io/action-to-motion (the data set is a zip of .npy files). Put the folder into the source
folder:

    HumanAct12/
      P01G01R01F0001T0064A0101.npy    (T, 24, 3) joint positions

The name says subject (P), group, recording, first and last frame, and the action: two digits coarse, two fine. The
files state no rate; they are taken as 20 fps, as HumanML3D takes them. Their axes are a camera's: bodies are turned
upright here.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from engines.datasets.corpus import ClipInfo, labelled, to_house
from engines.datasets.folders import files_below
from engines.datasets.joints import SMPL24, from_joints, load_npy
from engines.motion import Motion

_FILE = re.compile(r"P(\d+)G\d+R\d+F\d+T\d+A(\d{2})(\d{2})")

ACTIONS: tuple[tuple[str, str | None, tuple[str, ...]], ...] = (
    # coarse label, the action of `engines.actions` it is, fine labels in the order of their codes (thesis, table 3.1)
    ("warm up", None, (
        "warm up, wrist and ankle", "warm up, pectoral", "warm up, elbow back", "warm up, lean right arm",
        "warm up, lean left arm", "warm up, bow right", "warm up, bow left")),
    ("walk", "walk", ("walk",)),
    ("run", "run", ("run",)),
    ("jump", "jump", ("jump, hands up", "jump, vertical")),
    ("drink", None, (
        "drink, bottle in right hand", "drink, bottle in left hand", "drink, cup in right hand",
        "drink, cup in left hand", "drink, both hands")),
    ("lift dumbbell", None, (
        "lift dumbbell, right hand", "lift dumbbell, left hand", "lift dumbbell, both hands",
        "lift dumbbell, overhead", "lift dumbbell, both hands, bent legs")),
    ("sit", "sit down", ("sit",)),
    ("eat", None, ("eat, right hand", "eat, left hand", "eat, pie or burger")),
    ("turn steering wheel", None, ("turn steering wheel",)),
    ("phone", None, ("phone, take out, call and put back", "phone, call with left hand")),
    ("boxing", "boxing", (
        "boxing, left then right", "boxing, left then upwards", "boxing, right then upwards",
        "boxing, right then left")),
    ("throw", "throw", ("throw, right hand", "throw, both hands")),
)  # fmt: skip
"""12 coarse labels with 34 fine ones."""


class HumanAct12:
    """Clips named by subject and action, coarse and fine."""

    name = "humanact12"
    archive = "HumanAct12/ (folder)"
    licence = "research use; cite Guo et al. 2020"
    download = "https://ericguo5513.github.io/action-to-motion/"
    layout = "HumanAct12/ with P..G..R..F..T..A....npy"

    fps = 20.0

    def clips(self, folder: Path) -> Iterator[ClipInfo]:
        """Every file whose name states an action of the two tables."""
        for path in files_below(folder, "P*A*.npy"):
            match = _FILE.fullmatch(path.stem)
            if match is None or not 1 <= int(match[2]) <= len(ACTIONS):
                continue
            label, action, fine = ACTIONS[int(match[2]) - 1]
            if 1 <= int(match[3]) <= len(fine):
                yield ClipInfo(
                    self.name, path.stem, path, action, subject=match[1], label=label, fine=fine[int(match[3]) - 1]
                )

    def read(self, clip: ClipInfo) -> Motion:
        """A clip on `smpl22`, upright."""
        motion = from_joints(clip.path, load_npy(clip.path), SMPL24, self.fps, turned=True)
        return to_house(labelled(motion, clip))
