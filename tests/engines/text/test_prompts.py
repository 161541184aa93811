"""What people type: read, refused with a reason, or told what is not known."""

from __future__ import annotations

import pytest

from engines.errors import MotionloomError, OutOfRangeError
from engines.text.prompts import PromptCheck, tidy
from engines.text.words import Words
from tests.engines.tm2t.tiny import FakeEncoder

WORDS = Words(("person", "walks", "waving", "hop", "tries", "jete", "left", "hand", "the", "a", ".", "dance"))


def unknown(prompt: str) -> list[str]:
    return [word for word, _ in PromptCheck(WORDS, FakeEncoder()).read(prompt).unknown]


@pytest.mark.parametrize(("prompt", "says"), [
    ("", "empty"), ("  \n\t ", "empty"), ("1234 !!", "no word"), ("歩く", "歩"), ("человек идёт", "cyrillic"),
    ("walk 🙂", "slightly smiling face"), ("walk\x00home", "control character"),
    ("walk\u202ehome", "control character"), ("يمشي", "arabic"),
])  # fmt: skip
def test_what_cannot_be_read_is_refused(prompt: str, says: str) -> None:
    with pytest.raises(MotionloomError, match=says) as caught:
        tidy(prompt)
    assert "accepted" in str(caught.value)
    assert len(str(caught.value)) < 400


def test_a_book_is_refused() -> None:
    with pytest.raises(OutOfRangeError, match="10000"):
        tidy("walk " * 2000)
    assert tidy("walk " * 200) == ("walk " * 200).strip()


def test_ten_thousand_odd_characters_are_not_all_named() -> None:
    with pytest.raises(MotionloomError, match="and 15 more"):
        tidy("".join(chr(0x4E00 + place) for place in range(20)))


def test_white_space_and_quotation_marks_are_put_right() -> None:
    assert tidy("  A\tperson’s \n “walk” — slow ") == 'A person\'s "walk" - slow'


@pytest.mark.parametrize(
    "prompt", ["A person walks.", "walk", "walked, walking", "she waves", "hopping", "He tried", "a jeté", "dances"]
)
def test_forms_of_known_words_are_known(prompt: str) -> None:
    assert unknown(prompt) == []


def test_unknown_words_come_with_the_nearest() -> None:
    reading = PromptCheck(WORDS, FakeEncoder()).read("A persn gallops with the left hand")
    assert [word for word, _ in reading.unknown] == ["persn", "gallops"]
    nearest = dict(reading.unknown)
    assert nearest["persn"][0] == "person"
    assert len(nearest["gallops"]) == 3
    assert "gallops" in reading.notes()[1]
    assert PromptCheck(Words(()), FakeEncoder()).read("gallop").unknown == ()
