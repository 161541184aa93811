"""Windows for Loom: which clips are drawn how often."""

from __future__ import annotations

from dataclasses import replace

import pytest

from engines.loom.data import Windows
from tests.engines.action2motion.tiny import clip
from tests.engines.loom.tiny import config

STYLES = ["old"] * 8 + ["proud"]


def chances(**changes: float) -> dict[str, float]:
    """Of one clip of each style, relative to the rarer one's."""
    found = [replace(clip("walk", 30, i), style=style) for i, style in enumerate(STYLES)]
    windows = Windows(found, config(**changes))
    each = {style: windows.probability[2 * i] for i, style in enumerate(STYLES)}
    assert windows.probability.sum() == pytest.approx(1.0)
    return {style: each[style] / each["proud"] for style in each}


def test_clips_of_a_rare_style_are_drawn_more_often() -> None:
    assert chances(style_balance=0.0)["old"] == pytest.approx(1.0)
    assert chances(style_balance=0.5)["old"] == pytest.approx(8**-0.5)
    assert chances(style_balance=1.0)["old"] == pytest.approx(1 / 8)


def test_rare_actions_are_drawn_more_often() -> None:
    found = [clip("walk", 30, i) for i in range(4)] + [clip("throw", 30, 9)]
    for balance, share in ((1.0, 0.8), (0.5, 2 / 3), (0.0, 0.5)):
        windows = Windows(found, config(label_balance=balance))
        assert windows.probability[:8].sum() == pytest.approx(share)
