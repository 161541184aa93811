"""The studio's timeline as an engine of sequences, so that what it makes is judged beside MultiAct."""

from __future__ import annotations

from collections.abc import Sequence as Listed
from dataclasses import replace
from typing import Any

from engines import Motion
from engines.evaluation.ways import SECONDS
from studio import sequencing, tasks
from studio.sequence import Block, Sequence
from studio.settings import MAX_SEED, GenerateSettings


class TimelineEngine:
    """Blocks made by an engine and led into each other as under *Sequence*.

    Args:
        name: of the engine that makes them.
    """

    variant = "timeline"
    capabilities = frozenset({"actions", "sequences"})

    def __init__(self, name: str) -> None:
        engine: Any = tasks.load_engine(name)
        self.name = name
        self.actions, self.licence, self.weights_hash = engine.actions, engine.licence, engine.weights_hash

    def sequence(self, blocks: Listed[tuple[str, float]], seed: int = 0) -> Motion:
        """As `MultiActEngine.sequence`: a block's seconds have the transition into it, here half a second."""
        first, *rest = blocks
        parts = [Block(first[0], seconds=first[1])]
        parts += [Block(action, seconds=seconds - SECONDS, transition=SECONDS) for action, seconds in rest]
        seeded = tuple(replace(block, seed=(seed + place) % MAX_SEED) for place, block in enumerate(parts))
        return sequencing.make(GenerateSettings(engine=self.name, count=1, sequence=Sequence(seeded)))[0]
