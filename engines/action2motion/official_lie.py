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

import torch
from torch import Tensor

from engines.errors import OutOfRangeError
from engines.geometry.kinematics import global_rotations
from engines.geometry.so3 import hat, vee

SQUARED_ANGLE_FLOOR = 1e-4
"""`exp` divides by no squared angle below this."""
ANGLE_FLOOR = 1e-4
"""`log` and `between` divide by no angle or sine below this."""
TRACE_SLACK = 1e-4
"""How far outside [-1, 3] a trace may lie before `log` refuses it."""


def exp(rotvec: Tensor) -> Tensor:
    """Rodrigues' formula with a floored angle: (..., 3) radians -> (..., 3, 3)."""
    squared = rotvec.square().sum(dim=-1, keepdim=True).clamp(min=SQUARED_ANGLE_FLOOR)[..., None]
    angle = squared.sqrt()
    skew = hat(rotvec)
    eye = torch.eye(3, dtype=rotvec.dtype, device=rotvec.device)
    return eye + torch.sin(angle) / angle * skew + (1 - torch.cos(angle)) / squared * (skew @ skew)


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
    offsets: tuple[tuple[int, int, int], ...]
    """J directions of the bone that leads to each joint, unit length; the root's is zero."""
    chains: tuple[tuple[int, ...], ...]
    """Runs of joints from the root, or from the joint they branch off."""

    def __len__(self) -> int:
        return len(self.offsets)

    @cached_property
    def parents(self) -> tuple[int, ...]:
        """The joint each bone starts at; -1 for the root."""
        parents = [-1] * len(self)
        for chain in self.chains:
            for parent, joint in zip(chain[:-1], chain[1:], strict=True):
                parents[joint] = parent
        return tuple(parents)

    @cached_property
    def rotation_parents(self) -> tuple[int, ...]:
        """The joint whose rotation each joint's is relative to: the root for the first bone of every chain."""
        starts = {chain[1] for chain in self.chains}
        return tuple(0 if joint in starts else parent for joint, parent in enumerate(self.parents))

    @cached_property
    def _paths(self) -> Tensor:
        """(J, J) ones where the second joint's bone lies between the root and the first joint."""
        paths = torch.zeros(len(self), len(self), dtype=torch.float64)
        for joint in range(1, len(self)):
            paths[joint] = paths[self.parents[joint]]
            paths[joint, joint] = 1.0
        return paths

    def bones(self, joints: Tensor) -> Tensor:
        """Joint positions (..., J, 3) -> vectors (..., J, 3) from each joint's parent to it, the root's zero."""
        return joints - joints[..., [max(parent, 0) for parent in self.parents], :]

    def bone_lengths(self, joints: Tensor) -> Tensor:
        """Joint positions (..., J, 3) -> lengths (..., J) of the bones that lead to them, the root's zero."""
        return torch.linalg.vector_norm(self.bones(joints), dim=-1)

    def bone_translations(self, joints: Tensor, scaled: Sequence[int] = (), scale: float = 1.25) -> Tensor:
        """Raw offsets times the bone lengths of a pose.

        Args:
            joints: (..., J, 3) the pose that supplies the lengths.
            scaled: joints whose bone is made longer; one listed twice counts once.
            scale: by how much.

        Returns:
            (..., J, 3).
        """
        factor = torch.ones(len(self), dtype=joints.dtype, device=joints.device)
        factor[list(scaled)] = scale
        return self.bone_lengths(joints)[..., None] * (self._offsets(joints) * factor[:, None])

    def inverse_kinematics(self, joints: Tensor) -> Tensor:
        """Joint positions (..., J, 3) -> Lie parameters (..., J, 3), radians, slot 0 zero."""
        bones = self.bones(joints)[..., 1:, :]
        directions = bones / torch.linalg.vector_norm(bones, dim=-1, keepdim=True)
        turned = exp(between(self._offsets(joints)[1:], directions))  # rotation of each bone against the world
        eye = torch.eye(3, dtype=joints.dtype, device=joints.device).expand(*joints.shape[:-2], 1, 3, 3)
        world = torch.cat([eye, turned], dim=-3)
        above = world[..., list(self.rotation_parents[1:]), :, :]
        return torch.cat([torch.zeros_like(joints[..., :1, :]), log(above.mT @ turned)], dim=-2)

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
        matrices = exp(lie)
        if not root_rotation:
            eye = torch.eye(3, dtype=lie.dtype, device=lie.device)
            matrices = torch.cat([eye.expand_as(matrices[..., :1, :, :]), matrices[..., 1:, :, :]], dim=-3)
        world = global_rotations(matrices, self.rotation_parents)
        bones = (world @ translations[..., None])[..., 0]
        return root[..., None, :] + self._paths.to(bones) @ bones

    def _offsets(self, like: Tensor) -> Tensor:
        return torch.tensor(self.offsets, dtype=like.dtype, device=like.device)
