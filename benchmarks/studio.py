"""How long a person waits in the studio: from the command to moving people, and from a press to its outcome.

    python benchmarks/studio.py [--rounds 5] [--moving]

Times are medians in Chromium on this machine, which draws the stage in software; with `--moving` the takes play
meanwhile, without it they stand still (as for people who asked their system for less motion).
"""

from __future__ import annotations

import argparse
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from tests.conftest import CHROMIUM_FLAGS  # noqa: E402 - no package, found through the line above
from tests.ui.conftest import _answers, free_port, wait_for  # noqa: E402


def timed(act: Callable[[], object]) -> float:
    """Seconds something takes."""
    began = time.perf_counter()
    act()
    return time.perf_counter() - began


def one_round(page: Page, url: str) -> dict[str, float]:
    def takes(count: int) -> None:
        wait_for(lambda: page.locator(".take").count() == count, f"{count} takes", 120)

    def open_page() -> None:
        page.goto(url)
        takes(4)

    def first_picture() -> None:
        page.locator(".motion-player").wait_for()
        wait_for(
            lambda: page.locator(".motion-player").evaluate("host => host.player?.actors.length") == 4, "the stage"
        )

    def generate() -> None:
        page.keyboard.press("Control+Enter")
        takes(8)

    def export(kind: str) -> None:
        page.get_by_role("radio", name=kind).click()
        with page.expect_download(timeout=120_000):
            page.get_by_role("button", name=f"Export take 5 as {kind}").click()

    found = {"page opened, 4 takes there": timed(open_page), "and on the stage, after": timed(first_picture)}
    found["4 more takes"] = timed(generate)
    page.get_by_role("tab", name="Export").click()
    found["BVH exported"] = timed(lambda: export("BVH"))
    found["MP4 of 3 s at 1280 x 720 exported"] = timed(lambda: export("MP4"))
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--moving", action="store_true")
    asked = parser.parse_args()
    port = free_port()
    url = f"http://127.0.0.1:{port}/"
    command = [sys.executable, "-m", "studio.cli", "studio", "--port", str(port), "--no-browser"]
    folder = tempfile.TemporaryDirectory()  # a library of its own
    places = os.environ | {"MOTIONLOOM_LIBRARY": f"{folder.name}/library.db"}
    server = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=places)
    try:
        start = timed(lambda: wait_for(lambda: _answers(url), "the server"))
        rounds = []
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=CHROMIUM_FLAGS)
            for _ in range(asked.rounds):
                calm = "no-preference" if asked.moving else "reduce"
                context = browser.new_context(viewport={"width": 1440, "height": 900}, reduced_motion=calm)
                rounds.append(one_round(context.new_page(), url))
                context.close()
    finally:
        server.terminate()
        server.wait(20)
    print(f"{'command to first answer':<40}{start:6.2f} s")
    print(f"{'first page, 4 takes there':<40}{rounds[0]['page opened, 4 takes there']:6.2f} s")
    for name in rounds[0]:
        later = [found[name] for found in rounds[1:] or rounds]
        print(f"{name:<40}{statistics.median(later):6.2f} s   ({min(later):.2f} to {max(later):.2f})")


if __name__ == "__main__":
    main()
