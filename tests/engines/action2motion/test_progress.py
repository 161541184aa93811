"""The time counter: from nothing done to all done, within one and without leaps while an action goes on."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from engines.action2motion.progress import progress_of

FRAMES, NOMINAL = st.integers(1, 2000), st.integers(1, 200)


@given(FRAMES, NOMINAL, st.booleans())
def test_starts_at_nothing_and_stays_within_one(frames: int, nominal: int, repeats: bool) -> None:
    done = progress_of(frames, nominal, repeats)
    assert done.shape == (frames,)
    assert done[0] == 0
    assert done.min() >= 0
    assert done.max() <= 1 + 1e-12


@given(FRAMES, NOMINAL, st.booleans())
def test_a_performance_of_usual_length_or_longer_ends_done(frames: int, nominal: int, repeats: bool) -> None:
    done = progress_of(frames, nominal, repeats)
    if frames >= max(2, int(0.7 * max(4, nominal))):
        assert abs(done[-1] - 1) < 1e-12
    else:
        assert done[-1] < 1


@given(FRAMES, st.integers(10, 200))
def test_what_goes_on_moves_without_leaps(frames: int, nominal: int) -> None:
    done = progress_of(frames, nominal, repeats=True)
    assert np.abs(np.diff(done)).max(initial=0) <= 1 / max(1, max(frames, int(0.7 * nominal)) - 1) + 1e-9


@given(st.integers(30, 2000), st.integers(10, 200))
def test_what_is_done_once_is_done_again_from_its_start(frames: int, nominal: int) -> None:
    done = progress_of(frames, nominal, repeats=False)
    starts = np.flatnonzero(done == 0)
    assert len(starts) == (1 if frames <= 1.5 * nominal else round(frames / nominal))
    for a, b in zip(starts, [*starts[1:], frames], strict=True):
        assert (np.diff(done[a:b]) > 0).all()
        assert b - a >= nominal / 2 or len(starts) == 1
