"""What a person asks for becomes requests: names are checked, prompts are read, several actions are told apart."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np

from engines.errors import OutOfRangeError, UnknownLabelError
from engines.loom.config import LoomConfig
from engines.loom.passes import Request
from engines.loom.plan import natural_length
from engines.text import reader
from engines.text.prompts import LONGEST

_MOST_IN_TURN, _LEAST_IN_TURN = 8, 15
"""Actions that one prompt may ask for one after the other, and frames that each of them gets at least."""


class Asking:
    """Requests to a model.

    Args:
        config: of the model, whose actions and styles may be asked for.
    """

    def __init__(self, config: LoomConfig) -> None:
        self.config = config

    def request(self, action: str | None, style: str | None, prompt: str | None) -> Request:
        """One request; what is not told is read out of the prompt.

        Raises:
            UnknownLabelError: an action or a style that is not known; the message lists the nearest.
            OutOfRangeError: the prompt is too long.
        """
        action = " ".join(str(action).lower().split()) if action else None
        style = " ".join(str(style).lower().split()) if style else None
        prompt = " ".join(str(prompt).split()) if prompt else None
        if action is not None and action not in self.config.actions:
            raise UnknownLabelError("action", action, self.config.actions)
        if style is not None and style not in self.config.styles:
            raise UnknownLabelError("style", style, self.config.styles)
        if prompt is not None and len(prompt) > LONGEST:
            raise OutOfRangeError("length of the prompt", len(prompt), f"up to {LONGEST:,} characters")
        if prompt and not (action and style):
            found = self.read(prompt)
            action = action or (found.action if found.action in self.config.actions else None)
            style = style or (found.style if found.style in self.config.styles else None)
        return Request(action, style, prompt)

    def asked(
        self, action: str | None, style: str | None, prompt: str | None, frames: int, *, apart: bool
    ) -> list[tuple[Request, int]]:
        """What is to be done and for how many frames, one after the other; long actions get more of them.

        Args:
            action: as in `request`.
            style: as in `request`.
            prompt: as in `request`.
            frames: in all.
            apart: whether a prompt of several actions may become several requests.
        """
        whole = self.request(action, style, prompt)
        parts = self.in_turn(whole.prompt, style) if apart and whole.prompt and not action else []
        if not parts or frames < len(parts) * _LEAST_IN_TURN:
            return [(whole, frames)]
        usual = np.array([self.config.usual_frames[self.config.actions.index(part.action or "")][1] for part in parts])
        ends = np.rint(frames * np.cumsum(usual) / usual.sum()).astype(int)
        return list(zip(parts, np.diff(ends, prepend=0).tolist(), strict=True))

    def in_turn(self, prompt: str, style: str | None = None) -> list[Request]:
        """The actions of a prompt that asks for several, one after the other; none if it is not clear that it does."""
        said = reader.clauses(prompt)
        if not 1 < len(said) <= _MOST_IN_TURN:
            return []
        parts = [self.request(None, style, part) for part in said]
        names = [part.action for part in parts]
        turned = len(parts) == 2 and names[0] == "walk" and names[1] in {"turn left", "turn right"}
        if None in names or turned or any(a == b for a, b in itertools.pairwise(names)):
            return []  # a walk that turns is one action
        manner = style or next((part.style for part in parts if part.style), None)
        return [replace(part, style=part.style or manner) for part in parts]

    def expected_frames(self, action: str | None, prompt: str | None) -> int:
        """How long what is asked takes by itself, several actions in turn one after the other; errors as `request`."""
        whole = self.request(action, None, prompt)
        parts = self.in_turn(whole.prompt) if whole.prompt and not action else []
        return sum(natural_length(self.config, part.action) for part in parts or [whole])

    def read(self, prompt: str) -> reader.Reading:
        """What a prompt is taken to ask for, of all actions and styles there are words for."""
        return reader.load().read([prompt])[0]

    def understood(self, prompt: str) -> str:
        """What is made of a prompt, a sentence or two for the person who typed it; nothing of an empty one."""
        prompt = " ".join(prompt.split())
        if not prompt:
            return ""
        parts = self.in_turn(prompt)
        if parts:
            return f"Understood as: {', then '.join(request.label for request in parts)}."
        found = self.read(prompt)
        manner = f", {found.style}" if found.style in self.config.styles else ""
        if found.action in self.config.actions:
            return f"Understood as: {found.action}{manner}."
        near = ", ".join(name for name in found.nearest if name in self.config.actions)
        return f"No action it has learned is clearly meant{manner}; it goes by the words alone. Nearest: {near}."
