"""Files of a training's folder: written beside the old ones, then put in their place."""

from __future__ import annotations

import os
from pathlib import Path

from engines.formats.files import atomic_path


def write_beside(path: Path, content: str | bytes, durable: bool = False) -> None:
    """Replace a file as a whole: whatever happens, the old content stands until the new one is complete.

    Args:
        path: in a folder that is there.
        content: text is written as UTF-8.
        durable: force it to the disk first, so that it also outlives a power failure.

    Raises:
        FormatError: the disk is full, the folder is missing, ...; nothing half-written is left.
    """
    with atomic_path(path) as temporary, temporary.open("wb") as file:
        file.write(content.encode() if isinstance(content, str) else content)
        if durable:
            file.flush()
            os.fsync(file.fileno())
