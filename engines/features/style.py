"""The stylization papers' representation: 260 numbers a frame at 30 frames a second (thesis, section 5.3).

Like HumanML3D's, with these differences: 21 joints and the root among them; rotations are those of joints in the frame
of the heading, not relative to their parents; velocities are those of the positions in the frame of the heading, so
that a body turning on the spot has them at rest.

The papers' data sets keep 21 of CMU's 31 joints. Ours keeps 21 of the house skeleton's 22, of one tree with theirs: all
but `spine2`, which decoding puts back where its neighbours say, its twist half way between theirs. `official_style` has
the released code's numbers, made of their joints and in the units of their files.

**Which source to decode from** is as for `humanml3d`: "rotations". Under the same noise it leaves joints 11.9 mm off
and "positions" 15.1 mm, feet 16.0 and 17.0 mm, turns 2.8 and 8.4 degrees.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from engines.features import arrays, heading
from engines.features.heading import HeadingCodec
from engines.features.layout import EMPHASIS, Layout, Part
from engines.geometry.kinematics import depth_levels
from engines.skeletons import SMPL22, Skeleton

LEFT_OUT = "spine2"
"""The joint of the house skeleton that the 21 do not hold."""


def layout(joints: int = 21) -> Layout:
    """The parts of a body of `joints` joints: 260 numbers for 21."""
    return Layout(
        (
            Part("yaw_velocity", (1,), EMPHASIS),
            Part("root_velocity", (2,), EMPHASIS),
            Part("root_height", (1,), EMPHASIS),
            Part("positions", (joints, 3)),
            Part("rotations", (joints, 6)),
            Part("velocities", (joints, 3)),
            Part("contacts", (4,), EMPHASIS),
        )
    )


@dataclass(frozen=True, eq=False)
class Style(HeadingCodec):
    """Features of the house skeleton less one joint."""

    name: str = "style"
    skeleton: Skeleton = SMPL22
    fps: float = 30.0

    @cached_property
    def layout(self) -> Layout:  # type: ignore[override]
        """As `layout()`."""
        return layout(len(self.kept))

    @cached_property
    def kept(self) -> list[int]:
        """Indices of the joints the features hold."""
        return [joint for joint, name in enumerate(self.skeleton.joints) if name != LEFT_OUT]

    def write_pose(self, body: heading.Bodies, features: np.ndarray) -> None:
        """See `HeadingCodec.write_pose`."""
        places = heading.local_joints(body)[:, self.kept]
        columns = [arrays.unyaw(body.world[:, column][:, self.kept], body.cosine, body.sine) for column in (0, 1)]
        planes = {
            "positions": places,
            "rotations": np.concatenate(columns),
            "velocities": body.hold_last(body.after(places) - places),
        }
        for name, values in planes.items():
            part = self.layout.read(features, name)
            part[...] = values.transpose(2, 1, 0).reshape(part.shape)

    def pose_quaternions(self, features: np.ndarray) -> np.ndarray:
        """See `HeadingCodec.pose_quaternions`."""
        stored = arrays.planes(self.layout.read(features, "rotations"))
        world = np.empty((4, len(self.skeleton), len(features)), np.float32)
        world[:, self.kept] = arrays.rotation_to_quaternion(*arrays.rot6d_to_columns(stored))
        missing = self.skeleton.index(LEFT_OUT)
        world[:, missing] = self._missing_rotation(world, self.layout.read(features, "positions"))
        local = np.array(world)
        for level in depth_levels(self.skeleton.parents)[1:]:
            joints = list(level)
            above = world[:, [self.skeleton.parents[joint] for joint in joints]]
            local[:, joints] = arrays.multiply(arrays.invert(above), world[:, joints])
        return local

    def _missing_rotation(self, world: np.ndarray, held: np.ndarray) -> np.ndarray:
        """(4, N) the left out joint's rotation: half way between its neighbours', then onto the bone that is seen.

        Args:
            world: (4, J, N) rotations in the frame of the heading, but for the one left out.
            held: (N, 21, 3) positions.
        """
        joint = self.skeleton.index(LEFT_OUT)
        above, below = self.skeleton.parents[joint], self.skeleton.children[joint][0]
        toward = np.where((world[:, above] * world[:, below]).sum(axis=0) < 0, -1, 1) * world[:, below]
        between = world[:, above] + toward
        between = between / np.maximum(np.linalg.norm(between, axis=0), 1e-12)
        turned = arrays.quaternion_to_matrix(between)
        seen = (held[:, self.kept.index(below)] - held[:, self.kept.index(above)]).T - _bone(
            arrays.quaternion_to_matrix(world[:, above]), self.skeleton.offsets[joint]
        )
        bone = arrays.unit(_bone(turned, self.skeleton.offsets[below]))
        seen = arrays.unit(seen)
        swing = np.concatenate([1 + arrays.dot(bone, seen)[None], arrays.cross(bone, seen)])
        length = np.linalg.norm(swing, axis=0)
        return np.where(length > 1e-3, arrays.multiply(swing / np.maximum(length, 1e-3), between), between)

    def local_positions(self, features: np.ndarray) -> np.ndarray:
        """See `HeadingCodec.local_positions`; the joint left out is where the 6-D part of its parent puts it."""
        held = self.layout.read(features, "positions")
        places = np.empty((*held.shape[:-2], len(self.skeleton), 3), np.float32)
        places[..., self.kept, :] = held
        joint = self.skeleton.index(LEFT_OUT)
        above = self.kept.index(self.skeleton.parents[joint])
        slopes = self.layout.read(features, "rotations")[..., above : above + 1, :]
        columns = np.stack(arrays.rot6d_to_columns(arrays.planes(slopes)), axis=1)[:, :, 0]
        bone = _bone(columns, self.skeleton.offsets[joint]).T.reshape(*held.shape[:-2], 3)
        places[..., joint, :] = held[..., above, :] + bone
        return places


def _bone(matrices: np.ndarray, offset: np.ndarray) -> np.ndarray:
    """One rest offset (3,) turned by matrices (3, 3, N) -> (3, N)."""
    return np.einsum("ijn,j->in", matrices, offset.astype(np.float32))


STYLE = Style()
"""260 numbers a frame, 30 frames a second."""
