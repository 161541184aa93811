"""Rectified flow over motions: training pairs of noise and motion on straight lines, sampling along them.

Liu et al. 2022, "Flow straight and fast"; Lipman et al. 2022, "Flow matching for generative modeling". The network
says where a line ends (the motion) rather than its slope, so that forward kinematics, steps and standing feet can be
part of the loss, and the last step of sampling is a motion without noise.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable

import torch
from torch import Tensor, nn

from engines.loom.config import LoomConfig
from engines.loom.networks import LoomNet, Wanted
from engines.loom.representation import KNOWN, LAYOUT

BEND = 2.0
"""Power that even steps of sampling are raised to: more of them lie where noise is nearly all there is, and where it is
decided which of many ways to move it will be (when a waving hand is left, and when right). Six such steps are
recognised as often as twelve even ones."""
PLAIN = ("velocity", "ground", "facing")
"""Parts that guidance does not exaggerate: a body pushed away from what it does untold outruns its feet. Walks that
were told how went at 1.1 to 2 times the speed of real ones."""
Adjust = Callable[[Tensor, float], Tensor]
"""(estimate (B, T, D), noise level) -> estimate: what a sampler does to every estimate."""


class Loom(nn.Module):
    """The network with the scale of its features."""

    mean: Tensor
    std: Tensor

    def __init__(self, config: LoomConfig) -> None:
        super().__init__()
        self.config = config
        self.net = LoomNet(config)
        self.register_buffer("mean", torch.zeros(LAYOUT.size))
        self.register_buffer("std", torch.ones(LAYOUT.size))

    def forward(self, x: Tensor, t: Tensor, wanted: Wanted, known: Tensor | None, mask: Tensor) -> Tensor:
        """The motion (B, T, D), normalised, that x at noise level t (0 noise, 1 motion) is on the way to."""
        return self.net(x, t, wanted, known, mask)

    @torch.no_grad()
    def sample(  # noqa: PLR0913, PLR0917 - what a draw depends on
        self,
        noise: Tensor,
        wanted: Wanted,
        mask: Tensor,
        known: Tensor | None = None,
        steps: int = 6,
        guidance: float = 2.0,
        start: tuple[Tensor, float] | None = None,
        adjust: Adjust | None = None,
    ) -> Tensor:
        """Motions (B, T, D), normalised, from noise.

        Args:
            noise: (B, T, D) standard normal.
            wanted: what they are told to be.
            mask: (B, T) frames that are there.
            known: (B, T, K) what is known beforehand; kept exactly.
            steps: of the network.
            guidance: how much further than without being told, but for the parts in `PLAIN`; 1 leaves all as it is
                (classifier-free guidance, Ho 2022).
            start: a motion (B, T, D) and the noise level to begin from instead of pure noise.
            adjust: called on every estimate.
        """
        begin = 0.0 if start is None else start[1]
        levels = (begin + (1.0 - begin) * torch.linspace(0.0, 1.0, steps + 1) ** BEND).tolist()
        x = noise if start is None else start[1] * start[0] + (1 - start[1]) * noise
        for now, then in itertools.pairwise(levels):
            end = self._guided(x, now, wanted, known, mask, guidance)
            end = end if known is None else keep(end, known)
            end = end if adjust is None else adjust(end, now)
            x = end if then == 1.0 else x + (then - now) / (1 - now) * (end - x)
        return x

    def _guided(  # noqa: PLR0913, PLR0917 - as `sample`
        self, x: Tensor, now: float, wanted: Wanted, known: Tensor | None, mask: Tensor, guidance: float
    ) -> Tensor:
        t = x.new_full((len(x),), now)
        if guidance == 1.0:
            return self(x, t, wanted, known, mask)
        both = wanted.joined(wanted.told_nothing())
        facts = None if known is None else torch.cat([known, known])
        with_it, without = self(torch.cat([x, x]), torch.cat([t, t]), both, facts, torch.cat([mask, mask])).chunk(2)
        further = without + guidance * (with_it - without)
        for name in PLAIN:
            further[..., LAYOUT[name]] = with_it[..., LAYOUT[name]]
        return further


def keep(x: Tensor, known: Tensor) -> Tensor:
    """x (B, T, D) with what is known (B, T, K) of its own parts put in place."""
    x = x.clone()
    for name in ("turns", "height", "ground", "facing"):
        held = LAYOUT.read(x, name)
        mask = KNOWN.read(known, f"{name}_known")
        mask = mask[..., None] if name == "turns" else mask
        held[...] = torch.where(mask > 0, KNOWN.read(known, name), held)
    return x
