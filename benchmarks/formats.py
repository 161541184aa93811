"""Reading and writing motion files: milliseconds per 1,000 frames, on a motion of 10,000.

    python benchmarks/formats.py [file.bvh]

Without a file the motion is synthetic, of the house skeleton. The last column is the time over that of the BVH reader
in the same run; `bvhio`, a second BVH reader, is timed on 300 frames.
"""

from __future__ import annotations

import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from engines import formats
from engines.motion import Motion
from engines.skeletons import SMPL22

FRAMES = 10_000
ROUNDS = 5


def synthetic() -> Motion:
    """Slow random turning of every joint."""
    rng = np.random.default_rng(0)
    turns = np.cumsum(rng.normal(size=(FRAMES, len(SMPL22), 4)) * 0.02, axis=0)
    turns[..., 0] += 1.5
    return Motion(SMPL22, turns, np.cumsum(rng.normal(size=(FRAMES, 3)) * 0.01, axis=0), 120)


def repeated(motion: Motion) -> Motion:
    """The motion over and over, 10,000 frames long."""
    return motion.concat(*[motion] * (FRAMES // len(motion)))[:FRAMES]


def milliseconds(call: Callable[[], object], frames: int, rounds: int = ROUNDS) -> float:
    """Median time of a call per 1,000 frames."""
    times = []
    for _ in range(rounds):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return statistics.median(times) * 1000 / frames * 1000


def main() -> None:
    motion = repeated(formats.read(sys.argv[1])) if len(sys.argv) > 1 else synthetic()
    print(f"{len(motion):,} frames of {len(motion.skeleton)} joints")
    rows: list[tuple[str, float, float]] = []
    with tempfile.TemporaryDirectory() as folder:
        for end in (".bvh", ".npz", ".amass.npz"):
            path = Path(folder) / f"motion{end}"
            wrote = milliseconds(lambda path=path: formats.write(motion, path), FRAMES)
            size = path.stat().st_size / FRAMES
            rows.append((f"write {end}", wrote, size))
            rows.append((f"read {end}", milliseconds(lambda path=path: formats.read(path), FRAMES), size))
        rows.append(("read .bvh by bvhio", *others(motion[:300], Path(folder))))
    unit = {name: taken for name, taken, _ in rows}["read .bvh"]
    print(f"{'':22}{'ms / 1,000 frames':>18}{'bytes / frame':>15}{'x read .bvh':>13}")
    for name, taken, size in rows:
        print(f"{name:22}{taken:18.2f}{size:15.0f}{taken / unit:13.2f}")


def others(motion: Motion, folder: Path) -> tuple[float, float]:
    """bvhio's time per 1,000 frames and bytes a frame, to the point where positions can be asked for."""
    import bvhio

    path = formats.write(motion, folder / "short.bvh")
    taken = milliseconds(lambda: bvhio.readAsHierarchy(str(path)), len(motion), rounds=1)
    return taken, path.stat().st_size / len(motion)


if __name__ == "__main__":
    main()
