"""Finding a data set's folders and reading its small index files."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from engines.errors import FormatError
from engines.formats.files import read_bytes

_DEPTH = 5
"""How far below the given folder a data set's own folder may lie."""


def folders_with(folder: Path, *children: str) -> Iterator[Path]:
    """Folders at or below `folder` that hold all of the named children, in a fixed order."""
    top = len(folder.parts)
    for place, below, files in os.walk(folder):
        held = {*below, *files}
        if held.issuperset(children):
            yield Path(place)
        deep = len(Path(place).parts) - top >= _DEPTH
        below[:] = [] if deep else sorted(name for name in below if name not in children)


def files_below(folder: Path, pattern: str) -> list[Path]:
    """Files at any depth that match, sorted by path."""
    return sorted(path for path in folder.rglob(pattern) if path.is_file())


def read_text(path: Path) -> str:
    """A text file.

    Raises:
        FormatError: missing, too large, or not UTF-8.
    """
    try:
        return read_bytes(path).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise FormatError(path, f"is not UTF-8 text ({error.reason} at byte {error.start}).") from error


def read_json(path: Path) -> Any:
    """A JSON file.

    Raises:
        FormatError: missing or not JSON; the message names the line.
    """
    try:
        return json.loads(read_text(path))
    except json.JSONDecodeError as error:
        raise FormatError(path, f"not JSON: {error.msg}.", error.lineno) from error
    except RecursionError as error:
        raise FormatError(path, "not JSON that can be read: nested too deeply.") from error
