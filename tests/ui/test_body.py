"""The tab Body, with the keyboard and with the mouse, from the slider to the file."""

from __future__ import annotations

import pytest
import trimesh
from playwright.sync_api import expect

from tests.ui.conftest import Tab, wait_for
from tests.ui.test_studio import download

HIGHEST = "Math.max(...player.actors[0].solid.geometry.attributes.position.array.filter((_, i) => i % 3 === 1))"
"""Of the body that the browser has, in its rest pose, metres."""


@pytest.fixture
def wardrobe(context, constrained_address):
    made = Tab(context.new_page(), constrained_address).open()
    made.page.get_by_role("tab", name="Body").click()
    yield made
    assert made.faults == []


def test_the_body_is_shaped_seen_exported_and_undone(wardrobe, tmp_path):
    page, keys = wardrobe.page, wardrobe.page.keyboard
    before = wardrobe.player(HIGHEST)
    page.get_by_role("slider", name="Height").first.focus()
    keys.press("End")
    expect(wardrobe.button("Undo change height")).to_be_enabled()
    wait_for(lambda: wardrobe.player(HIGHEST) > before + 0.1, "a taller body on the stage")
    page.get_by_role("tab", name="Export").click()
    expect(page.get_by_role("slider", name="Height").first).to_be_hidden()
    page.get_by_role("radio", name="GLB").click()
    tall = download(wardrobe, lambda: page.get_by_role("button", name="Export take 1 as GLB").click())
    tall.save_as(tmp_path / "tall.glb")
    assert trimesh.load(tmp_path / "tall.glb").extents[1] > 1.85
    page.reload()
    wardrobe.takes(4)
    wait_for(lambda: wardrobe.player(HIGHEST) > before + 0.1, "the same body when the page is opened again")
    page.get_by_role("tab", name="Body").click()
    expect(page.get_by_role("slider", name="Height").first).to_have_value("0.8")
    keys.press("Control+z")
    expect(page.get_by_role("slider", name="Height").first).to_have_value("0.4")
    wait_for(lambda: wardrobe.player(HIGHEST) < before + 0.01, "the usual body")


def test_bones_are_those_of_the_next_takes(wardrobe):
    page = wardrobe.page
    bones = page.get_by_role("region", name="Bones of the next takes")
    bones.get_by_role("slider", name="Legs").focus()
    page.keyboard.press("PageUp")
    expect(bones.get_by_role("button", name="Reset bones of the next takes")).to_be_enabled()
    said = bones.get_by_role("slider", name="Legs").input_value()
    page.keyboard.press("Control+Enter")
    wardrobe.takes(8)
    page.get_by_role("tab", name="Details").click()
    expect(page.get_by_text(f"legs × {float(said):g}")).to_be_visible()
