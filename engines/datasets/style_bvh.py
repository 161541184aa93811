"""The two style sets of motion stylization: Aberman et al. 2020 (16 styles) and Xia et al. 2015 (8 styles), as BVH.

Download: github.com/DeepMotionEditing/deep-motion-editing (its page links both sets, prepared as BVH). Put the folders
into the source folder:

    mocap_bfa/
      Angry_01.bvh              style_take: long recordings of Aberman et al.
    mocap_xia/
      angry_13_000.bvh          style_content_take: short recordings of Xia et al.
      angry_walk_000.bvh        the content may be a word

Style and content are told from the name; a file whose name does not begin with one of the styles belongs to no style
set. Contents given as numbers stay numbers, since the files do not say what they mean.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from engines.datasets.corpus import ClipInfo, labelled, to_house
from engines.datasets.folders import files_below
from engines.errors import SkeletonError
from engines.formats import bvh
from engines.motion import Motion
from engines.skeletons import SMPL22

XIA_STYLES = ("angry", "childlike", "depressed", "neutral", "old", "proud", "sexy", "strutting")
ABERMAN_STYLES = (
    "angry", "childlike", "depressed", "drunk", "female model", "happy", "heavy", "hurried", "lazy", "neutral", "old",
    "proud", "robot", "sneaky", "soldier", "strutting", "sexy", "zombie",
)  # fmt: skip
"""Styles by which a file is known to be of the set; older and newer releases differ in one or two."""
_CONTENTS = {
    "walk": "walk", "walking": "walk", "normal walking": "walk", "slow walking": "walk", "fast walking": "walk",
    "run": "run", "running": "run", "jump": "jump", "jumping": "jump", "kick": "kick", "kicking": "kick",
    "punch": "punch", "punching": "punch", "fast punching": "punch",
}  # fmt: skip
"""Contents as the releases write them -> actions of `engines.actions`."""
_CAMEL = re.compile(r"(?<=[a-z])(?=[A-Z])")


class _StyleBVH:
    """What both sets share."""

    name = ""
    styles: tuple[str, ...] = ()
    shortest = 2
    """Fewest parts of a file's name."""
    longest = 3

    def clips(self, folder: Path) -> Iterator[ClipInfo]:
        """Every BVH named by one of the styles, in this set's pattern."""
        for path in files_below(folder, "*.bvh"):
            style, *rest = (_CAMEL.sub(" ", part).lower().strip() for part in path.stem.split("_"))
            if style.replace(" ", "") not in {known.replace(" ", "") for known in self.styles}:
                continue
            if not self.shortest <= 1 + len(rest) <= self.longest or not rest[-1].isdigit():
                continue
            content = rest[0] if len(rest) == 2 else None
            known = next(s for s in self.styles if s.replace(" ", "") == style.replace(" ", ""))
            yield ClipInfo(self.name, path.stem, path, _CONTENTS.get(content or ""), known, label=content)

    def read(self, clip: ClipInfo) -> Motion:
        """A clip on `smpl22`, by its rest pose if that stands upright and else by its first frame."""
        motion = bvh.read(clip.path)
        try:
            moved = motion.retarget(SMPL22)
        except SkeletonError:
            moved = motion.retarget(SMPL22, reference="first")
        return to_house(labelled(moved, clip))


class AbermanStyles(_StyleBVH):
    """Long recordings in 16 styles: Style_take.bvh."""

    name = "aberman-styles"
    archive = "mocap_bfa/ (folder)"
    licence = "research use; cite Aberman et al. 2020"
    download = "https://github.com/DeepMotionEditing/deep-motion-editing"
    layout = "mocap_bfa/ with Style_01.bvh"
    styles = ABERMAN_STYLES
    longest = 2


class XiaStyles(_StyleBVH):
    """Short recordings of contents in 8 styles: style_content_take.bvh."""

    name = "xia-styles"
    archive = "mocap_xia/ (folder)"
    licence = "research use; cite Xia et al. 2015"
    download = "https://github.com/DeepMotionEditing/deep-motion-editing"
    layout = "mocap_xia/ with style_content_000.bvh"
    styles = XIA_STYLES
    shortest = 3
