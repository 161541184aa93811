"""What Action2Motion is trained to make small: named terms, thesis equations 3.10 and 3.11 and a few of ours."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from engines.action2motion.config import Action2MotionConfig
from engines.action2motion.model import Action2Motion, Draws
from engines.action2motion.representation import world_step
from engines.training.devices import ALONE, Share
from engines.training.schedules import Linear


@dataclass(frozen=True)
class Batch:
    """Real sequences, time first."""

    vectors: Tensor
    """(T, B, D) poses as the networks are fed them."""
    conditions: Tensor
    """(T, B, C) one-hot action and time counter."""
    positions: Tensor
    """(T, B, J, 3) joints in the heading frame."""
    matrices: Tensor
    """(T, B, J, 3, 3) local rotations."""
    velocity: Tensor
    """(T, B, 3) root velocity."""
    contacts: Tensor
    """(T, B, 4) standing foot joints."""
    mask: Tensor
    """(T, B) 1 on real frames, 0 where a short clip's last pose is held."""


def losses(  # noqa: PLR0913, PLR0917 - what a loss is a function of
    model: Action2Motion, batch: Batch, step: int, feet: list[int], generator: torch.Generator, share: Share = ALONE
) -> dict[str, Tensor]:
    """Every term, already weighted; their sum is what is minimised. The batch is this process's share of the whole."""
    config = model.config
    poses, (mu_q, logvar_q, mu_p, logvar_p) = model.reconstruct(
        batch.vectors, batch.conditions, batch.positions, draws(config, batch, generator, share)
    )
    terms = {
        # eq. 3.11: distance of every joint, summed over joints
        "reconstruction": (poses.positions - batch.positions).square().sum(-1).add(1e-8).sqrt().sum(-1).mean(),
        # eq. 3.10: prior against posterior, nats a frame
        "kl": kl_weight(config, step) * gaussian_kl(mu_q, logvar_q, mu_p, logvar_p).sum(-1).mean(),
        # eq. 3.10: root velocity
        "alignment": config.alignment_weight
        * (poses.velocity - batch.velocity).square().sum(-1).add(1e-8).sqrt().mean(),
    }
    if config.rotation_weight and poses.matrices is not None:
        # chordal distance of local rotations: joint positions say nothing of twist
        terms["rotation"] = config.rotation_weight * (poses.matrices - batch.matrices).square().sum((-1, -2)).mean()
    if config.velocity_weight:
        moved = (poses.positions[1:] - poses.positions[:-1]) - (batch.positions[1:] - batch.positions[:-1])
        terms["velocity"] = config.velocity_weight * moved.square().sum(-1).add(1e-8).sqrt().sum(-1).mean()
    if config.contact_weight:
        # a foot that stands does not travel over the ground
        standing = batch.contacts[1:] * batch.contacts[:-1]
        slide = world_step(poses.positions, poses.velocity)[:, :, feet]
        terms["contact"] = config.contact_weight * (slide.square().sum(-1).add(1e-8).sqrt() * standing).sum(-1).mean()
    return terms


def draws(config: Action2MotionConfig, batch: Batch, generator: torch.Generator, share: Share = ALONE) -> Draws:
    """What is random in a pass over a share of a batch: drawn for the whole of it, alike in all processes."""
    frames, count = len(batch.mask), batch.mask.shape[1] * share.world

    def kept(values: Tensor) -> Tensor:
        return values[:, share.rows].to(share.device)

    latent = kept(torch.randn(frames, count, config.latent_size, generator=generator))
    if not config.feed_rounds:
        chances = torch.full((count,), config.teacher_forcing)
        return Draws(latent, forced=share.count(int(torch.bernoulli(chances, generator=generator).sum())))
    # some sequences are fed mostly their own poses, some hardly any, and some more noise than others
    shares = torch.rand(count, generator=generator) * min(1.0, 2 * (1 - config.teacher_forcing))
    spread = torch.rand(1, count, 1, generator=generator) * config.pose_noise
    return Draws(
        latent,
        own=kept(torch.rand(frames, count, generator=generator) < shares),
        pose=kept(torch.randn(frames, count, config.pose_size, generator=generator) * spread),
        # only the first half of the sequences take the prior's latents
        prior=kept(torch.randn(frames, count, config.latent_size, generator=generator)[:, : count // 2]),
    )


def kl_weight(config: Action2MotionConfig, step: int) -> float:
    """lambda_kl at a step: a linear rise, then constant (thesis, training strategy)."""
    return Linear(*config.kl_weight, steps=config.kl_rise * config.steps)(step)


def gaussian_kl(mu_q: Tensor, logvar_q: Tensor, mu_p: Tensor, logvar_p: Tensor) -> Tensor:
    """KL(q || p) of diagonal Gaussians, elementwise, nats."""
    return 0.5 * (logvar_p - logvar_q + (torch.exp(logvar_q) + (mu_q - mu_p).square()) * torch.exp(-logvar_p) - 1.0)
