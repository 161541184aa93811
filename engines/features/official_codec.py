"""What the released representations that are made of joint positions have in common."""

from __future__ import annotations

from abc import abstractmethod

import numpy as np

from engines.features.codec import Codec, Source, Start
from engines.geometry import kinematics, retarget, rotations
from engines.motion import Motion
from engines.skeletons import SMPL22


class OfficialCodec(Codec):
    """A released representation behind the same interface as ours.

    T frames give T - 1 rows, and those T - 1 frames. Decoded motions are on the house skeleton, whose bones are not
    the data set's: poses are fitted to the joints (`retarget.from_points`).
    """

    unit: float
    """Metres in one unit of the features."""

    @abstractmethod
    def features_of(self, joints: np.ndarray) -> np.ndarray:
        """Joints (..., T, J, 3) in the data set's units -> features (..., T - 1, size)."""

    @abstractmethod
    def recover(self, features: np.ndarray, source: str) -> np.ndarray:
        """Features (..., T, size) -> joints (..., T, J, 3) in the data set's units, from one part or the other."""

    def fitted_joints(self, joints: np.ndarray) -> np.ndarray:
        """Joints (..., T, J, 3) as the data set has its bodies."""
        return joints

    def encode_arrays(self, turns: np.ndarray, path: np.ndarray, contacts: np.ndarray | None = None) -> np.ndarray:
        """See `Codec.encode_arrays`, one row fewer; the release finds contacts itself, those given are not used."""
        matrices = rotations.quaternion_to_matrix(turns)
        joints, _ = kinematics.forward_kinematics(matrices, path, self.skeleton.offsets, self.skeleton.parents)
        return self.features_of(self.fitted_joints(joints / self.unit))

    def decode_arrays(
        self, features: np.ndarray, *, source: Source, start: Start | None = None
    ) -> tuple[np.ndarray, np.ndarray, Start]:
        """See `Codec.decode_arrays`: quaternions and path of the house skeleton.

        The start that comes back is where the body stood: the release cannot go on from where it ended.
        """
        joints = self.positions(features, start) if source == "positions" else self._placed(features, source, start)
        clips = [self._pose(clip) for clip in joints.reshape(-1, *joints.shape[-3:])]
        turns, path = (np.stack([getattr(clip, name) for clip in clips]) for name in ("rotations", "translation"))
        lead = features.shape[:-2]
        return turns.reshape(*lead, *turns.shape[1:]), path.reshape(*lead, *path.shape[1:]), start or Start()

    def decode(self, features: np.ndarray, *, source: Source, start: Start | None = None) -> Motion:
        """See `Codec.decode`; the Motion is on the house skeleton."""
        self.check_source(source)
        features = self.layout.check(features)
        turns, path, _ = self.decode_arrays(features, source=source, start=start)
        return Motion(SMPL22, turns, path, self.fps)

    def positions(self, features: np.ndarray, start: Start | None = None) -> np.ndarray:
        """Joint positions (..., T, J, 3) float32 of the data set's body, metres, from the position part."""
        return self._placed(features, "positions", start)

    def _placed(self, features: np.ndarray, source: str, start: Start | None) -> np.ndarray:
        self.check_source(source)
        joints = self.recover(features, source) * self.unit
        start = start or Start()
        turn = rotations.yaw_quaternion(np.asarray(start.yaw))[..., None, None, :]
        placed = rotations.rotate(turn, joints)
        placed[..., [0, 2]] += np.asarray(start.ground)[..., None, None, :]
        return placed.astype(np.float32)

    def _pose(self, joints: np.ndarray) -> Motion:
        points = {name: joints[:, i] for i, name in enumerate(self.skeleton.joints) if name in SMPL22}
        return retarget.from_points(points, self.fps)
