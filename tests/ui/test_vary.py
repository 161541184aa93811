"""Edits, comparison and variations of takes, done in Chromium."""

from __future__ import annotations

import re

import numpy as np
import pytest
from playwright.sync_api import expect

import engines
from studio.mapping import stands_for
from tests.ui.conftest import wait_for
from tests.ui.test_studio import download, generate


def names(tab) -> list[str]:
    return tab.player("player.actors.map(a => a.take.name)")


def card(tab, number: int):
    return tab.page.get_by_role("button", name=re.compile(f"^Take {number}, "))


def export_npz(tab, number: int, path) -> engines.Motion:
    tab.page.get_by_role("tab", name="Export").click()
    tab.page.get_by_role("radio", name="NPZ").click()
    file = download(tab, lambda: tab.page.get_by_role("button", name=f"Export take {number} as NPZ").click())
    file.save_as(path)
    return engines.read(path)


def test_edits_are_shown_exported_and_taken_back(tab, tmp_path):
    page = tab.page
    plain = export_npz(tab, 1, tmp_path / "plain.npz")
    before = tab.player("[...player.actors[0].pose.places.slice(0, 60)]")
    changes = page.get_by_role("group", name="Changes to Take 1")
    for name in ("Mirror", "In place"):
        changes.get_by_role("button", name=name, exact=True).click()
    expect(page.get_by_role("button", name=re.compile("^Take 1, .*shown with Mirror, In place"))).to_be_visible()
    tab.player("player.seek(40)")
    wait_for(lambda: abs(tab.player("player.actors[0].root.z - player.actors[0].object.position.z")) < 0.3, "in place")
    edited = export_npz(tab, 1, tmp_path / "edited.npz")
    np.testing.assert_array_equal(edited.rotations, plain.mirror().in_place().rotations)
    np.testing.assert_array_equal(edited.translation, plain.mirror().in_place().translation)
    card(tab, 2).click()
    expect(page.get_by_role("group", name="Changes to Take 2").get_by_role("button", name="Mirror")).to_have_attribute(
        "aria-pressed", "false"
    )
    tab.button("Undo edit take 1").click()
    tab.button("Undo edit take 1").click()
    tab.player("player.seek(0)")
    wait_for(
        lambda: np.allclose(tab.player("[...player.actors[0].pose.places.slice(0, 60)]"), before, atol=1e-3), "undo"
    )


def test_takes_are_compared_in_a_row_and_overlaid(tab):
    generate(tab, "run")
    card(tab, 5).click()
    card(tab, 8).click(modifiers=["Shift"])
    card(tab, 1).click(modifiers=["Control"])
    wait_for(lambda: names(tab) == ["Take 5", "Take 6", "Take 7", "Take 8", "Take 1"], "five on the stage")
    expect(tab.page.get_by_role("radio", name="Compare 5")).to_have_attribute("aria-checked", "true")
    tab.player("player.seek(17)")
    frames = tab.player("player.actors.map(a => Math.round(player.clock.seconds * a.take.fps))")
    assert set(frames) == {17}, "in sync"
    tab.page.locator("main").focus()
    tab.page.keyboard.press("v")
    wait_for(lambda: len(set(tab.player("player.actors.map(a => a.object.position.x)"))) == 1, "all in one place")
    card(tab, 6).click(modifiers=["Control"])
    wait_for(lambda: names(tab) == ["Take 5", "Take 7", "Take 8", "Take 1"], "one less")


def test_a_blend_is_seen_chosen_and_kept(tab, tmp_path):
    page = tab.page
    page.get_by_role("tab", name="Vary").click()
    page.get_by_label("Blend from").select_option("take-2")
    page.get_by_label("Blend to").select_option("take-3")
    wait_for(lambda: names(tab) == ["Take 2", "50 % of the way", "Take 3"], "both ends and what lies between")
    expect(page.get_by_role("group", name="What lies between").get_by_role("button")).to_have_count(7)
    slider = page.get_by_role("slider", name="How far from the one to the other")
    slider.focus()
    for _ in range(4):
        page.keyboard.press("ArrowRight")
    wait_for(lambda: names(tab)[1] == "70 % of the way", "the slider to be followed")
    page.get_by_role("group", name="What lies between").get_by_role("button", name="0 percent", exact=True).click()
    wait_for(lambda: names(tab)[1] == "0 % of the way", "the strip to be followed")
    page.get_by_role("button", name="Keep this one").click()
    tab.takes(5)
    wait_for(lambda: names(tab) == ["Take 5"], "the take that was kept")
    expect(page.get_by_text("What made take 5")).to_be_visible()
    expect(page.get_by_text("0 % towards seed 7")).to_be_visible()
    kept = export_npz(tab, 5, tmp_path / "kept.npz")
    card(tab, 2).click()
    np.testing.assert_allclose(
        kept.positions, export_npz(tab, 2, tmp_path / "end.npz").positions, atol=1e-4, err_msg="0 % is the first end"
    )


def test_what_cannot_be_blended_is_said(tab):
    page = tab.page
    generate(tab, "run")
    page.get_by_role("tab", name="Vary").click()
    page.get_by_label("Blend from").select_option("take-1")
    page.get_by_label("Blend to").select_option("take-6")
    expect(page.get_by_text("Take 1 and take 6 are of different actions")).to_be_visible()
    expect(page.get_by_role("button", name="Keep this one")).to_be_hidden()


@pytest.mark.parametrize("button", ["Go on from 1.5 s", "Change at 1.5 s"])
def test_from_the_playhead_on_with_the_keyboard(tab, tmp_path, button):
    page, keys = tab.page, tab.page.keyboard
    start = export_npz(tab, 1, tmp_path / "start.npz")
    tab.player("player.seek(30)")
    page.get_by_role("tab", name="Vary").focus()
    keys.press("Enter")
    expect(page.get_by_label("What follows")).to_be_visible()
    page.get_by_label("What follows").focus()
    keys.type("run")
    keys.press("Tab")
    keys.type("1")
    keys.press("Tab")
    keys.type("2")
    keys.press("Tab")
    page.get_by_role("button", name=button).focus()
    keys.press("Enter")
    tab.takes(6)
    made = export_npz(tab, 5, tmp_path / "made.npz")
    assert (made.frames, made.label_at(40)) == (50, "run")
    if button.startswith("Go on"):
        np.testing.assert_allclose(made.positions[:30], start.positions[:30], atol=1e-4)
    else:
        assert made.label_at(0) == "walk"


def test_a_place_on_the_map_is_chosen_looked_at_and_kept(tab, tmp_path):
    page, keys = tab.page, tab.page.keyboard
    page.get_by_role("tab", name="Vary").click()
    page.get_by_role("button", name="Draw the map of “walk”").click()
    themap = page.get_by_role("application", name="Map of walk")
    themap.wait_for()
    dots = themap.locator(".dot")
    expect(dots).to_have_count(40)
    themap.focus()
    keys.press("ArrowRight")
    wait_for(lambda: re.match(r"Draw \d+|\d+ % from draw", names(tab)[0]), "what is there to be shown")
    at = themap.locator(".point").get_attribute("cx")
    keys.press("Shift+ArrowUp")
    keys.press("ArrowLeft")
    wait_for(lambda: themap.locator(".point").get_attribute("cx") != at, "the point to move")
    dots.nth(11).click(force=True)
    wait_for(lambda: names(tab) == ["Draw 12"], "the draw that was pressed")
    expect(themap.locator(".peek img")).to_have_attribute("src", re.compile("^data:image"))
    points = np.array(
        themap.evaluate("(map) => [...map.querySelectorAll('.dot')].map(d => [d.cx, d.cy].map(c => c.baseVal.value))")
    )
    points = np.stack([points[:, 0], 240 - points[:, 1]], axis=1) / 240
    x, y = next(
        at for at in np.random.default_rng(0).uniform(0.2, 0.8, (500, 2)) if 0.3 < stands_for(points, at).share < 0.7
    )
    box = themap.bounding_box()
    page.mouse.click(box["x"] + x * box["width"], box["y"] + (1 - y) * box["height"])
    wait_for(lambda: "from draw" in names(tab)[0], "what lies between to be shown")
    wait_for(lambda: themap.locator(".way").get_attribute("points"), "what lies between to be worked out")
    shown = tab.player("[...player.actors[0].pose.places.slice(0, 60)]")
    keys.press("Enter")
    tab.takes(5)
    wait_for(lambda: names(tab) == ["Take 5"], "it to be kept")
    tab.player("player.seek(0)")
    np.testing.assert_allclose(tab.player("[...player.actors[0].pose.places.slice(0, 60)]"), shown, atol=1e-3)
