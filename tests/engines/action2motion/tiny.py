"""A small Action2Motion with random weights, and movements made by formula: tests without shipped weights or data."""

from __future__ import annotations

import numpy as np
import torch

from engines.action2motion.config import SMALL, Action2MotionConfig
from engines.action2motion.engine import Action2MotionEngine
from engines.action2motion.model import Action2Motion
from engines.datasets import Clip
from engines.geometry import rotations
from engines.motion import Motion
from engines.skeletons import SMPL22

ACTIONS = ("walk", "turn left", "turn right", "wave left hand", "wave right hand", "throw")
NOMINAL = (20, 18, 18, 24, 24, 16)


def config(decoder: str = "glmi-m", **changes) -> Action2MotionConfig:
    """Sizes of a few units each."""
    small = {
        "decoder": decoder, "actions": ACTIONS, "nominal_frames": NOMINAL, "window": 8, "embed_size": 12,
        "generator_size": 16, "latent_size": 5, "movement_size": 4, "batch_size": 6,
    }  # fmt: skip
    return SMALL.replaced(**{**small, **changes})


def model(decoder: str = "glmi-m", seed: int = 0, **changes) -> Action2Motion:
    """Random weights, the same for the same seed; a root height of about a metre."""
    torch.manual_seed(seed)
    made = Action2Motion(config(decoder, **changes))
    with torch.no_grad():
        if decoder != "plain":
            made.head.output.bias[0] = 0.95
        made.velocity_std.fill_(0.05)
    return made


def engine(decoder: str = "glmi-m", **changes) -> Action2MotionEngine:
    return Action2MotionEngine(model(decoder, **changes), "0" * 64)


def movement(frames: int = 30, seed: int = 0, fps: float = 20.0, turning: float = 2.5) -> Motion:
    """Smooth turning of every joint, a path in all directions, and `turning` radians a second about the vertical."""
    rng = np.random.default_rng(seed)
    time = np.arange(frames)[:, None, None] / fps
    speed, phase = rng.uniform(0.5, 2.0, (2, 1, len(SMPL22), 3))
    lie = 0.5 * np.sin(2 * np.pi * speed * time + 6 * phase)
    turns = rotations.rotvec_to_quaternion(lie)
    yaw = turning * time[:, 0, 0] + rng.uniform(-3, 3)
    turns[:, 0] = rotations.multiply(rotations.yaw_quaternion(yaw), rotations.rotvec_to_quaternion(0.3 * lie[:, 0]))
    along = np.stack([np.sin(yaw), 0.1 * np.sin(5 * yaw) / 3, np.cos(yaw)], axis=-1)
    path = 0.9 * along + np.array([rng.normal(), 0.95, rng.normal()])
    return Motion(SMPL22, rotations.continuous(turns), path, fps)


def clip(action: str, frames: int = 30, seed: int = 0) -> Clip:
    return Clip("formula", f"{action}-{seed}", action, None, None, None, "train", movement(frames, seed))


def clips(count: int = 2) -> list[Clip]:
    """Some of each action that is not another one mirrored."""
    return [clip(action, 24 + 6 * i, 10 * i + k) for i, action in enumerate(ACTIONS) for k in range(count)]
