"""The real app in a real Chromium: one server for all tests, a fresh browser context for each."""

from __future__ import annotations

import os
import re
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from playwright.sync_api import Browser, BrowserContext, Page, expect

ROOT = Path(__file__).resolve().parents[2]
# a machine without a GPU draws the stage in software while the engine works
PATIENCE = 60_000
expect.set_options(timeout=PATIENCE / 2)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if Path(item.fspath).is_relative_to(Path(__file__).parent):
            item.add_marker(pytest.mark.ui)
            item.add_marker(pytest.mark.timeout(240))


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@pytest.fixture(scope="session")
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """`motionloom studio` as a person starts it."""
    with serving("studio.cli", tmp_path_factory.mktemp("studio")) as url:
        yield url


@pytest.fixture(scope="session")
def told(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The file to which the stand-in writes what it is told."""
    return tmp_path_factory.mktemp("told") / "told.jsonl"


@pytest.fixture(scope="session")
def constrained_address(tmp_path_factory: pytest.TempPathFactory, told: Path) -> Iterator[str]:
    """The same with a quick stand-in for an engine, which takes styles, words and pins."""
    folder = tmp_path_factory.mktemp("constrained")
    with serving("tests.ui.constrained_studio", folder, {"MOTIONLOOM_TEST_TOLD": str(told)}) as url:
        yield url


@contextmanager
def serving(module: str, folder: Path, more: dict[str, str] | None = None) -> Iterator[str]:
    """A studio in a process of its own; at the end nothing may have gone wrong in it or be left of it."""
    log = folder / "server.log"
    url, server = start(module, folder, free_port(), more)
    try:
        yield url
    finally:
        server.terminate()
        server.wait(20)
    assert "Traceback" not in log.read_text(), log.read_text()
    assert not list(folder.glob("motionloom-*")), "files of sessions are left behind"


def start(
    module: str, folder: Path, port: int, more: dict[str, str] | None = None
) -> tuple[str, subprocess.Popen[bytes]]:
    """Start a studio that keeps its library and its files in a folder. Returns its address once it answers."""
    log = folder / "server.log"
    command = [sys.executable, "-m", module, "studio", "--port", str(port), "--no-browser"]
    places = {
        "TMPDIR": str(folder),
        "MOTIONLOOM_LIBRARY": str(folder / "library.db"),
        "MOTIONLOOM_CHARACTERS": str(folder / "characters"),
    }
    with log.open("a") as out:
        server = subprocess.Popen(
            command, cwd=ROOT, stdout=out, stderr=subprocess.STDOUT, env=os.environ | places | (more or {})
        )
    url = f"http://127.0.0.1:{port}/"
    wait_for(lambda: server.poll() is not None or _answers(url), "the server to answer")
    assert server.poll() is None, log.read_text()
    return url, server


def _answers(url: str) -> bool:
    try:
        with urllib.request.urlopen(url, timeout=20) as reply:
            return reply.status == 200
    except (urllib.error.URLError, OSError):
        return False


def wait_for(true: Callable[[], object], what: str, seconds: float = 60.0) -> None:
    """Ask until it is so."""
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end, f"waited {seconds:g} s for {what}"
        time.sleep(0.1)


class Tab:
    """A page of the studio, with what went wrong in it."""

    def __init__(self, page: Page, url: str) -> None:
        self.page, self.url = page, url
        self.faults: list[str] = []
        self.foreign: list[str] = []
        page.set_default_timeout(PATIENCE)
        page.on("console", lambda m: self.faults.append(m.text) if m.type == "error" else None)
        page.on("pageerror", lambda e: self.faults.append(str(e)))
        page.on("request", lambda r: self._mind(r.url))
        page.on("websocket", lambda w: self._mind(w.url))

    def _mind(self, url: str) -> None:
        if not re.match(r"(https?|ws)://127\.0\.0\.1:\d+/|blob:|data:", url):
            self.foreign.append(url)

    def open(self, takes: int = 4) -> Tab:
        """Load the page and wait for its first takes."""
        self.page.goto(self.url)
        self.takes(takes)
        self.page.locator("#splash.gone").wait_for(state="attached")
        return self

    def takes(self, count: int) -> None:
        """Wait until the gallery holds so many takes."""
        wait_for(lambda: self.page.locator(".take").count() == count, f"{count} takes")

    def player(self, expression: str) -> object:
        """Ask the 3D player: `player` is the object, `expression` JavaScript."""
        self.page.locator(".motion-player").wait_for()
        return self.page.locator(".motion-player").evaluate(
            f"(host) => {{ const player = host.player; return {expression} }}"
        )

    def button(self, name: str):
        """A button by its exact name."""
        return self.page.get_by_role("button", name=name, exact=True)


@pytest.fixture
def context(chromium: Browser) -> Iterator[BrowserContext]:
    # the takes stand still, since drawing them in software would take the engine's time; one test lets them move
    made = chromium.new_context(viewport={"width": 1280, "height": 720}, accept_downloads=True, reduced_motion="reduce")
    yield made
    made.close()


@pytest.fixture
def tab(context: BrowserContext, address: str) -> Iterator[Tab]:
    """An open studio. After the test: no console error, no request that left this machine."""
    made = Tab(context.new_page(), address).open()
    yield made
    assert made.faults == []
    assert made.foreign == []
