"""Under the timeline: the words each moment came from, and tokens with their figures; a press goes there."""

from __future__ import annotations

import pytest

from tests.viewers.web.synthetic import walk

pytestmark = pytest.mark.ui

FRAMES = [[50, 0, 50, 50, 50, 90]] * 4
STRIPS = {
    "words": {
        "text": ["walk", "left"], "seconds": 0.2,
        "weights": [[0.9, 0.1], [0.9, 0.1], [0.2, 0.8], [0.1, 0.9], [0.5, 0.5]],
    },
    "tokens": {
        "codes": [7, 3, 7, 3, 3], "seconds": 0.2, "all": 12,
        "figures": {"parents": [-1, 0, 1], "head": 2, "points": {"7": FRAMES, "3": FRAMES}},
    },
}  # fmt: skip
SHOWN = "[...root.querySelectorAll('.strip')].filter((one) => !one.hidden).map((one) => one.className)"


@pytest.fixture
def strips(open_player):
    player = open_player(walk(1.0), playing=False)
    player.set("strips", STRIPS)
    return player


def press(player, selector: str, share: float) -> None:
    """Press so far along an element."""
    box = player.page.locator(selector).bounding_box()
    player.page.mouse.click(box["x"] + share * box["width"], box["y"] + box["height"] / 2)


def test_without_any_nothing_is_there(open_player):
    player = open_player(walk(1.0))
    assert player.js(SHOWN) == []


def test_words_are_open_and_a_press_goes_to_their_moment(strips):
    assert strips.js(SHOWN) == ["strip words", "strip tokens"]
    assert "left most at 0.6 s" in strips.js("root.querySelector('.heat canvas').getAttribute('aria-label')")
    press(strips, ".heat canvas", 0.5)
    assert strips.frame == 8
    strips.pictures(1)
    assert strips.js("root.querySelector('.said .heard').textContent") == "left"
    assert strips.js("root.querySelector('.heat canvas').title").startswith("0.4 s: ")


def test_the_heat_is_where_the_weights_are(strips):
    walks, turns = strips.js(
        """((c) => {
            const { data } = c.getContext('2d').getImageData(0, 0, c.width, c.height);
            const alpha = (x, y) => data[4 * (Math.floor(y * c.height) * c.width + Math.floor(x * c.width)) + 3];
            return [0.25, 0.75].map((y) => [0.15, 0.7].map((x) => alpha(x, y)));
        })(root.querySelector('.heat canvas'))"""
    )
    assert walks[0] > 200 < turns[1]
    assert walks[1] < 100 > turns[0]


def test_tokens_open_and_a_figure_goes_to_where_its_token_comes_next(strips):
    assert strips.js("root.querySelector('.tokens .fold-body').hidden")
    strips.page.get_by_role("button", name="Motion tokens").click()
    assert strips.get("open_strips") == "words,tokens"
    figures = strips.page.get_by_role("group", name="What each token looks like").get_by_role("button")
    assert figures.count() == 3  # two, and the one for all
    seven = strips.page.get_by_role("button", name="Token 7, 2 × from 0.0 s")
    seven.click()
    assert strips.frame == 8
    seven.click()
    assert strips.frame == 0
    press(strips, ".codes", 0.3)
    strips.pictures(1)
    assert strips.frame == 4
    assert strips.js("root.querySelector('.figure.on').dataset.code") == "3"
    drawn = (
        "((c) => c.getContext('2d').getImageData(0, 0, c.width, c.height).data.some(Boolean))"
        "(root.querySelector('.figure canvas'))"
    )
    assert strips.js(drawn)
    strips.page.get_by_role("button", name="All 12").click()
    assert strips.get("open_strips") == "words,tokens,all"


def test_what_is_offered_is_asked_for_by_opening_it(open_player):
    player = open_player(walk(1.0))
    player.set("strips", {"tokens": {}})
    assert player.js(SHOWN) == ["strip tokens"]
    player.page.get_by_role("button", name="Motion tokens").click()
    assert player.js("root.querySelector('.tokens .fold-body').textContent") == "…"
    player.set("strips", STRIPS)
    assert player.js("root.querySelectorAll('.figure').length") == 2
    player.set("strips", {})
    assert player.js(SHOWN) == []
