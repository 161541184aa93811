"""The parametric body that is fitted: what it has to offer, and its shape and pose as torch sees them."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import Protocol

import numpy as np
import torch
from jaxtyping import Float, Integer
from torch import Tensor

from engines.geometry.kinematics import forward_kinematics
from engines.skeletons.skeleton import Skeleton


class Slider(Protocol):
    """One way in which a template's shape can be changed."""

    @property
    def name(self) -> str: ...  # noqa: D102
    @property
    def low(self) -> float: ...  # noqa: D102
    @property
    def high(self) -> float: ...  # noqa: D102
    @property
    def usual(self) -> float: ...  # noqa: D102


class Template(Protocol):
    """A skinned body with sliders on the house skeleton, in its T-pose: `viewers.bodies.get("anny")`, or SMPL.

    Its shape is piecewise linear in the sliders: each adds one blend below and one above its usual value.
    """

    @property
    def skeleton(self) -> Skeleton:
        """The joints the weights refer to, those of `smpl22`."""
        ...

    @property
    def vertices(self) -> Float[np.ndarray, "V 3"]:
        """(V, 3) rest positions, metres."""
        ...

    @property
    def faces(self) -> Integer[np.ndarray, "F 3"]:
        """(F, 3) vertex indices, counter-clockwise from outside."""
        ...

    @property
    def skin_indices(self) -> Integer[np.ndarray, "V 4"]:
        """(V, 4) joints a vertex hangs on."""
        ...

    @property
    def skin_weights(self) -> Float[np.ndarray, "V 4"]:
        """(V, 4) and by how much; rows sum to one."""
        ...

    @property
    def coarse(self) -> Sequence[Integer[np.ndarray, "_F 3"]]:
        """Fewer faces over the same vertices, the finer first; may be empty."""
        ...

    @property
    def sliders(self) -> Sequence[Slider]:
        """What of its shape can be changed."""
        ...

    def shaped(self, **values: float) -> Template:
        """The template with sliders at `values`."""
        ...

    def skinned(self, matrices: Float[np.ndarray, "J 3 4"]) -> Float[np.ndarray, "V 3"]:
        """(V, 3) vertices under skinning matrices."""
        ...


class Puppet:
    """A template as differentiable functions: sliders to rest shape, rotations to posed vertices.

    Everything is float64 on the CPU: some thousand numbers, for which a step's time is that of calls.

    Args:
        template: the body.
        chosen: (N,) the vertices that are posed; all of them if left out.
    """

    def __init__(self, template: Template, chosen: Integer[np.ndarray, " N"] | None = None) -> None:
        chosen = np.arange(len(template.vertices)) if chosen is None else np.asarray(chosen)
        self.template = template
        self.parents = template.skeleton.parents
        self.names = tuple(slider.name for slider in template.sliders)
        self.low = _tensor([slider.low for slider in template.sliders])
        self.high = _tensor([slider.high for slider in template.sliders])
        usual = {slider.name: slider.usual for slider in template.sliders}
        self.usual = _tensor(list(usual.values()))
        base = template.shaped(**usual)
        self.vertices, self.offsets = _tensor(base.vertices[chosen]), _tensor(base.skeleton.offsets)
        ends = [base.shaped(**{s.name: end}) for s in template.sliders for end in (s.low, s.high)]
        self._vertex_moves = _stacked([_tensor(end.vertices[chosen]) - self.vertices for end in ends], self.vertices)
        self._offset_moves = _stacked([_tensor(end.skeleton.offsets) - self.offsets for end in ends], self.offsets)
        self.skin = torch.zeros(len(chosen), len(template.skeleton), dtype=torch.float64)
        index = torch.from_numpy(template.skin_indices[chosen].astype(np.int64))
        self.skin.scatter_add_(1, index, _tensor(template.skin_weights[chosen]))

    def rest(self, values: Float[Tensor, " S"]) -> tuple[Float[Tensor, "N 3"], Float[Tensor, "J 3"]]:
        """Rest vertices (N, 3) and joint offsets (J, 3), metres, with the sliders at `values` (S,)."""
        below = ((values - self.usual) / _span(self.low - self.usual)).clamp(min=0)
        above = ((values - self.usual) / _span(self.high - self.usual)).clamp(min=0)
        shares = torch.stack([below, above], dim=1).flatten()  # low and high of one slider after the other
        vertices = self.vertices + torch.einsum("s,snc->nc", shares, self._vertex_moves)
        return vertices, self.offsets + torch.einsum("s,sjc->jc", shares, self._offset_moves)

    def posed(
        self, values: Float[Tensor, " S"], pose: Float[Tensor, "J 3 3"], root: Float[Tensor, " 3"]
    ) -> tuple[Float[Tensor, "N 3"], Float[Tensor, "J 3"], Float[Tensor, "J 3 3"]]:
        """Linear blend skinning.

        Args:
            values: (S,) sliders.
            pose: (J, 3, 3) rotations against the parent.
            root: (3,) place of the root, metres.

        Returns:
            Vertices (N, 3), joints (J, 3), metres, and the joints' rotations against the world (J, 3, 3).
        """
        rest, offsets = self.rest(values)
        places = rest_places(offsets, self.parents)
        joints, turns = forward_kinematics(pose, root, offsets, self.parents)
        moves = joints - torch.einsum("jab,jb->ja", turns, places)
        blended = (self.skin @ torch.cat([turns.flatten(1), moves], dim=1)).split([9, 3], dim=1)
        return torch.einsum("nab,nb->na", blended[0].unflatten(1, (3, 3)), rest) + blended[1], joints, turns

    def only(self, rows: Integer[Tensor, " M"]) -> Puppet:
        """The puppet with some of its vertices (M,), in their order."""
        fewer = copy.copy(self)
        fewer.vertices, fewer.skin = self.vertices[rows], self.skin[rows]
        fewer._vertex_moves = self._vertex_moves[:, rows]
        return fewer

    def shape(self, values: Float[Tensor, " S"]) -> dict[str, float]:
        """Sliders by name, brought within their bounds."""
        inside = torch.minimum(torch.maximum(values.detach(), self.low), self.high)
        return dict(zip(self.names, inside.tolist(), strict=True))


def rest_places(offsets: Float[Tensor, "J 3"], parents: tuple[int, ...]) -> Float[Tensor, "J 3"]:
    """(J, 3) joints of the rest pose, the root's offset counted as forward kinematics does."""
    places = [offsets[0]]
    for joint in range(1, len(parents)):
        places.append(places[parents[joint]] + offsets[joint])
    return torch.stack(places)


def posed_vertices(
    template: Template, pose: Float[np.ndarray, "J 3 3"], root: Float[np.ndarray, " 3"]
) -> Float[np.ndarray, "V 3"]:
    """(V, 3) all vertices of a shaped template under rotations (J, 3, 3) with its root at (3,), metres."""
    skeleton = template.skeleton
    joints, turns = forward_kinematics(np.asarray(pose), np.asarray(root), skeleton.offsets, skeleton.parents)
    moves = joints - np.einsum("jab,jb->ja", turns, skeleton.rest_positions)
    return np.asarray(template.skinned(np.concatenate([turns, moves[..., None]], axis=-1)), np.float64)


def strongest_joints(template: Template) -> Integer[np.ndarray, " V"]:
    """(V,) the joint each vertex hangs on most: its part of the body."""
    index = np.take_along_axis(template.skin_indices, template.skin_weights.argmax(1)[:, None], axis=1)
    return index[:, 0].astype(np.int64)


def _tensor(values) -> Tensor:
    return torch.as_tensor(np.array(values, dtype=np.float64))


def _stacked(moves: list[Tensor], like: Tensor) -> Tensor:
    """(2S, ...) moves of sliders' ends; none for a template without sliders."""
    return torch.stack(moves) if moves else like.new_zeros(0, *like.shape)


def _span(span: Tensor) -> Tensor:
    """What a share is divided by; an end that is the usual value itself has no share."""
    return torch.where(span == 0, torch.inf, span)
