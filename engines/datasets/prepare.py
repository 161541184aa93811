"""Every corpus into one cache of house motions: read, retarget, check, split, store.

The cache is two files in a per-user folder (`cache_folder`), made again by `motionloom data prepare`.
"""

from __future__ import annotations

import hashlib
import json
import logging
import os
import tarfile
import tempfile
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
import platformdirs

from engines.datasets.amass import AMASS
from engines.datasets.babel import BABEL
from engines.datasets.bandai_namco import BandaiNamco
from engines.datasets.cmu import CMU
from engines.datasets.corpus import ClipInfo, Corpus
from engines.datasets.humanact12 import HumanAct12
from engines.datasets.humanml3d import HumanML3D
from engines.datasets.kit_ml import KITML
from engines.datasets.ntu_rgbd import NTURGBD
from engines.datasets.style_bvh import AbermanStyles, XiaStyles
from engines.datasets.utd_mhad import UTDMHAD
from engines.errors import Cancelled, FormatError, MotionloomError, UnknownLabelError
from engines.motion import Motion

log = logging.getLogger(__name__)

_ALL: tuple[Corpus, ...] = (
    BandaiNamco(), CMU(), UTDMHAD(), HumanML3D(), KITML(), HumanAct12(), NTURGBD(), AMASS(), BABEL(), AbermanStyles(),
    XiaStyles(),
)  # fmt: skip
CORPORA: dict[str, Corpus] = {corpus.name: corpus for corpus in _ALL}
VERSION = 4
"""Raised whenever prepared clips change, so that an old cache is made anew."""
SPLIT_SEED = 22
_TEST_SHARE, _VAL_SHARE = 0.10, 0.05
_UTD_TEST, _UTD_VAL = {"7"}, {"6"}
_SPEED_LIMIT = 20.0
"""A joint faster than this, in m/s, is a broken capture."""
_MIN_FRAMES = 12


@dataclass(frozen=True)
class Failure:
    """A clip that was left out."""

    clip: str
    reason: str


def cache_folder() -> Path:
    """Where prepared data lives: $MOTIONLOOM_CACHE, or the user's cache folder."""
    return Path(os.environ.get("MOTIONLOOM_CACHE", platformdirs.user_cache_dir("motionloom"))) / "datasets"


def prepare(
    source: Path,
    corpora: Sequence[str] = tuple(CORPORA),
    progress: Callable[[int, int, str], None] | None = None,
    cancel: Callable[[], bool] | None = None,
    workers: int | None = None,
) -> tuple[Path, list[Failure]]:
    """Read every clip of the corpora and store the cache.

    Args:
        source: a folder with the archives, or with the unpacked data sets.
        corpora: names from `CORPORA`; those not found under `source` are an error only if none is found.
        progress: called with (clips done, clips in all, clip name).
        cancel: asked between clips.
        workers: processes; the machine's cores by default.

    Returns:
        The cache file and the clips left out, each with a reason.

    Raises:
        UnknownLabelError: no such corpus.
        FormatError: nothing of the corpora under `source`, or not one clip that can be read.
        Cancelled: `cancel` said so; the old cache is untouched.
    """
    for name in corpora:
        if name not in CORPORA:
            raise UnknownLabelError("data set", name, CORPORA)
    with unpacked(Path(source), corpora) as folders:
        if not folders:
            archives = ", ".join(CORPORA[name].archive for name in corpora)
            raise FormatError(source, f"holds none of {archives}, packed or unpacked")
        clips = [clip for name, folder in folders.items() for clip in CORPORA[name].clips(folder)]
        kept, failures = _read_all(clips, progress, cancel, workers)
    for failure in failures:
        log.warning("left out %s: %s", failure.clip, failure.reason)
    if not kept:
        first = f"; the first: {failures[0].clip}: {failures[0].reason}" if failures else ""
        raise FormatError(source, f"not one of {len(clips)} clips could be read{first}")
    return _store(kept, failures), failures


def _read_all(
    clips: Sequence[ClipInfo],
    progress: Callable[[int, int, str], None] | None,
    cancel: Callable[[], bool] | None,
    workers: int | None,
) -> tuple[list[tuple[ClipInfo, Motion]], list[Failure]]:
    """The clips that can be read, with their motions, and those that cannot, over several processes."""
    kept: list[tuple[ClipInfo, Motion]] = []
    failures: list[Failure] = []
    with ProcessPoolExecutor(workers or os.cpu_count()) as pool:
        for done, (clip, result) in enumerate(zip(clips, pool.map(_read, clips, chunksize=8), strict=True), start=1):
            if cancel and cancel():
                pool.shutdown(cancel_futures=True)
                raise Cancelled("data preparation was cancelled; the old cache is untouched")
            if isinstance(result, str):
                failures.append(Failure(f"{clip.corpus}/{clip.name}", result))
            else:
                kept.append((clip, result))
            if progress:
                progress(done, len(clips), clip.name)
    return kept, failures


def _read(clip: ClipInfo) -> Motion | str:
    """A house motion, or why there is none."""
    try:
        motion = CORPORA[clip.corpus].read(clip)
        _check(motion)
    except MotionloomError as error:
        return str(error).replace(str(clip.path.parent) + os.sep, "")
    return replace(motion)  # without the positions found on the way, four times as large, on its way between processes


def _check(motion: Motion) -> None:
    """Refuse what no body does."""
    if len(motion) < _MIN_FRAMES:
        raise MotionloomError(f"only {len(motion)} frames at {motion.fps:g} fps (needed {_MIN_FRAMES})")
    speed = np.linalg.norm(np.diff(motion.positions, axis=0), axis=-1) * motion.fps
    if speed.max() > _SPEED_LIMIT:
        raise MotionloomError(f"a joint moves at {speed.max():.0f} m/s (limit {_SPEED_LIMIT:g})")


@contextmanager
def unpacked(source: Path, corpora: Sequence[str]) -> Iterator[dict[str, Path]]:
    """Folders of the corpora found under `source`; archives are unpacked to a temporary folder meanwhile."""
    with tempfile.TemporaryDirectory(prefix="motionloom-") as scratch:
        folders: dict[str, Path] = {}
        for name in corpora:
            archive = source / CORPORA[name].archive
            if archive.is_file():
                folders[name] = Path(scratch) / name
                with tarfile.open(archive) as tar:
                    tar.extractall(folders[name], filter="data")
            elif source.is_dir() and _holds(CORPORA[name], source):
                folders[name] = source
        yield folders


def _holds(corpus: Corpus, folder: Path) -> bool:
    try:
        return next(iter(corpus.clips(folder)), None) is not None
    except FormatError:
        return False


def _splits(clips: Sequence[ClipInfo]) -> list[str]:
    """train / val / test of each clip: as published; UTD by subject; others by clip within each action, seeded."""
    split = ["train"] * len(clips)
    groups: dict[tuple, list[int]] = defaultdict(list)
    for i, clip in enumerate(clips):
        if clip.split is not None:
            split[i] = clip.split
        elif clip.corpus == UTDMHAD.name:
            split[i] = "test" if clip.subject in _UTD_TEST else "val" if clip.subject in _UTD_VAL else "train"
        else:
            groups[clip.corpus, clip.action or clip.label].append(i)
    for members in groups.values():
        order = sorted(members, key=lambda i: hashlib.sha256(f"{SPLIT_SEED}/{clips[i].name}".encode()).digest())
        test, val = round(len(order) * _TEST_SHARE), round(len(order) * _VAL_SHARE)
        for i in order[:test]:
            split[i] = "test"
        for i in order[test : test + val]:
            split[i] = "val"
    return split


def _store(kept: Sequence[tuple[ClipInfo, Motion]], failures: Sequence[Failure]) -> Path:
    """Write the cache beside the old one and put it in its place."""
    folder = cache_folder()
    folder.mkdir(parents=True, exist_ok=True)
    split = _splits([clip for clip, _ in kept])
    starts = np.cumsum([0] + [len(motion) for _, motion in kept])
    index = {
        "version": VERSION,
        "clips": [
            {
                **asdict(clip),
                "path": clip.path.name,
                "split": part,
                "start": int(start),
                "frames": len(motion),
                "labels": [[s.start, s.end, s.kind, s.value] for s in motion.labels],
            }
            for (clip, motion), part, start in zip(kept, split, starts, strict=False)
        ],
        "left_out": [asdict(failure) for failure in failures],
    }
    target = folder / f"house-v{VERSION}.npz"
    with tempfile.NamedTemporaryFile(dir=folder, suffix=".npz", delete=False) as temporary:
        try:
            np.savez(
                temporary,
                rotations=np.concatenate([m.rotations for _, m in kept]).astype(np.float32),
                translation=np.concatenate([m.translation for _, m in kept]).astype(np.float32),
                index=np.frombuffer(json.dumps(index).encode(), dtype=np.uint8),
            )
        except BaseException:
            Path(temporary.name).unlink()
            raise
    Path(temporary.name).replace(target)
    return target
