"""How fast styles are, measured on clips made by formula, and motions that follow it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from engines.motion import Motion
from engines.stylization import tempo
from engines.stylization.engine import StylizationEngine
from tests.engines.action2motion.tiny import clip, movement
from tests.engines.stylization.tiny import engine


def at(speed: float, style: str):
    """A clip of the same movement, `speed` times as fast."""
    made = clip("walk", 60, 1)
    return replace(made, style=style, motion=tempo.at_pace(made.motion, speed))


def test_a_style_is_as_fast_beside_the_neutral_one_as_its_clips_are() -> None:
    clips = [at(1.0, "normal"), at(0.8, "old"), at(1.5, "active")]
    assert all(tempo.travels(one.motion) for one in clips)
    paces = tempo.measured(clips, ("normal", "old", "active", "proud"))
    assert [standing for standing, _ in paces] == [1.0] * 4  # nothing on the spot to compare
    np.testing.assert_allclose([way for _, way in paces], [1.0, 0.8, 1.5, 1.0], rtol=0.03)


def test_what_stands_does_not_travel() -> None:
    motion = clip("walk", 60, 1).motion
    assert tempo.travels(motion) and not tempo.travels(motion.in_place())


@pytest.fixture
def paced() -> StylizationEngine:
    return engine(pace=((0.5, 0.5), (1.25, 1.25)))


def test_tempo_follows_style_and_strength_where_it_may(paced: StylizationEngine) -> None:
    motion = movement(81)
    whole = paced.stylise(motion, "old")[0]
    assert "tempo" in paced.capabilities and whole.duration == pytest.approx(motion.duration, abs=0.1)

    def seconds(motion: Motion, style: str, strength: float = 1.0) -> float:
        return paced.stylise(motion, style, strength=strength, tempo=True)[0].duration

    assert seconds(motion, "old") == pytest.approx(2 * whole.duration, rel=0.03)
    assert seconds(motion, "old", 0.5) == pytest.approx(2**0.5 * whole.duration, rel=0.03)
    assert seconds(motion, "old", 0.0) == pytest.approx(whole.duration, rel=0.03)
    # from its own style, not from a neutral one
    assert seconds(motion.labelled("proud", "style"), "old") == pytest.approx(2.5 * whole.duration, rel=0.03)
    assert seconds(motion.labelled("old", "style"), "old") == pytest.approx(whole.duration, rel=0.03)


def test_a_slower_motion_goes_the_same_way() -> None:
    motion = movement(41)
    slow = tempo.at_pace(motion, 0.5)
    np.testing.assert_allclose(slow.positions[::2], motion.positions, atol=1e-5)
