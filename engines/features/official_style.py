"""The 260 numbers of latent stylization as the released code computes them, in the units of CMU's files.

Kept for the authors' checkpoints; everything else uses `style`. Source: the data processing of the release, as
described by its reference numbers. What departs from ours:

- made of CMU's 31 joints, of which 21 are kept: rotations are those of the whole tree, positions those of a tree of the
  21 alone, and the heading and the floor are again those of the 31;
- the heading is across hips and shoulders, smoothed over time (Gaussian, 10 frames), and its quaternion's sign breaks
  at -z; `yaw_velocity` is twice the arc sine of that quaternion's step, so the full angle otherwise;
- `root_velocity` is written in the heading of its own frame and read back in that of the next: a body that turns while
  it walks comes back on another path;
- the floor is the lowest any joint comes; contacts are told by squared way and height in the files' units;
- T frames give T - 1 rows.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.ndimage import gaussian_filter1d

from engines.errors import OutOfRangeError
from engines.features import arrays
from engines.features.codec import through_inverse
from engines.features.layout import Layout
from engines.features.official_codec import OfficialCodec
from engines.features.official_humanml3d import between, rotate
from engines.features.skeletons import STYLE21
from engines.features.style import layout
from engines.geometry import kinematics, rotations
from engines.skeletons import Skeleton

HEADING_SMOOTHING = 10.0
"""Standard deviation of the Gaussian over headings, frames."""
CMU_UNIT = 0.0254 / 0.45
"""Metres in one unit of CMU's files."""
CONTACT_LIMIT = 0.05
"""Squared way to the next frame, at 60 or 30 fps as the file comes, below which a foot is in contact."""
CONTACT_LIMIT_HALVED = 0.1
"""The same where every second frame was taken."""
_HEIGHTS = (3.0, 2.0, 3.0, 2.0)
"""How high left ankle, left toe, right ankle and right toe may be in contact."""
_ACROSS = ("right_hip", "left_hip", "right_shoulder", "left_shoulder")
_FEET = ("left_ankle", "left_foot", "right_ankle", "right_foot")


@dataclass(frozen=True, eq=False)
class OfficialStyle(OfficialCodec):
    """The released features on the 21 joints."""

    name: str = "style-official"
    skeleton: Skeleton = STYLE21
    fps: float = 30.0
    unit: float = CMU_UNIT

    @cached_property
    def layout(self) -> Layout:  # type: ignore[override]
        """As ours."""
        return layout(len(self.skeleton))

    def features_of_tree(
        self,
        tree: Skeleton,
        turns: np.ndarray,
        root: np.ndarray,
        kept: list[int],
        contact_limit: float = CONTACT_LIMIT,
    ) -> np.ndarray:
        """Features (T - 1, 260) of a file's own skeleton, of whose J joints 21 are kept.

        Args:
            tree: all joints, in the files' units; its root's offset is not used.
            turns: (T, J, 4) quaternions wxyz, parent-relative, already at the rate wanted.
            root: (T, 3) root path.
            kept: the 21 joints' indices, in the order of `STYLE21`.
            contact_limit: see `CONTACT_LIMIT`.
        """
        path = root - tree.offsets[0]
        local = rotations.quaternion_to_matrix(turns)
        whole, world = kinematics.forward_kinematics(local, path, tree.offsets, tree.parents)
        joints = self._positions(world[:, kept], root, tree.offsets[kept])
        joints[..., 1] -= whole[..., 1].min()
        return self._features(joints, world[:, kept], whole[:, kept], contact_limit)

    def _positions(self, world: np.ndarray, root: np.ndarray, offsets: np.ndarray) -> np.ndarray:
        """Joints (..., T, 21, 3) from world rotations (..., T, 21, 3, 3), root and the 21 joints' offsets (21, 3)."""
        joints = np.empty(world.shape[:-1])
        joints[..., 0, :] = root
        for joint, parent in enumerate(self.skeleton.parents[1:], start=1):
            joints[..., joint, :] = joints[..., parent, :] + world[..., parent, :, :] @ offsets[joint]
        return joints

    def _features(self, joints: np.ndarray, world: np.ndarray, faced: np.ndarray, contact_limit: float) -> np.ndarray:
        """Features (..., T - 1, 260) of one or more clips.

        Args:
            joints: (..., T, 21, 3) on the floor.
            world: (..., T, 21, 3, 3).
            faced: (..., T, 21, 3) the joints that tell the heading.
            contact_limit: see `CONTACT_LIMIT`.
        """
        if joints.shape[-3] < 2:
            raise OutOfRangeError("number of frames", joints.shape[-3], "2 or more")
        heading = self.headings(faced)  # (4, ..., T)
        now = heading[..., :-1]
        places = np.moveaxis(joints, -1, 0)
        step = np.diff(places, axis=-2)
        ways = rotate(now, step[..., 0])
        above = places - places[..., :1] * np.array([1.0, 0.0, 1.0]).reshape(3, *([1] * (places.ndim - 1)))
        local = rotate(heading[..., None], above)
        columns = [rotate(now[..., None], np.moveaxis(world[..., :-1, :, :, column], -1, 0)) for column in (0, 1)]
        feet = [self.skeleton.index(name) for name in _FEET]
        low = places[1, ..., :-1, :][..., feet] < np.array(_HEIGHTS)
        turned = 2 * np.arcsin(arrays.multiply(heading[..., 1:], arrays.invert(now))[2])
        return self.layout.join(
            yaw_velocity=turned[..., None],
            root_velocity=np.moveaxis(ways[[0, 2]], 0, -1),
            root_height=places[1, ..., :-1, :1],
            positions=np.moveaxis(local[..., :-1, :], 0, -1),
            rotations=np.moveaxis(np.concatenate(columns), 0, -1),
            velocities=np.moveaxis(np.diff(local, axis=-2), 0, -1),
            contacts=low & ((step[..., feet] ** 2).sum(axis=0) < contact_limit),
        )

    def headings(self, joints: np.ndarray) -> np.ndarray:
        """Quaternions (4, ..., T) that turn joints (..., T, 21, 3) to face +Z."""
        right, left, right_arm, left_arm = (joints[..., self.skeleton.index(name), :] for name in _ACROSS)
        across = rotations.normalise(left_arm - right_arm + left - right)
        ahead = np.cross(across, [0.0, 1.0, 0.0])
        ahead = rotations.normalise(gaussian_filter1d(ahead, HEADING_SMOOTHING, axis=-2, mode="nearest"))
        return between(np.moveaxis(ahead, -1, 0), np.array([0.0, 0.0, 1.0]).reshape(3, *([1] * (ahead.ndim - 1))))

    def features_of(self, joints: np.ndarray) -> np.ndarray:
        """Joints (..., T, 21, 3) in the files' units -> features (..., T - 1, 260), rotations found from the joints."""
        turns, _ = through_inverse(joints * self.unit, self.skeleton)
        return self._of_motion(joints, rotations.quaternion_to_matrix(turns))

    def encode_arrays(self, turns: np.ndarray, path: np.ndarray, contacts: np.ndarray | None = None) -> np.ndarray:
        """See `Codec.encode_arrays`, one row fewer; the release finds contacts itself, those given are not used."""
        local = rotations.quaternion_to_matrix(turns)
        joints, _ = kinematics.forward_kinematics(local, path, self.skeleton.offsets, self.skeleton.parents)
        return self._of_motion(joints / self.unit, local)

    def _of_motion(self, joints: np.ndarray, local: np.ndarray) -> np.ndarray:
        joints = np.array(joints, dtype=np.float64)
        joints[..., 1] -= joints[..., 1].min(axis=(-1, -2), keepdims=True)
        world = kinematics.global_rotations(local, self.skeleton.parents)
        return self._features(joints, world, joints, CONTACT_LIMIT)

    # ---- features -> joints -----------------------------------------------------------------------------------

    def recover_root(self, features: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Heading quaternions (..., T, 4) that face +Z, and root positions (..., T, 3), of features (..., T, 260)."""
        yaw = np.zeros(features.shape[:-1])
        yaw[..., 1:] = np.cumsum(features[..., :-1, self.layout["yaw_velocity"]][..., 0], axis=-1, dtype=np.float64)
        way = np.zeros((*yaw.shape, 3))
        way[..., 1:, [0, 2]] = features[..., :-1, self.layout["root_velocity"]]
        quaternion = rotations.yaw_quaternion(yaw)
        place = np.cumsum(rotations.rotate(rotations.invert(quaternion), way), axis=-2)
        place[..., 1] = features[..., self.layout["root_height"]][..., 0]
        return quaternion, place

    def recover_positions(self, features: np.ndarray) -> np.ndarray:
        """Joints (..., T, 21, 3) in the files' units from the position part."""
        quaternion, root = self.recover_root(features)
        local = self.layout.read(features, "positions")
        turned = rotations.rotate(rotations.invert(quaternion)[..., None, :], local)
        return turned + (root * np.array([1.0, 0.0, 1.0]))[..., None, :]

    def recover_turns(self, features: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Quaternions (..., T, 21, 4) of the 6-D part in the world, and relative to their parents."""
        quaternion, _ = self.recover_root(features)
        columns = arrays.rot6d_to_columns(arrays.planes(self.layout.read(features, "rotations")))
        seen = arrays.unplanes(arrays.rotation_to_quaternion(*columns), features.shape[:-1])
        world = rotations.multiply(rotations.invert(quaternion)[..., None, :], seen)
        local = np.array(world)
        above = list(self.skeleton.parents[1:])
        local[..., 1:, :] = rotations.multiply(rotations.invert(world[..., above, :]), world[..., 1:, :])
        return world, local

    def recover_rotations(self, features: np.ndarray, offsets: np.ndarray | None = None) -> np.ndarray:
        """Joints (..., T, 21, 3) from the 6-D part and a body's offsets (21, 3), by default ours in files' units."""
        offsets = self.skeleton.offsets / self.unit if offsets is None else np.asarray(offsets, np.float64)
        world, _ = self.recover_turns(features)
        return self._positions(rotations.quaternion_to_matrix(world), self.recover_root(features)[1], offsets)

    def recover(self, features: np.ndarray, source: str) -> np.ndarray:
        """See `OfficialCodec.recover`."""
        return self.recover_positions(features) if source == "positions" else self.recover_rotations(features)


STYLE = OfficialStyle()
"""260 numbers a frame, 30 frames a second."""
