"""The tab Character in Chromium: a rendered picture is looked at, corrected, made a body and worn."""

from __future__ import annotations

import pytest
from PIL import Image
from playwright.sync_api import Locator, expect

from tests.engines.character.people import arms_down, needs_networks, photographed
from tests.ui.conftest import Tab, wait_for
from tests.ui.test_accessibility import AXE, grave

WIDEST = "Math.max(...player.actors[0].solid.geometry.attributes.position.array.filter((_, i) => i % 3 === 0))"
"""Of the body that the browser has, in its rest pose, metres to the side."""


@pytest.fixture
def studio(context, constrained_address):
    made = Tab(context.new_page(), constrained_address).open()
    made.page.evaluate(AXE)
    made.page.get_by_role("tab", name="Character", exact=True).click()
    yield made
    assert made.faults == []
    assert made.foreign == []


@needs_networks
def test_a_picture_is_dropped_corrected_made_worn_renamed_and_deleted(studio, tmp_path):
    what_is_no_picture_is_refused(studio, tmp_path)
    corrected(studio, tmp_path)
    worn(studio)
    kept(studio)


def what_is_no_picture_is_refused(tab: Tab, folder) -> None:
    (folder / "cat.jpg").write_bytes(b"meow")
    tab.page.get_by_label("Picture or mesh").set_input_files(folder / "cat.jpg")
    expect(tab.page.get_by_role("alert").filter(has_text="cat.jpg: is no picture")).to_be_visible()


def corrected(tab: Tab, folder) -> None:
    """A joint by the keyboard and by the mouse, the silhouette with the brush; taken back by key and button."""
    page = tab.page
    Image.fromarray(photographed(arms_down()).pixels).save(folder / "ada.jpg")
    page.get_by_label("Picture or mesh").set_input_files(folder / "ada.jpg")
    wrist, undo = (
        tab.button("Left wrist"),
        page.get_by_role("region", name="Who is seen").get_by_role("button", name="Undo"),
    )
    expect(undo).to_be_disabled()
    start = left(wrist)
    wrist.focus()
    page.keyboard.press("Shift+ArrowRight")
    expect(undo).to_be_enabled()
    assert left(wrist) == pytest.approx(start + 10, abs=1.5)
    page.keyboard.press("Control+z")
    expect(undo).to_be_disabled()
    assert left(wrist) == pytest.approx(start, abs=1.5)
    page.get_by_role("radio", name="Paint").click()
    box = page.locator(".sheet.painting").bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + 20, box["y"] + 20)
    page.mouse.down()
    page.mouse.move(box["x"] + 50, box["y"] + 30)
    page.mouse.up()
    expect(undo).to_be_enabled()
    assert grave(page, "portrait") == []
    undo.click()
    expect(undo).to_be_disabled()
    page.get_by_role("radio", name="Move joints").click()
    wrist.hover()
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] - 4, box["y"] + 80)
    page.mouse.up()
    expect(undo).to_be_enabled()
    assert left(wrist) == pytest.approx(box["x"] + box["width"] - 4, abs=2)


def worn(tab: Tab) -> None:
    """The takes wear what was made of the joint as it was dragged; undo takes it off."""
    before = tab.player(WIDEST)
    assert isinstance(before, float)
    tab.page.get_by_role("button", name="Make the character").click()
    wait_for(lambda: tab.player(WIDEST) < 0.9 * before, "the character on the stage")
    expect(tab.button("ada")).to_have_attribute("aria-pressed", "true")
    tab.page.get_by_role("tab", name="Body", exact=True).click()
    expect(tab.page.get_by_label("Body of this project")).to_have_value("character:ada")


def kept(tab: Tab) -> None:
    page = tab.page
    tab.button("Rename ada").click()
    page.get_by_label("New name of ada").fill("Ada L")
    page.keyboard.press("Enter")
    expect(tab.button("Ada L")).to_have_attribute("aria-pressed", "true")
    tab.button("Delete Ada L").click()
    page.get_by_role("button", name="Delete", exact=True).click()
    expect(tab.button("Ada L")).to_have_count(0)
    expect(page.get_by_label("Body of this project")).to_have_value("anny")


def left(dot: Locator) -> float:
    """The middle of a dot, pixels of the page."""
    box = dot.bounding_box()
    assert box is not None
    return box["x"] + box["width"] / 2
