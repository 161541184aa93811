"""The engines by name. What an engine can do is declared by itself; nothing here or in the studio asks which it is."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from engines.errors import UnknownLabelError

WEIGHTS = Path(__file__).resolve().parent / "weights"


def _action2motion(**options: Any) -> Any:
    from engines.action2motion import engine

    return engine.load(**options)


def _loom(**options: Any) -> Any:
    from engines.loom import engine

    return engine.load(**options)


def _tm2t(**options: Any) -> Any:
    from engines.tm2t import engine

    return engine.load(**options)


def _stylization(**options: Any) -> Any:
    from engines.stylization import engine

    return engine.load(**options)


def _text2motion(**options: Any) -> Any:
    from engines.text2motion import engine

    return engine.load(**options)


def _multiact(**options: Any) -> Any:
    from engines.multiact import engine

    return engine.load(**options)


_ENGINES: dict[str, tuple[str, Callable[..., Any]]] = {
    "action2motion": ("an action's name becomes a motion (temporal VAE, Guo et al. 2020)", _action2motion),
    "loom": ("actions, styles, sentences, poses and paths become a motion (flow matching, our own)", _loom),
    "multiact": ("actions one after another, without end, with the transitions between (Lee et al. 2023)", _multiact),
    "text2motion": (
        "a sentence becomes a motion as long as it calls for (temporal VAE, Guo et al. 2022)",
        _text2motion,
    ),
    "tm2t": ("a sentence becomes a motion and a motion a sentence, by motion tokens (Guo et al. 2022)", _tm2t),
}


SEQUENCERS = frozenset({"multiact"})
"""Engines that go on from any motion with another action: `continue_from(motion, action, ...)`."""

_STYLISERS: dict[str, tuple[str, Callable[..., Any]]] = {
    "stylization": ("any motion in another manner, in a latent space (Guo et al. 2024)", _stylization),
}


_MAKES, _DESCRIBES = {"tm2t": "text2motion"}, {"tm2t": "motion2text"}
"""Engine -> the part of its weights that makes motions, that describes them; weights may hold but one of both."""


def available() -> dict[str, str]:
    """Names of the engines that make motions and whose weights are there, and a line about each."""
    return {name: line for name, line in _shipped(_ENGINES).items() if name not in _MAKES or _holds(name, _MAKES[name])}


def sequencers() -> dict[str, str]:
    """Those of `available()` that are `SEQUENCERS`."""
    return {name: line for name, line in available().items() if name in SEQUENCERS}


def stylisers() -> dict[str, str]:
    """Names of the engines that only change motions and whose weights are there, and a line about each."""
    return _shipped(_STYLISERS)


def captioners() -> dict[str, str]:
    """Names of the engines that put motions into words and whose weights are there, and a line about each."""
    shipped = _shipped(_ENGINES)
    return {name: shipped[name] for name, part in _DESCRIBES.items() if name in shipped and _holds(name, part)}


def load(name: str, **options: Any) -> Any:
    """An engine with its shipped weights, on the CPU.

    Args:
        name: one of `available()`, `stylisers()` or `captioners()`.
        options: of that engine: `variant`, `checkpoint`, ...

    Raises:
        UnknownLabelError: no such engine.
        CheckpointError: the weights are missing or damaged.
    """
    known = {**_ENGINES, **_STYLISERS}
    if name not in known:
        raise UnknownLabelError("engine", name, known)
    return known[name][1](**options)


def _shipped(known: dict[str, tuple[str, Callable[..., Any]]]) -> dict[str, str]:
    return {name: line for name, (line, _) in known.items() if any(WEIGHTS.glob(f"{name}*.safetensors"))}


def _holds(name: str, part: str) -> bool:
    """Whether shipped weights of an engine hold a part, by the settings beside them."""
    settings = (path.with_suffix(".json") for path in WEIGHTS.glob(f"{name}*.safetensors"))
    return any(part in json.loads(path.read_text(encoding="utf-8"))["parts"] for path in settings)
