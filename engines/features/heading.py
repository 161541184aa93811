"""Bodies seen from where they face: the frame of the root's place on the ground and of the heading.

Shared by the representations that take a body out of its place and heading and keep how both change.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from engines.features import arrays
from engines.features.codec import Codec, Source, Start, continuous, through_inverse
from engines.geometry import rotations
from engines.geometry.contacts import HEIGHT_MARGIN, SPEED_LIMIT
from engines.skeletons import Skeleton

BLOCK = 800
"""Frames that are worked on at a time: their planes stay in the processor's cache."""
_ACROSS = ("hip", "collar", "shoulder")
"""A body's heading is across the line through these and up, as `geometry.canonical.heading` has it."""


@dataclass(frozen=True)
class Bodies:
    """Movement of B clips of T frames as planes, float32; N = B * T."""

    shape: tuple[int, ...]
    """The leading dimensions and T."""
    local: np.ndarray
    """(3, 3, J, N) parent-relative rotations."""
    world: np.ndarray
    """(3, 3, J, N) rotations in the world."""
    joints: np.ndarray
    """(3, J, N) joints relative to the root, in the world's axes, metres."""
    root: np.ndarray
    """(3, N) the root joint in the world, metres."""
    step: np.ndarray
    """(3, N) the root's way to the next frame, metres; the last of a clip as the one before."""
    cosine: np.ndarray
    """(N,) of the heading."""
    sine: np.ndarray
    """(N,) of the heading."""
    skeleton: Skeleton

    def after(self, values: np.ndarray) -> np.ndarray:
        """Values (..., N) one frame later; the last frame of a clip is followed by itself."""
        clips = values.reshape(*values.shape[:-1], -1, self.shape[-1])
        return np.concatenate([clips[..., 1:], clips[..., -1:]], axis=-1).reshape(values.shape)

    def hold_last(self, values: np.ndarray) -> np.ndarray:
        """Values (..., N) of steps, a clip's last one made what the one before is; changed in place."""
        clips = values.reshape(*values.shape[:-1], -1, self.shape[-1])
        if self.shape[-1] > 1:
            clips[..., -1] = clips[..., -2]
        return values


def bodies(turns: np.ndarray, path: np.ndarray, skeleton: Skeleton) -> Bodies:
    """Forward kinematics and heading of quaternions (..., T, J, 4) and root translations (..., T, 3)."""
    shape = turns.shape[:-2]
    local = arrays.quaternion_to_matrix(arrays.planes(turns))
    world = arrays.world(local, skeleton.parents)
    joints = arrays.place(world, skeleton.offsets, skeleton.parents)
    root = np.asarray(path, np.float64) + skeleton.offsets[0]
    step = np.zeros(root.shape, np.float32)
    if shape[-1] > 1:
        step[..., :-1, :] = np.diff(root, axis=-2)  # before the rounding to float32, which is coarse far away
        step[..., -1, :] = step[..., -2, :]
    cosine, sine = facing(joints, skeleton)
    return Bodies(
        shape,
        local,
        world,
        joints,
        np.ascontiguousarray(root.reshape(-1, 3).T, np.float32),
        np.ascontiguousarray(step.reshape(-1, 3).T),
        cosine,
        sine,
        skeleton,
    )


def facing(joints: np.ndarray, skeleton: Skeleton) -> tuple[np.ndarray, np.ndarray]:
    """Cosine and sine (N,) of the heading of joints (3, J, N); a body that faces straight up or down counts as +Z."""
    pairs = [(f"left_{part}", f"right_{part}") for part in _ACROSS if f"left_{part}" in skeleton]
    left, right = ([skeleton.index(pair[side]) for pair in pairs] for side in (0, 1))
    x, z = (joints[axis, left].sum(0) - joints[axis, right].sum(0) for axis in (0, 2))
    length = np.hypot(x, z)
    lost = length < 1e-9
    length = np.where(lost, 1, length)
    return np.where(lost, np.float32(1), x / length), np.where(lost, np.float32(0), -z / length)


def root_parts(body: Bodies) -> dict[str, np.ndarray]:
    """The parts `yaw_velocity` (..., T, 1), `root_velocity` (..., T, 2) and `root_height` (..., T, 1).

    All in the heading of the frame itself; the turn from each heading to the next is in (-pi, pi], a full angle.
    """
    cosine, sine = body.after(body.cosine), body.after(body.sine)
    turned = np.arctan2(
        sine * body.cosine - cosine * body.sine, cosine * body.cosine + sine * body.sine
    )  # no angle is ever taken of the heading itself, so nothing breaks where that passes from pi to -pi
    step = arrays.unyaw(body.step, body.cosine, body.sine)
    return {
        "yaw_velocity": body.hold_last(turned).reshape(*body.shape, 1),
        "root_velocity": step[[0, 2]].T.reshape(*body.shape, 2),
        "root_height": body.root[1].reshape(*body.shape, 1),
    }


def local_joints(body: Bodies) -> np.ndarray:
    """(3, J, N) joints in the heading frame, root over the origin, heights above the floor."""
    seen = arrays.unyaw(body.joints, body.cosine, body.sine)
    seen[1] += body.root[1]
    return seen


def world_steps(body: Bodies) -> np.ndarray:
    """(3, J, N) how each joint moves to the next frame over the ground, in the heading of its own frame."""
    step = body.after(body.joints) - body.joints + body.step[:, None]
    return body.hold_last(arrays.unyaw(step, body.cosine, body.sine))


def foot_paces(body: Bodies) -> tuple[np.ndarray, np.ndarray]:
    """Heights and ways to the next frame (N, feet * 2), metres, of ankles and toes."""
    feet = [body.skeleton.index(name) for foot in body.skeleton.feet for name in foot]
    joints = body.joints[:, feet]
    step = body.hold_last(body.after(joints) - joints + body.step[:, None])
    return (joints[1] + body.root[1]).T, np.sqrt(arrays.dot(step, step)).T


def detect_contacts(height: np.ndarray, pace: np.ndarray, fps: float, skeleton: Skeleton) -> np.ndarray:
    """(B, T, feet * 2) 0 or 1: `geometry.contacts.detect` for many clips at once.

    Args:
        height: (B, T, feet * 2) of ankles and toes, metres.
        pace: (B, T, feet * 2) their way to the next frame, metres; the last of no meaning.
        fps: frames a second.
        skeleton: says how high they stand at rest.
    """
    names = [skeleton.index(name) for foot in skeleton.feet for name in foot]
    speed = np.zeros_like(pace)
    if pace.shape[1] > 1:
        steps = np.concatenate([pace[:, :1], pace[:, :-1], pace[:, -2:-1]], axis=1) * fps
        speed = (steps[:, :-1] + steps[:, 1:]) / 2
    rest = skeleton.rest_positions[names, 1] - skeleton.rest_positions[:, 1].min() + 0.03
    standing = np.minimum(_percentile(height, 0.05), rest)[:, None]
    return ((height < standing + HEIGHT_MARGIN) & (speed < SPEED_LIMIT)).astype(np.float32)


def _percentile(values: np.ndarray, share: float) -> np.ndarray:
    """Over time, (B, T, F) -> (B, F), linear between neighbours; several times as fast as `np.percentile`."""
    ordered, place = np.sort(values, axis=1), share * (values.shape[1] - 1)
    below = int(place)
    above = min(below + 1, values.shape[1] - 1)
    return ordered[:, below] + (ordered[:, above] - ordered[:, below]) * (place - below)


def travel(
    yaw_velocity: np.ndarray, root_velocity: np.ndarray, start: Start | None
) -> tuple[np.ndarray, np.ndarray, Start]:
    """Headings (..., T) and ground path (..., T, 2) summed up from the root parts, and where the next row starts.

    Args:
        yaw_velocity: (..., T, 1) radians a frame.
        root_velocity: (..., T, 2) x and z, metres a frame, in each frame's heading.
        start: of the first row.
    """
    start = start or Start()
    lead = yaw_velocity.shape[:-2]
    began = np.broadcast_to(np.asarray(start.yaw, np.float64), lead)[..., None]
    turned = np.cumsum(yaw_velocity[..., 0], axis=-1, dtype=np.float64)
    yaw = np.concatenate([began, began + turned], axis=-1)
    cosine, sine = np.cos(yaw[..., :-1]), np.sin(yaw[..., :-1])
    x, z = root_velocity[..., 0], root_velocity[..., 1]
    steps = np.stack([cosine * x + sine * z, cosine * z - sine * x], axis=-1)
    stood = np.broadcast_to(np.asarray(start.ground, np.float64), (*lead, 2))[..., None, :]
    ground = np.concatenate([stood, stood + np.cumsum(steps, axis=-2)], axis=-2)
    return yaw[..., :-1], ground[..., :-1, :], Start(yaw[..., -1], ground[..., -1, :])


class HeadingCodec(Codec):
    """A representation of heading, root height and a pose in the frame of the heading."""

    @abstractmethod
    def write_pose(self, body: Bodies, features: np.ndarray) -> None:
        """Write all parts but root and contacts into features (..., T, size)."""

    @abstractmethod
    def pose_quaternions(self, features: np.ndarray) -> np.ndarray:
        """(4, J, N) parent-relative, the root's relative to the heading, from features (N, size)."""

    @abstractmethod
    def local_positions(self, features: np.ndarray) -> np.ndarray:
        """Joints (..., T, J, 3) in the heading frame above the origin, metres, from features (..., T, size)."""

    def encode_arrays(self, turns: np.ndarray, path: np.ndarray, contacts: np.ndarray | None = None) -> np.ndarray:
        """See `Codec.encode_arrays`."""
        lead, frames = turns.shape[:-3], turns.shape[-3]
        turns, path = turns.reshape(-1, *turns.shape[-3:]), path.reshape(-1, frames, 3)
        features = np.empty((len(turns), frames, self.layout.size), np.float32)
        feet = np.empty((2, len(turns), frames, 2 * len(self.skeleton.feet)), np.float32)
        for clips, rows, kept in _blocks(len(turns), frames):
            body = bodies(turns[clips, rows], path[clips, rows], self.skeleton)
            # a whole clip is written where it belongs; a stretch that shares its last row with the next, beside
            whole = rows == slice(0, frames)
            block = features[clips] if whole else np.empty((*body.shape, self.layout.size), np.float32)
            for name, part in root_parts(body).items():
                self.layout.read(block, name)[...] = part
            self.write_pose(body, block)
            if not whole:
                features[clips, rows][:, kept] = block[:, kept]
            if contacts is None:
                for held, values in zip(feet, foot_paces(body), strict=True):
                    held[clips, rows][:, kept] = values.reshape(*body.shape, -1)[:, kept]
        found = detect_contacts(feet[0], feet[1], self.fps, self.skeleton) if contacts is None else contacts
        self.layout.read(features, "contacts")[...] = np.reshape(found, (len(turns), frames, -1))
        return features.reshape(*lead, frames, -1)

    def decode_arrays(
        self, features: np.ndarray, *, source: Source, start: Start | None = None
    ) -> tuple[np.ndarray, np.ndarray, Start]:
        """See `Codec.decode_arrays`, and the codec's module for which source to choose."""
        self.check_source(source)
        yaw, ground, after = self._travel(features, start)
        if source == "positions":
            return *through_inverse(self._placed(features, yaw, ground), self.skeleton), after
        rows = features.reshape(-1, self.layout.size)
        turns = np.empty((len(rows), len(self.skeleton), 4))
        headings = rotations.yaw_quaternion(yaw.ravel()).T
        for first in range(0, len(rows), BLOCK):
            block = slice(first, first + BLOCK)
            pose = self.pose_quaternions(rows[block])
            pose[:, 0] = arrays.multiply(headings[:, block], pose[:, 0])
            turns[block] = pose.transpose(2, 1, 0)
        height = features[..., self.layout["root_height"]]
        path = np.concatenate([ground[..., :1], height, ground[..., 1:]], axis=-1)
        return continuous(turns.reshape(*yaw.shape, -1, 4)), path - self.skeleton.offsets[0], after

    def positions(self, features: np.ndarray, start: Start | None = None) -> np.ndarray:
        """Joint positions (..., T, J, 3) float32 of features (..., T, size), metres, from their position part."""
        yaw, ground, _ = self._travel(features, start)
        return self._placed(features, yaw, ground)

    def _travel(self, features: np.ndarray, start: Start | None) -> tuple[np.ndarray, np.ndarray, Start]:
        read = self.layout.read
        return travel(read(features, "yaw_velocity"), read(features, "root_velocity"), start)

    def _placed(self, features: np.ndarray, yaw: np.ndarray, ground: np.ndarray) -> np.ndarray:
        local = self.local_positions(features)
        cosine, sine = (value.astype(np.float32)[..., None] for value in (np.cos(yaw), np.sin(yaw)))
        places = np.empty(local.shape, np.float32)
        places[..., 0] = cosine * local[..., 0] + sine * local[..., 2] + ground[..., :1].astype(np.float32)
        places[..., 1] = local[..., 1]
        places[..., 2] = cosine * local[..., 2] - sine * local[..., 0] + ground[..., 1:].astype(np.float32)
        return places


def _blocks(clips: int, frames: int) -> Iterator[tuple[slice, slice, slice]]:
    """Stretches of about `BLOCK` frames: which clips, which frames, and which of those frames' rows to keep.

    Long clips are cut into stretches that share a frame, so that each way to the next frame is in one of them.
    """
    together = max(1, BLOCK // frames)
    stretches, first = [(slice(0, frames), slice(None))], 0
    if frames > 2 * BLOCK:
        stretches = []
        while first < frames - 1:
            last = min(first + BLOCK + 1, frames)
            stretches.append((slice(first, last), slice(None) if last == frames else slice(None, -1)))
            first = last - 1
    for clip in range(0, clips, together):
        for rows, kept in stretches:
            yield slice(clip, clip + together), rows, kept
