"""`MotionPlayer` for Jupyter, `PanelPlayer` for the app, `save_html` for a file: one bundle, one set of options.

    from viewers.web.player import MotionPlayer, PanelPlayer, save_html

    MotionPlayer(motion)                                  # last line of a notebook cell
    MotionPlayer([a, b], labels=["before", "after"], ghosts=8, trail=True)
    MotionPlayer([Actor(a, colour="#dc8f85"), Actor(b, offset=(0, 0, 1))], arrangement="overlay")
    PanelPlayer(motion, sizing_mode="stretch_both", height=None)
    save_html(motion, "walk.html")                        # one file, no server, no network

anywidget and Panel are imported when their class is first asked for, not before.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from viewers.web.controls import OPTIONS, Controls
from viewers.web.payload import Actor
from viewers.web.standalone import save_html

if TYPE_CHECKING:
    from viewers.web.jupyter import MotionPlayer
    from viewers.web.panel_player import PanelPlayer


def __getattr__(name: str) -> Any:
    if name == "MotionPlayer":
        from viewers.web.jupyter import MotionPlayer

        return MotionPlayer
    if name == "PanelPlayer":
        from viewers.web.panel_player import PanelPlayer

        return PanelPlayer
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


__all__ = ["OPTIONS", "Actor", "Controls", "MotionPlayer", "PanelPlayer", "save_html"]
