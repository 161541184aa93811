"""The studio in a notebook cell: the controls of an engine, and the player beside them.

    from studio import notebook

    panel = notebook.panel("loom", action="wave right hand", seconds=3)
    panel                        # last line of a cell: choose, press Generate, click a figure
    panel.motion                 # the take that is chosen; panel.motions: those drawn with it
    panel.generate().wait()      # the same without the mouse
    notebook.panel("stylization", motion=panel.motion, style="old")   # that take in another manner

`maker.py` asks the engine, off the kernel's thread; `controls.py` and `pins.py` are what a person touches, built from
what the engine says it can do; `widget.py` puts them beside the player.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from studio.notebook.widget import Panel


def panel(engine: Any = "", height: int = 480, **settings: Any) -> Panel:
    """Controls of an engine and the player, for a notebook.

    Args:
        engine: a name of `engines.available()`, or an engine as `engines.load` gives it; the studio's own if empty.
        height: of the player, pixels.
        settings: what the controls begin with: action, style, prompt, seconds, count, seed, guidance, best_of,
            bone_scale; or, of an engine that puts a motion in another manner: motion, style, like, strength, tempo,
            count, seed.

    Raises:
        UnknownLabelError: no such engine, or no such setting.
        OutOfRangeError: a value that is not accepted.
        CheckpointError: the engine's weights are missing.
    """
    from studio.notebook.widget import Panel

    return Panel(engine, height, **settings)


__all__ = ["panel"]
