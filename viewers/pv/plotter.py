"""PyVista, imported when it is needed, with words where it or a screen is missing."""

from __future__ import annotations

import os
import sys
from typing import Any

from engines.errors import MissingDependencyError
from viewers.display import NoDisplayError, has_display

Plotter = Any
"""A `pyvista.Plotter`; its own annotations do not pass a type checker."""

LARGEST = 8192
"""Longest side of a picture, pixels."""


_WITHOUT_SCREEN = ("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")


def pyvista_module():
    """The package pyvista.

    Raises:
        MissingDependencyError: it is not installed.
    """
    if sys.platform.startswith("linux"):
        # VTK finds EGL by itself, but only after complaining on stderr that there is no X server
        if not os.environ.get("DISPLAY"):
            os.environ.setdefault(*_WITHOUT_SCREEN)
        elif os.environ.get(_WITHOUT_SCREEN[0]) == _WITHOUT_SCREEN[1]:
            del os.environ[_WITHOUT_SCREEN[0]]
    try:
        import pyvista
    except ImportError as problem:
        raise MissingDependencyError("pyvista", "viewers", "looking at motions with PyVista") from problem
    return pyvista


def make_plotter(width: int, height: int, window: bool = False, title: str = "motionloom") -> Plotter:
    """A plotter without lights and decorations.

    Args:
        width: pixels.
        height: pixels.
        window: a window on the screen; else pictures only.
        title: of the window.

    Raises:
        MissingDependencyError: pyvista is not installed.
        NoDisplayError: a window without a screen.
    """
    if window and not has_display():
        raise NoDisplayError
    return pyvista_module().Plotter(
        off_screen=not window, window_size=[width, height], lighting="none", title=title, notebook=False
    )
