"""The figures of TM2T's card, by tiny random weights: nothing about how good they are."""

from __future__ import annotations

import pytest

from engines.metrics import physical
from engines.tm2t.assess import assess
from tests.engines.action2motion.tiny import clip
from tests.engines.tm2t.tiny import engine


def test_figures_are_of_the_clips_they_are_given() -> None:
    clips = [clip("walk", 40), clip("throw", 40, 1), clip("walk", 40, 2)]
    sentences = ["a person walks", "a person throws", "somebody walks"]
    found = assess(engine(), clips, sentences, most=2)
    assert found.clips == 2 == len(found.captions)
    of = {one.name: sentence for one, sentence in zip(clips, sentences, strict=True)}
    for caption in found.captions:
        assert caption.human == of[caption.clip]
        assert -1 <= caption.fit <= 1
        assert -1 <= caption.human_fit <= 1
    chosen = [one.motion for one in clips if one.name in {caption.clip for caption in found.captions}]
    real = sum(physical.summary(motion)["jitter"] for motion in chosen) / 2
    assert found.physics["jitter"][1] == pytest.approx(real)
    assert found.error > 0.01, "random weights do not give a motion back"
    assert 0 <= found.recognised[0] <= 1
    assert 1 <= found.codes <= 20
    assert sum(count for _, count in found.lost.values()) == 2
