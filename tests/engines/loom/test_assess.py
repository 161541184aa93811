"""The figures of the card: in range, and right for an engine that gives back real motions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from engines.evaluation.prompts import PROMPTS, Answer, answers
from engines.evaluation.prompts_more import MORE
from engines.loom.assess import assess
from engines.metrics import evaluators
from tests.engines.action2motion.tiny import clip
from tests.engines.loom.tiny import engine


@pytest.fixture(scope="module")
def clips():
    return [
        replace(clip(action, 24 + i, i), split=split, style="proud", corpus="bandai-namco")
        for i, (action, split) in enumerate(
            (a, s) for a in ("walk", "throw", "turn left") for s in ("train", "train", "val", "test")
        )
    ]


class Echo:
    """An engine that gives back training clips."""

    def __init__(self, clips) -> None:
        self.config = engine().config
        self.clips = [c for c in clips if c.split == "train"]

    def generate_many(self, action=None, count=4, frames=60, seed=0, **_):
        found = [c.motion for c in self.clips if action is None or c.action == action] or [self.clips[0].motion]
        return [found[i % len(found)] for i in range(count)]


def test_an_engine_that_repeats_its_training_clips_is_found_out(clips) -> None:
    found = assess(Echo(clips), clips, draws=4)  # type: ignore[arg-type]
    assert found.nearest[0] == 0.0 < found.nearest[1]
    assert found.physics["jitter"][0] > 0
    assert set(found.by_action) == set(Echo(clips).config.actions)


def test_figures_of_random_weights_are_in_range(clips) -> None:
    found = assess(engine(), clips, draws=2)
    for ours, real in (*found.accuracy.values(), found.styles):
        assert 0 <= ours <= 1 and 0 <= real <= 1
    assert found.nearest[0] > 0
    assert np.isfinite([*found.fid, *found.multimodality]).all()
    assert (len(found.prompts), len(found.more)) == (len(PROMPTS), len(MORE))
    assert set(found.held) <= {c.action for c in clips if c.split != "train"}


def test_a_sentence_counts_as_right_by_what_is_seen() -> None:
    recogniser = evaluators.load("action")
    motion = clip("walk").motion
    said = recogniser.recognise([motion])[0]
    found = answers(lambda _: [motion, motion], recogniser)
    assert all(answer.seen == (said, said) for answer in found)
    assert sum(answer.share for answer in found) == sum(said in accepted for _, accepted in PROMPTS)
    assert Answer("x", ("a",), ("a", "b")).share == 0.5


def test_prompts_are_no_captions_and_name_what_the_recogniser_knows() -> None:
    labels = set(evaluators.load("action").labels)
    assert len({sentence for sentence, _ in PROMPTS}) == len(PROMPTS) == 60
    assert all(set(accepted) <= labels for _, accepted in PROMPTS)
