from __future__ import annotations

import pytest

from studio.links import Link, cookie


def test_an_address_names_project_take_and_frame():
    query = {"project": [b"6fb8e4c4b851"], "take": [b"3"], "frame": [b"52"]}
    assert Link.parse(query, {}, "lib") == Link("6fb8e4c4b851", "take-3", 52, True)
    assert Link.parse({"take": [b"take-12"]}, {}, "lib").take == "take-12"


def test_without_one_the_cookie_of_this_library_counts():
    cookies = {cookie("lib"): "abc", cookie("other"): "def"}
    assert Link.parse({}, cookies, "lib") == Link("abc", "", -1, False)
    assert Link.parse({"project": [b"123"]}, cookies, "lib") == Link("123", "", -1, True)
    assert Link.parse({}, cookies, "") == Link()


@pytest.mark.parametrize(
    "query",
    [
        {"project": [b"../../etc"], "take": [b"-1"], "frame": [b"1e9"]},
        {"project": [b"x" * 400], "take": [b"9" * 50], "frame": [b"\xff"]},
        {"project": [], "take": [b""], "frame": [b"-3"]},
    ],
)
def test_what_is_not_understood_is_left_out(query):
    assert Link.parse(query, {}, "lib") == Link()
