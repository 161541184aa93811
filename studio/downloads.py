"""Finished files on their way to the browser: each under a key that cannot be guessed, gone with its session."""

from __future__ import annotations

import secrets
import threading
from pathlib import Path

ROUTE = "downloads"
"""First part of the address, relative to the page."""

_files: dict[str, Path] = {}
_lock = threading.Lock()


def offer(path: Path) -> str:
    """Let a file be downloaded. Returns its address, relative to the page."""
    key = secrets.token_urlsafe(16)
    with _lock:
        _files[key] = path
    return f"{ROUTE}/{key}/{path.name}"


def find(key: str, name: str) -> Path | None:
    """The file under a key, if its name agrees and it is still there."""
    with _lock:
        path = _files.get(key)
    return path if path is not None and path.name == name and path.is_file() else None


def withdraw(folder: Path) -> None:
    """Forget every file inside a folder."""
    with _lock:
        for key in [key for key, path in _files.items() if path.is_relative_to(folder)]:
            del _files[key]
