"""Finished files on their way to the browser: each under a key that cannot be guessed, gone with its session.

Where several processes serve, any of them may be asked for a file: `share` names a folder in which each notes its own.
"""

from __future__ import annotations

import secrets
import threading
from pathlib import Path

ROUTE = "downloads"
"""First part of the address, relative to the page."""

_files: dict[str, Path] = {}
_lock = threading.Lock()
_shared: list[Path] = []
"""The folder of notes, where there is one."""


def share(folder: Path) -> None:
    """Note what is offered in a folder, for other processes; before they are split off."""
    _shared[:] = [folder]


def offer(path: Path) -> str:
    """Let a file be downloaded. Returns its address, relative to the page."""
    key = secrets.token_urlsafe(16)
    with _lock:
        _files[key] = path
    for folder in _shared:
        beside = folder / f".{key}"
        beside.write_text(str(path), encoding="utf-8")
        beside.replace(folder / key)
    return f"{ROUTE}/{key}/{path.name}"


def find(key: str, name: str) -> Path | None:
    """The file under a key, if its name agrees and it is still there."""
    with _lock:
        path = _files.get(key)
    for folder in _shared:
        note = folder / key
        path = path or (Path(note.read_text(encoding="utf-8")) if note.is_file() else None)
    return path if path is not None and path.name == name and path.is_file() else None


def withdraw(folder: Path) -> None:
    """Forget every file inside a folder."""
    with _lock:
        for key in [key for key, path in _files.items() if path.is_relative_to(folder)]:
            del _files[key]
            for shared in _shared:
                (shared / key).unlink(missing_ok=True)
