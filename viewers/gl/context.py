"""One OpenGL context for each thread that draws, made without a screen, and the programs compiled in it."""

from __future__ import annotations

import contextlib
import ctypes
import logging
import os
import re
import sys
import threading
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from engines.errors import MotionloomError

if TYPE_CHECKING:
    import moderngl

SHADERS = Path(__file__).resolve().parent.parent / "shaders"
_LOG = logging.getLogger(__name__)
_LOCAL = threading.local()
_LOCK = threading.Lock()
_FREE: list[GraphicsContext] = []

_ATTEMPTS: tuple[tuple[str, dict[str, Any]], ...] = (
    ("EGL", {"backend": "egl"}),
    ("EGL by its library names", {"backend": "egl", "libgl": "libGL.so.1", "libegl": "libEGL.so.1"}),
    ("EGL without libGL", {"backend": "egl", "libgl": "libOpenGL.so.0", "libegl": "libEGL.so.1"}),
    ("the window system", {}),
)


class NoGraphicsError(MotionloomError):
    """No OpenGL context could be made; the message says what to install."""

    def __init__(self, failures: list[str]) -> None:
        super().__init__(
            "pictures and videos need OpenGL 3.3, and no way to it was found (" + "; ".join(failures) + "). Install a "
            "driver or Mesa's software renderer, which needs neither GPU nor screen: "
            "'apt-get install libegl1 libgl1 libgl1-mesa-dri' on Debian or Ubuntu, "
            "'dnf install mesa-libEGL mesa-libGL mesa-dri-drivers' on Fedora."
        )


class GraphicsContext:
    """A context and what is compiled and uploaded in it. Belongs to one thread at a time."""

    def __init__(self, opened: moderngl.Context | None = None) -> None:
        """Take over a context that is current, or open one without a window."""
        self.gl: moderngl.Context = opened or open_context()
        self.thread = threading.get_ident()
        self._programs: dict[tuple[str, str, tuple[tuple[str, int], ...]], moderngl.Program] = {}
        self.cache: dict[object, Any] = {}
        """Vertex arrays and the like, keyed by their owners."""
        self.meshes: dict[object, Any] = {}
        """Uploaded bodies, see `figures.mesh`."""
        self._handle = _current_handle()
        self._token = os.urandom(16)
        self._proof = self.gl.buffer(self._token)

    def take_up(self) -> bool:
        """Make this the thread's current context, in whose place another library may have put its own; False if lost.

        VTK shuts EGL's display down with each window it closes, and all contexts of the process with it.
        """
        self.gl.__enter__()
        return self._handle is None or _current_handle() == self._handle

    def alive(self) -> bool:
        """Is it still there, with what was uploaded? Makes it current."""
        # another context may by now have the same address, but not hold the token
        return self.take_up() and self._proof.read() == self._token

    def program(self, vertex: str, fragment: str, **defines: int) -> moderngl.Program:
        """The program of two shader files (names without folder and ending), compiled once.

        Args:
            vertex: vertex shader.
            fragment: fragment shader.
            defines: preprocessor constants (ROWS of joint matrices, GRAIN, ...).
        """
        key = (vertex, fragment, tuple(sorted(defines.items())))
        if key not in self._programs:
            self._programs[key] = self.gl.program(
                vertex_shader=source(f"{vertex}.vert.glsl", defines),
                fragment_shader=source(f"{fragment}.frag.glsl", defines),
            )
        return self._programs[key]


class _Lease:
    """A thread's hold on a context; when the thread ends, the context is free for another."""

    def __init__(self, graphics: GraphicsContext) -> None:
        self.graphics = graphics
        graphics.thread = threading.get_ident()

    def __del__(self) -> None:
        with contextlib.suppress(Exception):  # at the end of the program there may be nothing left to do it with
            self.graphics.gl.__exit__(None, None, None)
            with _LOCK:
                _FREE.append(self.graphics)


def context() -> GraphicsContext:
    """This thread's context, made on first use.

    An OpenGL context can be current in one thread only; so every thread that draws has its own, and objects made
    with one must not be used in another. The contexts of threads that ended are used again, with all they hold. In
    place of a context that was lost (see `take_up`) there is a new one.

    Raises:
        NoGraphicsError: no OpenGL here.
    """
    lease = getattr(_LOCAL, "lease", None)
    if lease is None or not lease.graphics.alive():
        del lease
        _LOCAL.lease = None  # a lost one first, since letting go of it makes none current
        lease = _LOCAL.lease = _Lease(_idle() or GraphicsContext())
    return lease.graphics


def _idle() -> GraphicsContext | None:
    """A context of a thread that ended, if there is one that was not lost meanwhile."""
    while True:
        with _LOCK:
            if not _FREE:
                return None
            found = _FREE.pop()
        if found.alive():
            return found


def _current_handle() -> int | None:
    """EGL's name of the current context; None where EGL is not what makes contexts."""
    egl = _egl()
    return None if egl is None else egl.eglGetCurrentContext()


@lru_cache(maxsize=1)
def _egl() -> ctypes.CDLL | None:
    if not sys.platform.startswith("linux"):
        return None
    try:
        library = ctypes.CDLL("libEGL.so.1")
    except OSError:
        return None
    library.eglGetCurrentContext.restype = ctypes.c_void_p
    return library


def open_context() -> moderngl.Context:
    """A fresh OpenGL 3.3 context without a window: EGL first (works without a screen), then the window system.

    Raises:
        NoGraphicsError: nothing worked; says what was tried and what to install.
    """
    import moderngl

    failures = []
    attempts = _ATTEMPTS if sys.platform.startswith("linux") else _ATTEMPTS[-1:]
    for name, options in attempts:
        try:
            opened = moderngl.create_context(standalone=True, require=330, **options)
        except Exception as problem:  # glcontext raises bare Exception, OSError, ImportError, ...
            failures.append(f"{name}: {problem}")
            continue
        _LOG.info("drawing with %s (OpenGL %s), through %s", opened.info["GL_RENDERER"], opened.version_code, name)
        return opened
    raise NoGraphicsError(failures)


def source(name: str, defines: Mapping[str, int] | None = None) -> str:
    """Text of a shader file, its #include lines filled in and constants defined after its #version line."""
    text = (SHADERS / name).read_text(encoding="utf-8")
    text = re.sub(r'#include "([\w.]+)"', lambda match: (SHADERS / match[1]).read_text(encoding="utf-8"), text)
    version, rest = text.split("\n", 1)
    return "\n".join([version, *(f"#define {key} {value}" for key, value in (defines or {}).items()), rest])


def put(program: moderngl.Program, **values: Any) -> None:
    """Set a program's uniforms: numbers, vectors, lists of vectors, and matrices (4, 4) for column vectors."""
    import moderngl

    for name, value in values.items():
        uniform = program[name]
        assert isinstance(uniform, moderngl.Uniform), name
        uniform.value = tuple(value.T.ravel().tolist()) if isinstance(value, np.ndarray) else value
