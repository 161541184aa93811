"""The studio's timeline judged as an engine of sequences."""

from __future__ import annotations

from engines.evaluation.sequences import passages
from studio.timeline_engine import TimelineEngine


def test_blocks_have_the_transition_into_them_and_seeds_of_their_own(engine):
    timeline = TimelineEngine("fake")
    blocks = [("walk", 3.0), ("run", 3.0), ("walk", 2.0)]
    made = timeline.sequence(blocks, seed=2**62)
    assert len(made) == 160
    assert [(s.start, s.end) for s in made.labels if s.kind == "transition"] == [(60, 70), (120, 130)]
    assert [passage.name for passage in passages(made)] == ["run", "walk"]
    assert len({call["seed"] for call in engine.calls}) == 3
    assert timeline.weights_hash == engine.weights_hash
