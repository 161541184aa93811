"""What MACVAE is trained to make small (section "Training objectives"): named terms."""

from __future__ import annotations

import torch
from torch import Tensor

from engines.features.smplh import SMPLH_HOUSE
from engines.loom.representation import kinematics
from engines.multiact.config import MultiActConfig
from engines.multiact.data import Batch
from engines.multiact.model import MACVAE
from engines.multiact.representation import LAYOUT, summed
from engines.multiact.triplets import PREVIOUS
from engines.skeletons import SMPL22
from engines.text2motion.losses import divergence
from engines.training.devices import ALONE, Share

FEET = [SMPL22.index(name) for foot in SMPL22.feet for name in foot]
_STILL = 0.2 / SMPLH_HOUSE.fps
"""Metres a frame below which a foot stands."""
_BEFORE = 2
"""Frames of the previous motion that speeds and accelerations of the first made frames are taken from."""


def losses(model: MACVAE, batch: Batch, generator: torch.Generator, share: Share = ALONE) -> dict[str, Tensor]:
    """Every term, already weighted, of a share of a batch; noise is drawn for the whole batch."""
    config: MultiActConfig = model.config
    whole = len(batch.x) * share.world
    noise = torch.randn(whole, 2, config.width, generator=generator)[share.rows].to(share.device)
    blur = torch.randn(whole, PREVIOUS, LAYOUT.size, generator=generator)[share.rows].to(share.device)
    told = model(batch.x, batch.labels, batch.frames, noise, blur)
    real = batch.x[:, PREVIOUS:]
    there = (torch.arange(real.shape[1], device=real.device) < batch.frames.sum(1)[:, None]).float()
    there = there / there.sum()

    def mean(values: Tensor) -> Tensor:
        """Over frames that are there, of (B, T, ...) and over all that each has."""
        return (values.flatten(2).mean(-1) * there).sum()

    before = batch.x[:, PREVIOUS - _BEFORE : PREVIOUS]
    made_joints, made_place = joints_and_place(torch.cat([before, told.made], dim=1))
    joints, place = joints_and_place(torch.cat([before, real], dim=1))
    made_step, step = (j.diff(dim=1) + p.diff(dim=1)[:, :, None] for j, p in
                       ((made_joints, made_place), (joints, place)))  # fmt: skip
    speed, stands = made_step[:, 1:], step[:, 1:, FEET].norm(dim=-1) < _STILL
    terms = {
        "pose": config.pose_weight * mean((told.made - real).abs()),
        "joints": config.joint_weight * mean((made_joints - joints)[:, _BEFORE:].abs()),
        "place": config.place_weight * mean((made_place - place)[:, _BEFORE:].abs()),
        "acceleration": config.acceleration_weight * mean((made_step.diff(dim=1) - step.diff(dim=1)).abs()),
        "movement": config.movement_weight * mean((speed - step[:, 1:]).abs()),
        "contact": config.contact_weight * mean(speed[:, :, FEET].norm(dim=-1) * stands),
    }
    nats = torch.stack([divergence(*pair).mean() for pair in zip(told.posterior, told.prior, strict=True)]).sum()
    terms["kl"] = config.kl_weight * (nats - config.free_nats).clamp_min(0)
    terms["length"] = config.length_weight * (told.length - batch.frames[:, 0].log()).abs().mean()
    return terms


def joints_and_place(features: Tensor) -> tuple[Tensor, Tensor]:
    """Joints (B, T, J, 3) from the root's place on the floor, and that place (B, T, 3); metres.

    Args:
        features: (B, T, D), of which the frame at `_BEFORE` - 1 is the anchor.
    """
    parts = LAYOUT.split(features)
    place = summed(parts["step"])
    place = place - place[:, _BEFORE - 1 : _BEFORE]
    joints = kinematics(parts["rotations"], parts["height"])
    return joints, torch.stack([place[..., 0], torch.zeros_like(place[..., 0]), place[..., 1]], dim=-1)
