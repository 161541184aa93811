"""What Loom is trained to make small, named terms."""

from __future__ import annotations

import torch
from torch import Tensor

from engines.action2motion.representation import world_step
from engines.loom.config import LoomConfig
from engines.loom.data import Batch
from engines.loom.model import Loom
from engines.loom.representation import LAYOUT, kinematics
from engines.skeletons import SMPL22
from engines.training.devices import ALONE, Share

FEET = [SMPL22.index(name) for foot in SMPL22.feet for name in foot]
EMPHASIS = {"height": 4.0, "velocity": 8.0, "contacts": 2.0, "ground": 4.0, "facing": 4.0}
"""How much a number of these parts counts against one of the 132 of the rotations."""
_STEEPEST = 5.0
_USUAL = 0.03
"""Squared metres that all joints of one frame move to the next: half of that of a walk."""


def losses(model: Loom, batch: Batch, generator: torch.Generator, share: Share = ALONE) -> dict[str, Tensor]:
    """Every term, already weighted, of a share of a batch; noise and its levels are drawn for the whole batch."""
    config: LoomConfig = model.config
    count = len(batch.x) * share.world
    t = _levels(count, generator)[share.rows].to(share.device)
    noise = torch.randn(count, *batch.x.shape[1:], generator=generator)[share.rows].to(share.device)
    x = t[:, None, None] * batch.x + (1 - t[:, None, None]) * noise
    made = model(x, t, batch.wanted, batch.known, batch.mask)
    # the slope's error is the motion's error over 1 - t; squared it would leave all else behind
    weight = (1 / (1 - t).clamp_min(1 / _STEEPEST)) / 1.6
    there = batch.mask.float() * weight[:, None]
    there = there / batch.mask.sum()

    def mean(values: Tensor) -> Tensor:
        """Over frames that are there, of (B, T), or (B, T - 1) from the second on."""
        return (values * there[:, -values.shape[1] :]).sum()

    error = (made - batch.x).square()
    terms = {}
    for part in LAYOUT:
        scale = EMPHASIS.get(part.name, 1.0) / 100
        terms[part.name] = scale * mean(error[..., LAYOUT[part.name]].sum(-1))
    raw = made * model.std + model.mean
    real = batch.x * model.std + model.mean
    places = kinematics(LAYOUT.read(raw, "turns"), LAYOUT.read(raw, "height"))
    terms["joints"] = config.joint_weight * mean((places - batch.joints).square().sum((-1, -2)))
    step = _step(places, LAYOUT.read(raw, "velocity"))
    true = _step(batch.joints, LAYOUT.read(real, "velocity"))
    missed = (step - true).square().sum((-1, -2)) * _quiet(true, batch.mask)[:, None]
    terms["movement"] = config.movement_weight * mean(missed)
    contacts = LAYOUT.read(real, "contacts")
    standing = contacts[:, 1:] * contacts[:, :-1]
    slide = step[:, :, FEET].square().sum(-1)
    terms["contact"] = config.contact_weight * mean((slide * standing).sum(-1))
    return terms


def _step(joints: Tensor, velocity: Tensor) -> Tensor:
    """(B, T - 1, J, 3) how joints move over the ground, metres a frame."""
    return world_step(joints.transpose(0, 1), velocity.transpose(0, 1)).transpose(0, 1)


def _quiet(step: Tensor, mask: Tensor) -> Tensor:
    """(B,) how much more the movement of a window counts, the less there is of it.

    Beside a run the swing of a waving hand is next to nothing, and would be left out.
    """
    squared = step.square().sum((-1, -2)) * mask[:, 1:]
    usual = squared.sum(1) / mask[:, 1:].sum(1).clamp_min(1)
    return (_USUAL / (usual + 0.05 * _USUAL)).clamp(0.5, 4.0)


def _levels(count: int, generator: torch.Generator) -> Tensor:
    """(B,) noise levels: mostly in the middle (Esser et al. 2024), a fifth anywhere."""
    middle = torch.sigmoid(torch.randn(count, generator=generator) - 0.3)
    anywhere = torch.rand(count, generator=generator)
    return torch.where(torch.rand(count, generator=generator) < 0.2, anywhere, middle).clamp_max(0.995)
