"""A camera in one's hand, with no graphics API in it: what the mouse turns, shifts and zooms, on top of any camera."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from viewers.camera import CameraTrack, direction
from viewers.viewing import STEEPEST

TURN = np.pi
"""Radians that a drag over the whole height of the window turns."""
WHEEL = 0.9
"""Times as far away a notch of the wheel goes."""
NEAREST, FARTHEST = 0.05, 20.0
"""Times the camera's own distance."""


@dataclass
class Steering:
    """How far the camera was moved by hand."""

    yaw: float = 0.0
    """Radians, towards the figure's left."""
    pitch: float = 0.0
    """Radians, upwards."""
    zoom: float = 1.0
    """Times as far away."""
    shift: tuple[float, float] = (0.0, 0.0)
    """To the right and up, in distances from what is looked at."""

    def reset(self) -> None:
        """As the camera itself stands."""
        self.yaw, self.pitch, self.zoom, self.shift = 0.0, 0.0, 1.0, (0.0, 0.0)

    def turn(self, across: float, down: float) -> None:
        """A drag by so many heights of the window to the right and down: the scene goes along with the mouse."""
        self.yaw -= TURN * across
        self.pitch = float(np.clip(self.pitch + TURN * down, -np.pi, np.pi))

    def pan(self, across: float, down: float) -> None:
        """A drag with the other button: shifts instead."""
        self.shift = (self.shift[0] - across, self.shift[1] + down)

    def wheel(self, notches: float) -> None:
        """Nearer (positive) or farther."""
        self.zoom = float(np.clip(self.zoom * WHEEL**notches, NEAREST, FARTHEST))

    def moved(self, track: CameraTrack) -> CameraTrack:
        """A camera's track (N moments) with these moves on top."""
        arm = track.eye - track.target
        distance = np.linalg.norm(arm, axis=-1, keepdims=True)
        arm = arm / distance
        yaw = np.arctan2(arm[:, 0], arm[:, 2]) + self.yaw
        own = np.arcsin(np.clip(arm[:, 1], -1.0, 1.0))
        limit = np.maximum(np.abs(own), STEEPEST)
        pitch = np.clip(own + self.pitch, -limit, limit)
        look = np.stack([direction(float(a), float(b)) for a, b in zip(yaw, pitch, strict=True)])
        side = np.stack([np.cos(yaw), 0 * yaw, -np.sin(yaw)], axis=-1)
        up = np.cross(look, side)
        reach = 2 * np.tan(track.fov / 2) * distance * self.zoom  # metres from the lower to the upper edge
        target = track.target + reach * (self.shift[0] * side + self.shift[1] * up)
        near, far = (float(np.clip(z * self.zoom, 0.02, 1e4)) for z in (track.near, track.far))
        return replace(
            track, eye=target + distance * self.zoom * look, target=target, near=near, far=max(far, track.far)
        )
