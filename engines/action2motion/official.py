"""The released Action2Motion, run from the authors' own checkpoints.

Its weights go into our networks (`nn.GRU` where the release has `GRUCell`s), its own so(3) maths stays beside them in
`official_lie`, and its order of doing things is kept: the same weights and the same noise give the same motions.
Where it departs from the paper:

- the teacher-forcing flag is reversed: `tf_ratio` is the probability of feeding the network its own output;
- what is fed back is the raw decoder output, so a Lie network that has joint positions as real previous poses
  gets Lie parameters there when it feeds itself;
- the KL term is summed over latent and batch and divided by the configured batch size, both terms are summed over
  the frames for the loss and divided by their number for the log;
- bone lengths come from the target pose of each frame in training, from a real motion's first frame in sampling.

Letters: T frames, B batch, J joints, C classes, Z latent, H hidden.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import torch
from torch import Tensor
from torch.nn.functional import one_hot

from engines.action2motion.networks import rollout, sample_latent
from engines.action2motion.official_lie import SKELETONS, OfficialSkeleton
from engines.action2motion.official_weights import (
    OfficialConfig,
    OfficialNetworks,
    from_official,
    load_official,
    to_official,
)
from engines.errors import CheckpointError, OutOfRangeError, UnknownLabelError

__all__ = [
    "ADAM", "KL_WEIGHT", "TF_RATIO", "OfficialConfig", "OfficialModel", "OfficialNetworks", "OfficialPass",
    "OfficialSamples", "feeds_own_output", "from_official", "gaussian_kl", "load_official", "to_official",
]  # fmt: skip

TF_RATIO = 0.6
"""The release's `tf_ratio`."""
KL_WEIGHT = 0.01
"""The release's `lambda_kld` for Lie models of NTU and mocap; 0.001 for HumanAct12 with Lie, 0.0001 without Lie."""
ADAM = {"lr": 2e-4, "betas": (0.9, 0.999), "weight_decay": 1e-5}
"""Arguments of the release's optimiser, `torch.optim.Adam`."""


class Gaussians(NamedTuple):
    """Mean, log-variance and top-layer hidden vector of each frame."""

    mu: Tensor
    """(T, B, Z)."""
    logvar: Tensor
    """(T, B, Z)."""
    hidden: Tensor
    """(T, B, H)."""


@dataclass(frozen=True)
class OfficialPass:
    """One pass of the released training over a batch."""

    posterior: Gaussians
    """Of the real current pose."""
    prior: Gaussians
    """Of the previous pose, real or the network's own."""
    z: Tensor
    """(T, B, Z) posterior draw."""
    prior_input: Tensor
    """(T, B, 3J + C) [previous pose, condition]."""
    generator_input: Tensor
    """(T, B, 3J + C + Z) [previous pose, condition, z]."""
    hidden: Tensor
    """(T, B, H) of the generator."""
    raw: Tensor
    """(T, B, 3J) decoder output."""
    joints: Tensor
    """(T, B, 3J) joint positions: the raw output, with Lie after forward kinematics."""
    recon: Tensor
    """(T,) mean squared error of the joints."""
    kl: Tensor
    """(T,) divergence of posterior from prior, summed over the latent, mean over the batch."""

    def loss(self, kl_weight: float = KL_WEIGHT) -> Tensor:
        """What the release minimises: both terms summed over the frames."""
        return self.recon.sum() + kl_weight * self.kl.sum()

    def logged(self, kl_weight: float = KL_WEIGHT) -> dict[str, float]:
        """The scalars the release logs, means over the frames: g_recon_loss, g_kld_loss and g_loss."""
        frames = len(self.recon)
        scalars = {"g_recon_loss": self.recon.sum(), "g_kld_loss": self.kl.sum(), "g_loss": self.loss(kl_weight)}
        return {name: value.item() / frames for name, value in scalars.items()}


@dataclass(frozen=True)
class OfficialSamples:
    """Motions drawn from the learned prior."""

    joints: Tensor
    """(B, T, J, 3) joint positions in the units and axes of the data set; `OfficialSkeleton.house` turns them."""
    raw: Tensor
    """(T, B, 3J) decoder output."""
    z: Tensor
    """(T, B, Z) the latents drawn."""
    mu: Tensor
    """(T, B, Z) mean of the prior."""
    logvar: Tensor
    """(T, B, Z) log-variance of the prior."""


def gaussian_kl(mu_q: Tensor, logvar_q: Tensor, mu_p: Tensor, logvar_p: Tensor) -> Tensor:
    """Divergence of N(mu_q, exp logvar_q) from N(mu_p, exp logvar_p), elementwise."""
    spread = (torch.exp(logvar_q) + (mu_q - mu_p).square()) / torch.exp(logvar_p)
    return 0.5 * (logvar_p - logvar_q + spread - 1)


def feeds_own_output(draw: float, tf_ratio: float = TF_RATIO) -> bool:
    """Whether a training batch is fed with the network's own output, for a uniform draw in [0, 1).

    The release's reversed flag: true with probability `tf_ratio`, decided once a batch.
    """
    return draw < tf_ratio


class OfficialModel:
    """A released model: its training pass and its sampling.

    Args:
        networks: of `load_official`.
        skeleton: a Lie model's; the release's skeleton of as many joints by default.

    Raises:
        CheckpointError: a Lie model whose joints fit none of the release's skeletons.
    """

    def __init__(self, networks: OfficialNetworks, skeleton: OfficialSkeleton | None = None) -> None:
        self.networks, self.config = networks, networks.config
        by_joints = {len(s): s for s in SKELETONS.values()}
        self.skeleton = skeleton or by_joints.get(self.config.joints)
        fits = self.skeleton is not None and len(self.skeleton) == self.config.joints
        if not fits and self.config.lie:
            raise CheckpointError(
                f"the checkpoint's Lie decoder has {self.config.joints} joints; the released skeletons have "
                + ", ".join(f"{joints} ({s.name})" for joints, s in by_joints.items())
                + "."
            )

    @classmethod
    def load(cls, path: str | Path, time_counter: bool | None = None) -> OfficialModel:
        """The model of an authors' checkpoint; see `load_official`."""
        return cls(load_official(path, time_counter))

    @property
    def actions(self) -> tuple[str, ...]:
        """C names of the labels: the data set's where there are as many, else "0", "1", ..."""
        named = self.skeleton.actions if self.skeleton else ()
        return named if len(named) == self.config.classes else tuple(map(str, range(self.config.classes)))

    def label(self, action: str) -> int:
        """Index of an action's label.

        Raises:
            UnknownLabelError: there is no such action.
        """
        if action not in self.actions:
            raise UnknownLabelError("action", action, self.actions)
        return self.actions.index(action)

    # ---- pieces -----------------------------------------------------------------------------------------

    def condition(self, labels: Tensor | Sequence[int], frames: int) -> Tensor:
        """Labels (B,) -> (T, B, C) one-hot, with the time counter i / (T - 1) behind it where the model has one.

        Raises:
            OutOfRangeError: a label outside 0 ... C - 1, or no frames.
        """
        labels = torch.as_tensor(labels, dtype=torch.long)
        if frames < 1:
            raise OutOfRangeError("number of frames", frames, "1 or more")
        if labels.numel() == 0 or labels.min() < 0 or labels.max() >= self.config.classes:
            raise OutOfRangeError("labels", labels.tolist(), f"one or more of 0 to {self.config.classes - 1}")
        weight = self.networks.prior.embed.weight
        parts = [one_hot(labels, self.config.classes).to(weight).expand(frames, -1, -1)]
        if self.config.time_counter:
            times = torch.arange(frames, dtype=torch.float64) / max(frames - 1, 1)
            parts.append(times.to(weight)[:, None, None].expand(-1, len(labels), -1))
        return torch.cat(parts, dim=-1)

    def positions(self, raw: Tensor, lengths: Tensor) -> Tensor:
        """Decoder output (..., 3J) -> joint positions (..., J, 3), the root's rotation fixed.

        Args:
            raw: root translation and Lie parameters; positions themselves without Lie.
            lengths: (..., J) bone lengths, without Lie not looked at.
        """
        slots = raw.unflatten(-1, (self.config.joints, 3))
        if not self.config.lie or self.skeleton is None:
            return slots
        return self.skeleton.forward_kinematics(slots, slots[..., 0, :], self.skeleton.bone_translations(lengths))

    # ---- training ---------------------------------------------------------------------------------------

    def reconstruct(
        self, joints: Tensor, labels: Tensor, noise: Tensor, own_output: bool, batch_size: int | None = None
    ) -> OfficialPass:
        """The released training pass; gradients flow through what is fed back.

        Args:
            joints: (B, T, 3J) real poses, the root of the first frame at the origin.
            labels: (B,).
            noise: (T, B, Z) of the posterior draw.
            own_output: feed the raw output of each frame to the next (`feeds_own_output`), not the real pose.
            batch_size: the configured one, which the KL term is divided by; B by default.

        Raises:
            CheckpointError: the checkpoint has no posterior.
        """
        networks = self.networks
        if networks.posterior is None:
            raise CheckpointError("the checkpoint has no posterior_net, which training needs; sampling does not.")
        real = joints.transpose(0, 1)
        condition = self.condition(labels, len(real))
        mu, logvar, hidden_q, _ = networks.posterior(torch.cat([real, condition], dim=-1))
        posterior, z = Gaussians(mu, logvar, hidden_q), sample_latent(mu, logvar, noise)
        first = torch.zeros_like(real[0])
        if own_output:
            hidden, raw, _ = networks.generator.unroll(torch.cat([condition, z], dim=-1), first, networks.head)
        previous = torch.cat([first[None], (raw if own_output else real)[:-1]])
        prior_input = torch.cat([previous, condition], dim=-1)
        generator_input = torch.cat([prior_input, z], dim=-1)
        prior = Gaussians(*networks.prior(prior_input)[:3])
        if not own_output:
            hidden, _ = networks.generator(generator_input)
            raw = networks.head(hidden)
        made = self._target_lengths(raw, real).flatten(-2)
        kl = gaussian_kl(*posterior[:2], *prior[:2]).sum(dim=(1, 2)) / (batch_size or real.shape[1])
        recon = (made - real).square().mean(dim=(1, 2))
        return OfficialPass(posterior, prior, z, prior_input, generator_input, hidden, raw, made, recon, kl)

    def _target_lengths(self, raw: Tensor, real: Tensor) -> Tensor:
        """Joints (T, B, J, 3) with the bone lengths of the real pose of the same frame."""
        if not self.config.lie or self.skeleton is None:
            return self.positions(raw, raw)
        return self.positions(raw, self.skeleton.bone_lengths(real.unflatten(-1, (self.config.joints, 3))))

    # ---- sampling ---------------------------------------------------------------------------------------

    def noise(self, count: int, frames: int, seed: int) -> Tensor:
        """Standard normal draws (T, B, Z); motion i of a seed has the same draws whatever the count."""
        generator = torch.Generator().manual_seed(seed)
        draws = [torch.randn(frames, self.config.latent_size, generator=generator) for _ in range(count)]
        return torch.stack(draws, dim=1)

    @torch.inference_mode()
    def sample(self, labels: Tensor | Sequence[int], noise: Tensor, bones: Tensor | None = None) -> OfficialSamples:
        """Motions from the learned prior, each frame fed with the raw output of the one before.

        Args:
            labels: (B,).
            noise: (T, B, Z) standard normal draws, of `noise` or the caller's own; zeros for the likeliest latents.
            bones: (N, T', 3J) real motions whose first frames supply the bone lengths of a Lie model, taken in turn
                and again from the first when there are fewer than labels; the data set's means by default.

        Raises:
            OutOfRangeError: labels or noise do not fit the model.
        """
        labels = torch.as_tensor(labels, dtype=torch.long)
        if noise.ndim != 3 or noise.shape[1:] != (len(labels), self.config.latent_size):
            accepted = f"(frames, {len(labels)}, {self.config.latent_size})"
            raise OutOfRangeError("shape of noise", tuple(noise.shape), accepted)
        condition = self.condition(labels, len(noise))
        networks, first = self.networks, condition.new_zeros(len(labels), 3 * self.config.joints)
        made = rollout(networks.prior, networks.generator, networks.head, condition, noise.to(condition), first)
        joints = self.positions(made.poses.transpose(0, 1), self._sampling_lengths(len(labels), bones)[:, None])
        return OfficialSamples(joints, made.poses, made.z, made.mu, made.logvar)

    def _sampling_lengths(self, count: int, bones: Tensor | None) -> Tensor:
        """Bone lengths (B, J) of so many motions."""
        like = self.networks.prior.embed.weight
        if not self.config.lie or self.skeleton is None:
            return like.new_zeros(count, self.config.joints)
        if bones is None:
            return like.new_tensor(self.skeleton.mean_lengths).expand(count, -1)
        first = bones[torch.arange(count) % len(bones), 0].unflatten(-1, (self.config.joints, 3))
        return self.skeleton.bone_lengths(first.to(like))
