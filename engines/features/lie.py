"""Action2Motion's representation: rotations as so(3) vectors, and how the root travels (thesis, section 3.2.1).

The thesis has one vector a bone, in the frame of the first root, and the root's translation. Ours is what the engine
is trained on (`action2motion.representation`): one vector a joint, root height, and the step and turn from the frame
before, in the heading of the root's rotation. Vectors have angles in [0, pi]; a joint that turns past pi jumps to the
other side, which no part of a body does but the root, whose yaw is taken out. `action2motion.official_lie` has the
release's maths.

Decoding has one source, "rotations": there are no positions among the features.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from engines.features import heading
from engines.features.codec import Codec, Source, Start, continuous, joints_of
from engines.features.layout import EMPHASIS, Layout, Part
from engines.geometry import rotations
from engines.motion import Motion
from engines.skeletons import SMPL22, Skeleton

_FOLDED = 0.3
"""A body whose z axis has less than this of its length along the ground is bent double: -y tells where it faces."""


@dataclass(frozen=True, eq=False)
class Lie(Codec):
    """so(3) features of any skeleton with two feet."""

    name: str = "lie"
    skeleton: Skeleton = SMPL22
    fps: float = 20.0
    sources: tuple[Source, ...] = ("rotations",)

    @cached_property
    def layout(self) -> Layout:  # type: ignore[override]
        """3 of root velocity (yaw with it), 1 of height, 3 a joint, and contacts: 74 for 22 joints."""
        return Layout(
            (
                Part("root_velocity", (2,), EMPHASIS),
                Part("yaw_velocity", (1,), EMPHASIS),
                Part("root_height", (1,), EMPHASIS),
                Part("rotations", (len(self.skeleton), 3)),
                Part("contacts", (4,), EMPHASIS),
            )
        )

    def start(self, motion: Motion) -> Start:
        """Where a motion stands at its first frame, its yaw that of the root's rotation."""
        first = self.fitted(motion[:1])
        yaw = root_yaw(first.global_rotations[:, 0])
        return Start(float(yaw[0]), first.positions[0, 0, [0, 2]])

    def encode_arrays(self, turns: np.ndarray, path: np.ndarray, contacts: np.ndarray | None = None) -> np.ndarray:
        """See `Codec.encode_arrays`. A clip's first row has no step and no turn: nothing is before it."""
        turns = np.array(turns, dtype=np.float64)
        place = np.asarray(path, dtype=np.float64) + self.skeleton.offsets[0]
        if contacts is None:
            contacts = self._contacts(turns, path)
        yaw = root_yaw(rotations.quaternion_to_matrix(turns[..., 0, :]))
        back = rotations.yaw_quaternion(-yaw)
        turns[..., 0, :] = rotations.multiply(back, turns[..., 0, :])
        step, turned = np.zeros_like(place), np.zeros_like(yaw)
        step[..., 1:, :] = rotations.rotate(back[..., :-1, :], np.diff(place, axis=-2))
        turned[..., 1:] = np.diff(yaw, axis=-1)
        return self.layout.join(
            root_velocity=step[..., [0, 2]],
            yaw_velocity=turned[..., None],
            root_height=place[..., 1:2],
            rotations=rotations.quaternion_to_rotvec(turns),
            contacts=contacts,
        )

    def _contacts(self, turns: np.ndarray, path: np.ndarray) -> np.ndarray:
        body = heading.bodies(turns, path, self.skeleton)
        frames = turns.shape[-3]
        height, pace = (values.reshape(-1, frames, values.shape[-1]) for values in heading.foot_paces(body))
        return heading.detect_contacts(height, pace, self.fps, self.skeleton).reshape(*turns.shape[:-2], -1)

    def decode_arrays(
        self, features: np.ndarray, *, source: Source, start: Start | None = None
    ) -> tuple[np.ndarray, np.ndarray, Start]:
        """See `Codec.decode_arrays`; to go on with a stream, hand the returned start to the next stretch."""
        self.check_source(source)
        read = self.layout.read
        # a row's velocity brings the body to it, where `travel` has it go on from it: the same sums, one row apart
        yaw, ground, after = heading.travel(read(features, "yaw_velocity"), read(features, "root_velocity"), start)
        yaw = np.concatenate([yaw[..., 1:], np.asarray(after.yaw)[..., None]], axis=-1)
        ground = np.concatenate([ground[..., 1:, :], np.asarray(after.ground)[..., None, :]], axis=-2)
        turns = rotations.rotvec_to_quaternion(read(features, "rotations"))
        turns[..., 0, :] = rotations.multiply(rotations.yaw_quaternion(yaw), turns[..., 0, :])
        path = np.concatenate([ground[..., :1], read(features, "root_height"), ground[..., 1:]], axis=-1)
        return continuous(turns), path - self.skeleton.offsets[0], after

    def positions(self, features: np.ndarray, start: Start | None = None) -> np.ndarray:
        """Joint positions (..., T, J, 3) float32, metres, by forward kinematics."""
        turns, path, _ = self.decode_arrays(features, source="rotations", start=start)
        return joints_of(turns, path, self.skeleton)


def root_yaw(matrices: np.ndarray) -> np.ndarray:
    """Yaw (..., T), unwrapped, of root rotations (..., T, 3, 3): of their z axis, or of -y of a body bent double."""
    forward = matrices[..., 2]
    folded = np.hypot(forward[..., 0], forward[..., 2]) < _FOLDED
    ahead = np.where(folded[..., None], -np.sign(forward[..., 1:2]) * matrices[..., 1], forward)
    return np.unwrap(np.arctan2(ahead[..., 0], ahead[..., 2]), axis=-1)


LIE = Lie()
"""74 numbers a frame on the house skeleton, 20 frames a second."""
