"""Stylization as people ask it, on random weights: what holds whatever was learned."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from engines.errors import CheckpointError, OutOfRangeError, UnknownLabelError
from engines.motion import Motion
from engines.stylization.engine import StylizationEngine, load
from tests.engines.action2motion.tiny import movement
from tests.engines.stylization.tiny import engine as tiny_engine


@pytest.fixture(scope="module", params=["ae", "vae"])
def engine(request: pytest.FixtureRequest) -> StylizationEngine:
    return tiny_engine(latent=request.param)


def gap(a: Motion, b: Motion) -> float:
    return float(np.abs(a.positions - b.positions).max())


def test_no_strength_gives_the_motion_back(engine: StylizationEngine) -> None:
    motion = movement(40)
    (made,) = engine.stylise(motion, "old", strength=0.0)
    assert made.fps == 30 and made.label_at(0, "style") == "old"
    assert gap(made, motion.resample(30)) < 0.01


def test_more_strength_is_further_away(engine: StylizationEngine) -> None:
    motion = movement(40)
    before = motion.resample(30)
    gaps = [gap(engine.stylise(motion, "proud", strength=s, seed=3)[0], before) for s in (0.0, 0.5, 1.0, 1.5)]
    assert gaps == sorted(gaps) and gaps[-1] > 3 * gaps[0]


def test_draws_labels_and_references_differ_and_seeds_repeat(engine: StylizationEngine) -> None:
    motion = movement(40)
    first, second = engine.stylise(motion, "old", count=2, seed=5)
    assert gap(first, second) > 1e-4
    assert (
        np.array_equal(first.positions, engine.stylise(motion, "old", count=1, seed=5)[0].positions)
        or gap(first, engine.stylise(motion, "old", count=1, seed=5)[0]) < 1e-4
    )
    assert gap(first, engine.stylise(motion, "proud", seed=5)[0]) > 1e-4
    assert gap(first, engine.stylise(motion, "old", like=movement(50, seed=3), seed=5)[0]) > 1e-4
    assert len(engine.stylise(motion)) == 1  # from the prior


@pytest.mark.parametrize("frames", [6, 7, 33, 200])
def test_any_length_comes_back_as_long_and_where_it_stood(engine: StylizationEngine, frames: int) -> None:
    motion = movement(frames, turning=0.5).moved((3.0, 0.0, -1.0), yaw=1.0)
    house = motion.resample(30)
    (made,) = engine.stylise(motion, "old")
    assert len(made) == len(house)
    np.testing.assert_allclose(made.positions[0, 0, [0, 2]], house.positions[0, 0, [0, 2]], atol=0.02)
    assert np.isfinite(made.positions).all()


def test_style_codes_and_what_lies_between(engine: StylizationEngine) -> None:
    motion = movement(40)
    a, b = engine.style_code(movement(60, seed=1), "old"), engine.style_code(movement(60, seed=2), "proud")
    made = engine.interpolate_styles(motion, a, b, 4, ("old", "proud"))
    back = engine.interpolate_styles(motion, b, a, 4, ("proud", "old"))
    assert a.shape == (4,) and len(made) == 4
    for one, other in zip(made, reversed(back), strict=True):
        assert gap(one, other) < 1e-4
    assert min(gap(one, other) for one, other in itertools.pairwise(made)) > 0


def test_weights_without_labels_take_no_label() -> None:
    engine = tiny_engine(supervised=False)
    assert engine.styles == () and "styles" not in engine.capabilities
    motion = movement(40)
    assert gap(engine.stylise(motion, like=movement(50, seed=3))[0], motion.resample(30)) > 1e-3
    with pytest.raises(UnknownLabelError, match="without labels"):
        engine.stylise(motion, "old")


@pytest.mark.parametrize(
    ("asked", "error", "said"),
    [
        ({"style": "ould"}, UnknownLabelError, "old"),
        ({"strength": 2.0}, OutOfRangeError, "0 to 1.5"),
        ({"count": 0}, OutOfRangeError, "1 to 256"),
        ({"seed": -1}, OutOfRangeError, "2\\^63"),
    ],
)
def test_requests_out_of_range(engine: StylizationEngine, asked: dict, error: type, said: str) -> None:
    with pytest.raises(error, match=said):
        engine.stylise(movement(40), **asked)


def test_a_clip_of_three_frames_is_too_short(engine: StylizationEngine) -> None:
    with pytest.raises(OutOfRangeError, match="8 to 18,000"):
        engine.stylise(movement(3), "old")


def test_missing_weights_say_how_to_get_them(tmp_path) -> None:
    with pytest.raises(CheckpointError, match="motionloom train stylization"):
        load(checkpoint=tmp_path / "none.safetensors")
    with pytest.raises(UnknownLabelError, match="vae"):
        load("gan")
