"""Motions in words: the sentence that an engine finds for a motion, and how well sentences and motions fit."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import cache
from typing import Any

from engines import Motion, registry
from engines.errors import CheckpointError
from studio import quality, tasks

_loading = threading.Lock()


@dataclass(frozen=True)
class Description:
    """What is said of a motion."""

    sentence: str = ""
    """The likeliest; empty where no engine that describes motions has weights here."""
    fit: float | None = None
    """Similarity of that sentence and the motion, -1 to 1; see `engines.metrics.evaluators.co_embedding`."""
    prompt_fit: float | None = None
    """The same of the prompt that the motion was made of; None where there was none, or nobody judges."""

    def measures(self) -> list[quality.Measure]:
        """How well it fits, to be shown beside a take's other measures."""
        caption = [] if self.fit is None else [quality.fit(self.fit, "fit", "Caption fits", "caption")]
        return [*self.prompt_measure(), *caption]

    def prompt_measure(self) -> list[quality.Measure]:
        """How well the prompt is met; none where there was none."""
        if self.prompt_fit is None:
            return []
        return [quality.fit(self.prompt_fit, "prompt_fit", "Fits the prompt", "prompt")]

    def to_json(self) -> dict[str, Any]:
        """As JSON values."""
        return asdict(self)


NOTHING_SAID = Description()


def captioner() -> Any | None:
    """The engine that describes motions; None where none has weights here."""
    known = registry.captioners()
    return tasks.load_engine(next(iter(known))) if known else None


def judge() -> Any | None:
    """What judges how well sentences and motions fit; None where its weights or its encoder of sentences are missing.

    Returns:
        An `engines.metrics.evaluators.CoEmbedding`, or None.
    """
    with _loading:
        return _judge()


@cache
def _judge() -> Any | None:
    from engines import text
    from engines.metrics.evaluators import co_embedding

    try:
        made = co_embedding.load()
        text.load(made.config.encoder)
    except CheckpointError:
        return None
    return made


def describe(motions: Sequence[Motion], prompts: Sequence[str]) -> list[Description]:
    """Each motion in words.

    Args:
        motions: of any skeleton and rate.
        prompts: what each was made of; empty where it was not made of words.
    """
    engine = captioner()
    said = [found[0].sentence for found in engine.caption_many(motions, count=1)] if engine else [""] * len(motions)
    fits, prompt_fits = _fits(said, motions), _fits(prompts, motions)
    return [Description(*told) for told in zip(said, fits, prompt_fits, strict=True)]


def _fits(sentences: Sequence[str], motions: Sequence[Motion]) -> list[float | None]:
    """Similarity of each sentence and its motion; None where there is no sentence, or nobody judges."""
    there = [place for place, sentence in enumerate(sentences) if sentence]
    found: list[float | None] = [None] * len(sentences)
    judging = judge() if there else None
    if judging is not None:
        values = judging.similarity([sentences[place] for place in there], [motions[place] for place in there])
        for place, value in zip(there, values, strict=True):
            found[place] = round(float(value), 3)
    return found
