"""How quick a sequence is made and made again after a change, in how much memory, and how quick its timeline is.

    python benchmarks/sequence.py [--minutes 10] [--engine loom]

A block of a walk and a transition last six seconds. Memory is what Python allocated at most while the pieces of the
sequence passed by, and nobody kept them; what the engine and the cache hold is in both lengths. Zooming is one turn of
the wheel over the timeline, its drawing included, in Chromium.
"""

from __future__ import annotations

import argparse
import os
import shutil
import sys
import tempfile
import time
import tracemalloc
from dataclasses import replace
from pathlib import Path

from playwright.sync_api import sync_playwright

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from studio import sequencing, tasks
from studio.library.motions import Cache
from studio.sequence import Block, Sequence
from studio.settings import GenerateSettings
from tests.conftest import CHROMIUM_FLAGS
from tests.viewers.web.synthetic import walk
from viewers.web.player import save_html

ZOOM = """(blocks) => {
    const host = document.querySelector(".motion-player"), { model } = window.motionPlayer;
    const known = { actions: [], styles: [], engines: [], words: true, error: "", heard: 0 };
    const made = { kind: "action", style: "", seed: 7, transition: 0.2, locked: false, engine: "", made: true };
    const block = (_, i) => ({ ...made, id: String(i), what: `action ${i % 20}`, seconds: 1 });
    model.set("sequence", { ...known, blocks: Array.from({ length: blocks }, block) });
    const view = host.shadowRoot.querySelector(".seq-view"), at = view.getBoundingClientRect();
    const clientX = at.left + at.width / 2;
    const turn = (deltaY) => view.dispatchEvent(new WheelEvent("wheel", { deltaY, clientX, cancelable: true }));
    const start = performance.now();
    for (let i = 0; i < 40; i++) turn(i % 20 < 10 ? -150 : 150);
    return [(performance.now() - start) / 40, host.shadowRoot.querySelectorAll(".track .block").length];
}"""


def asked(engine: str, minutes: float) -> GenerateSettings:
    """So many minutes of walking."""
    blocks = tuple(Block("walk", seconds=5.4, seed=i) for i in range(round(minutes * 10)))
    return GenerateSettings(engine=engine, count=1, sequence=Sequence(blocks))


def making(engine: str, minutes: float) -> None:
    """Time and memory of a minute and of all."""
    print(f"{'made by ' + engine:28}{'blocks':>8}{'seconds':>10}{'one changed':>13}{'memory':>12}")
    tasks.generate(asked(engine, 0.2))
    for length in (1.0, minutes):
        sequencing.at_hand = Cache(64 * 2**20)
        settings = asked(engine, length)
        start = time.perf_counter()
        whole = tasks.generate(settings)[0]
        first = time.perf_counter() - start
        one = settings.sequence.changed(settings.sequence.blocks[-2].id, seed=99_999)
        start = time.perf_counter()
        tasks.generate(replace(settings, sequence=one))
        again = time.perf_counter() - start
        sequencing.at_hand = Cache(8 * 2**20)
        tracemalloc.start()
        for _piece in sequencing.pieces(settings):
            pass
        memory = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        blocks = len(settings.sequence.blocks)
        print(f"{whole.duration / 60:<28.1f}{blocks:>8}{first:>10.1f}{again:>13.2f}{memory / 2**20:>9.1f} MB")


def zooming() -> None:
    """Milliseconds a turn of the wheel."""
    print(f"{'zooming the timeline':28}{'elements':>8}{'ms':>10}")
    path = shutil.which("chromium") or shutil.which("google-chrome")
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=CHROMIUM_FLAGS)
        page = browser.new_page(viewport={"width": 1440, "height": 900})
        page.goto(save_html(walk(2.0), Path(folder) / "player.html", body="stick").as_uri())
        page.wait_for_function("() => window.motionPlayer?.model.get('ready')")
        for blocks in (10, 100, 500):
            cost, elements = page.evaluate(ZOOM, blocks)
            print(f"{blocks:<5}{'blocks':23}{elements:>8}{cost:>10.2f}")
        browser.close()


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--engine", default="loom")
    told = parser.parse_args()
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    making(told.engine, told.minutes)
    zooming()


if __name__ == "__main__":
    main()
