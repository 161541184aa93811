"""How fast the browser player draws, what travels to it, and how long that takes to encode.

    python benchmarks/player.py [--seconds 4] [--size 1280x720] [--body anny] [--hardware]

Chromium draws with SwiftShader, that is on the processor, unless `--hardware` is given. Pictures a second are those of
a playing clip, and mean little on a busy machine; the processor time Chromium spends on a picture means something there
too (all its processes and threads together).
"""

from __future__ import annotations

import argparse
import os
import shutil
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

from playwright.sync_api import sync_playwright

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from tests.viewers.textured import checkers, textured
from tests.viewers.web.synthetic import walk
from viewers.web.controls import actors_of, encode
from viewers.web.player import save_html

SOFTWARE = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
FLAGS = [
    "--no-sandbox",
    "--ignore-gpu-blocklist",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-sync",
]
CASES: list[tuple[str, int, dict[str, Any]]] = [
    ("body", 1, {}),
    ("skeleton", 1, {"show": "skeleton"}),
    ("both", 1, {"show": "both"}),
    ("body with a texture, no coarse one", 1, {"body": textured(checkers(1024))}),
    ("the same without texture", 1, {"body": replace(textured(checkers(1024)), uv=None, texture=None)}),
    ("body, 6 ghosts", 1, {"ghosts": 8}),
    ("body, trail, contacts", 1, {"trail": True, "contacts": True}),
    ("4 bodies", 4, {}),
    ("16 bodies (coarse)", 16, {}),
    ("16 skeletons", 16, {"show": "skeleton"}),
]
COUNT = """async (milliseconds) => {
    const { stage } = document.querySelector(".motion-player").player;
    const start = performance.now(), before = stage.pictures;
    const enough = () => performance.now() - start >= milliseconds && stage.pictures - before >= 10;
    while (!enough()) await new Promise((done) => setTimeout(done, 20));
    return [stage.pictures - before, performance.now() - start];
}"""
PREPARE = """() => {
    const { player } = document.querySelector(".motion-player");
    const start = performance.now();
    for (let i = 0; i < 200; i++) for (const actor of player.actors) actor.pose.sample(actor.take, i + 0.5);
    return (performance.now() - start) / 200;
}"""


def sizes(body: str) -> None:
    """Bytes and encoding time of a body and of ten seconds."""
    print(f"{'what travels':32}{'bytes':>10}{'encoded in':>14}")
    for name, count in (("body", 0), ("10 s, 20 fps, 1 take", 1), ("10 s, 20 fps, 16 takes", 16)):
        actors = actors_of([walk(10.0)] * max(count, 1))
        encode(actors[:1], body)
        _ = [actor.motion.contacts for actor in actors]
        start = time.perf_counter()
        body_data, take_data = encode(actors, body)
        spent = time.perf_counter() - start
        size = len(take_data) if count else len(body_data)
        print(f"{name:32}{size:>10,}{f'{spent * 1e3:.1f} ms' if count else '':>14}")


def processor_seconds() -> float:
    """Processor time of all processes that this one has started, directly or not (Linux)."""
    parent, spent = {}, {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rsplit(")", 1)[1].split()
        except OSError:  # it ended meanwhile
            continue
        pid = int(stat.parent.name)
        parent[pid], spent[pid] = int(fields[1]), int(fields[11]) + int(fields[12])

    def is_ours(pid: int) -> bool:
        while pid in parent:
            pid = parent[pid]
            if pid == os.getpid():
                return True
        return False

    return sum(ticks for pid, ticks in spent.items() if is_ours(pid)) / os.sysconf("SC_CLK_TCK")


def speeds(arguments: argparse.Namespace) -> None:
    """Pictures a second of each case."""
    width, height = map(int, arguments.size.split("x"))
    print(f"\n{f'drawing at {arguments.size}':32}{'pictures/s':>12}{'CPU ms each':>12}{'poses, ms':>12}")
    with sync_playwright() as playwright, tempfile.TemporaryDirectory() as folder:
        flags = FLAGS if arguments.hardware else FLAGS + SOFTWARE
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=flags)
        for name, count, options in CASES:
            shown = {"body": arguments.body, "in_place": True, **options}
            path = save_html([walk(10.0)] * count, Path(folder) / "player.html", **shown)
            page = browser.new_page(viewport={"width": width, "height": height})
            page.goto(path.as_uri())
            page.wait_for_function("() => window.motionPlayer?.model.get('ready')")
            page.evaluate("motionPlayer.model.set('frame', 60); motionPlayer.model.set('playing', true)")
            page.evaluate(COUNT, 1000)
            before = processor_seconds()
            pictures, elapsed = page.evaluate(COUNT, arguments.seconds * 1000)
            spent = (processor_seconds() - before) * 1e3 / max(pictures, 1)
            print(
                f"{name:32}{pictures / elapsed * 1e3:>12.1f}{spent:>12.0f}{page.evaluate(PREPARE):>12.2f}", flush=True
            )
            page.close()
        browser.close()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=4.0, help="measured for each case, and at least 10 pictures")
    parser.add_argument("--size", default="1280x720", help="of the whole player, controls included")
    parser.add_argument("--body", default="anny")
    parser.add_argument("--hardware", action="store_true", help="draw with the machine's graphics card")
    arguments = parser.parse_args()
    sizes(arguments.body)
    speeds(arguments)


if __name__ == "__main__":
    main()
