"""Damage to motion files, and what a reader may do with it: give a Motion or a FormatError, soon and in little room.

    python -m tests.engines.formats.mutations FILE... [--seconds 60] [--seed 1] [--keep DIR]

damages the files over and over, prints what came of it, and keeps every file that a reader did not take well. An .amc
is damaged together with its .asf.
"""

from __future__ import annotations

import argparse
import resource
import shutil
import signal
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from types import FrameType

import numpy as np

from engines import formats
from engines.errors import FormatError

SLOW = 5.0
"""Seconds after which a reader hangs rather than takes long."""
ROOM = 2**30
"""Bytes that a reader may take."""
PIECES = (
    b"{", b"}", b"[", b"]", b'"', b":", b",", b"\n", b"nan", b"1e308", b"-", b"99999999999", b"JOINT", b"\0",
    b"\xff\xfe", b" 0", b"CHANNELS 3", b"PK\x05\x06", b"begin\n", b"end\n", b"null", b"-1", b"true", b'"count":9999999',
)  # fmt: skip
NUMBERS = (b"\xff\xff\xff\x7f", b"\xff\xff\xff\xff", b"\0\0\0\0", b"\0\0\xc0\x7f", b"\xff\xff\x7f\x7f")
DIGITS = b"0123456789"

Edit = tuple[int, float, int, int]
"""Kind of the edit, where in the file (0 to 1), size, and which piece."""
KINDS = 9


def damaged(data: bytes, edits: Sequence[Edit]) -> bytes:
    """The bytes after some edits: changed, removed, repeated, cut off, or replaced by something of the grammar."""
    out = bytearray(data)
    for kind, where, size, piece in edits:
        at = int(where * len(out))
        if kind == 0:
            out[at : at + 1] = bytes([piece % 256])
        elif kind == 1:
            del out[at : at + size]
        elif kind == 2:
            out[at:at] = out[at : at + size]
        elif kind == 3:
            out[at:at] = PIECES[piece % len(PIECES)]
        elif kind == 4:
            out[at : at + 4] = NUMBERS[piece % len(NUMBERS)]
        elif kind in (5, 6, 7):  # 5 changes a number's length as well, which a binary file seldom survives
            at = next((i for i in range(at, min(at + 200, len(out))) if out[i] in DIGITS), at)
            out[at : at + 1] = str(piece % (1000 if kind == 5 else 10)).encode()
        else:
            del out[at:]
    return bytes(out)


def read(path: Path) -> str:
    """Read a file and say what came of it: "read" or "refused".

    Raises:
        AssertionError: the motion is no motion, or the message does not name the file.
    """
    try:
        motion = formats.read(path)
    except FormatError as error:
        assert str(path.parent) in str(error) and len(str(error)) < 2000, str(error)[:200]
        return "refused"
    assert np.isfinite(motion.rotations).all() and np.isfinite(motion.translation).all()
    return "read"


def _late(_signal: int, _frame: FrameType | None) -> None:
    raise TimeoutError(f"more than {SLOW} s")


def run(files: Sequence[Path], seconds: float, seed: int, keep: Path) -> Counter[str]:
    """Damage files and read them for so many seconds; what a reader did not take well is kept. Returns counts."""
    rng = np.random.default_rng(seed)
    outcomes: Counter[str] = Counter()
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + ROOM, resource.RLIM_INFINITY))
    signal.signal(signal.SIGALRM, _late)
    end = time.monotonic() + seconds
    with tempfile.TemporaryDirectory() as folder:
        while time.monotonic() < end:
            original = files[int(rng.integers(len(files)))]
            group = [original, *(original.parent.glob("*.asf") if original.suffix == ".amc" else ())]
            victim = group[int(rng.integers(len(group)))]
            edits = [
                (int(rng.integers(KINDS)), float(rng.random()), int(rng.integers(1, 20)), int(rng.integers(2**16)))
                for _ in range(min(int(rng.geometric(0.6)), 5))
            ]
            for file in group:
                whole = file.read_bytes()
                (Path(folder) / file.name).write_bytes(damaged(whole, edits) if file is victim else whole)
            outcomes[_outcome(Path(folder), original.name, keep)] += 1
    return outcomes


def _outcome(folder: Path, name: str, keep: Path) -> str:
    signal.setitimer(signal.ITIMER_REAL, SLOW)
    try:
        return read(folder / name)
    except Exception as error:  # whatever it is, it is what is looked for
        signal.setitimer(signal.ITIMER_REAL, 0)
        place = keep / f"{type(error).__name__}-{len(list(keep.glob('*')))}"
        shutil.copytree(folder, place)
        return f"{type(error).__name__}: {error!s:.80} ({place})"
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)


def main() -> None:
    """The command of the module's docstring."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", type=Path)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", type=Path, default=Path("fuzz-found"))
    given = parser.parse_args()
    given.keep.mkdir(parents=True, exist_ok=True)
    outcomes = run(given.files, given.seconds, given.seed, given.keep)
    for outcome, count in outcomes.most_common():
        print(f"{count:8,}  {outcome}")
    sys.exit(bool(set(outcomes) - {"read", "refused"}))


if __name__ == "__main__":
    main()
