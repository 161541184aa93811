"""What axe-core finds in the page: nothing that it calls serious or critical, in any tab, in either colours."""

from __future__ import annotations

from importlib.resources import files

import pytest
from playwright.sync_api import Page, expect

from tests.ui.conftest import Tab

AXE = files("axe_playwright_python").joinpath("axe.min.js").read_text(encoding="utf-8")
GRAVE = ("serious", "critical")
OPEN = (
    ("Action", "Details"), ("Text", "Body"), ("Sequence", "Details"), ("Vary", "Export"), ("Character", "Details"),
    ("Import", "Details"),
)  # fmt: skip
"""Tabs of the left and of the right panel that are looked at together: each at least once."""


def grave(page: Page, where: str) -> list[str]:
    """What axe-core finds in the page as it is, a line an element."""
    found = page.evaluate("() => axe.run(document, {resultTypes: ['violations']})")["violations"]
    lines = []
    for rule in found:
        if rule["impact"] in GRAVE:
            lines += [f"{where}: {rule['id']}: {_last(node['target'])}: {_why(node)}" for node in rule["nodes"]]
    return lines


def _last(target: list) -> str:
    """The element itself, without the shadow trees it is in."""
    inner = target[-1]
    return inner[-1] if isinstance(inner, list) else inner


def _why(node: dict) -> str:
    return node["failureSummary"].split("\n")[1].strip()


@pytest.mark.parametrize("theme", ["dark", "light"])
def test_axe_finds_nothing_grave(context, address, theme):
    context.add_init_script(f"localStorage.setItem('motionloom-theme', '{theme}')")
    tab = Tab(context.new_page(), address).open()
    page = tab.page
    page.evaluate(AXE)
    found = []
    for left, right in OPEN:
        for name in (left, right):
            page.get_by_role("tab", name=name, exact=True).click()
            expect(page.get_by_role("tab", name=name, exact=True)).to_have_attribute("aria-selected", "true")
        if left == "Sequence":
            for action in ("walk", "bow"):
                page.get_by_role("option", name=action, exact=True).click()
            page.get_by_role("button", name="Block 2 of 2: bow").wait_for()
        found += grave(page, f"{left}, {right}")
    page.get_by_role("button", name="Projects", exact=False).first.click()
    page.get_by_role("dialog").wait_for()
    found += grave(page, "projects")
    page.keyboard.press("Escape")
    page.locator("main").focus()
    page.keyboard.press("?")
    page.get_by_role("dialog", name="Help").wait_for()
    found += grave(page, "help")
    assert page.locator("html").get_attribute("data-theme") == theme
    assert found == [], "\n".join(found)


def test_axe_is_able_to_find_something(context):
    page = context.new_page()
    page.set_content("<html lang='en'><title>t</title><button></button><p style='color: #ccc'>pale</p></html>")
    page.evaluate(AXE)
    assert sorted(line.split(": ")[1] for line in grave(page, "")) == ["button-name", "color-contrast"]
