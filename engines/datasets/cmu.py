"""CMU Graphics Lab motion capture database (a subset, with its manifest).

Free for all use; mocap.cs.cmu.edu, NSF EIA-0196217.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path

from engines.datasets.corpus import ClipInfo, Timed, to_house
from engines.errors import FormatError
from engines.formats import bvh
from engines.geometry.opening import opening
from engines.motion import Motion, Segment

_RULES: tuple[tuple[str, str], ...] = (
    # the first pattern found in CMU's own description decides
    (r"uneven terrain", "walk on rough ground"),
    (r"climb|hang, hold|go under", "climb"),
    (r"hop on one foot", "hop"),
    (r"run, leap", "leap"),
    (r"reach for, tiptoe", "reach up"),
    (r"forward jumps|jump", "jump"),
    (r"punch", "punch"),
    (r"swordplay", "sword fight"),
    (r"wash self", "wash"),
    (r"dribble", "dribble"),
    (r"cartwheel-like", "dance"),
    (r"^cartwheel", "cartwheel"),
    (r"dance", "dance"),
    (r"balance on one leg", "balance"),
    (r"^run", "run"),
    (r"walk forward, backward, sideways", ""),
    (r"walk", "walk"),
)


class CMU:
    """182 clips of 120 Hz capture, in BVH; those in ASF/AMC, which `engines.read` takes one by one, are left out."""

    name = "cmu"
    archive = "cmu-mocap-subset.tar.xz"
    licence = "free for all use; acknowledge mocap.cs.cmu.edu, NSF EIA-0196217"
    download = "http://mocap.cs.cmu.edu/"
    layout = "the archive, or a folder with manifest.json and bvh/"

    def clips(self, folder: Path) -> Iterator[ClipInfo]:
        """The clips `manifest.json` lists, with CMU's descriptions."""
        found = sorted(folder.rglob("manifest.json"))
        if not found:
            raise FormatError(folder, "no manifest.json; the CMU subset has one beside its bvh folders")
        try:
            rows = json.loads(found[0].read_text(encoding="utf-8"))
        except ValueError as error:
            raise FormatError(found[0], f"not JSON: {error}") from error
        for row in rows:
            yield ClipInfo(
                self.name,
                row["clip"],
                found[0].parent / row["file"],
                _action(row["description"]),
                subject=row["clip"].split("_")[0],
                text=f"{row['description']} [fps {row['cmu_fps']}, tpose {row['first_frame_is_tpose']}]",
                timed=_kit_sentences(row),
            )

    def read(self, clip: ClipInfo) -> Motion:
        """A clip on `smpl22`; the first frame of most files is a T-pose, the reference, and is then dropped."""
        if clip.path.suffix.lower() != ".bvh":
            raise FormatError(clip.path, "this data set is read from BVH alone; engines.read takes ASF/AMC")
        from engines.skeletons import SMPL22

        motion = bvh.read(clip.path)
        facts = re.search(r"\[fps ([\d.]+), tpose (\w+)\]", clip.text or "")
        if facts:
            motion = motion.replaced(fps=float(facts[1]))
        reference = "first" if facts and facts[2] == "True" else "rest"
        # the others' rest pose is upright, and they too open with a T-pose that is no part of the motion
        moved = motion.retarget(SMPL22, reference=reference)
        moved = moved[max(1, opening(moved)) :]
        labels = (Segment(0, len(moved), "action", clip.action),) if clip.action else ()
        return to_house(moved.replaced(labels=labels))


def _kit_sentences(row: dict) -> tuple[Timed, ...]:
    """What the annotators of KIT Motion-Language wrote of the clip, where they had it."""
    return tuple(Timed("text", " ".join(text.split())) for kit in row.get("kitml", ()) for text in kit["texts"])


def _action(description: str) -> str | None:
    for pattern, action in _RULES:
        if re.search(pattern, description):
            return action or None
    return None
