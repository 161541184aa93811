"""A made-up walk on smpl22: swinging hips, bending knees, swinging arms, on a straight or curved way."""

from __future__ import annotations

import numpy as np

from engines.geometry import rotations
from engines.motion import Motion, Provenance, Segment
from engines.skeletons import SMPL22, Skeleton


def walk(
    seconds: float = 10.0,
    fps: float = 20.0,
    *,
    turn: float = 0.0,
    wave: bool = False,
    skeleton: Skeleton = SMPL22,
    labels: bool = True,
) -> Motion:
    """A walk along +Z that turns by `turn` radians a second and waves the left hand if asked to."""
    frames = round(seconds * fps)
    time = np.arange(frames) / fps
    stride = 2 * np.pi * 0.8 * time
    quaternions = np.tile(rotations.IDENTITY, (frames, len(skeleton), 1))

    def bend(joint: str, x=0.0, y=0.0, z=0.0) -> None:
        """One more turn about an axis of the parent, after those the joint has already."""
        vector = np.stack([np.broadcast_to(v, frames) for v in (x, y, z)], axis=-1)
        j = skeleton.index(joint)
        quaternions[:, j] = rotations.multiply(rotations.rotvec_to_quaternion(vector), quaternions[:, j])

    for side, phase, out in (("left", 0.0, 1), ("right", np.pi, -1)):
        swing = np.sin(stride + phase)  # the leg moves forward while its cosine is positive
        bend(f"{side}_hip", x=-0.38 * swing)
        bend(f"{side}_knee", x=0.1 + 0.95 * np.clip(np.sin(stride + phase + 1.9), 0, None) ** 2)
        bend(f"{side}_ankle", x=0.1 * swing)
        bend(f"{side}_elbow", y=-out * (0.35 - 0.15 * swing))
        rise = 1 / (1 + np.exp(-(time - seconds * 0.5) * 4)) if wave and side == "left" else np.zeros(frames)
        bend(f"{side}_elbow", z=rise * (0.5 + 0.4 * np.sin(2 * np.pi * 1.6 * time)))
        bend(f"{side}_shoulder", z=-out * 1.25 + 2.2 * rise)
        bend(f"{side}_shoulder", x=0.4 * swing * (1 - rise))
    bend("spine1", y=0.08 * np.sin(stride))
    quaternions[:, 0] = rotations.yaw_quaternion(turn * time)
    path = planted(Motion(skeleton, quaternions, np.zeros((frames, 3)), fps))
    tags = ()
    if labels:
        a, b, c = round(0.42 * frames), round(0.5 * frames), round(0.85 * frames)
        tags = (
            Segment(0, a, "action", "walk"), Segment(a, b, "transition", "walk to wave"),
            Segment(b, c, "action", "wave left"), Segment(c, frames, "action", "stand"),
            Segment(0, frames, "style", "elderly"),
        )  # fmt: skip
    made = Provenance(source="synthetic", prompt="a person walks and waves with the left hand" if wave else "")
    return Motion(skeleton, quaternions, path, fps, tags, made)


def planted(motion: Motion) -> np.ndarray:
    """(T, 3) root path that keeps the lower foot where it stands, the sole on the floor."""
    feet = motion.positions[:, [motion.skeleton.index(toe) for _, toe in motion.skeleton.feet]]
    standing = feet[..., 1].argmin(axis=1)
    path = np.zeros((len(motion), 3))
    for frame in range(1, len(motion)):
        foot = standing[frame]
        path[frame] = path[frame - 1] - (feet[frame, foot] - feet[frame - 1, foot])
    path[:, 1] = 0.0277 - feet[..., 1].min(axis=1)
    return path
