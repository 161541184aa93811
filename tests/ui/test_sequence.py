"""Blocks dragged and typed onto the timeline in Chromium, made, undone, found again."""

from __future__ import annotations

import re

from playwright.sync_api import expect

import engines
from tests.ui.conftest import wait_for
from tests.ui.test_studio import download


def blocks(tab, what: str = "what") -> list:
    return tab.player(f"(player.sequence.blocks ?? []).map(block => block.{what})")


def drop(tab, card, share: float) -> None:
    """Drag an action or a take onto the timeline."""
    view = tab.page.locator(".seq-view")
    before = len(blocks(tab))
    box = view.bounding_box()
    card.drag_to(view, target_position={"x": box["width"] * share, "y": box["height"] * 0.7})
    wait_for(lambda: len(blocks(tab)) == before + 1, "one more block on the timeline")


def test_a_scene_is_dragged_typed_made_exported_undone_and_there_again(tab, tmp_path):
    page, keys = tab.page, tab.page.keyboard
    page.get_by_role("tab", name="Sequence").click()
    expect(page.get_by_role("button", name="Make the sequence")).to_be_disabled()
    for action, share in (("walk", 0.5), ("bow", 0.95), ("jump", 0.05)):
        drop(tab, page.get_by_role("option", name=action, exact=True), share)
    assert blocks(tab) == ["jump", "walk", "bow"], "dropped where it was let go"
    words = page.get_by_label("A block in words")
    words.fill("a person waves, proudly")
    words.press("Enter")
    wait_for(lambda: len(blocks(tab)) == 4, "the block in words")
    assert blocks(tab)[1] == "a person waves, proudly", "behind the picked one"
    drop(tab, page.get_by_role("button", name=re.compile("^Take 1, ")), 0.98)
    page.get_by_role("button", name=re.compile("^Block 3 of 5: walk")).focus()
    keys.press("Alt+Shift+ArrowLeft")
    wait_for(lambda: blocks(tab, "seconds")[2] == 2, "it to be shorter")
    keys.press("Shift+ArrowRight")
    wait_for(lambda: blocks(tab)[3] == "walk", "it to be moved")
    keys.press("Control+z")
    wait_for(lambda: blocks(tab)[2] == "walk", "one step back")
    keys.press("Enter")
    field = page.get_by_role("dialog", name="Block").get_by_label("Shows")
    field.fill("wlak")
    field.press("Enter")
    expect(page.get_by_text("Block 3: “wlak” is not an action this engine knows. Nearest: “walk”")).to_be_visible()
    keys.press("Control+z")
    wait_for(lambda: blocks(tab)[2] == "walk", "the action to be known again")
    keys.press("Control+Enter")
    tab.takes(5)
    wait_for(lambda: all(blocks(tab, "made")), "all blocks to be in the take")
    page.get_by_role("tab", name="Export").click()
    page.get_by_role("radio", name="NPZ").click()
    download(tab, lambda: page.get_by_role("button", name="Export take 5 as NPZ").click()).save_as(tmp_path / "a.npz")
    made = engines.read(tmp_path / "a.npz")
    done = [label.value for label in made.labels if label.kind in ("action", "text")]
    assert done == ["jump", "a person waves, proudly", "walk", "bow", "take 1"]
    assert made.frames == tab.player("player.clock.frames")
    page.get_by_role("button", name=re.compile("^Block 3 of 5: walk")).click(button="right")
    page.get_by_role("menuitem", name="Regenerate").click()
    tab.takes(6)
    wait_for(lambda: all(blocks(tab, "made")), "the sequence with another walk")
    page.get_by_role("button", name=re.compile("^Take 1, ")).click()
    page.get_by_role("tab", name="Action", exact=True).click()
    expect(page.get_by_role("group", name="Timeline")).to_be_visible()
    page.get_by_role("button", name=re.compile("^Take 5, ")).click()
    expect(page.get_by_role("button", name=re.compile("^Block 1 of 5: jump"))).to_be_visible()
    page.reload()
    page.locator("#splash.gone").wait_for(state="attached")
    page.get_by_role("tab", name="Sequence").click()
    wait_for(lambda: len(blocks(tab)) == 5, "the blocks to be there again")
