"""Parts of speech and kinds of motion words, against sentences tagged by hand."""

from __future__ import annotations

import numpy as np
import pytest

from engines import text
from engines.text import tags
from engines.text.lexicon import base_forms

TAGGED = (
    "A/DET person/NOUN walks/VERB forward/ADV slowly/ADV ./OTHER",
    "someone/PRON takes/VERB two/NUM steps/NOUN back/ADV ,/OTHER then/ADV turns/VERB to/ADP the/DET left/ADJ",
    "the/DET person/NOUN raises/VERB the/DET right/ADJ hand/NOUN and/OTHER lowers/VERB it/PRON",
    "she/PRON throws/VERB a/DET ball/NOUN with/ADP her/PRON left/ADJ arm/NOUN",
    "a/DET man/NOUN is/AUX walking/VERB in/ADP a/DET circle/NOUN",
    "this/DET is/AUX a/DET figure/NOUN running/VERB without/ADP moving/VERB ahead/ADV",
    "they/PRON start/VERB to/OTHER run/VERB very/ADV fast/ADJ",
    "jump/VERB up/ADP and/OTHER down/ADP",
    "he/PRON receives/VERB a/DET strong/ADJ push/NOUN from/ADP a/DET giant/NOUN 's/OTHER child/NOUN",
    "3/NUM quick/ADJ jumps/NOUN in/ADP a/DET childish/ADJ manner/NOUN",
)


def split(sentence: str) -> tuple[list[str], list[str]]:
    pairs = [token.rsplit("/", 1) for token in sentence.split()]
    return [word for word, _ in pairs], [tag for _, tag in pairs]


@pytest.mark.parametrize("sentence", TAGGED)
def test_parts_of_speech(sentence: str) -> None:
    words, expected = split(sentence)
    assert tags.words_of(" ".join(words)) == [word.lower() for word in words]
    assert tags.parts_of_speech([word.lower() for word in words]) == expected


@pytest.mark.parametrize(
    "sentence",
    [
        "a/DET person/NOUN is/AUX walking/action backwards/direction quickly/manner",
        "he/PRON boxes/action with/ADP a/DET heavy/ADJ box/object",
        "someone/PRON bats/action at/ADP a/DET ball/object with/ADP a/DET bat/object",
        "both/DET hands/body_part up/direction",
        "circle/action round/NOUN in/ADP a/DET circle/direction",
        "waves/action",
    ],
)
def test_motion_words_go_before_parts_of_speech(sentence: str) -> None:
    words, expected = split(sentence)
    assert tags.tags(words) == [tag.replace("_", " ") for tag in expected]


def test_base_forms() -> None:
    for form, base in {
        "waves": "wave", "hopping": "hop", "tries": "try", "ran": "run", "pushes": "push", "swung": "swing",
        "lying": "lie", "clapped": "clap", "feet": "foot", "rolling": "roll", "raised": "raise", "kisses": "kiss",
    }.items():  # fmt: skip
        assert base in base_forms(form)
    assert base_forms("walk")[0] == "walk"


def test_pieces_have_the_tag_of_their_word() -> None:
    pieces = ["a", "person", "jo", "##gs", "counter", "##clock", "##wise", "."]
    found = [tags.TAGS[place] for place in tags.tags_of_pieces(pieces)]
    assert found == ["DET", "NOUN", "action", "action", "direction", "direction", "direction", "OTHER"]
    sentence = "A person pirouettes counterclockwise!"
    (pieces,) = text.load().pieces([sentence])
    assert len(tags.tags_of_pieces(pieces)) == len(pieces)


def test_sides_are_told_apart() -> None:
    pieces = ["left", "hand", "##s", "right", "##wards", "counter", "-", "clockwise", "clockwise", "counter", "##clock",
              "##wise", "both", "back", "ahead"]  # fmt: skip
    assert tags.sides_of_pieces(pieces) == [0, -1, -1, 1, 1, -1, -1, 6, 5, 6, 6, 6, 2, 4, 3]


def test_whatever_is_typed_has_a_tag() -> None:
    for typed in ("", "?!", "œuvre naïve 12th", "x" * 500, "'s", "’s", "a-b"):
        found = tags.words_of(typed)
        assert len(tags.tags(found)) == len(found)
        assert set(tags.tags(found)) <= set(tags.TAGS)


def test_the_release_matches_words_as_they_are() -> None:
    assert tags.TAGS[tags.released_tag("walk", "NOUN", known=True)] == "action"
    assert tags.TAGS[tags.released_tag("walks", "VERB", known=True)] == "VERB"
    assert tags.TAGS[tags.released_tag("walk", "VERB", known=False)] == "OTHER"
    assert tags.TAGS[tags.released_tag("and", "CCONJ", known=True)] == "OTHER"
    made = tags.one_hot(np.array([[0, 14]]))
    assert made.shape == (1, 2, 15)
    assert made[0, 0, 0] == made[0, 1, 14] == made.sum() / 2 == 1
