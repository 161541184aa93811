"""BABEL (Punnakkal et al. 2021): what is done when, for 43 hours of AMASS.

Download: babel.is.tue.mpg.de (the labels), amass.is.tue.mpg.de (the motions). Put both into the source folder:

    babel_v1.0_release/
      train.json  val.json  test.json  extra_train.json  extra_val.json
    AMASS/
      CMU/01/01_01_poses.npz ...

Labels of frames are used where a sequence has them, else those of the sequence. A label of the category "transition"
becomes a transition, any other an action. Labels may overlap.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from engines.datasets import amass as folders
from engines.datasets.corpus import ClipInfo, Split, Timed, labelled, to_house
from engines.datasets.folders import files_below, read_json
from engines.errors import FormatError
from engines.formats import amass
from engines.motion import Motion

log = logging.getLogger(__name__)

_FILES: dict[str, Split] = {
    "train.json": "train", "extra_train.json": "train", "val.json": "val", "extra_val.json": "val",
    "test.json": "test",
}  # fmt: skip
TRANSITION = "transition"


class BABEL:
    """AMASS motions under BABEL's labels, with their times."""

    name = "babel"
    archive = "babel_v1.0_release/ and AMASS/ (folders)"
    licence = "research use; cite Punnakkal et al. 2021 and AMASS"
    download = "https://babel.is.tue.mpg.de/data.html"
    layout = "babel_v1.0_release/ with train.json, val.json, test.json, and AMASS/ beside it"

    def clips(self, folder: Path) -> Iterator[ClipInfo]:
        """Every labelled sequence whose motion is there.

        Raises:
            FormatError: a json of another layout.
        """
        indices = [path for name in _FILES for path in files_below(folder, name) if _is_babel(path)]
        motions = folders.motions(folder) if indices else {}
        given: set[str] = set()
        missing = 0
        for path in indices:
            for sid, row in read_json(path).items():
                try:
                    key, timed, label = folders.clip_key(row["feat_p"]), labels(row), _category(row)
                except (AttributeError, KeyError, TypeError, ValueError) as error:
                    raise FormatError(path, f"sequence {sid!r} lacks, or has of another kind: {error}.") from error
                if key is None or key not in motions:
                    missing += 1
                elif key not in given:
                    given.add(key)
                    yield ClipInfo(
                        self.name, key, motions[key], None, subject=key.split("/")[1], label=label,
                        text=timed[0].value if timed else None, split=_FILES[path.name], timed=timed,
                    )  # fmt: skip
        if missing:
            log.warning("BABEL labels %d sequences whose motion is not under %s", missing, folder)

    def read(self, clip: ClipInfo) -> Motion:
        """A clip on `smpl22`, its labels as segments."""
        return to_house(labelled(amass.read(clip.path), clip))


def labels(row: dict[str, Any]) -> tuple[Timed, ...]:
    """What BABEL says of a sequence, in order of time: of its frames if it does, else of the whole.

    Args:
        row: one sequence of a BABEL json; test sequences have no labels.
    """
    frames = [item for annotation in _annotations(row, "frame") for item in annotation["labels"]]
    whole = [item for annotation in _annotations(row, "seq") for item in annotation["labels"]]
    timed = []
    for item in frames or whole:
        value = item.get("proc_label") or item.get("raw_label")
        if not value:
            continue
        kind = "transition" if TRANSITION in (*(item.get("act_cat") or ()), value) else "action"
        start, end = (float(item["start_t"]), float(item["end_t"])) if frames else (0.0, None)
        timed.append(Timed(kind, " ".join(str(value).split()), start, end))
    return tuple(dict.fromkeys(sorted(timed, key=lambda item: (item.start, item.end or 0.0, item.value))))


def _annotations(row: dict[str, Any], kind: str) -> list[dict[str, Any]]:
    """One annotation (train, val) or several (the extra files), of frames or of the sequence."""
    one, several = row.get(f"{kind}_ann"), row.get(f"{kind}_anns")
    return [annotation for annotation in (one, *(several or ())) if annotation]


def _category(row: dict[str, Any]) -> str | None:
    """The category that most of the sequence's time, or most of its labels, belongs to."""
    spent: dict[str, float] = {}
    for kind in ("frame", "seq"):
        for annotation in _annotations(row, kind):
            for item in annotation["labels"]:
                time = float(item["end_t"]) - float(item["start_t"]) if "start_t" in item else 1.0
                for category in item.get("act_cat") or ():
                    spent[category] = spent.get(category, 0.0) + (0.0 if category == TRANSITION else time)
        if spent:
            break
    return max(spent, key=lambda category: spent[category]) if spent else None


def _is_babel(path: Path) -> bool:
    """Does a json hold sequences with `feat_p`? Other data sets have a train.json too."""
    with path.open("rb") as file:
        return b'"feat_p"' in file.read(2**16)
