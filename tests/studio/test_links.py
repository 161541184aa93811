from __future__ import annotations

import pytest

from studio.links import Link, cookie
from studio.state import StudioState


def test_an_address_names_project_take_and_frame():
    query = {"project": [b"6fb8e4c4b851"], "take": [b"3"], "frame": [b"52"]}
    assert Link.parse(query, {}, "lib") == Link("6fb8e4c4b851", "take-3", 52, asked=True)
    assert Link.parse({"take": [b"take-12"]}, {}, "lib").take == "take-12"


def test_an_address_says_what_is_shown_and_is_read_again():
    state = StudioState(project="abc", selected="take-3", compose_tab="sequence", compared=["take-1", "take-12"])
    parts = Link.of_state(state)
    assert parts == {"project": "abc", "take": "3", "frame": "", "tab": "sequence", "compare": "1.12"}
    query = {name: [value.encode()] for name, value in parts.items() if value}
    assert Link.parse(query, {}, "lib") == Link("abc", "take-3", -1, "sequence", ("take-1", "take-12"), asked=True)
    plain = Link.of_state(StudioState(project="abc"))
    assert [name for name, value in plain.items() if value] == ["project"], "what is as usual is left out"


def test_without_one_the_cookie_of_this_library_counts():
    cookies = {cookie("lib"): "abc", cookie("other"): "def"}
    assert Link.parse({}, cookies, "lib") == Link("abc", "", -1)
    assert Link.parse({"project": [b"123"]}, cookies, "lib") == Link("123", "", -1, asked=True)
    assert Link.parse({}, cookies, "") == Link()


@pytest.mark.parametrize(
    "query",
    [
        {"project": [b"../../etc"], "take": [b"-1"], "frame": [b"1e9"]},
        {"project": [b"x" * 400], "take": [b"9" * 50], "frame": [b"\xff"]},
        {"project": [], "take": [b""], "frame": [b"-3"]},
        {"tab": [b"kitchen"], "compare": [b"1..2"]},
        {"tab": [b"text|"], "compare": [b"1,2"]},
    ],
)
def test_what_is_not_understood_is_left_out(query):
    assert Link.parse(query, {}, "lib") == Link()
