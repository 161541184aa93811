"""What a person does in the studio, done in Chromium."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys

import imageio_ffmpeg
import numpy as np
import pytest
from playwright.sync_api import expect

import engines
from engines.actions import VOCABULARY
from studio.views.inspector import FORMATS
from tests.ui.conftest import ROOT, Tab, wait_for

WAVES = sum("wave" in action.name for action in VOCABULARY)


def generate(tab: Tab, action: str, count: int = 4) -> None:
    before = tab.page.locator(".take").count()
    tab.page.get_by_label("Action", exact=True).fill(action)
    tab.page.get_by_label("Action", exact=True).press("Enter")
    tab.page.get_by_role("button", name=re.compile("^Generate")).click()
    tab.takes(before + count)


def download(tab: Tab, start) -> object:
    with tab.page.expect_download(timeout=120_000) as waiting:
        start()
    return waiting.value


def test_a_newcomer_sees_four_people_walk(chromium, address):
    context = chromium.new_context(viewport={"width": 1280, "height": 720}, reduced_motion="no-preference")
    tab = Tab(context.new_page(), address).open()
    page = tab.page
    assert page.title() == "Untitled scene · motionloom"
    expect(page.get_by_label("Action", exact=True)).to_have_value("walk")
    assert tab.player("player.actors.length") == 4
    first = tab.player("player.frame")
    wait_for(lambda: tab.player("player.frame") != first, "the takes to play")
    expect(page.locator(".take img").first).to_have_attribute("src", re.compile("^data:image/webp"))
    expect(page.locator(".take")).to_have_count(4)
    expect(page.get_by_text(f"{len(VOCABULARY)} actions this engine knows")).to_be_visible()
    assert tab.faults == []
    assert tab.foreign == []
    context.close()


def test_generate_pick_and_inspect(tab):
    page = tab.page
    generate(tab, "wave right hand")
    expect(page.locator(".group .subject").first).to_have_text("wave right hand")
    assert tab.player("player.actors.map(a => a.take.name)") == ["Take 5", "Take 6", "Take 7", "Take 8"]
    page.get_by_role("button", name=re.compile("^Take 7, ")).click()
    expect(page.get_by_text("What made take 7")).to_be_visible()
    expect(page.get_by_text("motionloom generate --settings take-7.json")).to_be_attached()
    wait_for(lambda: tab.player("player.options.selected") == 2, "the stage to pick it too")


def test_picking_on_the_stage_picks_in_the_gallery(tab):
    tab.player("player.set('selected', 3)")
    expect(tab.page.get_by_text("What made take 4")).to_be_visible()


def test_play_and_scrub(tab):
    assert tab.player("player.options.playing") is False, "whoever asked for calm is not shown motion unasked"
    tab.player("player.seek(30)")
    tab.page.locator("body").press("ArrowRight")
    wait_for(lambda: tab.player("player.frame") == 31, "one frame on")
    tab.page.locator("body").press("Space")
    wait_for(lambda: tab.player("player.options.playing"), "Space to play")


def test_click_in_the_grid_chooses_the_action(tab):
    page = tab.page
    page.get_by_role("radio", name="gestures").click()
    page.get_by_role("option", name="bow", exact=True).click()
    expect(page.get_by_label("Action", exact=True)).to_have_value("bow")
    expect(page.get_by_text("A person bows.")).to_be_visible()


def test_an_unknown_action_is_named_and_a_near_one_is_a_click_away(tab):
    page = tab.page
    field = page.get_by_label("Action", exact=True)
    field.fill("moonwlk")
    field.press("Enter")
    expect(page.get_by_text("“moonwlk” is not an action this engine knows.")).to_be_visible()
    expect(page.get_by_role("button", name=re.compile("^Generate"))).to_be_disabled()
    page.locator(".chip").first.click()
    expect(page.get_by_text("is not an action")).to_have_count(0)
    expect(page.get_by_role("button", name=re.compile("^Generate"))).to_be_enabled()


def test_search_narrows_the_grid(tab):
    tab.page.get_by_label("Action", exact=True).fill("wave")
    expect(tab.page.locator("button[role=option]")).to_have_count(WAVES)
    expect(tab.page.get_by_text(f"{WAVES} of {len(VOCABULARY)} actions")).to_be_visible()
    tab.page.locator("button[role=option]").nth(1).click()
    chosen = tab.page.locator("[role=option][aria-selected=true]").get_attribute("data-key")
    expect(tab.page.get_by_label("Action", exact=True)).to_have_value(chosen or "")
    assert "wave" in (chosen or ""), "the card that was pressed, though the word in the field is no action"


def test_enter_takes_the_best_match(tab):
    field = tab.page.get_by_label("Action", exact=True)
    field.fill("wave l")
    field.press("Enter")
    expect(field).to_have_value("wave left hand")
    expect(tab.page.get_by_text("is not an action")).to_have_count(0)


def test_keep_star_compare_delete_undo(tab):
    page = tab.page
    page.get_by_role("button", name=re.compile("^Take 2, ")).click()
    tab.button("Keep").click()
    expect(tab.button("Kept")).to_be_visible()
    tab.button("Star Take 3").click()
    expect(tab.button("Star Take 3")).to_have_attribute("aria-pressed", "true")
    tab.button("Compare Take 1").click()
    tab.button("Compare Take 4").click()
    wait_for(lambda: tab.player("player.actors.map(a => a.take.name)") == ["Take 1", "Take 4"], "two on the stage")
    tab.button("Delete this take").click()
    tab.takes(3)
    page.keyboard.press("Control+z")
    tab.takes(4)
    tab.button("Clear takes that are neither kept nor starred").click()
    tab.takes(2)
    expect(tab.button("Undo clear 2 takes")).to_be_enabled()


def test_same_seed_same_motion_as_the_command_line(tab, tmp_path):
    """Take 3 of the first draw, exported by the app, and made again from its settings file by the command line."""
    page = tab.page
    page.get_by_role("button", name=re.compile("^Take 3, ")).click()
    expect(page.get_by_text("What made take 3")).to_be_visible()
    settings = download(tab, lambda: page.get_by_text("Save settings file").click())
    assert settings.suggested_filename == "take-3.json"
    settings.save_as(tmp_path / "take-3.json")
    page.get_by_role("tab", name="Export").click()
    page.get_by_role("radio", name="NPZ").click()
    export = download(tab, lambda: page.get_by_role("button", name="Export take 3 as NPZ").click())
    assert export.suggested_filename == "take-3-walk.npz"
    export.save_as(tmp_path / "app.npz")
    command = [sys.executable, "-m", "studio.cli", "generate", "--settings", str(tmp_path / "take-3.json")]
    command += ["-f", "npz", "-o", str(tmp_path / "cli")]
    subprocess.run(command, cwd=ROOT, check=True, timeout=200, capture_output=True)
    (file,) = (tmp_path / "cli").iterdir()
    ours, theirs = engines.read(tmp_path / "app.npz"), engines.read(file)
    np.testing.assert_array_equal(ours.rotations, theirs.rotations)
    np.testing.assert_array_equal(ours.translation, theirs.translation)
    assert ours.provenance == theirs.provenance


def test_bvh_opens_in_another_program(tab, tmp_path):
    import bvhio

    page = tab.page
    page.get_by_role("tab", name="Export").click()
    page.get_by_role("radio", name="BVH").click()
    file = download(tab, lambda: page.get_by_role("button", name="Export take 1 as BVH").click())
    file.save_as(tmp_path / file.suggested_filename)
    tree = bvhio.readAsBvh(str(tmp_path / "take-1-walk.bvh"))
    assert (tree.FrameCount, round(1 / tree.FrameTime)) == (100, 20)


def test_mp4_plays(tab, tmp_path):
    page = tab.page
    page.get_by_role("tab", name="Export").click()
    page.get_by_label("Size").select_option("854 × 480")
    file = download(tab, lambda: page.get_by_role("button", name="Export take 1 as MP4").click())
    path = tmp_path / file.suggested_filename
    file.save_as(path)
    assert path.name == "take-1-walk.mp4"
    frames, seconds = imageio_ffmpeg.count_frames_and_secs(str(path))
    assert frames >= 60
    assert seconds == pytest.approx(5.0, abs=0.1)
    meta = next(imageio_ffmpeg.read_frames(str(path)))
    assert meta["size"] == (854, 480)
    expect(page.locator("a.link")).to_contain_text("take-1-walk.mp4")


def test_one_export_after_another(tab, tmp_path):
    """Each press brings its file: not the page, which the empty address between two exports would bring."""
    page = tab.page
    page.get_by_role("tab", name="Export").click()
    for kind, start in {"BVH": b"HIERARCHY", "GLB": b"glTF", "GIF": b"GIF89a", "NPZ": b"PK"}.items():
        page.get_by_role("radio", name=kind).click()
        file = download(tab, lambda kind=kind: page.get_by_role("button", name=f"Export take 1 as {kind}").click())
        path = tmp_path / file.suggested_filename
        file.save_as(path)
        assert path.name == f"take-1-walk.{kind.lower()}"
        assert path.read_bytes().startswith(start)


def test_cancel_of_an_export(tab):
    page = tab.page
    page.get_by_label("Length, seconds").fill("60")
    page.get_by_label("Length, seconds").press("Enter")
    generate(tab, "walk")
    page.get_by_role("tab", name="Export").click()
    page.get_by_label("Size").select_option("1920 × 1080")
    page.get_by_role("button", name="Export take 5 as MP4").click()
    tab.button("Cancel").click()
    expect(page.get_by_text("Cancelled; nothing was written.")).to_be_visible()
    expect(page.get_by_role("button", name="Export take 5 as MP4")).to_be_enabled()
    expect(page.locator("a.link")).to_have_count(0)


def test_import_of_a_good_and_a_bad_file(tab, tmp_path):
    page = tab.page
    engines.load("action2motion").generate("jump", frames=30).write(tmp_path / "my jump.bvh")
    (tmp_path / "broken.bvh").write_text("HIERARCHY\nROOT hips\n{\n  OFFSET 0 0\n")
    page.get_by_role("tab", name="Import").click()
    page.get_by_label("Motion file").set_input_files(tmp_path / "broken.bvh")
    expect(page.get_by_text(re.compile(r"^broken\.bvh:5: the file ends"))).to_be_visible()
    page.get_by_label("Motion file").set_input_files(tmp_path / "my jump.bvh")
    tab.takes(5)
    expect(page.get_by_text(re.compile("Imported my jump.bvh: 30 frames"))).to_be_visible()
    expect(page.get_by_text("broken.bvh")).to_have_count(0)
    wait_for(lambda: tab.player("player.actors.length") == 1, "the import on the stage")


def test_a_file_dropped_anywhere_is_imported(tab, tmp_path):
    page = tab.page
    path = engines.load("action2motion").generate("bow", frames=30).write(tmp_path / "bow.bvh")
    drop = page.evaluate_handle(
        "(text) => { const d = new DataTransfer(); d.items.add(new File([text], 'bow.bvh')); return d }",
        path.read_text(),
    )
    page.dispatch_event("main", "dragenter", {"dataTransfer": drop})
    expect(page.get_by_text("Drop to import")).to_be_visible()
    page.dispatch_event("main", "drop", {"dataTransfer": drop})
    tab.takes(5)
    expect(page.get_by_text(re.compile("Imported bow.bvh"))).to_be_visible()


def test_two_people_at_once(tab, chromium, address):
    other_context = chromium.new_context(viewport={"width": 1280, "height": 720})
    try:
        other = Tab(other_context.new_page(), address).open()
        generate(other, "kick")
        expect(tab.page.locator(".take")).to_have_count(4)
        generate(tab, "bow", 4)
        expect(other.page.locator(".group .subject").first).to_have_text("kick")
        expect(tab.page.locator(".group .subject").first).to_have_text("bow")
        assert other.faults == []
        assert other.foreign == []
    finally:
        other_context.close()


def test_with_the_keyboard_alone(tab):
    """Search, choose with arrows, generate, pick a take, keep it."""
    page, keys = tab.page, tab.page.keyboard
    page.get_by_label("Action", exact=True).focus()
    keys.type("wave")
    expect(page.locator("button[role=option]")).to_have_count(WAVES)
    keys.press("ArrowDown")
    keys.press("ArrowRight")
    expect(page.locator("[role=option]:focus")).to_have_count(1)
    expect(page.locator("button[role=option]")).to_have_count(WAVES)
    name = page.locator("[role=option]:focus").inner_text()
    keys.press("Enter")
    expect(page.get_by_label("Action", exact=True)).to_have_value(name)
    keys.press("Control+Enter")
    tab.takes(8)
    page.locator(".pick").first.focus()
    keys.press("ArrowDown")
    expect(page.get_by_text("What made take 6")).to_be_visible()
    keys.press("k")
    expect(page.locator(".take .kept")).to_have_count(1)


def test_export_with_the_keyboard_alone(tab):
    """Choose a format with arrows and start the export with Enter."""
    page, keys = tab.page, tab.page.keyboard
    keys.press("Control+e")
    expect(page.get_by_role("radio", name="MP4")).to_be_visible()
    page.get_by_role("tab", name="Export").focus()
    keys.press("Tab")
    expect(page.get_by_role("radio", name="MP4")).to_be_focused()
    for _ in range([key for key, _ in FORMATS].index("bvh")):
        keys.press("ArrowRight")
    expect(page.get_by_role("radio", name="BVH")).to_have_attribute("aria-checked", "true")
    export = page.get_by_role("button", name="Export take 1 as BVH")
    expect(export).to_be_enabled()
    expect(page.get_by_label("Size")).to_be_hidden()
    keys.press("Tab")
    expect(export).to_be_focused()
    file = download(tab, lambda: keys.press("Enter"))
    assert file.suggested_filename.startswith("take-1-")


def test_theme_is_kept_for_the_next_visit(tab):
    page = tab.page
    tab.button("Use light colours").click()
    expect(page.locator("html")).to_have_attribute("data-theme", "light")
    wait_for(lambda: tab.player("player.options.theme") == "light", "the stage to follow")
    page.reload()
    tab.takes(4)
    expect(page.locator("html")).to_have_attribute("data-theme", "light")
    expect(tab.button("Use dark colours")).to_be_visible()


def test_help_opens_and_closes(tab):
    tab.page.locator("main").focus()
    tab.page.keyboard.press("?")
    expect(tab.page.get_by_role("dialog", name="Help")).to_be_visible()
    tab.page.keyboard.press("Escape")
    expect(tab.page.get_by_role("dialog", name="Help")).to_have_count(0)


@pytest.mark.parametrize(("width", "height"), [(1280, 720), (1440, 900), (1920, 1080)])
def test_everything_fits(chromium, address, width, height):
    context = chromium.new_context(viewport={"width": width, "height": height})
    try:
        tab = Tab(context.new_page(), address).open()
        overflow = (
            "document.scrollingElement.scrollWidth > innerWidth || document.scrollingElement.scrollHeight > innerHeight"
        )
        assert tab.page.evaluate(overflow) is False
        for name in ("Import", "Export"):
            box = tab.page.locator(".topbar").get_by_role("button", name=name).bounding_box()
            assert box["x"] + box["width"] <= width
        for name in (re.compile("^Generate 4"), "Keep", "Again", "Compare", "Delete this take"):
            box = tab.page.get_by_role("button", name=name, exact=True).bounding_box()
            assert box["y"] + box["height"] <= height
            assert box["x"] + box["width"] <= width
        assert tab.page.locator("button[role=option]").first.bounding_box()["y"] + 60 < height
    finally:
        context.close()


def test_what_a_screen_reader_finds(tab):
    """Every control has a name; landmarks and the current choice are told."""
    page = tab.page
    for role in ("banner", "main"):
        expect(page.get_by_role(role)).to_have_count(1)
    for name in ("Compose", "Takes and inspector"):
        expect(page.get_by_role("complementary", name=name)).to_be_visible()
    for label in ("Action", "Length, seconds", "Variations", "Seed"):
        expect(page.get_by_label(label, exact=True).filter(visible=True)).to_have_count(1)  # other tabs have their own
    unnamed = page.evaluate(
        """() => {
          const found = []
          const text = (node) => node.nodeType === 3 ? node.data
            : [...(node.shadowRoot?.childNodes ?? []), ...node.childNodes].map(text).join(" ").trim()
          const walk = (root) => { for (const node of root.querySelectorAll("*")) {
            if (node.shadowRoot) walk(node.shadowRoot)
            if (node.matches("button, a[href], input, select") && node.offsetParent) {
              const label = node.labels?.[0]?.innerText
              const name = node.getAttribute("aria-label") || text(node) || label || node.title
              if (!name && !node.matches(".bk-spin-btn")) found.push(node.outerHTML.slice(0, 120))
            }
          } }
          walk(document)
          return found
        }"""
    )
    assert unnamed == []


def test_a_command_that_needs_a_port_finds_one(address):
    """The second studio on a port that is taken says which one it uses."""
    assert shutil.which(sys.executable)
    port = int(re.search(r":(\d+)/", address)[1])
    from studio.app import free_port

    assert free_port(port) > port
