"""The player in a real Panel app on localhost: Python to browser, browser to Python."""

from __future__ import annotations

import socket
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from engines.motion import Motion
from tests.viewers.web.conftest import PATIENCE, SIZE
from tests.viewers.web.synthetic import walk
from viewers.web.player import PanelPlayer

pytestmark = [pytest.mark.ui, pytest.mark.timeout(240)]

FIND = """() => {
    const search = (root) => {
        for (const e of root.querySelectorAll('*')) {
            const found = e.player ? e : e.shadowRoot && search(e.shadowRoot);
            if (found) return found;
        }
        return null;
    };
    return search(document);
}"""


class App:
    """One session of an app with a player in it: the Python half and the page."""

    def __init__(self, page: Any, player: Any, complaints: list[str], requests: list[str]) -> None:
        self.page, self.player, self.complaints, self.requests = page, player, complaints, requests
        self.host = page.evaluate_handle(FIND)

    def js(self, expression: str) -> Any:
        return self.page.evaluate(f"(host) => {{ const player = host.player; return ({expression}); }}", self.host)

    def until(self, condition: Callable[[], bool], what: str, seconds: float = 90.0) -> None:
        """Both halves run by themselves; waits until they agree."""
        end = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < end, f"not reached: {what}"
            self.page.wait_for_timeout(50)


@pytest.fixture
def serve(chromium: Any) -> Iterator[Callable[..., App]]:
    import panel as pn

    servers, apps = [], []

    def start(motions: Motion | list[Motion], **options: Any) -> App:
        made: list[PanelPlayer] = []

        def app() -> Any:
            made.append(PanelPlayer(motions, **{"body": "stick", "height": 420, **options}))
            return pn.Column("# A stage", made[-1], sizing_mode="stretch_width")

        port = _free_port()
        servers.append(pn.serve(app, port=port, threaded=True, show=False, verbose=False))
        _await(port)
        page, complaints, requests = chromium.new_page(viewport=SIZE), [], []
        page.set_default_timeout(PATIENCE)
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on("console", lambda m: complaints.append(m.text) if m.type == "error" else None)
        page.on("request", lambda request: requests.append(request.url))
        page.goto(f"http://localhost:{port}/")
        page.wait_for_selector(".motion-player canvas")
        apps.append(App(page, made[-1], complaints, requests))
        apps[-1].until(lambda: made[-1].ready, "ready")
        return apps[-1]

    yield start
    for app in apps:
        app.page.close()
    for server in servers:
        server.stop()
    assert [text for app in apps for text in app.complaints] == []


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("localhost", 0))
        return probe.getsockname()[1]


def _await(port: int) -> None:
    for _ in range(400):
        with socket.socket() as probe:
            if probe.connect_ex(("localhost", port)) == 0:
                return
        time.sleep(0.05)
    raise AssertionError("the server did not start")


def test_both_ways(serve: Callable[..., App]):
    app = serve([walk(4.0), walk(3.0)], ghosts=6)
    player = app.player
    assert app.js("[player.actors.length, player.options.ghosts]") == [2, 6]
    assert all("//localhost" in url or url.startswith("blob:") for url in app.requests), "nothing comes from elsewhere"

    player.frame = 30
    app.until(lambda: app.js("player.frame") == 30, "frame from Python")
    player.param.update(show="skeleton", camera="left", theme="light", mirror=True)
    app.until(
        lambda: (
            app.js("['show', 'camera', 'theme', 'mirror'].map((name) => player.options[name])")
            == ["skeleton", "left", "light", True]
        ),
        "options from Python",
    )

    app.js("host.shadowRoot.querySelector('.view').focus()")
    app.page.keyboard.press("ArrowRight")
    app.until(lambda: player.frame == 31, "frame from the browser")
    app.page.keyboard.press("g")
    app.until(lambda: player.ghosts == 0, "ghosts from the browser")
    app.page.keyboard.press("i")
    app.until(lambda: player.selection == [31, 80] and player.loop == "selection", "the range from the browser")
    player.selection = [5, 15]
    app.until(lambda: app.js("player.clock.selection") == [5, 15], "the range from Python")
    app.page.get_by_role("button", name="Take 2").click()
    app.until(lambda: player.selected == 1, "selection from the browser")


def test_playing_sends_a_few_frames_and_the_last(serve: Callable[..., App]):
    app = serve(walk(3.0), loop="off", show="skeleton")
    frames: list[int] = []
    app.player.param.watch(lambda event: frames.append(event.new), "frame")
    app.player.play()
    app.until(lambda: app.js("player.options.playing"), "playing")
    app.until(lambda: not app.player.playing, "the end")
    app.until(lambda: app.player.frame == 59, "the last frame")
    assert len(frames) >= 3
    assert frames == sorted(frames)


def test_new_motions_travel_alone(serve: Callable[..., App]):
    app = serve(walk(2.0), frame=20)
    app.js("player.body.mark = 1")
    app.player.motions = [walk(1.0), walk(1.0), walk(1.0)]
    app.until(lambda: app.js("player.actors.length") == 3, "three figures")
    assert app.js("player.body.mark") == 1, "the body stayed"
    app.until(lambda: app.player.frame == 0, "from the start again")


def test_two_sessions_do_not_meet(serve: Callable[..., App]):
    one, two = serve(walk(2.0)), serve(walk(2.0))
    one.player.frame = 9
    one.until(lambda: one.js("player.frame") == 9, "frame")
    assert (two.player.frame, two.js("player.frame")) == (0, 0)


def test_taken_out_of_the_layout_it_stops(serve: Callable[..., App]):
    app = serve(walk(2.0), playing=True)
    app.until(lambda: app.player.frame > 0, "playing")
    stage = app.page.evaluate_handle("(host) => host.player.stage", app.host)
    app.page.evaluate("() => Bokeh.documents[0].clear()")
    app.until(lambda: app.page.evaluate("(stage) => stage.stopped", stage), "taken down")
