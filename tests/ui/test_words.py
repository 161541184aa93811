"""What takes show in words, in Chromium with a quick stand-in for the engine."""

from __future__ import annotations

import re

from playwright.sync_api import BrowserContext, expect

from tests.ui.conftest import Tab


def test_takes_are_said_in_words_and_how_well_they_meet_their_prompt(context: BrowserContext, constrained_address: str):
    tab = Tab(context.new_page(), constrained_address).open()
    page = tab.page
    expect(page.get_by_role("button", name=re.compile("^Take 1, walk, shows: A person sways"))).to_be_visible()
    page.get_by_role("tab", name="Text").click()
    page.get_by_label("Describe the motion").fill("a person sways")
    page.get_by_role("button", name=re.compile("^Generate")).click()
    tab.takes(8)
    met = re.compile(r"^Take 5, a person sways, shows: A person sways, .*Fits the prompt -?0\.\d\d")
    expect(page.get_by_role("button", name=met)).to_be_visible()
    details = page.get_by_role("region", name="Inspector")
    expect(details.get_by_text("A person sways.", exact=True)).to_be_visible()
    expect(details.get_by_text("Caption fits")).to_be_visible()
    assert tab.faults == []
