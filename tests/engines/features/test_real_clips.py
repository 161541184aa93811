"""Real capture through every representation and back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engines import features
from engines.datasets import CORPORA
from tests.engines.features.movement import turned

MEAN_LIMIT = 0.005
"""Metres, the mean over joints and frames that is allowed; what is reached is a thousand times less."""


@pytest.mark.data
@pytest.mark.parametrize("corpus", ["bandai-namco", "cmu", "utd-mhad"])
def test_round_trip(real_clips: Path, corpus: str) -> None:
    clip = next(iter(CORPORA[corpus].clips(real_clips)))
    motion = CORPORA[corpus].read(clip)[:80]
    for name in ("humanml3d", "kit", "style", "smplh", "lie"):
        codec = features.get(name)
        wanted = codec.fitted(motion)
        made, start = codec.encode(wanted), codec.start(wanted)
        for source in codec.sources:
            back = codec.decode(made, source=source, start=start)
            error = np.linalg.norm(back.positions - wanted.positions, axis=-1)
            assert error.mean() < MEAN_LIMIT / 1000, (name, source)
            if source == "rotations" and name != "style":
                assert turned(back, wanted).max() < 3e-3, name
