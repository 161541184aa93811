"""Settings from the command line: every kind of field, and words for every mistake."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import pytest

from engines.action2motion.config import Action2MotionConfig
from engines.errors import OutOfRangeError, UnknownLabelError
from engines.training.overrides import overrides
from engines.training.plan import TrainingPlan


@dataclass(frozen=True)
class Kinds:
    count: int = 1
    rate: float = 0.1
    name: str = "a"
    fast: bool = False
    mode: Literal["soft", "hard"] = "soft"
    levels: tuple[int, ...] = ()
    ends: tuple[float, float] = (0.0, 1.0)
    limit: int | None = None
    notes: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Other:
    rate: int = 5
    depth: int = 2


@pytest.mark.parametrize(
    ("pair", "value"),
    [
        ("count=1_000", 1000), ("rate=2e-4", 2e-4), ("rate=3", 3.0), ("name=walk slowly", "walk slowly"),
        ("name=a=b", "a=b"), ("fast=yes", True), ("fast=False", False), ("mode=hard", "hard"),
        ("levels=1,2, 3", (1, 2, 3)), ("levels=", ()), ("ends=0.01,0.5", (0.01, 0.5)),
        ("limit=none", None), ("limit=7", 7), (" count = 4 ", 4),
    ],
)  # fmt: skip
def test_a_value_takes_its_fields_type(pair: str, value: object) -> None:
    (found,) = overrides([pair], Kinds)
    assert list(found.values()) == [value]
    assert type(next(iter(found.values()))) is type(value)
    Kinds(**found)


@pytest.mark.parametrize(
    ("pair", "accepted"),
    [
        ("count=1.5", "a whole number"), ("rate=fast", "a number"), ("fast=2", "true or false"),
        ("mode=medium", "soft or hard"), ("levels=1,x", "a whole number each, with commas"),
        ("ends=1", "2 values with a comma between them, each a number"), ("limit=x", "a whole number or none"),
        ("count", "KEY=VALUE"), ("", "KEY=VALUE"),
    ],
)  # fmt: skip
def test_a_value_of_another_type_says_what_would_be_accepted(pair: str, accepted: str) -> None:
    with pytest.raises(OutOfRangeError, match=accepted):
        overrides([pair], Kinds)


def test_an_unknown_key_is_answered_with_the_nearest() -> None:
    with pytest.raises(UnknownLabelError, match="unknown setting 'learning_rat'; did you mean 'learning_rate'"):
        overrides(["learning_rat=1"], Action2MotionConfig, TrainingPlan)
    with pytest.raises(UnknownLabelError, match="unknown setting 'notes'"):
        overrides(["notes={}"], Kinds)


def test_a_key_belongs_to_the_first_that_has_it_and_the_last_value_counts() -> None:
    assert overrides(["rate=1", "depth=3", "rate=2"], Kinds, Other) == [{"rate": 2.0}, {"depth": 3}]
    assert overrides([], Kinds, Other) == [{}, {}]


def test_every_setting_of_action2motion_can_be_given() -> None:
    pairs = [
        "kl_weight=0.01,0.1",
        "decoder=lie",
        "normalise=true",
        "actions=walk,turn left",
        "patience=3",
        "precision=bf16",
    ]
    config, plan = overrides(pairs, Action2MotionConfig, TrainingPlan)
    made = Action2MotionConfig().replaced(**config)
    assert (made.kl_weight, made.decoder, made.normalise) == ((0.01, 0.1), "lie", True)
    assert made.actions == ("walk", "turn left")
    assert plan == {"patience": 3, "precision": "bf16"}
