"""A library in a file of its own."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from studio.library import Library, open_library
from studio.settings import GenerateSettings
from studio.takes import TakeList
from tests.studio.fakes import METRICS, sway


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "data" / "library.db"


@pytest.fixture
def library(file: Path) -> Iterator[Library]:
    made = open_library(str(file))
    yield made
    made.close()


@pytest.fixture
def draw() -> Callable[..., list[str]]:
    """`draw(takes, 2, action="run")` adds a draw to a list of takes as the studio does. Returns the ids."""

    def add(takes: TakeList, count: int = 2, seed: int = 1, group: str = "g", **asked) -> list[str]:
        settings = GenerateSettings(**{"engine": "loom", "count": count, "seed": seed, **asked})
        motions = [sway(settings.action, 8, seed, index) for index in range(count)]
        held = takes.store.hold(motions)
        made = takes.add(held, group=f"{group}{seed}", settings=settings, metrics=[METRICS] * count)
        return [take.id for take in made]

    return add
