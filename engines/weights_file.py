"""Weights and their settings as two files beside each other, `NAME.safetensors` and `NAME.json`: read and written."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path

from safetensors.torch import load_file, save
from torch import Tensor, nn

from engines.errors import CheckpointError
from engines.training.files import write_beside

SHIPPED = Path(__file__).parent / "weights"
"""Where weights that come with the program are."""


def read_settings(path: Path, missing: str) -> str:
    """The settings (JSON) beside weights.

    Args:
        path: of the weights.
        missing: what to do where there are none, for the message.

    Raises:
        CheckpointError: no such weights, or none with settings beside them.
    """
    if not path.is_file():
        raise CheckpointError(f"{path}: no such weights; {missing}")
    try:
        return path.with_suffix(".json").read_text(encoding="utf-8")
    except (OSError, ValueError) as error:
        raise CheckpointError(f"{path.with_suffix('.json')}: the settings cannot be read: {error}") from error


def fill(net: nn.Module, path: Path) -> None:
    """Put the weights of a file into a network, as float32 whatever they are stored in.

    Raises:
        CheckpointError: damaged, or of another network.
    """
    try:
        stored = load_file(path)
        net.load_state_dict({k: v.float() if v.is_floating_point() else v for k, v in stored.items()})
    except Exception as error:  # safetensors and torch raise many kinds; each means the file does not fit
        raise CheckpointError(f"{path}: these weights do not fit their settings: {error}") from error


def write(weights: Mapping[str, Tensor], settings: str, path: Path) -> str:
    """Write weights (float16; running statistics stay float32) and settings; gives the SHA-256 of the weights.

    Raises:
        FormatError: a file cannot be written; nothing half-written is left.
    """
    content = save({name: _small(name, value).cpu().contiguous() for name, value in weights.items()})
    write_beside(path, content)
    write_beside(path.with_suffix(".json"), settings + "\n")
    return hashlib.sha256(content).hexdigest()


def _small(name: str, value: Tensor) -> Tensor:
    return value.half() if value.is_floating_point() and "running" not in name else value
