"""HumanML3D's 263 and KIT-ML's 251 numbers as the released code computes them, slips included.

The authors' checkpoints and their prepared data speak this dialect, so it is kept for them; everything else uses
`humanml3d`. Source of formulas and tables: `motion_representation`, `common/quaternion`, `common/skeleton` and
`paramUtil` of the release, as described by their reference numbers. What departs from right mathematics:

- `yaw_velocity` is HALF the turn to the next frame: the arc sine of the heading quaternion's y.
- That quaternion never has a negative w, so a heading that passes -z turns its sign and the step there is wrong; all
  that follows comes back turned.
- The heading of the features takes left and right hip the wrong way round, so that the hips are subtracted from the
  shoulders; the heading that a clip starts with has them right.
- It is smoothed over time (Gaussian, 20 frames) and, in the first frame, replaced by none at all: a jump to the second.
- `root_velocity` is in the heading of the frame after, `velocities` in that of the frame before.
- `rotations` turn fixed axes onto bones by the shortest way, the chain starting from the heading's inverse, so
  that the first joint of each chain holds the heading twice; they know no twist, and jump where a bone lies
  opposite to its axis.
- `between` of exactly three vectors takes the cross product along the wrong axis.
- Contacts have no height; the floor is the lowest any joint ever comes.
- T frames give T - 1 rows.

What the broken sign costs: of the prepared clips brought through these features and their own inverse, 1 of 2834 of
Bandai-Namco and 19 of 167 of CMU come back more than 10 mm off on average, the worst, 05_06, by 375 mm; ours by
0.0007 mm at most (`scripts/features_round_trip.py`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.ndimage import gaussian_filter1d

from engines.errors import OutOfRangeError
from engines.features import arrays
from engines.features.humanml3d import layout
from engines.features.layout import Layout
from engines.features.official_codec import OfficialCodec
from engines.features.skeletons import KIT21
from engines.geometry import rotations
from engines.skeletons import SMPL22, Skeleton

HEADING_SMOOTHING = 20.0
"""Standard deviation of the Gaussian over headings, frames."""
_UP = np.array([0.0, 1.0, 0.0])[:, None, None]
_AHEAD = np.array([0.0, 0.0, 1.0])[:, None, None]


def between(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Shortest rotation (4, ..., T) wxyz that turns directions (3, ..., T) onto others, float32.

    Not a number for opposite directions; of exactly three frames, the cross product runs along time.
    """
    start, end = np.broadcast_arrays(np.asarray(start, np.float32), np.asarray(end, np.float32))
    if start.shape[-1] == 3:
        axis = np.moveaxis(arrays.cross(np.moveaxis(start, -1, 0), np.moveaxis(end, -1, 0)), 0, -1)
    else:
        axis = arrays.cross(start, end)
    w = np.sqrt(arrays.dot(start, start) * arrays.dot(end, end)) + arrays.dot(start, end)
    quaternion = np.concatenate([w[None], axis])
    with np.errstate(invalid="ignore"):
        return quaternion / np.sqrt((quaternion * quaternion).sum(axis=0))


def rotate(quaternion: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Vectors (3, ...) turned by unit quaternions (4, ...) wxyz, shapes broadcast."""
    axis = quaternion[1:]
    twice = 2 * arrays.cross(axis, vectors)
    return vectors + quaternion[0] * twice + arrays.cross(axis, twice)


@dataclass(frozen=True, eq=False)
class OfficialHumanML3D(OfficialCodec):
    """The released features of one data set's skeleton."""

    name: str
    skeleton: Skeleton
    fps: float
    axes: str
    """Direction of each joint's raw offset, in the joints' order: "+x", "-y", ..., "." for the root."""
    arm_parents: Mapping[str, str] = field(default_factory=dict)
    """First joints of the chains that start at a joint other than the root, and that joint."""
    feet: tuple[str, ...] = ("left_ankle", "left_foot", "right_ankle", "right_foot")
    """The joints whose contacts are kept."""
    contact_limit: float = 0.002
    """A foot joint whose squared way to the next frame is below this is in contact."""
    lengths: tuple[float, ...] | None = None
    """Bone lengths that all clips are brought to, metres; None leaves them as they are."""
    unit: float = 1.0
    """Metres in one unit of the features."""

    @cached_property
    def layout(self) -> Layout:  # type: ignore[override]
        """As ours."""
        return layout(len(self.skeleton))

    @cached_property
    def raw_offsets(self) -> np.ndarray:
        """(J, 3) unit vectors along the axes."""
        signs = {"+": 1.0, "-": -1.0}
        offsets = np.zeros((len(self.skeleton), 3), np.float32)
        for joint, word in enumerate(self.axes.split()):
            if word != ".":
                offsets[joint, "xyz".index(word[1])] = signs[word[0]]
        return offsets

    @cached_property
    def rotation_parents(self) -> tuple[int, ...]:
        """The joint whose rotation each joint's is relative to: the root for the first of every chain."""
        return tuple(
            0 if name in self.arm_parents else parent
            for name, parent in zip(self.skeleton.joints, self.skeleton.parents, strict=True)
        )

    def _joint(self, *names: str) -> list[int]:
        return [self.skeleton.index(name) for name in names]

    # ---- joints -> features -----------------------------------------------------------------------------------

    def features_of(self, joints: np.ndarray) -> np.ndarray:
        """Joints (..., T, J, 3), any place and heading -> features (..., T - 1, size) float32, units as they come.

        Raises:
            OutOfRangeError: fewer than two frames.
        """
        if joints.shape[-3] < 2:
            raise OutOfRangeError("number of frames", joints.shape[-3], "2 or more")
        places = self._clips(self.canonical(joints))  # (3, J, B, T)
        heading = self.headings(places)[:, None]
        now, step = heading[..., :-1], np.diff(places, axis=-1)
        turned = arrays.multiply(heading[..., 1:], arrays.invert(now))[2]
        ways = rotate(heading[..., 1:], step[:, :1])[[0, 2]]
        local = rotate(now, self._above_origin(places)[..., :-1])
        matrices = arrays.quaternion_to_matrix(self.rotations(places, heading)[:, 1:, :, :-1])
        planes = {
            "yaw_velocity": np.arcsin(turned)[None],
            "root_velocity": ways,
            "root_height": places[1:2, :1, :, :-1],
            "positions": local[:, 1:],
            "rotations": arrays.slopes(matrices),
            "velocities": rotate(now, step),
            "contacts": self._contacts(step)[None],
        }
        lead, frames = joints.shape[:-3], joints.shape[-3] - 1
        features = np.empty((*lead, frames, self.layout.size), np.float32)
        for name, values in planes.items():
            part = features.reshape(-1, frames, self.layout.size)[..., self.layout[name]]
            part[...] = values.transpose(2, 3, 1, 0).reshape(part.shape)
        return features

    @staticmethod
    def _clips(joints: np.ndarray) -> np.ndarray:
        """(..., T, J, 3) -> (3, J, B, T) float32."""
        return np.ascontiguousarray(joints.reshape(-1, *joints.shape[-3:]).transpose(3, 2, 0, 1), dtype=np.float32)

    @staticmethod
    def _above_origin(places: np.ndarray) -> np.ndarray:
        local = np.array(places)
        local[[0, 2]] -= places[[0, 2], :1]
        return local

    def _contacts(self, step: np.ndarray) -> np.ndarray:
        feet = step[:, self._joint(*self.feet)]
        return (arrays.dot(feet, feet) < self.contact_limit).astype(np.float32)

    def canonical(self, joints: np.ndarray) -> np.ndarray:
        """(..., T, J, 3) float32: lowest joint of all frames on the floor, first frame above the origin, facing +Z."""
        places = np.array(joints, dtype=np.float32).reshape(-1, *joints.shape[-3:])
        places[..., 1] -= places[..., 1].min(axis=(-1, -2), keepdims=True)
        places[..., [0, 2]] -= places[:, :1, :1, [0, 2]]
        right, left, right_arm, left_arm = self._joint("right_hip", "left_hip", "right_shoulder", "left_shoulder")
        first = places[:, 0].transpose(2, 1, 0)  # (3, J, B)
        across = arrays.unit(first[:, right] - first[:, left] + first[:, right_arm] - first[:, left_arm])
        ahead = arrays.unit(arrays.cross(_UP[..., 0].astype(np.float32), across))
        turn = between(ahead[..., None], _AHEAD)  # (4, B, 1): one vector a clip, whatever the number of clips
        return rotate(turn[..., None], places.transpose(3, 0, 1, 2)).transpose(1, 2, 3, 0).reshape(joints.shape)

    def headings(self, places: np.ndarray, smoothing: float = HEADING_SMOOTHING) -> np.ndarray:
        """Quaternions (4, B, T) that turn joints (3, J, B, T) to face +Z, the hips the wrong way round; none at first.

        Args:
            places: joints.
            smoothing: frames; 0 for none.
        """
        # what the release calls left hip is the right one: the difference of the hips has the wrong sign
        left, right, right_arm, left_arm = self._joint("right_hip", "left_hip", "right_shoulder", "left_shoulder")
        across = arrays.unit(places[:, right] - places[:, left] + places[:, right_arm] - places[:, left_arm])
        ahead = arrays.cross(_UP.astype(np.float32), across)
        if smoothing:
            ahead = gaussian_filter1d(ahead, smoothing, axis=-1, mode="nearest")
        heading = between(arrays.unit(ahead), _AHEAD)
        heading[..., 0] = rotations.IDENTITY[:, None]
        return heading

    def rotations(self, places: np.ndarray, heading: np.ndarray) -> np.ndarray:
        """(4, J, B, T) rotations of joints (3, J, B, T), along each chain from the heading (4, 1, B, T) on."""
        turns = np.empty((4, *places.shape[1:]), np.float32)
        turns[:, :1] = heading
        turns[:, 1:] = self._bones(places)
        above = list(self.rotation_parents[1:])
        turns[:, 1:] = arrays.multiply(arrays.invert(turns[:, above]), turns[:, 1:])
        return turns

    def _bones(self, places: np.ndarray) -> np.ndarray:
        """(4, J - 1, B, T) rotations of each raw offset onto its bone."""
        bones = places[:, 1:] - places[:, list(self.skeleton.parents[1:])]
        return between(self.raw_offsets[1:].T[:, :, None, None], arrays.unit(bones))

    def uniform(self, joints: np.ndarray, offsets: np.ndarray) -> np.ndarray:
        """Joints (..., T, J, 3) with the bones' lengths and the root's path those of another body.

        Args:
            joints: any place and heading.
            offsets: (J, 3) that body's offsets along the raw axes.
        """
        places = self._clips(joints)
        bones = rotate(self._bones(places), np.asarray(offsets, np.float32)[1:].T[:, :, None, None])
        legs = [self.skeleton.index(name) for name in self.legs]
        first = joints[..., 0, :, :]
        parents = [self.skeleton.parents[leg] for leg in legs]
        mine = np.linalg.norm(first[..., legs, :] - first[..., parents, :], axis=-1).sum(axis=-1).reshape(-1, 1)
        made = np.empty_like(places)
        made[:, 0] = places[:, 0] * (np.abs(offsets[legs]).max(axis=-1).sum() / mine)
        for joint, parent in enumerate(self.skeleton.parents[1:], start=1):
            made[:, joint] = made[:, parent] + bones[:, joint - 1]
        return made.transpose(2, 3, 1, 0).reshape(joints.shape)

    @property
    def legs(self) -> tuple[str, str]:
        """The joints whose bones say how long legs are: of the right leg, or in KIT's order of the left."""
        return ("left_knee", "left_ankle") if self.skeleton == KIT21 else ("right_knee", "right_ankle")

    # ---- features -> joints -----------------------------------------------------------------------------------

    def recover_root(self, features: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Heading quaternions (..., T, 4) that face +Z, and root positions (..., T, 3), of features (..., T, size)."""
        half = np.zeros(features.shape[:-1])
        half[..., 1:] = np.cumsum(features[..., :-1, self.layout["yaw_velocity"]][..., 0], axis=-1, dtype=np.float64)
        cosine, sine, zero = np.cos(half), np.sin(half), np.zeros_like(half)
        quaternion = np.stack([cosine, zero, sine, zero], axis=-1)
        x, z = np.moveaxis(features[..., :-1, self.layout["root_velocity"]].astype(np.float64), -1, 0)
        full, across = (cosine**2 - sine**2)[..., 1:], (2 * cosine * sine)[..., 1:]
        place = np.zeros((*half.shape, 3))
        # the step is in the heading of the frame it leads to, and the quaternion is the way back from that
        place[..., 1:, 0] = np.cumsum(full * x - across * z, axis=-1)
        place[..., 1:, 2] = np.cumsum(across * x + full * z, axis=-1)
        place[..., 1] = features[..., self.layout["root_height"]][..., 0]
        return quaternion, place

    def recover_positions(self, features: np.ndarray) -> np.ndarray:
        """Joints (..., T, J, 3) from the position part."""
        quaternion, root = self.recover_root(features)
        local = self.layout.read(features, "positions").astype(np.float64)
        cosine, sine = quaternion[..., :1], quaternion[..., 2:3]
        full, across = cosine**2 - sine**2, 2 * cosine * sine
        joints = np.empty((*local.shape[:-2], len(self.skeleton), 3), np.float32)
        joints[..., 0, :] = root
        joints[..., 1:, 0] = full * local[..., 0] - across * local[..., 2] + root[..., :1]
        joints[..., 1:, 1] = local[..., 1]
        joints[..., 1:, 2] = across * local[..., 0] + full * local[..., 2] + root[..., 2:]
        return joints

    def recover_rotations(self, features: np.ndarray, offsets: np.ndarray | None = None) -> np.ndarray:
        """Joints (..., T, J, 3) from the 6-D part and a body's offsets (J, 3) along the raw axes.

        Without offsets, the bones are those of the data set, or where these are not known, of the position part's mean.
        """
        offsets = self._offsets_of(features) if offsets is None else np.asarray(offsets)
        quaternion, root = self.recover_root(features)
        stored = arrays.planes(self.layout.read(features, "rotations"))
        local = np.empty((3, 3, len(self.skeleton), stored.shape[-1]), np.float32)
        local[:, :, 0] = arrays.quaternion_to_matrix(quaternion.reshape(-1, 4).T)
        local[:, :, 1:] = np.stack(arrays.rot6d_to_columns(stored), axis=1)
        world = arrays.world(local, self.rotation_parents)
        bones = np.einsum("ijkn,kj->ikn", world, offsets.astype(np.float32))
        made = np.zeros_like(bones)
        made[:, 0] = root.reshape(-1, 3).T
        for joint, parent in enumerate(self.skeleton.parents[1:], start=1):
            made[:, joint] = made[:, parent] + bones[:, joint]
        return arrays.unplanes(made, features.shape[:-1])

    def _offsets_of(self, features: np.ndarray) -> np.ndarray:
        if self.lengths is not None:
            return self.offsets
        joints = self.recover_positions(features).reshape(-1, len(self.skeleton), 3)
        bones = joints - joints[:, [max(parent, 0) for parent in self.skeleton.parents]]
        return self.raw_offsets * np.linalg.norm(bones, axis=-1).mean(axis=0)[:, None]

    @property
    def offsets(self) -> np.ndarray:
        """(J, 3) raw offsets times the data set's bone lengths.

        Raises:
            OutOfRangeError: those are not known.
        """
        if self.lengths is None:
            raise OutOfRangeError(f"bone lengths of {self.name!r}", None, "a data set whose bone lengths are known")
        return self.raw_offsets * np.array(self.lengths, np.float32)[:, None]

    def recover(self, features: np.ndarray, source: str) -> np.ndarray:
        """See `OfficialCodec.recover`."""
        return self.recover_positions(features) if source == "positions" else self.recover_rotations(features)

    def fitted_joints(self, joints: np.ndarray) -> np.ndarray:
        """See `OfficialCodec.fitted_joints`: with the data set's bone lengths, where those are known."""
        return joints if self.lengths is None else self.uniform(joints, self.offsets)


HUMANML3D = OfficialHumanML3D(
    "humanml3d-official",
    SMPL22,
    20.0,
    axes=". +x -x +y -y -y +y -y -y +y +z +z +y +x -x +z -y -y -y -y -y -y",
    arm_parents={"left_collar": "spine3", "right_collar": "spine3"},
    lengths=(
        0.0, 0.1031, 0.1099, 0.1316, 0.3936, 0.3902, 0.1432, 0.4324, 0.4256, 0.0574, 0.1434, 0.1494,
        0.2194, 0.1375, 0.1434, 0.1030, 0.1316, 0.1230, 0.2568, 0.2631, 0.2660, 0.2699,
    ),
)  # fmt: skip
"""HumanML3D: the house skeleton's joints; bone lengths are those of its clips."""

KIT = OfficialHumanML3D(
    "kit-official",
    KIT21,
    12.5,
    axes=". +y +y +y +y +x -y -y -x -y -y +x -y -y +z +z -x -y -y +z +z",
    arm_parents={"right_shoulder": "neck", "left_shoulder": "neck"},
    feet=("left_foot", "left_toe_end", "right_foot", "right_toe_end"),
    contact_limit=0.05,
)
"""KIT-ML, where the foot in contact is the toe joint and the toe's tip.

Its own bone lengths and units are not known here; the contact limit is in the data set's units.
"""
