"""The action vocabulary holds together, and with the data sets."""

from __future__ import annotations

import pytest

from engines import actions
from engines.datasets import bandai_namco, cmu, utd_mhad
from engines.errors import UnknownLabelError
from engines.geometry.mirror import mirror_words

NAMES = [action.name for action in actions.VOCABULARY]
GROUPS = {"locomotion", "gestures", "sports", "everyday", "dance and play"}


def test_names_are_unique_plain_and_described() -> None:
    assert len(set(NAMES)) == len(NAMES) >= 50
    for action in actions.VOCABULARY:
        assert action.name == " ".join(action.name.lower().split())
        assert action.description.startswith("A person ")
        assert action.description.endswith(".")
        assert action.group in GROUPS


def test_get_forgives_case_and_blanks() -> None:
    assert actions.get("  Wave  LEFT hand ").name == "wave left hand"
    with pytest.raises(UnknownLabelError, match="did you mean 'walk'"):
        actions.get("walkk")


def test_the_mirror_of_an_action_is_an_action() -> None:
    for action in actions.VOCABULARY:
        if action.mirrors:
            assert mirror_words(action.name) in NAMES
            assert actions.get(mirror_words(action.name)).mirrors
            if action.name != mirror_words(action.name):
                assert mirror_words(action.description) == actions.get(mirror_words(action.name)).description


def test_right_armed_actions_do_not_mirror() -> None:
    """Their name does not say the arm, so a mirrored one would be a wrong example of it."""
    for name in ("throw", "bowling", "tennis swing", "swipe left", "draw x", "draw circle clockwise"):
        assert not actions.get(name).mirrors


def test_what_goes_on() -> None:
    assert actions.get("walk").repeats
    assert actions.get("wave left hand").repeats
    assert not actions.get("clap").repeats
    assert not actions.get("jump").repeats
    assert not actions.get("sit down").repeats
    assert set(NAMES) >= actions._GO_ON


def test_every_label_of_every_corpus_is_in_the_vocabulary() -> None:
    found = {*bandai_namco._CONTENTS.values(), *utd_mhad._ACTIONS, *(action for _, action in cmu._RULES if action)}
    assert found <= set(NAMES)
    assert set(NAMES) <= found, "an action that no clip shows cannot be learnt"


@pytest.mark.parametrize(
    ("description", "action"),
    [
        ("playground - forward jumps, turn around", "jump"),
        ("walk on uneven terrain", "walk on rough ground"),
        ("dance - cartwheel-like start", "dance"),
        ("cartwheels", "cartwheel"),
        ("run/jog", "run"),
        ("navigate - walk forward, backward, sideways", None),
        ("slow walk/stride", "walk"),
        ("salsa", None),
    ],
)
def test_cmu_descriptions(description: str, action: str | None) -> None:
    assert cmu._action(description) == action
