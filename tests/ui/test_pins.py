"""Words, styles and pins, done in Chromium with a quick stand-in for the engine."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest
from playwright.sync_api import BrowserContext, Locator, Page, expect

from tests.ui.conftest import Tab, wait_for

ON_SCREEN = (
    "(() => { const v = player.stage.camera.position.clone().set(%s).add(player.pins.object.position)"
    ".project(player.stage.camera), b = player.stage.canvas.getBoundingClientRect();"
    "return [b.left + (v.x + 1) / 2 * b.width, b.top + (1 - v.y) / 2 * b.height]; })()"
)
"""Where on the page a place x, y, z beside the picked figure is seen."""
JOINT = "...player.actors[player.options.selected].pose.places.slice(argument * 3, argument * 3 + 3)"


@pytest.fixture
def pinning(context: BrowserContext, constrained_address: str, told: Path) -> Iterator[Tab]:
    """An open studio with the constraints unfolded."""
    told.unlink(missing_ok=True)
    made = Tab(context.new_page(), constrained_address).open()
    made.button("Constraints").click()
    yield made
    assert made.faults == []
    assert made.foreign == []


def composed(page: Page, label: str) -> Locator:
    """A field of the left panel."""
    return page.get_by_role("complementary", name="Compose").get_by_label(label, exact=True)


def pinned(tab: Tab) -> list[str]:
    return tab.page.get_by_role("list", name="Pinned").locator("li > span").all_inner_texts()


def shows(tab: Tab, words: Sequence[str]) -> None:
    wait_for(lambda: pinned(tab) == list(words), f"{words} to be listed, which lists {pinned(tab)}", 20)


def seen(tab: Tab, place: str) -> list[float]:
    return tab.player(ON_SCREEN % place)  # type: ignore[return-value]


def drag(tab: Tab, spots: Sequence[Sequence[float]]) -> None:
    mouse = tab.page.mouse
    mouse.move(*spots[0])
    mouse.down()
    for spot in spots[1:]:
        mouse.move(*spot, steps=8)
    mouse.up()


def generate(tab: Tab, told: Path, takes: int = 8) -> dict:
    """Press the button; what the engine was told then."""
    tab.page.get_by_role("button", name=re.compile("^Generate")).click()
    tab.takes(takes)
    return json.loads(told.read_text().splitlines()[-1])


def go_to(tab: Tab, frame: int) -> None:
    """The playhead there, and Python knows it."""
    tab.page.get_by_label("Go to frame").fill(str(frame))
    tab.page.get_by_label("Go to frame").press("Enter")
    wait_for(lambda: tab.player("player.frame") == frame, f"frame {frame}")
    tab.page.wait_for_timeout(300)


def test_typed_words_are_generated(pinning, told):
    page = pinning.page
    page.get_by_role("tab", name="Text").click()
    button = page.get_by_role("button", name=re.compile("^Generate"))
    expect(button).to_be_disabled()
    expect(page.get_by_text("Describe the motion.")).to_be_visible()
    page.get_by_role("button", name="someone runs, then jumps").click()
    expect(page.get_by_label("Describe the motion")).to_have_value("someone runs, then jumps")
    page.get_by_label("Describe the motion").fill("a person hops <b>happily</b>")
    composed(page, "Style").select_option("happy")
    expect(button).to_be_enabled()
    asked = generate(pinning, told)
    assert (asked["action"], asked["prompt"], asked["style"]) == (None, "a person hops <b>happily</b>", "happy")
    expect(page.locator(".group .subject").first).to_have_text("a person hops <b>happily</b>")
    expect(page.get_by_role("row", name=re.compile("^Prompt"))).to_contain_text("<b>happily</b>")
    page.get_by_role("tab", name="Action").click()
    assert generate(pinning, told, 12)["action"] == "walk"


def test_a_motion_lasts_as_long_as_it_takes_until_a_length_is_typed(pinning, told):
    page = pinning.page
    length, found = page.get_by_label("Length, seconds"), page.get_by_label("as long as it takes")
    expect(found).to_be_checked()
    page.get_by_role("tab", name="Text").click()
    page.get_by_label("Describe the motion").fill("a person hops on one leg")
    expect(length).to_have_value("3.0")
    page.get_by_label("Describe the motion").fill("a person hops")
    expect(length).to_have_value("1.5")
    expect(page.get_by_text(re.compile("4 × 30 frames at 20 fps"))).to_be_visible()
    assert generate(pinning, told)["frames"] is None
    length.fill("2.5")
    length.press("Enter")
    expect(found).not_to_be_checked()
    page.get_by_label("Describe the motion").fill("a person hops on one leg")
    assert generate(pinning, told, 12)["frames"] == 50
    found.check()
    expect(length).to_have_value("3.0")


def test_guidance_and_best_of(pinning, told):
    page = pinning.page
    page.get_by_role("button", name="Advanced").click()
    page.get_by_label(re.compile("^Best of")).fill("3")
    page.get_by_label(re.compile("^Best of")).press("Enter")
    expect(page.get_by_text("the best of 3 each")).to_be_visible()
    assert generate(pinning, told)["best_of"] == 3


def test_a_path_drawn_with_the_mouse_on_the_floor(pinning, told):
    pinning.button("Draw a path").click()
    expect(pinning.button("Draw a path")).to_have_attribute("aria-pressed", "true")
    expect(pinning.page.get_by_text("Draw on the floor: press, drag, release.")).to_be_visible()
    corners = [(0.4, 0.2), (0.8, 1.0), (2.0, 0.8)]
    drag(pinning, [seen(pinning, f"{x}, 0, {z}") for x, z in corners])
    expect(pinning.button("Draw a path")).to_have_attribute("aria-pressed", "false")
    (line,) = wait_and_read(pinning)
    assert 1.8 <= float(re.fullmatch(r"path of (\d+\.\d) m", line)[1]) <= 2.2
    assert pinning.player("player.pins.line.object.visible && player.pins.line.points.length > 10")
    path = generate(pinning, told)["constraints"]["path"]
    assert math.dist(path[0], corners[0]) < 0.05
    assert math.dist(path[-1], corners[-1]) < 0.05
    assert min(math.dist(point, corners[1]) for point in path) < 0.12
    pinning.button(f"Remove {line}").click()
    shows(pinning, [])
    wait_for(lambda: not pinning.player("player.pins.line.object.visible"), "the line to go")


def wait_and_read(tab: Tab) -> list[str]:
    wait_for(lambda: pinned(tab), "something to be listed")
    return pinned(tab)


def test_a_line_too_short_is_said_and_escape_puts_the_pencil_down(pinning):
    pinning.button("Draw a path").click()
    expect(pinning.page.get_by_text("Draw on the floor")).to_be_visible()
    drag(pinning, [seen(pinning, "0.4, 0, 0.2"), seen(pinning, "0.45, 0, 0.2")])
    expect(pinning.page.get_by_text("That was too short")).to_be_visible()
    assert pinned(pinning) == []
    before = pinning.player("player.stage.camera.position.toArray()")
    pinning.page.keyboard.press("Escape")
    expect(pinning.button("Draw a path")).to_have_attribute("aria-pressed", "false")
    drag(pinning, [seen(pinning, "0.4, 0, 0.2"), seen(pinning, "1.5, 0, 0.2")])
    assert pinned(pinning) == []
    assert pinning.player("player.stage.camera.position.toArray()") != before, "the mouse turns the camera again"


def test_what_could_not_be_met_is_said(pinning, told):
    pinning.button("With the keyboard").click()
    pinning.page.get_by_label("Path: points x,z in metres").fill("0,0 0,9")
    pinning.page.get_by_label("Path: points x,z in metres").press("Enter")
    shows(pinning, ["path of 9.0 m"])
    generate(pinning, told)
    expect(pinning.page.get_by_text("The path is 9.0 m long; it is followed for 5.0 m.")).to_have_count(2)
    expect(pinning.page.get_by_role("heading", name="Not met")).to_be_visible()


def test_a_pose_and_frames_are_pinned(pinning, told):
    page = pinning.page
    page.get_by_role("button", name=re.compile("^Take 2, ")).click()
    go_to(pinning, 30)
    pinning.button("Pin this pose").click()
    shows(pinning, ["pose of take 2 at 1.5 s"])
    hips = pinning.player("Array.from(player.actors[1].pose.places.slice(0, 3))")
    wait_for(lambda: pinning.player("player.pins.ghosts.length") == 1, "its ghost")
    assert pinning.player("player.pins.ghosts[0].object.visible")
    assert math.dist(pinning.player("player.pins.ghosts[0].root.toArray()"), hips) < 0.01
    go_to(pinning, 9)
    pinning.button("Keep frames").click()
    shows(pinning, ["pose of take 2 at 1.5 s", "frames 0–9 of take 2"])
    page.get_by_label("Loop: end as it began").check()
    given = generate(pinning, told)["constraints"]
    assert [(at, frames) for at, frames, _ in given["kept"]] == [(30, 1), (0, 10)]
    assert math.dist(given["kept"][0][2], hips) < 0.01
    assert given["loop"] is True
    expect(page.get_by_role("row", name=re.compile("^Pinned"))).to_contain_text("pose of take 2 at 1.5 s")
    pinning.button("Clear").click()
    shows(pinning, [])
    expect(page.get_by_label("Loop: end as it began")).not_to_be_checked()
    wait_for(lambda: pinning.player("player.pins.ghosts.length") == 0, "the ghosts to go")


def test_a_joint_is_dragged_to_its_place(pinning, told):
    go_to(pinning, 20)
    pinning.button("Pin a joint").click()
    expect(pinning.page.get_by_text("Drag a dot to where that joint is to be.")).to_be_visible()
    wait_for(lambda: pinning.player("player.tools.dots.visible"), "the dots")
    wrist = pinning.player("player.actors[0].take.skeleton.joints.indexOf('left_wrist')")
    place = JOINT.replace("argument", str(wrist))
    x, y = seen(pinning, place)
    before = pinning.player("player.stage.camera.position.toArray()")
    drag(pinning, [(x, y), (x + 40, y - 90)])
    shows(pinning, ["left wrist at 1.0 s"])
    assert pinning.player("player.stage.camera.position.toArray()") == before, "the camera stays"
    assert pinning.player("player.pins.balls.length") == 1
    (joint, frame, there), *others = generate(pinning, told)["constraints"]["pins"]
    assert (joint, frame, others) == ("left_wrist", 20, [])
    assert math.dist(seen(pinning, ", ".join(map(str, there))), (x + 40, y - 90)) < 6
    expect(pinning.button("Pin a joint")).to_have_attribute("aria-pressed", "false")


def test_without_the_mouse(pinning, told):
    """Every pin with the keyboard alone, mistakes included."""
    page, keys = pinning.page, pinning.page.keyboard
    go_to(pinning, 40)
    pinning.button("Pin this pose").focus()
    keys.press("Enter")
    shows(pinning, ["pose of take 1 at 2.0 s"])
    pinning.button("With the keyboard").focus()
    keys.press("Enter")
    page.get_by_label("Path: points x,z in metres").focus()
    keys.type("0,0 0;1")
    keys.press("Enter")
    expect(page.get_by_role("alert").get_by_text("Point of the path is '0'")).to_be_visible()
    page.get_by_label("Path: points x,z in metres").fill("0,0 0,1 1,2")
    keys.press("Enter")
    shows(pinning, ["pose of take 1 at 2.0 s", "path of 2.4 m"])
    expect(page.get_by_text("Point of the path is")).to_have_count(0)
    page.get_by_label("Joint", exact=True).select_option("head")
    page.get_by_label(re.compile("^Its place x, y, z")).fill("0, 1.5, 1")
    keys.press("Enter")
    shows(pinning, ["pose of take 1 at 2.0 s", "path of 2.4 m", "head at 2.0 s"])
    pinning.button("Remove path of 2.4 m").focus()
    keys.press("Enter")
    shows(pinning, ["pose of take 1 at 2.0 s", "head at 2.0 s"])
    keys.press("Control+Enter")
    pinning.takes(8)
    given = json.loads(told.read_text().splitlines()[-1])["constraints"]
    assert (given["pins"], given["path"]) == ([["head", 40, [0.0, 1.5, 1.0]]], [])


def test_another_engine_has_only_its_own_controls(pinning):
    page = pinning.page
    composed(page, "Engine").select_option("action2motion")
    expect(page.get_by_role("tab", name="Text")).to_have_count(0)
    for name in ("Constraints", "Advanced"):
        expect(page.get_by_role("button", name=name)).to_be_hidden()
    expect(composed(page, "Style")).to_be_hidden()
    page.get_by_role("tab", name="Body").click()
    expect(page.get_by_role("region", name="Bones of the next takes")).to_be_visible()
    composed(page, "Engine").select_option("stand-in")
    expect(page.get_by_role("tab", name="Text")).to_be_visible()
    expect(composed(page, "Style")).to_be_visible()


GENERATE = ".left .go"
FIELDS = {"Action": "Action", "Text": "Describe the motion"}


def bottom(tab: Tab, selector: str) -> float:
    box = tab.page.locator(selector).bounding_box()
    return box["y"] + box["height"]


def below(tab: Tab) -> bool:
    return bottom(tab, ".left .form") <= tab.page.locator(GENERATE).bounding_box()["y"] + 1


@pytest.mark.parametrize(("width", "height"), [(1280, 720), (1440, 900)])
def test_the_button_stays_in_sight_however_much_is_open(chromium, constrained_address, width, height):
    context = chromium.new_context(viewport={"width": width, "height": height}, reduced_motion="reduce")
    try:
        tab = Tab(context.new_page(), constrained_address).open()
        head = tab.button("Constraints")
        if head.get_attribute("aria-expanded") == "false":
            head.click()
        tab.button("With the keyboard").click()
        tab.page.get_by_role("button", name="Advanced").click()
        for name in FIELDS:
            tab.page.get_by_role("tab", name=name).click()
            expect(tab.page.get_by_role("tab", name=name)).to_have_attribute("aria-selected", "true")
            expect(
                tab.page.get_by_label("Action" if name == "Action" else "Describe", exact=name == "Action")
            ).to_be_visible()
            wait_for(lambda: below(tab) and bottom(tab, GENERATE) <= height, "room for the button under the form", 10)
        assert tab.faults == []
    finally:
        context.close()
