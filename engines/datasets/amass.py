"""AMASS (Mahmood et al. 2019): folders of SMPL motions, and the descriptions that others wrote of them.

Download: amass.is.tue.mpg.de (an account, research use). Unpack the archives of any of its data sets into one folder:

    AMASS/
      CMU/01/01_01_poses.npz            SMPL+H (`_poses`), or SMPL-X (`_stageii`)
      KIT/4/WalkingStraightForward01_poses.npz
      annotations.json                  optional: KIT Motion-Language sentences by AMASS path
      cmu-mocap-index.csv               optional: CMU's own descriptions by trial

Only poses and paths are used, no body model: bones have the house's lengths.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator
from pathlib import Path

from engines.datasets.corpus import ClipInfo, Split, Timed, labelled, to_house
from engines.datasets.folders import files_below, read_json, read_text
from engines.errors import FormatError
from engines.formats import amass
from engines.motion import Motion

_ENDING = re.compile(r"_(poses|stageii)$")
_SPLITS: dict[str, Split] = {
    # the parts the SMPL-X authors draw; everything else is for training
    "HumanEva": "val", "MPI_HDM05": "val", "HDM05": "val", "SFU": "val", "MPI_mosh": "val", "MoSh": "val",
    "Transitions_mocap": "test", "Transitions": "test", "SSM_synced": "test", "SSM": "test",
}  # fmt: skip
_TRIAL = re.compile(r"\d+_\d+")


class AMASS:
    """Every motion below a folder, named set/subject/clip."""

    name = "amass"
    archive = "AMASS/ (folder)"
    licence = "research use; cite Mahmood et al. 2019 and each data set in it"
    download = "https://amass.is.tue.mpg.de/"
    layout = "AMASS/ with SET/SUBJECT/CLIP_poses.npz or _stageii.npz"

    def clips(self, folder: Path) -> Iterator[ClipInfo]:
        """Every `_poses.npz` and `_stageii.npz`, with the sentences of an annotations.json and CMU's index if there."""
        sentences = kit_sentences(folder)
        described = cmu_descriptions(folder)
        for key, path in motions(folder).items():
            part, subject, clip = key.split("/")
            timed = sentences.get(key, ())
            text = described.get(clip) if part == "CMU" else None
            text = text or (timed[0].value if timed else None)
            yield ClipInfo(
                self.name, key, path, None, subject=subject, text=text, split=_SPLITS.get(part, "train"), timed=timed
            )

    def read(self, clip: ClipInfo) -> Motion:
        """A clip on `smpl22`, feet on the floor."""
        return to_house(labelled(amass.read(clip.path), clip))


def motions(folder: Path) -> dict[str, Path]:
    """set/subject/clip of every AMASS motion under a folder -> its file, sorted; the ending is no part of the name."""
    found = {}
    for path in files_below(folder, "*.npz"):
        key = clip_key(path.as_posix())
        if _ENDING.search(path.stem) and key is not None:
            found.setdefault(key, path)
    return found


def clip_key(path: str) -> str | None:
    """set/subject/clip of an AMASS path as any of its users write it, or None where it has fewer than three parts."""
    parts = path.removesuffix(".npz").split("/")[-3:]
    if len(parts) < 3:
        return None
    parts[2] = _ENDING.sub("", parts[2])
    return "/".join(part.replace(" ", "_") for part in parts)


def kit_sentences(folder: Path) -> dict[str, tuple[Timed, ...]]:
    """Sentences by set/subject/clip from every annotations.json (KIT Motion-Language by AMASS path) under a folder.

    Raises:
        FormatError: an annotations.json of another layout.
    """
    found: dict[str, tuple[Timed, ...]] = {}
    for path in files_below(folder, "annotations.json"):
        rows = read_json(path)
        try:
            for row in rows.values():
                key = clip_key(row["path"])
                said = tuple(_sentence(item, float(row["duration"])) for item in row["annotations"])
                if key is not None:
                    found[key] = found.get(key, ()) + said
        except (AttributeError, KeyError, TypeError, ValueError) as error:
            problem = f"accepted: {{id: {{path, duration, annotations: [{{text, start, end}}]}}}} ({error!r})."
            raise FormatError(path, problem) from error
    return found


def _sentence(item: dict, duration: float) -> Timed:
    text, start, end = " ".join(str(item["text"]).split()), float(item["start"]), float(item["end"])
    return Timed("text", text) if start <= 0 and end >= duration - 0.05 else Timed("text", text, start, end)


def cmu_descriptions(folder: Path) -> dict[str, str]:
    """CMU's description of each trial ("01_01") from every cmu-mocap-index.csv under a folder; "Unknown" is none.

    Raises:
        FormatError: not text.
    """
    found: dict[str, str] = {}
    for path in files_below(folder, "cmu-mocap-index.csv"):
        for row in csv.reader(read_text(path).splitlines()):
            text = " ".join(row[1].split()) if len(row) > 1 else ""
            if _TRIAL.fullmatch(row[0].strip() if row else "") and text and text.lower() != "unknown":
                found[row[0].strip()] = text
    return found
