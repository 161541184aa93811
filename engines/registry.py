"""The engines by name. What an engine can do is declared by itself; nothing here or in the studio asks which it is."""

from __future__ import annotations

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


_ENGINES: dict[str, tuple[str, Callable[..., Any]]] = {
    "action2motion": ("an action's name becomes a motion (temporal VAE, Guo et al. 2020)", _action2motion),
    "loom": ("actions, styles, sentences, poses and paths become a motion (flow matching, our own)", _loom),
    "tm2t": ("a sentence becomes a motion and a motion a sentence, by motion tokens (Guo et al. 2022)", _tm2t),
}


def available() -> dict[str, str]:
    """Names of the engines whose weights are there, and a line about each."""
    return {name: line for name, (line, _) in _ENGINES.items() if any(WEIGHTS.glob(f"{name}*.safetensors"))}


def load(name: str, **options: Any) -> Any:
    """An engine with its shipped weights, on the CPU.

    Args:
        name: one of `available()`.
        options: of that engine: `variant`, `checkpoint`, ...

    Raises:
        UnknownLabelError: no such engine.
        CheckpointError: the weights are missing or damaged.
    """
    if name not in _ENGINES:
        raise UnknownLabelError("engine", name, _ENGINES)
    return _ENGINES[name][1](**options)
