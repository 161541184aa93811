"""The project's own .npz: a Motion whole and bit for bit, skeleton, labels and provenance included.

The archive holds `rotations` (T, J, 4), `translation` (T, 3) and `offsets` (J, 3) as float64, `ends` and `hinges` as
rows of three, and `motionloom`, UTF-8 JSON as bytes, with all that is not an array. No pickle, and the same motion
always gives the same bytes.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, get_args

import numpy as np

from engines.errors import FormatError, MotionloomError
from engines.formats import arrays
from engines.formats.files import check_size
from engines.formats.registry import Format
from engines.motion import LabelKind, Motion, Provenance, Segment
from engines.skeletons.skeleton import Skeleton

VERSION = 1
"""Version written; files of a later one are refused."""
HEADER = "motionloom"
"""Name of the entry that makes an .npz one of ours."""
_ARRAYS = ("rotations", "translation", "offsets", "ends", "hinges")


def write(motion: Motion, path: str | Path) -> Path:
    """Write a motion losslessly.

    Raises:
        FormatError: the file cannot be written, or the provenance holds what JSON cannot say.
    """
    path = Path(path)
    return arrays.save(path, _content(path, motion))


def to_bytes(motion: Motion) -> bytes:
    """The bytes of the file that `write` writes.

    Raises:
        FormatError: the provenance holds what JSON cannot say.
    """
    return arrays.pack(_content(Path("motion.npz"), motion))


def _content(path: Path, motion: Motion) -> dict[str, np.ndarray]:
    """Every entry of the archive."""
    skeleton = motion.skeleton
    header = {
        "version": VERSION,
        "fps": motion.fps,
        "skeleton": {
            "name": skeleton.name,
            "joints": skeleton.joints,
            "parents": skeleton.parents,
            "ends": list(skeleton.end_offsets),
            "feet": skeleton.feet,
            "hinges": list(skeleton.hinges),
            "mirror_pairs": skeleton.mirror_pairs,
        },
        "labels": [[s.start, s.end, s.kind, s.value] for s in motion.labels],
        "provenance": {
            "source": motion.provenance.source,
            "weights": motion.provenance.weights,
            "prompt": motion.provenance.prompt,
            "seed": motion.provenance.seed,
            "index": motion.provenance.index,
            "parameters": motion.provenance.parameters,
        },
    }
    try:
        text = json.dumps(header, ensure_ascii=False, allow_nan=False, default=_plain)
        packed = np.frombuffer(text.encode("utf-8"), np.uint8)
    except (TypeError, ValueError, RecursionError) as error:
        raise FormatError(path, f"the motion's labels or provenance cannot be written as JSON: {error}.") from error
    return {
        HEADER: packed,
        "rotations": motion.rotations,
        "translation": motion.translation,
        "offsets": skeleton.offsets,
        "ends": _rows(skeleton.end_offsets),
        "hinges": _rows(skeleton.hinges),
    }


def read(path: str | Path) -> Motion:
    """Read a motion that `write` wrote: equal in every field, arrays bit for bit.

    Raises:
        FormatError: damaged, of a later version, or not one of ours.
    """
    return _read(Path(path))


def from_bytes(data: bytes, name: str = "motion.npz") -> Motion:
    """The motion that `to_bytes` packed; `name` stands for it in messages.

    Raises:
        FormatError: as `read`.
    """
    return _read(Path(name), data)


def _read(path: Path, data: bytes | None = None) -> Motion:
    held = arrays.load(path, (HEADER,), data)
    if HEADER not in held:
        found = "other arrays" if data is not None else ", ".join(sorted(arrays.names(path))[:12]) or "nothing"
        raise FormatError(
            path, f"an .npz with {found}; accepted: a motionloom .npz, or AMASS (trans, poses, mocap_framerate)."
        )
    header = _header(path, held[HEADER])
    held = arrays.load(path, _ARRAYS, data)
    missing = [name for name in _ARRAYS if name not in held]
    if missing:
        raise FormatError(path, f"array {missing[0]!r} is missing.")
    try:
        return _motion(path, header, held)
    except FormatError:
        raise
    except (MotionloomError, KeyError, TypeError, ValueError, AttributeError) as error:
        raise FormatError(path, f"is damaged: {error!s}") from error


def sniff(path: Path, head: bytes) -> bool:
    """Is it a zip archive with our header in it?"""
    return arrays.is_zip(head) and HEADER in arrays.names(path)


def _header(path: Path, packed: np.ndarray) -> dict[str, Any]:
    """The JSON part."""
    try:
        header = json.loads(packed.astype(np.uint8).tobytes().decode("utf-8"))
        version = int(header["version"])
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise FormatError(path, f"its {HEADER!r} entry is damaged ({error}).") from error
    if version > VERSION:
        raise FormatError(path, f"is of version {version}; this program reads up to {VERSION}: update it.")
    return header


def _motion(path: Path, header: dict[str, Any], held: Mapping[str, np.ndarray]) -> Motion:
    """A motion of the parts, which its own checks go over."""
    for name in _ARRAYS:
        if held[name].dtype != np.float64:
            raise FormatError(path, f"array {name!r} is of {held[name].dtype}; accepted: float64.")
    stated = header["skeleton"]
    check_size(path, len(held["rotations"]), len(stated["joints"]))
    skeleton = Skeleton(
        name=str(stated["name"]),
        joints=tuple(str(joint) for joint in stated["joints"]),
        parents=tuple(stated["parents"]),
        offsets=held["offsets"],
        end_offsets=_mapping(stated["ends"], held["ends"]),
        feet=tuple((str(ankle), str(toe)) for ankle, toe in stated["feet"]),
        hinges=_mapping(stated["hinges"], held["hinges"]),
        mirror_pairs=tuple((str(left), str(right)) for left, right in stated["mirror_pairs"]),
    )
    for joint in [*skeleton.end_offsets, *skeleton.hinges, *sum(skeleton.feet + skeleton.mirror_pairs, ())]:
        skeleton.index(joint)  # raises where the skeleton has no such joint
    labels = tuple(_segment(*label) for label in header["labels"])
    made = header["provenance"]
    if not isinstance(made["parameters"], dict) or not isinstance(made["seed"], int | None):
        raise ValueError("its provenance is not as it was written")
    provenance = Provenance(
        source=str(made["source"]),
        weights=str(made["weights"]),
        prompt=str(made["prompt"]),
        seed=made["seed"],
        index=int(made["index"]),
        parameters=made["parameters"],
    )
    return Motion(skeleton, held["rotations"], held["translation"], header["fps"], labels, provenance)


def _segment(start: int, end: int, kind: str, value: str) -> Segment:
    if kind not in get_args(LabelKind) or not isinstance(value, str):
        raise ValueError(f"{kind!r} is no kind of label; accepted: {', '.join(get_args(LabelKind))}")
    return Segment(int(start), int(end), kind, value)  # type: ignore[arg-type]  # checked above


def _rows(points: Mapping[str, np.ndarray]) -> np.ndarray:
    """The vectors of a mapping as (N, 3)."""
    return np.array(list(points.values()), dtype=np.float64).reshape(-1, 3)


def _mapping(keys: list[str], rows: np.ndarray) -> dict[str, np.ndarray]:
    if rows.shape != (len(keys), 3) or not np.isfinite(rows).all():
        raise ValueError(f"{len(keys)} names for finite points of shape {rows.shape}")
    return {str(key): np.array(row) for key, row in zip(keys, rows, strict=True)}


def _plain(value: object) -> object:
    """NumPy numbers and arrays as JSON knows them."""
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} is no JSON value")


FORMAT = Format("motionloom", (".npz",), "motionloom motion, lossless", sniff, read, write)
