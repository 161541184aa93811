"""Everyday sentences: all there, each for one action only, none that names a wrong side."""

from __future__ import annotations

import json
import re
from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path

import pytest

import engines
from engines.actions import VOCABULARY
from engines.datasets.captions.styles import STYLES
from engines.text.everyday import EVERYDAY, EVERYDAY_STYLES

NAMES = [action.name for action in VOCABULARY]
TWINS = [{"childish", "childlike"}, {"elderly", "old"}]


def sides(text: str) -> set[str]:
    """The sides and senses of rotation a text names."""
    words = re.sub(r"anti-?clockwise", "counterclockwise", text.lower())
    words = words.replace("left-handed", "left").replace("lefty", "left").replace("right-handed", "right")
    found = set(re.findall(r"\b(left|right|both|clockwise|counterclockwise)\b", words))
    return found | ({"both"} if re.search(r"\btwo(-handed| hands| arms)\b", words) else set())


def owners(texts: Mapping[str, tuple[str, ...]]) -> dict[str, list[str]]:
    """Which names each text stands under, case, punctuation and blanks aside."""
    found: dict[str, list[str]] = defaultdict(list)
    for name, lines in texts.items():
        for line in lines:
            found[" ".join(re.findall(r"\w+", line.casefold()))].append(name)
    return found


def test_every_action_has_its_sentences() -> None:
    assert sorted(EVERYDAY) == sorted(NAMES)
    assert {name: len(lines) for name, lines in EVERYDAY.items() if not 24 <= len(lines) <= 30} == {}


def test_every_style_has_its_phrases() -> None:
    card = json.loads((Path(engines.__file__).parent / "weights" / "loom.json").read_text(encoding="utf-8"))
    assert set(EVERYDAY_STYLES) == set(STYLES) | set(card["styles"])
    assert {name: len(lines) for name, lines in EVERYDAY_STYLES.items() if not 10 <= len(lines) <= 14} == {}


def test_sentences_are_short_and_clean() -> None:
    lines = [line for texts in (EVERYDAY, EVERYDAY_STYLES) for each in texts.values() for line in each]
    assert [line for line in lines if "\n" in line or "  " in line or not 1 <= len(line.split()) <= 14] == []


def test_no_sentence_stands_under_two_actions() -> None:
    assert {line: names for line, names in owners(EVERYDAY).items() if len(names) > 1} == {}


def test_phrases_of_styles_are_shared_by_twins_only() -> None:
    shared = {line: names for line, names in owners(EVERYDAY_STYLES).items() if len(names) > 1}
    assert {line: names for line, names in shared.items() if set(names) not in TWINS or len(names) > 2} == {}


@pytest.mark.parametrize("name", [name for name in NAMES if sides(name)])
def test_a_sided_action_names_its_side_and_no_other(name: str) -> None:
    assert [line for line in EVERYDAY[name] if sides(line) != sides(name)] == []


def test_an_unsided_action_favours_no_side() -> None:
    loose = [line for name in NAMES if not sides(name) for line in EVERYDAY[name]]
    assert [line for line in loose if len(sides(line) & {"left", "right"}) == 1] == []


def test_sentences_of_mirrored_actions_are_not_one_list_with_the_sides_exchanged() -> None:
    for name in NAMES:
        if "left" in name:
            turned = {line.replace("left", "right") for line in EVERYDAY[name]}
            assert turned != set(EVERYDAY[name.replace("left", "right")])
