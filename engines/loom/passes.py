"""Passes of the network: a request becomes windows, windows become motions, one set down after the other."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from engines.errors import OutOfRangeError
from engines.geometry.seams import join
from engines.loom import output
from engines.loom.constraints import NOTHING, Constraints, Keep, Known, compile_known
from engines.loom.model import Adjust, Loom
from engines.loom.networks import Wanted
from engines.loom.plan import Window, windows
from engines.loom.reach import Reach
from engines.loom.representation import LAYOUT, frames_of
from engines.motion import Motion
from engines.text import sides

FPS = 20.0
GUIDANCE = 3.0
"""How strongly what is told is followed, unless it is said: of 61 actions more are recognised than at 2, and feet
slide less than at 4."""
_FACING = {"walk backward": math.pi}
"""How a body faces beside the way it goes, radians, where it is not ahead."""


@dataclass(frozen=True)
class Request:
    """What is told of one stretch."""

    action: str | None = None
    style: str | None = None
    prompt: str | None = None

    @property
    def name(self) -> str:
        """A line for labels and provenance."""
        said = self.prompt or self.action or "motion"
        return f"{said} ({self.style})" if self.style else said

    @property
    def label(self) -> str:
        """The action and the style, for a person."""
        return ", ".join(part for part in (self.action, self.style) if part)


@dataclass(frozen=True, eq=False)
class How:
    """How passes are sampled."""

    guidance: float = GUIDANCE
    steps: int = 6
    constraints: Constraints = NOTHING
    start: tuple[Tensor, float] | None = None
    """Features (1, T, D) and the noise level to begin at, instead of noise alone."""

    @property
    def of_one_window(self) -> bool:
        """Whether all of it speaks of one window, so that there may be no second."""
        return bool(self.constraints) or self.start is not None


class Passes:
    """The model at work."""

    def __init__(self, model: Loom) -> None:
        self.model, self.config = model, model.config
        self._mean, self._std = model.mean.numpy(), model.std.numpy()

    def noise(self, seed: int, indices: Sequence[int], frames: int, window: int = 0) -> Tensor:
        """(B, T, D) standard normal, each motion's from its own stream; T is padded to whole patches."""
        if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or not 0 <= seed < 2**63:
            raise OutOfRangeError("seed", seed, "a whole number from 0 to 2^63 - 1")
        draws = []
        for index in indices:
            generator = torch.Generator().manual_seed((seed * 1_000_003 + index * 1_009 + window) % 2**63)
            draws.append(torch.randn(self._padded(frames), LAYOUT.size, generator=generator))
        return torch.stack(draws)

    def perform(
        self,
        segments: Sequence[tuple[Request, int]],
        seed: int,
        indices: Sequence[int],
        how: How,
        given: list[Motion] | None = None,
    ) -> tuple[list[Motion], list[str]]:
        """Window after window.

        Args:
            segments: (what is told, frames), in order.
            seed: of the noise.
            indices: which motions of the draw.
            how: how passes are sampled; constraints and start are for the only window there is.
            given: a motion for each, to go on from; kept as it is.

        Returns:
            The motions, what is given in front; and what could not be asked of anybody.
        """
        motions, said, number = given, [], 0
        for request, frames in segments:
            before = 0 if motions is None else len(motions[0])
            for window in windows(self.config, [(request.action, frames)], before, again=not how.of_one_window):
                shown = None if motions is None else [m[len(m) - window.shown :] for m in motions]
                noise = self.noise(seed, indices, window.shown + window.frames + how.constraints.loop * LOOP, number)
                new, told = self.window(window, request, noise, how, shown)
                said += told
                number += 1
                pairs = [] if motions is None else zip(motions, new, strict=True)
                motions = [join(a, b[window.shown :]) for a, b in pairs] or new
        assert motions is not None
        return motions, said

    def window(
        self, window: Window, request: Request, noise: Tensor, how: How, shown: list[Motion] | None = None
    ) -> tuple[list[Motion], list[str]]:
        """One pass: motions that begin with what is shown, and what could not be asked of anybody."""
        frames, count = window.shown + window.frames, len(noise)
        looped = LOOP if how.constraints.loop else 0
        mask = (torch.arange(noise.shape[1]) < frames + looped).expand(count, -1)
        known = self._known(how.constraints, shown, frames, count, request)
        facts = None if known is None else self._padded_facts(known, noise.shape[1])
        adjust = [_looped(frames)] if looped else []
        if known is not None and facts is not None and how.constraints.pins:
            adjust.append(Reach(self.model, facts, known[0].held))
        made = self.model.sample(
            noise,
            self._wanted(request, window.span, frames + looped, count),
            mask,
            facts,
            how.steps,
            how.guidance,
            None if how.start is None else (how.start[0].expand(count, -1, -1), how.start[1]),
            _one_after_the_other(adjust),
        )
        motions = output.to_motions(made * self.model.std + self.model.mean, frames, FPS, known)
        if shown is not None:
            motions = [output.exact(m, Constraints(kept=(Keep(s),))) for m, s in zip(motions, shown, strict=True)]
        elif how.constraints.kept:
            motions = [output.exact(m, how.constraints) for m in motions]
        return motions, [] if known is None else list(known[0].unmet)

    def features(self, house: Motion) -> Tensor:
        """(1, T, D) normalised features of a motion on smpl22 at 20 fps, padded to whole patches."""
        found = frames_of(house)
        turned = found.yaw - found.yaw[0]
        cos, sin = np.cos(found.yaw[0]), np.sin(found.yaw[0])
        x, z = (found.ground - found.ground[0]).T
        rows = LAYOUT.join(
            height=found.height, turns=found.turns, velocity=found.velocity, contacts=found.contacts,
            ground=np.stack([cos * x - sin * z, sin * x + cos * z], axis=-1),
            facing=np.stack([np.cos(turned), np.sin(turned)], axis=-1),
        )  # fmt: skip
        normal = torch.from_numpy((rows - self._mean) / self._std)
        return torch.nn.functional.pad(normal, (0, 0, 0, self._padded(len(house)) - len(house)))[None]

    def _wanted(self, request: Request, span: int, frames: int, count: int) -> Wanted:
        text = self._sentence(request.prompt) if request.prompt else torch.zeros(1, sides.SIZE)
        action = 1 + self.config.actions.index(request.action) if request.action else 0
        style = 1 + self.config.styles.index(request.style) if request.style else 0
        numbers = [torch.full((count,), value) for value in (action, style, span, frames)]
        return Wanted(numbers[0], numbers[1], text.expand(count, -1), numbers[2], numbers[3])

    def _sentence(self, prompt: str) -> Tensor:
        """(1, `sides.SIZE`) of a prompt."""
        from engines import text as encoders

        vector = encoders.sentence_vector(prompt, self.config.text_encoder)
        return torch.from_numpy(sides.joined(vector[None].numpy(), [prompt]))

    def _known(
        self, constraints: Constraints, shown: list[Motion] | None, frames: int, count: int, request: Request
    ) -> list[Known] | None:
        facing = _FACING.get(request.action or "", 0.0)
        scale = self._mean, self._std, facing, FPS
        if shown is not None:
            return [compile_known(Constraints(kept=(Keep(motion),)), frames, *scale) for motion in shown]
        if constraints.kept or constraints.path is not None or constraints.pins:
            return [compile_known(constraints, frames, *scale)] * count
        return None

    def _padded(self, frames: int) -> int:
        return -(-frames // self.config.patch) * self.config.patch

    def _padded_facts(self, known: list[Known], frames: int) -> Tensor:
        facts = torch.stack([told.facts for told in known])
        return torch.nn.functional.pad(facts, (0, 0, 0, frames - facts.shape[1]))


def _one_after_the_other(adjusts: Sequence[Adjust]) -> Adjust | None:
    def adjust(x: Tensor, level: float) -> Tensor:
        for change in adjusts:
            x = change(x, level)
        return x

    return adjust if adjusts else None


LOOP = 16
"""Frames by which a loop goes on into its own beginning while it is made."""


def _looped(frames: int) -> Adjust:
    """Make the frames past the end of every estimate those at its beginning: half of either."""
    parts = [LAYOUT[name] for name in ("height", "turns", "velocity", "contacts")]

    def adjust(x: Tensor, _level: float) -> Tensor:
        x = x.clone()
        for part in parts:
            # the first frame's velocity is nothing by definition, so the seam begins one later
            mean = (x[:, 1:LOOP, part] + x[:, frames + 1 : frames + LOOP, part]) / 2
            x[:, 1:LOOP, part] = mean
            x[:, frames + 1 : frames + LOOP, part] = mean
            if part != LAYOUT["velocity"]:
                both = (x[:, 0, part] + x[:, frames, part]) / 2
                x[:, 0, part] = x[:, frames, part] = both
        return x

    return adjust
