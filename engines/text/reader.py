"""What a prompt asks for: the action and the style of our vocabulary that its words mean, if they mean one.

    reading = reader.load().read(["an old man waves hello with his left arm"])[0]
    reading.action, reading.style       # "wave left hand", "elderly"

Two linear maps from a frozen encoder's sentence vector (and the sides it names), trained on everyday sentences and on
captions by `scripts/train_prompt_reader.py`. A sentence that asks for none of the actions gets none, and says which
would be nearest.
"""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import torch
from torch import Tensor, nn

from engines import weights_file
from engines.text.encoder import TextEncoder, sentence_vector
from engines.text.sides import SIDES, named
from engines.weights_file import SHIPPED

SIDE_WEIGHT = 0.5
"""Of a side that is named, beside a sentence vector of length one."""
SURE = 0.35
"""Probability from which a sentence is taken to ask for an action, if none of them is not likelier."""
SURE_STYLE = 0.5
"""... for a style: one that nobody asked for is worse than one that is missed."""
_NEAREST = 3
_THEN = re.compile(r"[.;]\s+|,?\s*\b(?:and\s+)?(?:then|afterwards?|after that|next|finally)\b,?\s*", re.IGNORECASE)


@dataclass(frozen=True)
class Reading:
    """A prompt as it is understood."""

    action: str | None
    """What is asked for; None where it is none of the vocabulary, or not clear."""
    style: str | None
    nearest: tuple[str, ...]
    """The likeliest actions, whether one is asked for or not."""
    sure: float
    """Probability of the first of `nearest`."""


def clauses(prompt: str) -> list[str]:
    """What is to be done one after the other, as far as words for it ("then", a full stop) say so."""
    return [part.strip(" ,.") for part in _THEN.split(prompt) if part.strip(" ,.")]


class PromptReader(nn.Module):
    """Sentences -> readings.

    Args:
        actions: the names it knows.
        styles: the names it knows.
        encoder: gives sentence vectors of many at a time; the usual one, sentence by sentence, if none.
    """

    def __init__(self, actions: Sequence[str], styles: Sequence[str], encoder: TextEncoder | None = None) -> None:
        super().__init__()
        self.actions, self.styles = tuple(actions), tuple(styles)
        self._encoder = encoder
        size = (encoder.size if encoder else 384) + len(SIDES)
        self.action = nn.Linear(size, len(self.actions) + 1)
        """Logits of the actions and, last, of none of them."""
        self.style = nn.Linear(size, len(self.styles) + 1)

    def vectors(self, sentences: Sequence[str]) -> Tensor:
        """(N, D) what the maps see of sentences."""
        if self._encoder is None:
            said = torch.stack([sentence_vector(line) for line in sentences])
        else:
            said = self._encoder.encode(sentences).sentences
        return torch.cat([said, torch.from_numpy(named(sentences)) * SIDE_WEIGHT], dim=-1)

    @torch.inference_mode()
    def read(self, sentences: Sequence[str]) -> list[Reading]:
        """What each sentence asks for."""
        if not sentences:
            return []
        seen = self.vectors(sentences)
        actions, styles = self.action(seen).softmax(-1), self.style(seen).softmax(-1)
        return [self._reading(action, style) for action, style in zip(actions, styles, strict=True)]

    def _reading(self, action: Tensor, style: Tensor) -> Reading:
        order = action[:-1].argsort(descending=True)
        nearest = tuple(self.actions[int(i)] for i in order[:_NEAREST])
        sure = float(action[order[0]])
        manner = int(style.argmax())
        known = manner < len(self.styles) and float(style[manner]) >= SURE_STYLE
        asked = sure >= max(SURE, float(action[-1]))
        return Reading(nearest[0] if asked else None, self.styles[manner] if known else None, nearest, sure)


def save(reader: PromptReader, path: Path) -> str:
    """Write weights and vocabulary beside each other; returns the weights' SHA-256."""
    settings = json.dumps({"actions": reader.actions, "styles": reader.styles}, indent=1)
    return weights_file.write(reader.state_dict(), settings, path)


@lru_cache(maxsize=1)
def load(path: Path = SHIPPED / "prompt-reader.safetensors") -> PromptReader:
    """The reader with its shipped weights, loaded once.

    Raises:
        CheckpointError: the file is missing or damaged.
    """
    settings = json.loads(weights_file.read_settings(path, "train them (scripts/train_prompt_reader.py)"))
    reader = PromptReader(settings["actions"], settings["styles"])
    weights_file.fill(reader, path)
    return reader.eval().requires_grad_(False)
