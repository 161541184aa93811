"""Blocks arranged in the player: what the pointer and the keyboard do to them, and what is reported."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import expect

from tests.viewers.web.conftest import PlayerPage
from tests.viewers.web.synthetic import walk

Open = Callable[..., PlayerPage]


def block(key: str, what: str, seconds: float = 2.0, **more: Any) -> dict[str, Any]:
    usual = {"kind": "action", "style": "", "seed": 7, "transition": 0.5, "locked": False, "engine": "", "made": True}
    return {"id": key, "what": what, "seconds": seconds, **usual, **more}


THREE = [block("1", "walk"), block("2", "bow", 3.0, locked=True), block("3", "wave", made=False)]
KNOWN = {"actions": ["walk", "bow", "wave"], "styles": ["proud"], "engines": ["one"], "words": True, "error": ""}


class Arranged:
    """A player with blocks, and what it reported of them."""

    def __init__(self, player: PlayerPage, blocks: list[dict[str, Any]]) -> None:
        self.player, self.page = player, player.page
        player.js("(window.told = [], model.on('change:arranged', () => window.told.push(model.get('arranged'))))")
        self.heard = 0
        self.show(blocks)

    def show(self, blocks: list[dict[str, Any]], **more: Any) -> None:
        self.heard += 1
        self.player.set("sequence", {**KNOWN, "blocks": blocks, "heard": self.heard, **more})

    def told(self) -> list[dict[str, Any]]:
        """What was reported since it was asked last."""
        said = self.player.js("window.told.splice(0)")
        return [{name: value for name, value in one.items() if name != "time"} for one in said]

    def block(self, what: str) -> Any:
        return self.page.get_by_role("button", name=re.compile(rf"^Block \d+ of \d+: {what},"))

    def drag(self, target: Any, dx: float, at: float = 0.5, *, drop: bool = True) -> None:
        """Press at a share of an element's width, move, and let go."""
        box = target.bounding_box()
        x, y = box["x"] + box["width"] * at, box["y"] + box["height"] / 2
        self.page.mouse.move(x, y)
        self.page.mouse.down()
        for step in range(1, 5):
            self.page.mouse.move(x + dx * step / 4, y)
        if drop:
            self.page.mouse.up()


@pytest.fixture
def arranged(open_player: Open) -> Arranged:
    return Arranged(open_player(walk(8.0)), THREE)


def scale(arranged: Arranged) -> float:
    """Pixels a second."""
    return arranged.block("walk").bounding_box()["width"] / 2.0


def test_blocks_take_the_place_of_the_timeline_and_are_dragged(arranged: Arranged):
    page = arranged.page
    expect(page.get_by_role("group", name="Timeline")).to_be_hidden()
    expect(arranged.block("bow")).to_have_attribute("aria-label", "Block 2 of 3: bow, 3 seconds, locked")
    expect(arranged.block("wave")).to_have_attribute("aria-label", "Block 3 of 3: wave, 2 seconds, not made yet")
    second = scale(arranged)
    arranged.drag(arranged.block("walk"), 1.07 * second, at=0.99)
    (trimmed,) = arranged.told()
    assert (trimmed["do"], trimmed["id"]) == ("change", "1")
    assert trimmed["values"]["seconds"] == pytest.approx(3.0), "the edge catches at the ruler's ticks"
    arranged.show(THREE)
    arranged.drag(arranged.block("wave"), -7 * second)
    assert arranged.told() == [{"do": "move", "id": "3", "to": 0}]
    arranged.show([THREE[2], *THREE[:2]])
    gap = page.get_by_role("slider", name="Transition to walk, seconds")
    arranged.drag(gap, 0.5 * second)
    (longer,) = arranged.told()
    assert longer["values"]["transition"] == pytest.approx(1.0, abs=0.11)
    arranged.drag(arranged.block("walk"), 3 * second, drop=False)
    arranged.player.press("Escape")
    page.mouse.up()
    assert arranged.told() == [], "a drag that was called off"
    page.evaluate(
        """() => {
            const view = document.querySelector('.motion-player').shadowRoot.querySelector('.seq-view');
            const box = view.getBoundingClientRect(), carried = new DataTransfer();
            carried.setData('application/x-motionloom-block', '{"what": "jump"}');
            const at = { dataTransfer: carried, clientX: box.right - 5, clientY: box.top + 40 };
            for (const name of ['dragover', 'drop']) view.dispatchEvent(new DragEvent(name, at));
        }"""
    )
    assert arranged.told() == [{"do": "add", "what": "jump", "at": 3}]


def test_the_keyboard_does_it_all(arranged: Arranged):
    player, page = arranged.player, arranged.page
    arranged.block("walk").focus()
    player.press("ArrowRight")
    assert player.get("block") == "2"
    expect(arranged.block("bow")).to_be_focused()
    player.press("Delete", "s", "r", "Shift+ArrowRight", "l", "d")
    assert [(one["do"], one["id"]) for one in arranged.told()] == [("move", "2"), ("lock", "2"), ("duplicate", "2")]
    player.press("End", "Alt+ArrowRight", "Alt+Shift+ArrowLeft", "Delete", "r")
    told = arranged.told()
    assert [one.get("values", one["do"]) for one in told] == [{"seconds": 2.1}, {"seconds": 1.0}, "remove", "renew"]
    assert {one["id"] for one in told} == {"3"}
    player.js("player.seek(Math.round(6.5 * player.clock.fps))")
    player.press("s")
    assert arranged.told() == [{"do": "split", "id": "3", "after": pytest.approx(0.5)}], "at the playhead"
    player.press("Enter")
    editor = page.get_by_role("dialog", name="Block")
    field = editor.get_by_label("Shows")
    expect(field).to_be_focused()
    field.fill("a person waves")
    field.press("Tab")
    editor.get_by_label("Kind").select_option("prompt")
    editor.get_by_label("Seconds").fill("0")
    editor.get_by_label("Seconds").press("Tab")
    expect(editor.get_by_label("Seconds")).to_have_value("2"), "what is not accepted is put back"
    player.press("Escape")
    expect(editor).to_be_hidden()
    expect(arranged.block("wave")).to_be_focused()
    assert [one["values"] for one in arranged.told()] == [{"what": "a person waves"}, {"kind": "prompt"}]
    arranged.block("wave").click(button="right")
    menu = page.get_by_role("menu", name="Block")
    expect(menu.get_by_role("menuitem")).to_have_count(6)
    menu.get_by_role("menuitem", name="Duplicate").click()
    assert arranged.told() == [{"do": "duplicate", "id": "3"}]


def test_ten_minutes_of_blocks_are_a_few_elements(arranged: Arranged):
    player = arranged.player
    count = "root.querySelectorAll('.track .block').length"
    overview = "root.querySelector('.seq-overview').style.visibility"
    arranged.show([block(str(i), f"action {i % 20}", 0.9, transition=0.3) for i in range(500)])
    assert player.js(count) == 0, "thinner than can be taken hold of: painted"
    assert player.js(overview) == "hidden", "all is in view"
    ruler = arranged.page.get_by_role("slider", name="Scrub")
    ruler.hover()
    for _ in range(9):
        arranged.page.mouse.wheel(0, -400)
    assert 0 < player.js(count) < 60
    assert player.js(overview) == ""
    arranged.page.locator(".track .block").first.focus()
    player.press("End")
    assert player.get("block") == "499"
    expect(arranged.page.get_by_role("button", name=re.compile("^Block 500 of 500"))).to_be_focused()
    assert player.js(count) < 60
    arranged.page.get_by_role("button", name="Fit").click()
    assert player.js(overview) == "hidden", "all is in view"
    arranged.show([], error="Block 2 is locked.")
    expect(arranged.page.get_by_text("Block 2 is locked.")).to_be_visible()
    expect(arranged.page.get_by_text("Drag an action here")).to_be_visible()
    player.set("sequence", {})
    expect(arranged.page.get_by_role("group", name="Timeline")).to_be_visible()
