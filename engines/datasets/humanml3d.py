"""HumanML3D (Guo et al. 2022) and data sets in its layout: 14,616 motions, each with three sentences; 20 fps.

Download: github.com/EricGuo5513/HumanML3D says how to make it from AMASS and HumanAct12. Put its folder, as made,
into the source folder:

    HumanML3D/
      new_joints/000000.npy        (T, 22, 3) joint positions, metres, Y up
      new_joint_vecs/000000.npy    (T - 1, 263) features
      texts/000000.txt             a line a sentence: sentence#word/TAG word/TAG#start#end
      train.txt  val.txt  test.txt    names of clips; M000000 is the mirror image of 000000

A sentence whose start and end are not both 0 speaks of those seconds only.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from engines.datasets.corpus import ClipInfo, Split, Timed, labelled, to_house
from engines.datasets.folders import folders_with, read_text
from engines.datasets.joints import from_joints, load_npy, shape_of
from engines.errors import FormatError
from engines.motion import Motion
from engines.skeletons import SMPL22

log = logging.getLogger(__name__)

_SPLITS: tuple[Split, ...] = ("train", "val", "test")


class HumanML3D:
    """Motions as joints or 263-d features, with texts, official splits and mirrored clips."""

    name = "humanml3d"
    archive = "HumanML3D/ (folder)"
    licence = "AMASS's and HumanAct12's, research use; cite Guo et al. 2022"
    download = "https://github.com/EricGuo5513/HumanML3D"
    layout = "HumanML3D/ with new_joints/ (or new_joint_vecs/), texts/, train.txt, val.txt, test.txt"

    fps = 20.0
    joints = 22
    codec = "humanml3d-official"
    """How `new_joint_vecs` are to be read, of `engines.features`."""
    roles: Mapping[str, int] = {role: index for index, role in enumerate(SMPL22.joints)}

    def clips(self, folder: Path) -> Iterator[ClipInfo]:
        """Every clip of the splits that has a motion, mirrored ones too; without split files every text's clip."""
        for root in folders_with(folder, "texts"):
            if not self._is_ours(root):
                continue
            missing = 0
            for name, split in _names(root):
                path = self._motion_file(root, name)
                if path is None:
                    missing += 1
                    continue
                sentences = read_sentences(root / "texts" / f"{name}.txt")
                text = sentences[0].value if sentences else None
                yield ClipInfo(self.name, name, path, None, text=text, split=split, timed=sentences)
            if missing:
                log.warning("%s: %d clips of the splits have no motion file", root, missing)

    def read(self, clip: ClipInfo) -> Motion:
        """A clip on `smpl22`: from `new_joints` where they are, else decoded from `new_joint_vecs`."""
        values = load_npy(clip.path)
        if values.ndim == 2:
            motion = self._decoded(clip.path, values)
        else:
            motion = from_joints(clip.path, values, self.roles, self.fps)
        return to_house(labelled(motion, clip))

    def _is_ours(self, root: Path) -> bool:
        """Has the first motion in it as many joints as this data set's skeleton?"""
        first = next((path for kind in ("new_joints", "new_joint_vecs") for path in (root / kind).glob("*.npy")), None)
        return first is not None and shape_of(first)[1:] in ((self.joints, 3), (self.features,))

    @property
    def features(self) -> int:
        """Numbers a frame of `new_joint_vecs`: root 4, then 3, 6 and 3 a joint (one less for the first two), feet 4."""
        return 4 + (3 + 6) * (self.joints - 1) + 3 * self.joints + 4

    def _motion_file(self, root: Path, name: str) -> Path | None:
        candidates = (root / kind / f"{name}.npy" for kind in ("new_joints", "new_joint_vecs"))
        return next((path for path in candidates if path.is_file()), None)

    def _decoded(self, path: Path, values: np.ndarray) -> Motion:
        """Features (T, D) back to a motion."""
        if values.shape[1] != self.features or len(values) == 0:
            raise FormatError(path, f"has shape {values.shape}; accepted: (frames, {self.features}).")
        from engines import features

        # these files are made by the released code, whose way of counting is a codec of its own
        return from_joints(path, features.get(self.codec).positions(values), self.roles, self.fps)


def read_sentences(path: Path) -> tuple[Timed, ...]:
    """The sentences of a text file, with their times; none if there is no such file.

    Raises:
        FormatError: a line that is not `sentence#tags#start#end`, or times that are no numbers.
    """
    if not path.is_file() or path.stat().st_size == 0:
        return ()
    found: dict[Timed, None] = {}
    for number, line in enumerate(read_text(path).splitlines(), start=1):
        if not line.strip():
            continue
        parts = line.rsplit("#", 3)
        if len(parts) != 4:
            raise FormatError(path, "accepted: sentence#tags#start#end.", number)
        try:
            start, end = (_seconds(part) for part in parts[2:])
        except ValueError:
            raise FormatError(
                path, f"start and end are {parts[2]!r} and {parts[3]!r}; accepted: seconds.", number
            ) from None
        sentence = " ".join(parts[0].split())
        if sentence:
            timed = Timed("text", sentence) if start == end == 0 else Timed("text", sentence, start, end)
            found[timed] = None
    return tuple(found)


def _seconds(text: str) -> float:
    value = float(text)
    return 0.0 if math.isnan(value) else value  # some official files say nan for 0


def _names(root: Path) -> list[tuple[str, Split | None]]:
    """Clip names with their official parts; those of all texts, without parts, where there are no split files."""
    names: dict[str, Split | None] = {}
    for split in _SPLITS:
        path = root / f"{split}.txt"
        if path.is_file() and path.stat().st_size:
            names.update((line.strip(), split) for line in read_text(path).splitlines() if line.strip())
    if names:
        return list(names.items())
    return [(path.stem, None) for path in sorted((root / "texts").glob("*.txt"))]
