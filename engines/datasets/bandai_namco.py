"""Bandai-Namco-Research-Motiondataset 1 and 2 (Kobayashi et al. 2023): contents performed in styles. CC BY-NC 4.0.

Download: github.com/BandaiNamcoResearchInc/Bandai-Namco-Research-Motiondataset; keep its folders, each with `data/`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

from engines.datasets.corpus import ClipInfo, to_house
from engines.errors import FormatError
from engines.formats import bvh
from engines.motion import Motion, Segment

_CONTENTS = {
    "bow": "bow", "bye": "wave goodbye", "byebye": "wave goodbye big", "call": "beckon", "dance-short": "dance",
    "dash": "dash", "guide": "guide", "kick": "kick", "punch": "punch", "respond": "respond", "run": "run",
    "slash": "slash", "walk": "walk", "walk-back": "walk backward", "walk-left": "walk left",
    "walk-right": "walk right", "raise-up-both-hands": "raise both hands", "raise-up-left-hand": "raise left hand",
    "raise-up-right-hand": "raise right hand", "walk-turn-left": "turn left", "walk-turn-right": "turn right",
    "wave-both-hands": "wave both hands", "wave-left-hand": "wave left hand", "wave-right-hand": "wave right hand",
}  # fmt: skip
_STYLES = {"masculinity": "masculine", "old": "elderly", "not-confident": "unconfident"}
_TURNS_THE_OTHER_WAY = {
    "dataset-2_walk-turn-left_masculine_007": "turn right",
    "dataset-2_walk-turn-right_masculine_007": "turn left",
    "dataset-2_walk-turn-right_normal_004": "turn left",
    "dataset-2_walk-turn-right_normal_032": "turn left",
    "dataset-2_walk-turn-right_normal_033": "turn left",
}
"""Files whose names say the wrong side: measured, they turn by 50 to 99 degrees to the other."""
_FILE = re.compile(r"dataset-([12])_([a-z-]+)_([a-z-]+)_(\d+)\.bvh")
_REFERENCE = "dataset-2_walk_normal_001.bvh"


class BandaiNamco:
    """Both sets, 2,834 clips."""

    name = "bandai-namco"
    archive = "bandai-namco-motiondataset.tar.xz"
    licence = "CC BY-NC 4.0"
    download = "https://github.com/BandaiNamcoResearchInc/Bandai-Namco-Research-Motiondataset"
    layout = "the archive, or its dataset/ folder with dataset-N_CONTENT_STYLE_ID.bvh"

    def clips(self, folder: Path) -> Iterator[ClipInfo]:
        """Every `dataset-N_{content}_{style}_{id}.bvh` under the folder."""
        for path in sorted(folder.rglob("dataset-*.bvh")):
            match = _FILE.fullmatch(path.name)
            if match:
                _, content, style, _ = match.groups()
                action = _TURNS_THE_OTHER_WAY.get(path.stem, _CONTENTS.get(content))
                yield ClipInfo(self.name, path.stem, path, action, _STYLES.get(style, style), text=content)

    def read(self, clip: ClipInfo) -> Motion:
        """A clip on `smpl22`; the bones of these files point along x, so a standing frame is the reference pose."""
        motion = bvh.read(clip.path)
        moved = motion.retarget(_house(), reference=_standing_frame(clip.path.parent.parent.parent))
        labels = [Segment(0, len(moved), "action", clip.action)] if clip.action else []
        if clip.style:
            labels.append(Segment(0, len(moved), "style", clip.style))
        return to_house(moved.replaced(labels=tuple(labels)))


def _house():
    from engines.skeletons import SMPL22

    return SMPL22


@lru_cache(maxsize=4)
def _standing_frame(folder: Path) -> Motion:
    """The most upright frame of some neutral clips, arms hanging: all files share one rig, so one pose serves all."""
    import numpy as np

    from engines.skeletons import roles

    candidates = sorted(folder.rglob("dataset-2_raise-up-*-hand_normal_00?.bvh"))
    candidates = candidates or sorted(folder.rglob("*_normal_*.bvh"))
    best: tuple[float, Motion] | None = None
    for path in candidates[:12]:
        try:
            motion = bvh.read(path)
        except FormatError:
            continue  # left out when its own turn comes; the others need not suffer for it
        named = roles.recognise(motion.skeleton.joints)
        at = {role: motion.positions[:, motion.skeleton.index(joint)] for role, joint in named.items()}
        score = np.zeros(len(motion))
        for top, bottom in (("neck", "pelvis"), ("head", "neck")):
            score += _vertical(at[top] - at[bottom])
        for side in ("left", "right"):
            for top, bottom in (("hip", "knee"), ("knee", "ankle")):
                score += _vertical(at[f"{side}_{top}"] - at[f"{side}_{bottom}"])
        frame = int(score.argmax())
        if best is None or score[frame] > best[0]:
            best = (float(score[frame]), motion[frame : frame + 1])
    if best is None:
        raise FormatError(folder, "no clip named *_normal_* to take the standing reference pose from")
    return best[1]


def _vertical(vectors):
    """(T,) cosine with straight up."""
    from engines.geometry import rotations

    return rotations.normalise(vectors)[:, 1]
