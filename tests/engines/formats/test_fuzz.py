"""Mutated files: a Motion or a FormatError, nothing else, and soon."""

from __future__ import annotations

import time
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
import scipy.io

from engines import formats
from engines.errors import FormatError
from engines.formats import amass, npz
from engines.motion import Motion
from tests.engines.formats.conftest import SMALL_BVH, random_motion
from tests.engines.formats.test_utd_mat import standing

MUTATIONS = 300
SLOW = 5.0
"""Seconds after which a small file hangs rather than takes long."""
PIECES = [
    b"{", b"}", b"\n", b"nan", b"1e308", b"-", b"99999999999", b"JOINT", b"\0", b"\xff\xfe", b" 0", b"CHANNELS 3",
    b"PK\x05\x06",
]  # fmt: skip


def mutated(data: bytes, rng: np.random.Generator) -> bytes:
    """A few random edits: bytes changed, removed, repeated, or replaced by something from the grammar."""
    out = bytearray(data)
    for _ in range(int(rng.integers(1, 5))):
        at = int(rng.integers(0, max(len(out), 1)))
        size = int(rng.integers(1, 20))
        match int(rng.integers(0, 6)):
            case 0:
                out[at : at + 1] = rng.bytes(1)
            case 1:
                del out[at : at + size]
            case 2:
                out[at:at] = out[at : at + size]
            case 3:
                out[at:at] = PIECES[int(rng.integers(len(PIECES)))]
            case 4:
                out[at : at + 4] = rng.choice([b"\xff\xff\xff\x7f", b"\xff\xff\xff\xff", b"\0\0\0\0"])
            case _:
                del out[at:]
    return bytes(out)


@pytest.fixture(params=["small.bvh", "ours.npz", "amass.npz", "kinect.mat", "packed.mat"])
def original(request, tmp_path) -> Path:
    path = tmp_path / request.param
    match request.param:
        case "small.bvh":
            path.write_text(SMALL_BVH)
        case "ours.npz":
            npz.write(random_motion(3).labelled("walk"), path)
        case "amass.npz":
            amass.write(random_motion(3), path)
        case name:
            scipy.io.savemat(path, {"d_skel": standing(3)}, do_compression=name == "packed.mat")
    return path


def test_mutations_give_a_motion_or_a_format_error(original):
    rng = np.random.default_rng(20240611)
    whole = original.read_bytes()
    outcomes: Counter[str] = Counter()
    for _ in range(MUTATIONS):
        original.write_bytes(mutated(whole, rng))
        start = time.monotonic()
        try:
            motion = formats.read(original)
        except FormatError as error:
            outcomes["refused"] += 1
            assert str(original) in str(error) and len(str(error)) < 2000
        else:
            outcomes["read"] += 1
            assert isinstance(motion, Motion) and np.isfinite(motion.positions).all()
        assert time.monotonic() - start < SLOW
    assert outcomes["refused"] > MUTATIONS / 4


def test_every_beginning_of_a_bvh_is_refused(tmp_path):
    path = tmp_path / "cut.bvh"
    for length in range(1, len(SMALL_BVH.rstrip()) - 1, 7):
        path.write_text(SMALL_BVH[:length])
        with pytest.raises(FormatError):
            formats.read(path)
