"""Rendered people of whom everything is known, before real backgrounds; needs OpenGL."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from engines import SMPL22, Motion
from engines.character import models
from engines.geometry import rotations
from viewers.camera import Camera
from viewers.moderngl_renderer import Renderer
from viewers.scene import Actor, Scene

needs_networks = pytest.mark.skipif(
    not models.installed(), reason="the networks that look at pictures are not installed: make character"
)
FIELD = 0.12
"""Vertical field of view, radians: far away, as good as weak perspective."""


@dataclass(frozen=True)
class Person:
    """A rendered person."""

    pixels: np.ndarray
    """(H, W, 3) uint8."""
    mask: np.ndarray
    """(H, W) 0 to 1."""
    joints: np.ndarray
    """(22, 2) pixels."""
    motion: Motion


def posed(**turns: tuple[float, float, float]) -> Motion:
    """One frame, joints turned from the T-pose by degrees about x, y and z."""
    pose = np.zeros((1, len(SMPL22), 3))
    for joint, turn in turns.items():
        pose[0, SMPL22.index(joint)] = np.radians(turn)
    return Motion(SMPL22, rotations.rotvec_to_quaternion(pose), np.zeros((1, 3)), 30.0).on_ground()


def arms_down(**turns: tuple[float, float, float]) -> Motion:
    """Standing with arms off the body."""
    return posed(**{"left_shoulder": (0, 0, -50), "right_shoulder": (0, 0, 50), **turns})


def background(name: str, size: tuple[int, int]) -> np.ndarray:
    """(H, W, 3) a photograph that scikit-learn brings (china.jpg, flower.jpg), stretched to a size."""
    datasets = pytest.importorskip("sklearn.datasets")
    with Image.open(Path(datasets.__file__).parent / "images" / name) as image:
        return np.asarray(image.convert("RGB").resize(size))


def photographed(motion: Motion, size: tuple[int, int] = (480, 720), behind: str = "china.jpg") -> Person:
    """The default body seen straight from the front."""
    scene = Scene((Actor(motion),), Camera("front", pitch=0.0, fov=FIELD, fill=0.8), floor=False, transparent=True)
    with Renderer(*size) as renderer:
        drawn = renderer.frame(scene)
    track = scene.track(np.zeros(1), size[0] / size[1])
    eye, target = track.eye[0], track.target[0]
    scale = size[1] / 2 / np.tan(FIELD / 2) / (eye - motion.positions[0])[:, 2:]
    joints = np.array(size) / 2 + (motion.positions[0] - target)[:, :2] * (1, -1) * scale
    alpha = drawn[..., 3:] / 255
    pixels = drawn[..., :3] * alpha + background(behind, size) * (1 - alpha)
    return Person(pixels.round().astype(np.uint8), alpha[..., 0], joints, motion)
