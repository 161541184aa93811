"""Settings as JSON and back; mistakes in them."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from engines.config import Config, preset
from engines.errors import CheckpointError, UnknownLabelError


@dataclass(frozen=True)
class Sizes(Config):
    width: int = 3
    names: tuple[str, ...] = ()
    table: tuple[tuple[int, int], ...] = ()


def test_there_and_back_with_tuples_in_tuples() -> None:
    made = Sizes(4, ("a",), ((1, 2), (3, 4)))
    assert Sizes.from_json(made.to_json()) == made
    assert made.replaced(width=9) == Sizes(9, ("a",), ((1, 2), (3, 4)))


@pytest.mark.parametrize("text", ["", "[1, 2]", '"x"', '{"width": 1, "wide": 2}'])
def test_what_is_no_settings_is_refused(text: str) -> None:
    with pytest.raises(CheckpointError, match=r"wide|Sizes"):
        Sizes.from_json(text)


def test_an_unknown_preset_names_the_nearest() -> None:
    assert preset("small", {"small": 1, "paper": 2}) == 1
    with pytest.raises(UnknownLabelError, match="paper"):
        preset("papers", {"small": 1, "paper": 2})
