"""Viewers: everything that turns Motion into pixels. Nothing heavy is imported until it is used."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from viewers.scene import Actor, Camera, Scene
    from viewers.video import render, write_video
    from viewers.web.player import MotionPlayer

_HOMES = {
    "Actor": "viewers.scene",
    "Camera": "viewers.scene",
    "Scene": "viewers.scene",
    "render": "viewers.video",
    "write_video": "viewers.video",
    "MotionPlayer": "viewers.web.player",
}

__all__ = ["Actor", "Camera", "MotionPlayer", "Scene", "render", "write_video"]


def __getattr__(name: str) -> object:
    if name not in _HOMES:
        raise AttributeError(f"module 'viewers' has no attribute {name!r}; it has {', '.join(__all__)}")
    from importlib import import_module

    return getattr(import_module(_HOMES[name]), name)
