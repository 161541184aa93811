"""The tab Style in Chromium, with a quick stand-in for the engine that puts takes in other manners."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import BrowserContext, Locator, expect

from tests.studio.fakes import sway
from tests.ui.conftest import Tab, wait_for
from tests.ui.test_accessibility import AXE, grave
from tests.ui.test_vary import card, names

ARM = "player.actors.map(a => a.pose.places[20 * 3 + 1])"
"""Height of a wrist of each figure on the stage."""


@pytest.fixture
def styling(context: BrowserContext, constrained_address: str) -> Iterator[Tab]:
    made = Tab(context.new_page(), constrained_address).open()
    made.page.evaluate(AXE)
    yield made
    assert made.faults == []
    assert made.foreign == []


def test_a_take_is_put_in_a_style_like_a_clip_and_off_the_map(styling, tmp_path):
    by_name(styling)
    with_less_strength(styling)
    like_a_clip(styling, tmp_path)
    off_the_map(styling)
    what_cannot_be_is_said(styling, tmp_path)


def go(tab: Tab, take: int) -> Locator:
    return tab.page.get_by_role("button", name=f"Stylise take {take}")


def chosen(tab: Tab, label: str, take: int) -> None:
    expect(tab.page.get_by_label(label, exact=True)).to_have_value(re.compile(f"^Take {take} "))


def by_name(tab: Tab) -> None:
    """From a take to the tab, and a style from the gallery, with keys alone; before and after beside each other."""
    page = tab.page
    card(tab, 2).focus()
    page.keyboard.press("y")
    expect(page.get_by_role("tab", name="Style", exact=True)).to_have_attribute("aria-selected", "true")
    chosen(tab, "Take", 2)
    expect(go(tab, 2)).to_be_disabled()
    page.get_by_role("option", name="happy").focus()
    page.keyboard.press("ArrowRight")
    page.keyboard.press("Enter")
    expect(page.get_by_role("option", name="old")).to_have_attribute("aria-selected", "true")
    assert grave(page, "by name") == []
    page.keyboard.press("Control+Enter")
    tab.takes(5)
    wait_for(lambda: names(tab) == ["Take 2", "Take 5"], "the take and what came of it")
    expect(page.get_by_role("button", name=re.compile("^Take 5, walk, old"))).to_be_visible()
    changes = page.get_by_role("group", name="Changes to Take 5")
    expect(changes.get_by_role("button", name="Foot clean-up")).to_have_attribute("aria-pressed", "true")
    before, after = tab.player(ARM)
    assert after - before > 0.1


def with_less_strength(tab: Tab) -> None:
    page = tab.page
    page.get_by_role("slider").first.focus()
    page.keyboard.press("Home")
    expect(page.get_by_text("old × 0", exact=False).first).to_be_visible()
    page.get_by_label("Foot clean-up", exact=True).uncheck()
    go(tab, 2).click()
    tab.takes(6)
    wait_for(lambda: names(tab) == ["Take 2", "Take 6"], "the take beside what came of no strength")
    tab.player("player.seek(0)")
    before, after = tab.player(ARM)
    assert after == pytest.approx(before, abs=1e-3)


def like_a_clip(tab: Tab, folder: Path) -> None:
    page = tab.page
    page.get_by_role("radio", name="Clip").click()
    page.get_by_label("Reference clip").set_input_files(sway("wave", frames=50).write(folder / "wave.bvh"))
    tab.takes(7)
    chosen(tab, "As in", 7)
    chosen(tab, "Take", 2)
    go(tab, 2).click()
    tab.takes(8)
    expect(page.get_by_role("button", name=re.compile("^Take 8, walk, as in take 7"))).to_be_visible()


def off_the_map(tab: Tab) -> None:
    page = tab.page
    page.get_by_role("radio", name="Map").click()
    page.get_by_role("button", name="Draw the map of “take 2”").click()
    themap = page.get_by_role("application", name="Map of take 2")
    expect(themap.locator(".dot")).to_have_count(6)
    themap.locator(".dot").first.click(force=True)
    wait_for(lambda: names(tab) == ["Take 2", "Happy"], "the style that was pressed, beside the take")
    assert grave(page, "map") == []
    page.keyboard.press("Enter")
    tab.takes(9)
    wait_for(lambda: names(tab) == ["Take 2", "Take 9"], "it to be kept")
    expect(page.get_by_role("button", name=re.compile("^Take 9, walk, happy"))).to_be_visible()


def what_cannot_be_is_said(tab: Tab, folder: Path) -> None:
    page = tab.page
    page.get_by_role("radio", name="Clip").click()
    page.get_by_label("Reference clip").set_input_files(sway(frames=3).write(folder / "short.bvh"))
    tab.takes(10)
    page.get_by_role("radio", name="Surprise").click()
    page.get_by_label("Take", exact=True).select_option(label="Take 10 · short.bvh")
    go(tab, 10).click()
    expect(page.get_by_role("alert").filter(has_text="8 to 18,000")).to_be_visible()
    tab.takes(10)
