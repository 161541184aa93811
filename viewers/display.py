"""Is there a screen, and what is said if there is none."""

from __future__ import annotations

import os
import sys

from engines.errors import MotionloomError


class NoDisplayError(MotionloomError):
    """A window was asked for where there is no screen."""

    def __init__(self) -> None:
        super().__init__(
            "a window needs a screen, and there is none here (neither $DISPLAY nor $WAYLAND_DISPLAY is set). Without "
            "one: `motionloom render` makes videos and pictures, Inspector.notebook() shows motions in Jupyter, and "
            "Inspector.save_html() writes a page that any browser plays."
        )


def has_display() -> bool:
    """Is there a screen to open a window on?"""
    if not sys.platform.startswith("linux"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
