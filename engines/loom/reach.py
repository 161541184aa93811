"""Bring pinned joints to their places while a motion is being sampled.

The network is told where a joint is to be and goes there roughly. After each of its estimates the rotations at the
pinned frames are changed a little, by damped least squares through forward kinematics, the trunk least, and the change
fades out in the frames around; the network's next estimate makes the rest of the body go with it.
"""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor

from engines.loom.model import Loom
from engines.loom.representation import JOINTS, KNOWN, LAYOUT, joints_from_start, kinematics, travelled
from engines.skeletons import SMPL22

_ITERATIONS = 12
_DAMPING = 1e-3
"""Square metres: how much of a step is held back where joints hardly answer to it."""
_LONGEST = 1.0
"""Of a step, in deviations of a rotation."""
_SPREAD = 5.0
"""Frames over which a change fades out (deviation of a Gaussian)."""
_STIFF = {"pelvis": 0.1, "spine1": 0.15, "spine2": 0.15, "spine3": 0.2, "neck": 0.5}
"""How readily the trunk gives way, against 1 of the limbs: a hand is reached out before the back is bent."""
_SETTLED = 0.3
"""Noise level before which nothing is changed: there is no pose yet."""


class Reach:
    """An `Adjust` of the sampler.

    Args:
        model: gives the scale of the features.
        known: (B, T, K) with joints that are known.
        held: (T, 2) how much place and facing count (`representation.travelled`); T frames without padding.
    """

    def __init__(self, model: Loom, known: Tensor, held: np.ndarray) -> None:
        frames = len(held)
        self.mean, self.std = model.mean, model.std
        mask = KNOWN.read(known, "joints_known")[:, :frames] > 0
        self.at = mask.any(-1).any(0).nonzero()[:, 0]  # (P,) frames with a pin
        self.joints = mask.any(1).any(0).nonzero()[:, 0]  # (K,) joints with one, the root not counted
        self.mask = mask[:, self.at][..., self.joints, None].float()  # (B, P, K, 1)
        self.target = KNOWN.read(known, "joints")[:, self.at][..., self.joints, :]
        stiff = torch.tensor([_STIFF.get(name, 1.0) for name in SMPL22.joints])
        self.give = (1 - KNOWN.read(known, "turns_known")[:, self.at]) * stiff  # (B, P, J)
        gap = torch.arange(frames)[:, None] - self.at
        weight = torch.exp(-0.5 * (gap / _SPREAD).square())
        # between pins their changes are averaged, beside them they fade out, at them they are exact
        self.weight = weight.square() / weight.sum(1, keepdim=True).clamp_min(1e-6)
        self.weight[self.at] = torch.eye(len(self.at))
        self.frames = frames
        self.held = held

    def __call__(self, x: Tensor, level: float) -> Tensor:
        """Estimates (B, T, D), normalised, with the pinned joints brought near."""
        if level < _SETTLED:
            return x
        here = x[:, self.at] * self.std + self.mean
        stands = self._stands(x)
        change = torch.zeros(*here.shape[:2], JOINTS, 6)
        for _ in range(_ITERATIONS):
            gap, slope = self._linear(here, stands, change)
            given = slope * self.give.repeat_interleave(6, dim=-1)[:, :, None]
            damped = given @ slope.mT + _DAMPING * torch.eye(gap.shape[-1])
            step = (given.mT @ torch.linalg.solve(damped, gap[..., None]))[..., 0]
            step = step / (step.abs().amax(-1, keepdim=True) / _LONGEST).clamp_min(1.0)
            change = change - step.unflatten(-1, (JOINTS, 6))
        made = x.clone()
        LAYOUT.read(made, "turns")[:, : self.frames] += torch.einsum("tp,bpjc->btjc", self.weight, change)
        return made

    def _stands(self, x: Tensor) -> tuple[Tensor, Tensor]:
        """Where the bodies will be and face at the pinned frames: places (B, P, 2) and facing (B, P, 2)."""
        rows = (x[:, : self.frames] * self.std + self.mean).numpy()
        found = [travelled(row, self.held) for row in rows]
        yaw, ground = (torch.from_numpy(np.stack(part)).float()[:, self.at] for part in zip(*found, strict=True))
        return ground, torch.stack([yaw.cos(), yaw.sin()], dim=-1)

    def _linear(self, here: Tensor, stands: tuple[Tensor, Tensor], change: Tensor) -> tuple[Tensor, Tensor]:
        """Where the joints are from their places (B, P, 3K), and its slope (B, P, 3K, J * 6)."""
        with torch.enable_grad():
            change = change.detach().requires_grad_()
            turns = LAYOUT.read(here, "turns") + change * LAYOUT.read(self.std, "turns")
            joints = joints_from_start(kinematics(turns, LAYOUT.read(here, "height")), *stands)
            gap = ((joints[..., 1:, :][..., self.joints, :] - self.target) * self.mask).flatten(-2)
            rows = [torch.autograd.grad(gap[..., i].sum(), change, retain_graph=True)[0] for i in range(gap.shape[-1])]
        return gap.detach(), torch.stack(rows, dim=2).flatten(-2)
