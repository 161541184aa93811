"""A map of draws, the same for an action and for the styles of a take."""

from __future__ import annotations

from studio.mapping import Mapping
from studio.views.binding import follow
from studio.views.parts import DrawMap

_SHOWN = ["subject", "names", "points", "pictures", "at", "ends", "line", "words", "busy", "progress", "error"]


def draw_map(mapping: Mapping, title: str, about: str) -> DrawMap:
    """Draws as points, and what lies between them.

    Args:
        mapping: whose map it is.
        title: over it.
        about: what it shows, said while there is none.
    """
    part = DrawMap(title=title, about=about, sizing_mode="stretch_width", margin=0)
    follow(part, mapping.state, _SHOWN, lambda: {name: getattr(mapping.state, name) for name in _SHOWN})
    part.on("draw", lambda _: mapping.draw())
    part.on("cancel", lambda _: mapping.cancel())
    part.on("move", lambda message: mapping.move(message["x"], message["y"]))
    part.on("keep", lambda _: mapping.keep())
    return part
