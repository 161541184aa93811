"""Beam search over sentences, many motions and all their beams in one batch.

A beam that has come to its end stays as it is and competes with the others by its score over length ** ALPHA; the
release lets it grow on past its end (`official.beam_search`). Letters: B motions, K beams, N words, V vocabulary.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import torch
from torch import Tensor

from engines.text.words import Words

ALPHA = 0.7
"""How much longer sentences are favoured: 0 not at all, 1 by the mean over their words."""


class BeamSteps(Protocol):
    """A decoder whose rows can be exchanged."""

    def step(self, tokens: Tensor) -> Tensor:
        """Tokens (B,) -> logits (B, V) of what follows."""
        ...

    def choose(self, rows: Tensor) -> None:
        """Go on from these rows."""
        ...


class Found(NamedTuple):
    """A sentence."""

    words: list[int]
    """Without its marks."""
    score: float
    """Log-probability of the words and the end, over their number ** ALPHA."""
    ended: bool
    """Whether the end was found within the words allowed."""


@dataclass
class _Beams:
    tokens: Tensor
    """(B, K, N) so far, from the first word on."""
    scores: Tensor
    """(B, K) log-probabilities."""
    lengths: Tensor
    """(B, K) words and end; what an open beam has so far."""
    ended: Tensor
    """(B, K)."""


@torch.no_grad()
def beam_search(  # noqa: PLR0913, PLR0917 - what a search depends on
    steps: BeamSteps, words: Words, motions: int, beams: int = 2, longest: int = 30, alpha: float = ALPHA
) -> list[list[Found]]:
    """The likeliest sentences of every motion, the best first.

    Args:
        steps: fresh, with `beams` rows a motion, those of the same motion beside each other.
        words: the vocabulary.
        motions: B.
        beams: K, kept of each motion.
        longest: words and end, at most.
        alpha: see `ALPHA`.

    Returns:
        K sentences a motion, or fewer where the vocabulary has not as many.
    """
    now = _start(steps, words, motions, beams)
    first_row = (torch.arange(motions) * beams)[:, None].to(now.tokens.device)
    for length in range(2, longest + 1):
        if now.ended.all():
            break
        logits = steps.step(now.tokens[:, :, -1].flatten()).float()
        gains = _allowed(logits, words).log_softmax(-1).unflatten(0, (motions, beams))
        # an ended beam has one way to go on, which costs nothing
        closed = torch.full_like(gains, -torch.inf)
        closed[..., words.pad] = 0.0
        gains = torch.where(now.ended[..., None], closed, gains)
        total = now.scores[..., None] + gains
        held = torch.where(now.ended, now.lengths, length)[..., None].float()
        best = (total / held**alpha).flatten(1).topk(beams, dim=-1).indices
        beam, word = best // gains.shape[-1], best % gains.shape[-1]
        steps.choose((first_row + beam).flatten())
        was_ended = now.ended.gather(1, beam)
        tokens = now.tokens.gather(1, beam[..., None].expand(-1, -1, now.tokens.shape[-1]))
        now = _Beams(
            torch.cat([tokens, word[..., None]], dim=-1),
            total.flatten(1).gather(1, best),
            torch.where(was_ended, now.lengths.gather(1, beam), length),
            was_ended | (word == words.end),
        )
    return _told(now, words, alpha)


def _start(steps: BeamSteps, words: Words, motions: int, beams: int) -> _Beams:
    """The likeliest first words, each motion's all different."""
    begin = torch.full((motions * beams,), words.begin)
    logits = _allowed(steps.step(begin).float(), words, first=True).log_softmax(-1)
    scores, first = logits[::beams].topk(min(beams, logits.shape[-1]), dim=-1)
    if first.shape[1] < beams:
        lack = beams - first.shape[1]
        scores = torch.cat([scores, scores.new_full((motions, lack), -torch.inf)], 1)
        first = torch.cat([first, first.new_full((motions, lack), words.pad)], 1)
    ended = scores == -torch.inf
    return _Beams(first[..., None], scores, torch.ones_like(first), ended)


def _allowed(logits: Tensor, words: Words, first: bool = False) -> Tensor:
    """No start mark, no padding, and no sentence without a word."""
    logits = logits.clone()
    logits[:, [words.begin, words.pad] + [words.end] * first] = -torch.inf
    return logits


def _told(now: _Beams, words: Words, alpha: float) -> list[list[Found]]:
    told = []
    scores = now.scores / now.lengths.float() ** alpha
    for rows, row_scores, ended in zip(now.tokens.tolist(), scores.tolist(), now.ended.tolist(), strict=True):
        found = [
            Found([word for word in row if word < words.begin], score, end)
            for row, score, end in zip(rows, row_scores, ended, strict=True)
            if score > -torch.inf
        ]
        told.append(sorted(found, key=lambda one: -one.score))
    return told
