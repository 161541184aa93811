"""Shapes and types of annotated arguments and results, checked while the tests run and never in the program.

`conftest.py` installs the check before any of `CHECKED` is imported.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jaxtyping
from beartype import BeartypeConf, beartype

CHECKED = (
    "engines.action2motion.networks",
    "engines.action2motion.output",
    "engines.action2motion.progress",
    "engines.action2motion.representation",
    "engines.character.arap",
    "engines.character.atlas",
    "engines.character.completion",
    "engines.character.correspondence",
    "engines.character.depth",
    "engines.character.guess",
    "engines.character.mask",
    "engines.character.models",
    "engines.character.outline",
    "engines.character.picture",
    "engines.character.prior",
    "engines.character.sighting",
    "engines.character.texture",
    "engines.character.video",
    "engines.character.view",
    "engines.geometry",
    "engines.metrics.physical",
    "engines.motion",
    "engines.multiact.model",
    "engines.multiact.networks",
    "engines.skeletons.skeleton",
    "viewers.bodies.body",
    "viewers.camera",
)
"""Modules, with those below them, whose signatures hold at every call in the tests."""

REFUSE_IN_WORDS = frozenset(
    {
        "engines.geometry.inverse.inverse",
        "engines.metrics.physical.bone_length_drift",
        "engines.motion.Motion.__getitem__",
        "engines.motion.Motion.__init__",
        "engines.motion.Motion.from_positions",
        "engines.skeletons.skeleton.Skeleton.__init__",
        "viewers.bodies.body.Body.__init__",
        "viewers.camera.Camera.__init__",
    }
)
"""What people's arrays reach first converts them, and answers a wrong shape with an error of the project's own."""

_CONF = BeartypeConf(is_pep484_tower=True)  # as for pyright, an int is a float


def checked(function: Callable[..., Any]) -> Callable[..., Any]:
    """The function with every argument and result checked, but for those that do that themselves."""
    if f"{function.__module__}.{function.__qualname__}" in REFUSE_IN_WORDS:
        return function
    return beartype(conf=_CONF)(function)


def install() -> None:
    """From here on an import of a module of `CHECKED` brings its checked form."""
    jaxtyping.install_import_hook(CHECKED, "tests.shape_check.checked")
