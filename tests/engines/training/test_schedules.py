"""Schedules at their corners, and the curriculum of Text2Motion."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from engines.errors import CheckpointError, OutOfRangeError
from engines.training.plan import TrainingPlan
from engines.training.schedules import (
    Constant,
    Cosine,
    Exponential,
    InverseSigmoid,
    LengthCurriculum,
    Linear,
    Steps,
)


@pytest.mark.parametrize(
    ("schedule", "points"),
    [
        (Constant(0.6), {0: 0.6, 10**6: 0.6}),
        (Linear(0.001, 0.021, 100), {0: 0.001, 50: 0.011, 100: 0.021, 999: 0.021}),
        (Linear(1.0, 0.0, 10, begin=20), {0: 1.0, 20: 1.0, 25: 0.5, 30: 0.0}),
        (Linear(3.0, 5.0, 0), {0: 3.0, 1: 5.0}),
        (Cosine(2.0, 1.0, 100), {0: 2.0, 25: 1.5 + math.sqrt(0.125), 50: 1.5, 100: 1.0, 400: 1.0}),
        (Steps(1.0, 0.5, 10), {0: 1.0, 9: 1.0, 10: 0.5, 29: 0.25}),
        (Exponential(1.0, 0.2, 100), {0: 1.0, 100: 0.6, 200: 0.4}),
        (InverseSigmoid(1e3), {0: 1000 / 1001, round(1e3 * math.log(1e3)): 0.5, 10**9: 0.0}),
    ],
)
def test_values(schedule, points: dict[int, float]) -> None:
    assert {step: schedule(step) for step in points} == pytest.approx(points, abs=1e-3)


def test_the_plans_rate_follows_its_schedule() -> None:
    plan = TrainingPlan(steps=100, learning_rate=0.4, final_learning_rate=0.1, warmup=4, rate_every=40, rate_factor=0.5)
    assert plan.rate(0) == pytest.approx(Cosine(0.4, 0.1, 100)(0) / 4)
    assert [replace(plan, rate_schedule="steps").rate(step) for step in (10, 39, 40, 80)] == [0.4, 0.4, 0.2, 0.1]
    assert [replace(plan, rate_schedule="constant").rate(step) for step in (1, 50, 99)] == [0.2, 0.4, 0.4]


def test_the_target_grows_each_time_the_loss_starts_rising() -> None:
    curriculum = LengthCurriculum()
    assert (curriculum.length, curriculum.longest) == (8, 50), "as the paper states"
    curriculum = LengthCurriculum(8, 10)
    lengths, grew = [], []
    for loss in (3.0, 2.0, 2.5, 4.0, 3.9, 4.1, 5.0, 6.0):
        grew.append(curriculum.validated({"reconstruction": loss, "kl": 100.0}))
        lengths.append(curriculum.length)
    assert lengths == [8, 8, 9, 9, 9, 10, 10, 10]
    assert grew == [False, False, True, False, False, True, False, False]
    assert curriculum.long_enough(np.array([9, 10, 30])).tolist() == [False, True, True]


def test_where_a_curriculum_stands_survives_as_json() -> None:
    one = LengthCurriculum(8, 50)
    for loss in (3.0, 4.0):
        one.validated({"reconstruction": loss})
    other = LengthCurriculum(8, 50)
    other.restore(json.loads(json.dumps(one.state())))
    assert other == one
    assert (other.length, other.best) == (9, math.inf)
    with pytest.raises(CheckpointError, match="no state of a length curriculum"):
        other.restore({"size": 3})


def test_a_curriculum_that_cannot_be_is_refused() -> None:
    with pytest.raises(OutOfRangeError, match="length is 60"):
        LengthCurriculum(60, 50)
    with pytest.raises(OutOfRangeError, match="accepted: fit"):
        LengthCurriculum().validated({"fit": 1.0})


def test_a_plan_takes_what_the_settings_have_by_its_names() -> None:
    settings = SimpleNamespace(steps=30, learning_rate=0.1, final_learning_rate=0.01, clip_norm=2.0, width=64)
    plan = TrainingPlan.of(settings, 5, clip_norm=3.0, patience=2)
    assert plan == TrainingPlan(30, 0.1, 0.01, clip_norm=3.0, patience=2, seed=5)
    with pytest.raises(TypeError, match="nonsense"):
        TrainingPlan.of(settings, nonsense=1)
