"""One recurrent step: a previous motion and an action in, the transition and the action after it out, in the world."""

from __future__ import annotations

from typing import Protocol

import numpy as np
import torch

from engines.geometry import canonical, seams
from engines.motion import Motion
from engines.multiact import triplets
from engines.multiact.model import MACVAE
from engines.multiact.networks import SEEN
from engines.multiact.representation import FPS, decode, encode


class Cell(Protocol):
    """What the engine needs of networks, ours or the authors'."""

    names: tuple[str, ...]
    """Of the actions."""
    usual: tuple[tuple[int, int, int], ...]
    """How many frames each usually takes: few, most often, many."""
    sees: int
    """Frames of the previous motion at most."""
    longest: int
    """Frames of transition and action in one step at most."""

    def advance(
        self, previous: Motion, action: int, frames: int, transition: int | None, rng: np.random.Generator
    ) -> tuple[Motion, int]:
        """So many frames that follow on `previous`, and how many of them are transition.

        Args:
            previous: on smpl22 at 20 frames a second, `sees` frames at most.
            action: place among `names`.
            frames: of transition and action together, 2 to `longest`.
            transition: of these; as learned if none, at most half.
            rng: gives the latents.
        """
        ...


class MACVAECell:
    """MACVAE in the canonical frame of the previous motion's last frame, and back.

    What is left of a gap in pose, place and speed between that frame and the first that is made dies away over the
    transition (`geometry.seams`).
    """

    sees = SEEN + 1
    """One more, for the first step."""
    longest = triplets.LONGEST

    def __init__(self, model: MACVAE) -> None:
        self.model = model.eval().requires_grad_(False)
        self.names, self.usual = model.config.actions, model.config.usual_frames

    def advance(
        self, previous: Motion, action: int, frames: int, transition: int | None, rng: np.random.Generator
    ) -> tuple[Motion, int]:
        """See `Cell.advance`."""
        front, placement = canonical.face_front(previous, len(previous) - 1)
        last = torch.from_numpy(encode(front)[-SEEN:])[None]
        label = torch.tensor([action])
        if transition is None:
            (transition,) = self.model.transition_frames(last, label)
        transition = min(transition, frames // 2)
        lengths = torch.tensor([[transition, frames - transition]])
        noise = rng.standard_normal((1, 2, self.model.config.width), dtype=np.float32)
        made = self.model.generate(last, label, lengths, torch.from_numpy(noise))[0].numpy()
        after = placement.restore(decode(made))
        return seams.join(previous, after, transition / FPS)[len(previous) :], transition
