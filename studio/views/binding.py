"""Ties parameters of components to parameters of the state."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import param


def tie(part: param.Parameterized, state: param.Parameterized, **names: str) -> None:
    """Keep `part.<name>` and `state.<names[name]>` equal, both ways, starting from the state's."""
    for own, theirs in names.items():
        setattr(part, own, getattr(state, theirs))
        state.param.watch(lambda event, own=own: setattr(part, own, event.new), theirs)
        part.param.watch(lambda event, theirs=theirs: setattr(state, theirs, event.new), own)


def follow(
    part: param.Parameterized, state: param.Parameterized, watched: Iterable[str], show: Callable[[], dict[str, Any]]
) -> None:
    """Set the part to `show()` now and whenever one of the state's `watched` parameters changes."""

    def update(*_: Any) -> None:
        part.param.update(**show())

    state.param.watch(update, list(watched))
    update()
