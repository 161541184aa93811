"""Projects, tags, search, links, and a studio that is killed while one works in it; done in Chromium."""

from __future__ import annotations

import re
import signal
from collections.abc import Iterator

import pytest
from playwright.sync_api import expect

from tests.ui.conftest import Tab, free_port, start, wait_for


def projects(tab: Tab):
    """The open dialog."""
    tab.page.get_by_role("button", name=re.compile("^Projects")).click()
    dialog = tab.page.get_by_role("dialog", name="Projects")
    expect(dialog).to_be_visible()
    return dialog


def rename(tab: Tab, name: str) -> None:
    tab.page.get_by_label("Project name").fill(name)
    tab.page.get_by_label("Project name").press("Enter")
    wait_for(lambda: tab.page.title() == f"{name} · motionloom", "the new name in the title")


def saved(tab: Tab) -> None:
    expect(tab.page.get_by_role("status").get_by_text("Saved", exact=True)).to_be_visible()


def address(tab: Tab) -> str:
    # the page's own word: Playwright's is late by a few events
    return tab.page.evaluate("location.href")


def pick(tab: Tab, number: int) -> None:
    tab.page.get_by_role("button", name=re.compile(f"^Take {number}, ")).click()
    expect(tab.page.get_by_text(f"What made take {number}")).to_be_visible()


def test_a_reload_brings_everything_back(tab):
    page = tab.page
    saved(tab)
    rename(tab, "Morning scene")
    tab.button("Star Take 2").click()
    pick(tab, 3)
    page.get_by_label("Add a tag to take 3").fill("Good one, old")
    page.get_by_label("Add a tag to take 3").press("Enter")
    expect(tab.button("Remove the tag good one")).to_be_visible()
    expect(tab.button("Remove the tag old")).to_be_visible()
    page.reload()
    tab.takes(4)
    expect(page.get_by_label("Project name")).to_have_value("Morning scene")
    expect(tab.button("Star Take 2")).to_have_attribute("aria-pressed", "true")
    expect(page.get_by_text("What made take 3")).to_be_visible()
    expect(tab.button("Remove the tag old")).to_be_visible()
    expect(page.locator(".take img")).to_have_count(4)
    saved(tab)
    tab.button("Undo tag take 3").click()
    expect(tab.button("Remove the tag old")).to_have_count(0)


def test_takes_are_found(tab):
    page = tab.page
    page.get_by_label("Add a tag to take 1").fill("good")
    page.get_by_label("Add a tag to take 1").press("Enter")
    tab.button("Star Take 4").click()
    field = page.get_by_label("Find takes")
    field.fill("tag:good")
    tab.takes(1)
    expect(page.get_by_role("button", name=re.compile("^Take 1, .*tagged good"))).to_be_visible()
    expect(page.get_by_text("1 of 4 takes")).to_be_visible()
    field.fill("walk is:starred")
    wait_for(lambda: page.get_by_role("button", name=re.compile("^Take 4, ")).count() == 1, "take 4 to be found")
    tab.takes(1)
    field.fill("swim")
    expect(page.get_by_text("No take fits “swim”.")).to_be_visible()
    field.press("Escape")
    tab.takes(4)


def test_the_address_follows_what_is_shown_and_shows_it_again(tab, chromium):
    pick(tab, 3)
    tab.player("player.seek(31)")
    wait_for(lambda: re.search(r"\?project=[0-9a-f]{12}&take=3&frame=31$", address(tab)), "the address to follow")
    context = chromium.new_context(viewport={"width": 1280, "height": 720})
    try:
        other = Tab(context.new_page(), address(tab)).open()
        expect(other.page.get_by_text("What made take 3")).to_be_visible()
        wait_for(lambda: other.player("player.frame") == 31, "the frame of the link")
        assert other.player("player.options.playing") is False
        assert other.player("player.options.selected") == 2
        wait_for(lambda: address(other) == address(tab), "the same address")
        assert other.faults == []
    finally:
        context.close()


def test_projects_with_the_keyboard_alone(tab):
    """Name one, begin another, open the first again, delete the second and bring it back."""
    page, keys = tab.page, tab.page.keyboard
    rename(tab, "Zebra one")
    page.locator("main").focus()
    keys.press("Control+Shift+P")
    dialog = page.get_by_role("dialog", name="Projects")
    field, found = dialog.get_by_label("Find a project or a take"), dialog.locator("button.open")
    expect(field).to_be_focused()
    keys.press("Tab")
    expect(dialog.get_by_role("button", name="New project")).to_be_focused()
    keys.press("Enter")
    tab.takes(0)
    expect(page.get_by_text("Nobody here yet.")).to_be_visible()
    expect(page.get_by_label("Project name")).to_have_value("Untitled scene")
    rename(tab, "Zebra two")
    page.locator("main").focus()
    keys.press("Control+Shift+P")
    keys.type("zebra")
    expect(found).to_have_count(2)
    keys.type(" one")
    expect(found).to_have_count(1)
    keys.press("ArrowDown")
    expect(found).to_be_focused()
    keys.press("Enter")
    tab.takes(4)
    expect(page.get_by_label("Project name")).to_have_value("Zebra one")
    page.locator("main").focus()
    keys.press("Control+Shift+P")
    field.fill("zebra")
    expect(found).to_have_count(2)
    dialog.get_by_role("button", name="Delete Zebra two").press("Enter")
    expect(found).to_have_count(1)
    dialog.locator("summary").press("Enter")
    dialog.get_by_role("button", name="Bring back Zebra two").press("Enter")
    expect(found).to_have_count(2)
    keys.press("Escape")
    expect(dialog).to_have_count(0)


def test_a_take_of_another_project_is_a_search_and_a_click_away(tab):
    rename(tab, "Here it is")
    tab.page.get_by_label("Add a tag to take 1").fill("rare")
    tab.page.get_by_label("Add a tag to take 1").press("Enter")
    pick(tab, 2)
    dialog = projects(tab)
    dialog.get_by_role("button", name="New project").click()
    tab.takes(0)
    dialog = projects(tab)
    dialog.get_by_label("Find a project or a take").fill("tag:rare")
    expect(dialog.locator("button.open")).to_have_count(1)
    dialog.get_by_role("button", name="take 1 · walk").click()
    tab.takes(4)
    expect(tab.page.get_by_text("What made take 1")).to_be_visible()


def test_two_tabs_of_one_project_show_the_same(tab, context):
    other = Tab(context.new_page(), address(tab)).open()
    tab.button("Star Take 1").click()
    expect(other.button("Star Take 1")).to_have_attribute("aria-pressed", "true")
    pick(other, 2)
    other.button("Delete this take").click()
    tab.takes(3)
    tab.button("Undo delete take 2").click()
    other.takes(4)
    assert other.faults == []


@pytest.fixture
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("killed")


@pytest.fixture
def port() -> Iterator[int]:
    return free_port()


def test_a_studio_that_is_killed_comes_back_with_everything(context, folder, port):
    """kill -9 while the page is open: it says so, and is itself again once the studio is."""
    url, server = start("tests.ui.constrained_studio", folder, port, {"MOTIONLOOM_TEST_TOLD": str(folder / "told")})
    try:
        tab = Tab(context.new_page(), url).open()
        rename(tab, "Survivor")
        tab.button("Star Take 2").click()
        expect(tab.button("Undo star take 2")).to_be_enabled()
        pick(tab, 3)
        tab.page.get_by_role("tab", name="Export").click()
        tab.page.get_by_role("radio", name="BVH").click()
        with tab.page.expect_download():
            tab.page.get_by_role("button", name="Export take 3 as BVH").click()
        for number in (1, 3):
            tab.page.get_by_role("button", name=re.compile(f"^Take {number}, ")).click(modifiers=["Control"])
        third = tab.page.get_by_role("button", name=re.compile("^Take 3, "))
        third.click()  # what is ticked first is picked as well
        expect(third).to_have_attribute("aria-pressed", "true")
        tab.page.get_by_role("tab", name="Sequence").click()
        tab.page.get_by_role("option", name="walk", exact=True).click()
        tab.page.get_by_role("option", name="run", exact=True).click()
        expect(tab.button("Undo add run")).to_be_enabled()
        saved(tab)
        assert list(folder.glob("motionloom-*"))
        server.send_signal(signal.SIGKILL)
        server.wait(20)
        expect(tab.page.get_by_text("The studio does not answer.")).to_be_visible()
        _, server = start("tests.ui.constrained_studio", folder, port, {"MOTIONLOOM_TEST_TOLD": str(folder / "told")})
        assert not list(folder.glob("motionloom-*")), "what the killed one left is cleared away"
        expect(tab.page.get_by_text("The studio does not answer.")).to_be_hidden(timeout=60_000)
        tab.takes(4)
        expect(tab.page.get_by_label("Project name")).to_have_value("Survivor")
        expect(tab.button("Star Take 2")).to_have_attribute("aria-pressed", "true")
        expect(tab.page.get_by_text("What made take 3")).to_be_visible()
        expect(tab.page.get_by_role("tab", name="Sequence")).to_have_attribute("aria-selected", "true")
        wait_for(
            lambda: tab.player("player.sequence?.blocks?.map(block => block.what)") == ["walk", "run"], "the blocks"
        )
        wait_for(lambda: tab.player("player.actors.map(a => a.take.name)") == ["Take 1", "Take 3"], "those compared")
        assert {"tab=sequence", "compare=1.3"} <= set(address(tab).split("&"))
        for step in ("add run", "add walk", "star take 2"):
            tab.button(f"Undo {step}").click()
        expect(tab.button("Star Take 2")).to_have_attribute("aria-pressed", "false")
    finally:
        server.terminate()
        server.wait(20)
    assert "Traceback" not in (folder / "server.log").read_text()


def test_a_library_that_cannot_be_used_is_said_and_the_studio_works(context, folder, port):
    (folder / "library.db").write_text("these are somebody's notes " * 50)
    url, server = start("tests.ui.constrained_studio", folder, port, {"MOTIONLOOM_TEST_TOLD": str(folder / "told")})
    try:
        tab = Tab(context.new_page(), url).open()
        expect(tab.page.get_by_text("In memory only")).to_be_visible()
        dialog = projects(tab)
        expect(dialog.get_by_text(re.compile("this file is no library; choose another with --library"))).to_be_visible()
        expect(dialog.get_by_text(re.compile("Takes are kept in memory: export what you need"))).to_be_visible()
        tab.page.keyboard.press("Escape")
        tab.button("Star Take 2").click()
        expect(tab.button("Undo star take 2")).to_be_enabled()
        assert tab.faults == []
    finally:
        server.terminate()
        server.wait(20)
    assert (folder / "library.db").read_text().startswith("these are somebody's notes")
