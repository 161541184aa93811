"""The so(3) maths of the released Action2Motion, approximations and slips included.

An official checkpoint gives the authors' motions only through these formulas, so they are kept as they are for that
one purpose; everything else uses the right mathematics of `engines.geometry.so3`. What departs from it:

- `exp`: the squared angle is floored at 1e-4, so below 0.01 rad the result is not quite a rotation.
- `log`: not a number at the exact identity, zero at exactly half a turn.
- `between`: not a number where rounding takes the cosine above 1, zero for opposite directions.
- every kinematic chain starts again from the root's rotation: arms do not inherit that of the spine.
- a joint's rotation turns the bone that leads to it; lengths are those of a pose that is handed in.

Source of formulas and tables: `lie/lie_util`, `lie/pose_lie` and `utils/paramUtil` of the release, as described by
their reference numbers. All functions run over all frames at once and take NaN as it comes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import torch
from torch import Tensor

from engines.errors import OutOfRangeError
from engines.geometry import planes
from engines.geometry.kinematics import depth_levels
from engines.geometry.so3 import vee
from engines.skeletons import SMPL22

SQUARED_ANGLE_FLOOR = 1e-4
"""`exp` divides by no squared angle below this."""
ANGLE_FLOOR = 1e-4
"""`log` and `between` divide by no angle or sine below this."""
TRACE_SLACK = 1e-4
"""How far outside [-1, 3] a trace may lie before `log` refuses it."""


def exp(rotvec: Tensor) -> Tensor:
    """Rodrigues' formula with a floored angle: (..., 3) radians -> (..., 3, 3)."""
    return planes.exp(rotvec.movedim(-1, 0), SQUARED_ANGLE_FLOOR).movedim((0, 1), (-2, -1))


def log(matrix: Tensor) -> Tensor:
    """Equation 3.3 with a floored angle: (..., 3, 3) -> (..., 3) radians, NaN at the exact identity.

    Raises:
        OutOfRangeError: a trace more than 1e-4 outside [-1, 3].
    """
    trace = matrix.diagonal(dim1=-2, dim2=-1).sum(-1)
    if ((trace < -1 - TRACE_SLACK) | (trace > 3 + TRACE_SLACK)).any():
        raise OutOfRangeError("trace of a rotation matrix", float(trace.abs().max()), "-1 to 3")
    angle = torch.acos((trace.clamp(-1, 3) - 1) / 2)
    angle = (angle.abs().clamp(min=ANGLE_FLOOR) * angle.sign())[..., None]
    return angle / torch.sin(angle) * vee(matrix)


def between(u: Tensor, v: Tensor) -> Tensor:
    """Rotation vector (..., 3) that turns unit vectors u (..., 3) onto v (..., 3); zero for opposite ones."""
    u, v = torch.broadcast_tensors(u, v)
    cross = torch.linalg.cross(u, v)
    axis = cross / torch.linalg.vector_norm(cross, dim=-1, keepdim=True).clamp(min=ANGLE_FLOOR)
    return axis * torch.acos((u * v).sum(dim=-1, keepdim=True))


@dataclass(frozen=True, eq=False)
class OfficialSkeleton:
    """One of the release's skeletons: axis-aligned unit offsets and five chains, the first joint the root."""

    name: str
    """Name of the data set it belongs to."""
    joints: tuple[str, ...]
    """J joint names, our names for them where the house skeleton has that joint."""
    offsets: tuple[tuple[int, int, int], ...]
    """J directions of the bone that leads to each joint, unit length; the root's is zero."""
    chains: tuple[tuple[int, ...], ...]
    """Runs of joints from the root, or from the joint they branch off."""
    mean_lengths: tuple[float, ...]
    """J bone lengths, means over the motions that come with the release."""
    actions: tuple[str, ...]
    """Action names in the order of the class labels, as the release trained them."""
    y_down: bool = False
    """The data are in camera coordinates: y down, facing -z."""
    metre: float = 1.0
    """Metres in one unit of the data."""

    def __len__(self) -> int:
        return len(self.offsets)

    @cached_property
    def parents(self) -> tuple[int, ...]:
        """The joint each bone starts at; -1 for the root."""
        parents = [-1] * len(self)
        for chain in self.chains:
            for parent, joint in pairwise(chain):
                parents[joint] = parent
        return tuple(parents)

    @cached_property
    def rotation_parents(self) -> tuple[int, ...]:
        """The joint whose rotation each joint's is relative to: the root for the first bone of every chain."""
        starts = {chain[1] for chain in self.chains}
        return tuple(0 if joint in starts else parent for joint, parent in enumerate(self.parents))

    def bones(self, joints: Tensor) -> Tensor:
        """Joint positions (..., J, 3) -> vectors (..., J, 3) from each joint's parent to it, the root's zero."""
        return joints - joints[..., [max(parent, 0) for parent in self.parents], :]

    def bone_lengths(self, joints: Tensor) -> Tensor:
        """Joint positions (..., J, 3) -> lengths (..., J) of the bones that lead to them, the root's zero."""
        return torch.linalg.vector_norm(self.bones(joints), dim=-1)

    def bone_translations(self, lengths: Tensor, scaled: Sequence[int] = (), scale: float = 1.25) -> Tensor:
        """Raw offsets times bone lengths.

        Args:
            lengths: (..., J) of `bone_lengths`.
            scaled: joints whose bone is made longer; one listed twice counts once.
            scale: by how much.

        Returns:
            (..., J, 3).
        """
        factor = torch.ones(len(self), dtype=lengths.dtype, device=lengths.device)
        factor[list(scaled)] = scale
        return (lengths * factor)[..., None] * self._offsets(lengths)

    def inverse_kinematics(self, joints: Tensor) -> Tensor:
        """Joint positions (..., J, 3) -> Lie parameters (..., J, 3), radians, slot 0 zero."""
        bones = self.bones(joints)[..., 1:, :]
        directions = bones / torch.linalg.vector_norm(bones, dim=-1, keepdim=True)
        turned = exp(between(self._offsets(joints)[1:], directions))  # rotation of each bone against the world
        local = torch.eye(3, dtype=joints.dtype, device=joints.device).expand(*joints.shape, 3).clone()
        world = local.clone()
        for level in depth_levels(self.rotation_parents)[1:]:
            above = world[..., [self.rotation_parents[joint] for joint in level], :, :]
            inside = above.mT @ turned[..., [joint - 1 for joint in level], :, :]
            # the release goes on from this product, not from `turned`: near pi the log sees the difference in rounding
            world[..., list(level), :, :], local[..., list(level), :, :] = above @ inside, inside
        return torch.cat([torch.zeros_like(joints[..., :1, :]), log(local[..., 1:, :, :])], dim=-2)

    def forward_kinematics(
        self, lie: Tensor, root: Tensor, translations: Tensor, root_rotation: bool = False
    ) -> Tensor:
        """Joint positions of Lie parameters (thesis eq. 3.4, chain by chain).

        Args:
            lie: (..., J, 3) rotation vectors; slot 0 is ignored unless `root_rotation`.
            root: (..., 3) root position.
            translations: (..., J, 3) of `bone_translations`.
            root_rotation: read slot 0 as the rotation every chain starts from.

        Returns:
            (..., J, 3).
        """
        # all components in front and frames last, so that every operation runs over long rows
        vectors = lie.reshape(-1, *lie.shape[-2:]).permute(2, 1, 0).contiguous()  # (3, J, N)
        offsets = translations.expand_as(lie).reshape(-1, *lie.shape[-2:]).permute(2, 1, 0)
        local = planes.exp(vectors, SQUARED_ANGLE_FLOOR)  # (3, 3, J, N)
        if not root_rotation:
            first = torch.eye(3, dtype=local.dtype, device=local.device)[..., None, None].expand_as(local[:, :, :1])
            local = torch.cat([first, local[:, :, 1:]], dim=2)
        bones = planes.turn(planes.world(local, self.rotation_parents), offsets)
        places = planes.place(bones, self.parents)
        return root[..., None, :] + places.permute(2, 1, 0).reshape(lie.shape)

    def _offsets(self, like: Tensor) -> Tensor:
        return torch.tensor(self.offsets, dtype=like.dtype, device=like.device)

    def house(self, joints: Tensor) -> Tensor:
        """Joint positions (..., J, 3) of the data set -> metres, Y up, facing +Z, left is +X."""
        return joints * joints.new_tensor([1.0, -1.0, -1.0] if self.y_down else [1.0, 1.0, 1.0]) * self.metre


def _directions(text: str) -> tuple[tuple[int, int, int], ...]:
    """Offsets from signed axis names, "." for none."""
    unit = {".": (0, 0, 0), "+x": (1, 0, 0), "-x": (-1, 0, 0), "+y": (0, 1, 0), "-y": (0, -1, 0)}
    unit |= {"+z": (0, 0, 1), "-z": (0, 0, -1)}
    return tuple(unit[word] for word in text.split())


HUMANACT12 = OfficialSkeleton(
    name="humanact12",
    joints=(*SMPL22.joints, "left_hand", "right_hand"),
    offsets=_directions(". +x -x +y -y -y +y -y -y +y +z +z +y +x -x +z -y -y -y -y -y -y -y -y"),
    chains=((0, 1, 4, 7, 10), (0, 2, 5, 8, 11), (0, 3, 6, 9, 12, 15), (9, 13, 16, 18, 20, 22), (9, 14, 17, 19, 21, 23)),
    mean_lengths=(
        0.0, 0.1040, 0.1096, 0.1203, 0.3561, 0.3545, 0.1321, 0.3888, 0.3821, 0.0540, 0.1302, 0.1393,
        0.2128, 0.1342, 0.1398, 0.1016, 0.1233, 0.1160, 0.2427, 0.2498, 0.2410, 0.2509, 0.0760, 0.0813,
    ),
    actions=(
        "warm_up", "walk", "run", "jump", "drink", "lift_dumbbell", "sit", "eat", "turn steering wheel", "phone",
        "boxing", "throw",
    ),
    y_down=True,
)  # fmt: skip
"""HumanAct12: SMPL's 24 joints, so the first 22 are the house skeleton's."""

NTU_VIBE = OfficialSkeleton(
    name="ntu_vibe",
    joints=(
        "pelvis", "neck", "right_shoulder", "right_elbow", "right_wrist", "left_shoulder", "left_elbow", "left_wrist",
        "nose", "right_hip", "right_knee", "right_ankle", "left_hip", "left_knee", "left_ankle", "left_heel",
        "right_heel", "head_top",
    ),
    offsets=_directions(". -y -y -x -z -y -y -z -y +y +y +y +y +y +y +y +y -y"),
    chains=((0, 12, 13, 14, 15), (0, 9, 10, 11, 16), (0, 1, 8, 17), (1, 5, 6, 7), (1, 2, 3, 4)),
    mean_lengths=(
        0.0, 0.5208, 0.2030, 0.2425, 0.2471, 0.1990, 0.2502, 0.2419, 0.2032, 0.1057, 0.3725, 0.3817,
        0.1086, 0.3627, 0.3806, 0.0671, 0.0701, 0.1907,
    ),
    actions=(
        "pickup", "throw", "sitting down", "standing up (from sitting position)", "cheer up", "hand waving",
        "kicking something", "salute", "squat down", "shake fist", "running on the spot",
        "butt kicks (kick backward)", "side kick",
    ),
    y_down=True,
)  # fmt: skip
"""NTU-RGB+D as re-annotated by the authors: 18 of the joints that the pose estimator gives."""

MOCAP = OfficialSkeleton(
    name="mocap",
    joints=(
        "pelvis", "chest", "neck", "head", "left_shoulder", "left_elbow", "left_wrist", "left_hand", "right_shoulder",
        "right_elbow", "right_wrist", "right_hand", "left_hip", "left_knee", "left_ankle", "left_foot", "right_hip",
        "right_knee", "right_ankle", "right_foot",
    ),
    offsets=_directions(". +y +y +y +y +x +y +y +y -x -x -x -y -y -y -y -y -y -y -y"),
    chains=((0, 1, 2, 3), (0, 12, 13, 14, 15), (0, 16, 17, 18, 19), (1, 4, 5, 6, 7), (1, 8, 9, 10, 11)),
    mean_lengths=(
        0.0, 0.2874, 0.1619, 0.0842, 0.1651, 0.2345, 0.1565, 0.1041, 0.1623, 0.2427, 0.1543, 0.0995,
        0.1402, 0.3270, 0.3603, 0.1261, 0.1364, 0.3230, 0.3637, 0.1377,
    ),
    actions=("Walk", "Wash", "Run", "Jump", "Animal Behavior", "Dance", "Step", "Climb"),
    metre=20 * 0.0254 / 0.45,
)  # fmt: skip
"""CMU motion capture, twenty joints; its units (0.45 to the inch) divided by 20."""

SKELETONS = {skeleton.name: skeleton for skeleton in (HUMANACT12, NTU_VIBE, MOCAP)}
"""By name of the data set; their joint counts differ, so a checkpoint tells which one it is for."""
