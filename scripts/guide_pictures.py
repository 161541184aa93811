"""Draw the pictures of docs/guide.md: the studio is driven in Chromium, step by step, as the guide says.

    python scripts/guide_pictures.py [--out docs/guide] [--step NAME]

`STEPS` is the guide in code: `tests/ui/test_guide.py` walks through the same, and sees that the guide tells of each.
"""

from __future__ import annotations

import argparse
import io
import logging
import os
import re
import shutil
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from PIL import Image
from playwright.sync_api import expect, sync_playwright

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from engines import registry  # noqa: E402 - below, found through the line above
from tests.conftest import CHROMIUM_FLAGS  # noqa: E402 - no package, found through the line above
from tests.ui.conftest import Tab, serving, wait_for  # noqa: E402

log = logging.getLogger("guide")

SIZE = (1280, 800)
LARGEST = 120_000
"""Bytes of a picture at most."""


@dataclass(frozen=True)
class Step:
    """One step of the guide."""

    name: str
    """Of its picture, docs/guide/NAME.webp."""
    title: str
    """Its heading in the guide."""
    act: Callable[[Tab], None]
    """Does it, and waits until it is seen."""
    frame: int = 24
    """Where the takes stand still in the picture."""
    there: Callable[[], object] = lambda: True
    """Whether the weights that it takes are here."""


def generate(tab: Tab, more: int) -> None:
    """Press Generate and wait for so many more takes."""
    before = tab.page.locator(".take").count()
    button = tab.page.get_by_role("button", name=re.compile("^Generate"))
    expect(button).to_be_enabled()
    button.click()
    tab.takes(before + more)
    wait_for(lambda: tab.player("player.actors.length") == more, "the takes on the stage")


def card(tab: Tab, number: int):
    """The card of a take."""
    return tab.page.get_by_role("button", name=re.compile(f"^Take {number}, "))


def of_action(tab: Tab) -> None:
    """An action by its name."""
    tab.page.get_by_role("tab", name="Action", exact=True).click()
    field = tab.page.get_by_label("Action", exact=True)
    field.fill("wave right hand")
    field.press("Enter")
    lock = tab.button("Keep this seed")
    lock.click()
    expect(lock).to_have_attribute("aria-pressed", "true")
    generate(tab, 4)


def in_words(tab: Tab) -> None:
    """A sentence."""
    tab.player("player.set('arrangement', 'side')")
    tab.page.get_by_role("tab", name="Text", exact=True).click()
    tab.page.get_by_label("Describe the motion").fill("a person walks forward and turns left")
    tab.page.get_by_label("Describe the motion").blur()
    generate(tab, 4)


def looked_at(tab: Tab) -> None:
    """One take alone, with its ghosts and its way."""
    card(tab, 5).click()
    tab.page.get_by_role("radio", name="One", exact=True).click()
    wait_for(lambda: tab.player("player.actors.length") == 1, "one take on the stage")
    for option, value in {"show": "'both'", "trail": "true", "contacts": "true", "ghosts": "8"}.items():
        tab.player(f"player.set('{option}', {value})")


def compared(tab: Tab) -> None:
    """Three takes in one place, in sync."""
    for option, value in {"show": "'body'", "trail": "false", "contacts": "false", "ghosts": "0"}.items():
        tab.player(f"player.set('{option}', {value})")
    for number in (5, 6, 8):
        card(tab, number).click(modifiers=["Control"])
    wait_for(lambda: tab.player("player.actors.length") == 3, "three takes on the stage")
    tab.player("player.set('arrangement', 'overlay')")


def varied(tab: Tab) -> None:
    """Other ways to go on from the playhead."""
    card(tab, 1).click()
    tab.page.get_by_role("radio", name=re.compile(r"^All \d")).click()
    tab.player("player.seek(30)")
    tab.page.get_by_role("tab", name="Vary", exact=True).click()
    tab.page.get_by_label("What follows").fill("run")
    tab.page.get_by_label("Ways").fill("3")
    tab.page.get_by_label("Ways").blur()
    before = tab.page.locator(".take").count()
    tab.page.get_by_role("button", name="Go on from 1.5 s").click()
    tab.takes(before + 3)
    wait_for(lambda: tab.player("player.actors.length") == 3, "three ways on")


def styled(tab: Tab) -> None:
    """A take in a style, beside the take."""
    card(tab, 1).click()
    tab.page.get_by_role("tab", name="Style", exact=True).click()
    styles = tab.page.get_by_role("listbox", name="Styles this engine knows")
    styles.get_by_role("option", name="musical", exact=True).click()
    before = tab.page.locator(".take").count()
    tab.page.get_by_role("button", name="Stylise take 1").click()
    tab.takes(before + 1)
    wait_for(lambda: tab.player("player.actors.length") == 2, "before and after")


def pinned(tab: Tab) -> None:
    """A way over the floor."""
    tab.page.get_by_role("tab", name="Action", exact=True).click()
    tab.page.get_by_label("Action", exact=True).fill("walk")
    tab.page.get_by_label("Action", exact=True).press("Enter")
    head = tab.button("Constraints")
    if head.get_attribute("aria-expanded") == "false":
        head.click()
    tab.button("With the keyboard").click()
    path = tab.page.get_by_label("Path: points x,z in metres")
    path.fill("0,0 0,1 1,2")
    path.press("Enter")
    expect(tab.page.get_by_role("button", name=re.compile("^Remove path"))).to_be_visible()
    tab.page.get_by_label("Variations").fill("1")
    tab.page.get_by_label("Variations").press("Enter")
    generate(tab, 1)


def arranged(tab: Tab) -> None:
    """Blocks on the timeline, made into one motion."""
    tab.page.get_by_role("tab", name="Sequence", exact=True).click()
    for count, action in enumerate(("walk", "turn left", "run", "bow"), 1):
        tab.page.get_by_role("option", name=action, exact=True).click()
        wait_for(lambda count=count: tab.player("player.sequence.blocks.length") == count, f"block {count}")
    words = tab.page.get_by_label("A block in words")
    words.fill("a person waves, proudly")
    words.press("Enter")
    expect(tab.page.get_by_role("button", name=re.compile("^Block 5 of 5: a person waves"))).to_be_visible()
    before = tab.page.locator(".take").count()
    tab.page.get_by_role("button", name="Make the sequence").click()
    tab.takes(before + 1)
    wait_for(lambda: tab.player("player.sequence.blocks.every(({ made }) => made)"), "the sequence to be made")


def shaped(tab: Tab) -> None:
    """A body of another shape."""
    tab.page.get_by_role("tab", name="Body", exact=True).click()
    for name, key in {"Muscle": "End", "Gender": "Home"}.items():
        tab.page.get_by_role("slider", name=name).focus()
        tab.page.keyboard.press(key)
        expect(tab.button(f"Undo change {name.lower()}")).to_be_enabled()


def exported(tab: Tab) -> None:
    """A file of a take."""
    tab.page.get_by_role("tab", name="Export", exact=True).click()
    tab.page.get_by_role("radio", name="GLB", exact=True).click()
    with tab.page.expect_download():
        tab.page.get_by_role("button", name=re.compile("^Export take .* as GLB")).click()


def kept(tab: Tab) -> None:
    """The projects there are."""
    tab.page.get_by_label("Project name").first.fill("My first scene")
    tab.page.get_by_label("Project name").first.press("Enter")
    expect(tab.page).to_have_title("My first scene · motionloom")
    tab.page.keyboard.press("Control+Shift+p")
    expect(tab.page.get_by_role("dialog").get_by_text("My first scene")).to_be_visible()


STEPS = (
    Step("open", "Open", lambda tab: tab.takes(4)),
    Step("action", "Ask for an action", of_action),
    Step("look", "Look closely", looked_at),
    Step("compare", "Compare", compared, 40),
    Step("text", "Ask in words", in_words, 40),
    Step("vary", "Go on from a moment", varied, 50),
    Step("style", "Put it in another manner", styled, 40, registry.stylisers),
    Step("pin", "Say where", pinned, 59),
    Step("sequence", "Arrange a scene", arranged, 96),
    Step("body", "Give it a body", shaped, 30),
    Step("export", "Take it with you", exported, 30),
    Step("projects", "Keep it", kept, 30),
)
"""The guide, in its order; each begins where the one before ended."""


def picture(tab: Tab, frame: int) -> bytes:
    """The page as WebP, the takes standing still at a frame."""
    tab.player(f"player.seek({frame})")
    tab.page.wait_for_timeout(1500)  # pictures of takes, and what fades
    shot = Image.open(io.BytesIO(tab.page.screenshot()))
    for quality in (82, 74, 66, 58, 50):
        packed = io.BytesIO()
        shot.convert("RGB").save(packed, "WEBP", quality=quality, method=6)
        if packed.tell() <= LARGEST:
            break
    return packed.getvalue()


def main() -> None:
    """Walk through the guide and draw."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "guide")
    parser.add_argument("--step", default="", help="draw this one only (those before are done, not drawn)")
    asked = parser.parse_args()
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    asked.out.mkdir(parents=True, exist_ok=True)
    chromium = os.environ.get("MOTIONLOOM_CHROMIUM") or shutil.which("chromium") or shutil.which("google-chrome")
    with (
        tempfile.TemporaryDirectory(prefix="studio-") as folder,
        serving("studio.cli", Path(folder)) as url,
        sync_playwright() as play,
    ):
        browser = play.chromium.launch(executable_path=chromium, args=CHROMIUM_FLAGS)
        width, height = SIZE
        context = browser.new_context(viewport={"width": width, "height": height}, reduced_motion="reduce")
        tab = Tab(context.new_page(), url).open()
        for step in STEPS:
            if not step.there():
                continue
            step.act(tab)
            if asked.step in ("", step.name):
                file = asked.out / f"{step.name}.webp"
                file.write_bytes(picture(tab, step.frame))
                log.info("%s: %d kB", file.name, file.stat().st_size // 1000)
        browser.close()


if __name__ == "__main__":
    main()
