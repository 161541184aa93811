from __future__ import annotations

import socket
import threading
from types import SimpleNamespace

import pytest
from bokeh.document import Document
from panel.io.state import set_curdoc

from engines.errors import OutOfRangeError
from studio import app
from studio.takes import TakeList
from studio.views.inspector import describe
from studio.views.takes import card
from tests.studio.fakes import METRICS, sway


@pytest.fixture
def taken():
    """Two ports of this machine in use, one after the other."""
    for base in range(41000, 60000, 7):
        first, second = socket.socket(), socket.socket()
        try:
            first.bind(("127.0.0.1", base))
            second.bind(("127.0.0.1", base + 1))
        except OSError:
            first.close()
            second.close()
            continue
        first.listen()
        second.listen()
        yield base
        first.close()
        second.close()
        return


def test_a_taken_port_gives_way_to_the_next_free_one(taken):
    assert app.free_port(taken) >= taken + 2


def test_no_free_port_is_said_with_the_range(taken, monkeypatch):
    monkeypatch.setattr(app, "_PORTS_TRIED", 2)
    with pytest.raises(OutOfRangeError, match=rf"none is free from {taken} to {taken + 1}"):
        app.free_port(taken)


def test_an_address_that_is_not_ours_is_refused():
    with pytest.raises(OutOfRangeError, match=r"192\.0\.2\.1"):
        app.free_port(5006, "192.0.2.1")


def made(**options):
    return TakeList().add([sway(frames=40)], group="g", **options)[0]


def test_a_card_says_seed_place_and_measures():
    from studio.settings import GenerateSettings

    shown = card(made(settings=GenerateSettings(seed=9, count=1), metrics=[METRICS]), METRICS)
    assert (shown["line"], shown["about"], shown["again"]) == ("seed 9 · 1 of 1", "1 × 2.0 s", True)
    assert [m["word"] for m in shown["measures"]] == ["skate 5.0", "jitter 40", "floor 0.1"]


def test_a_file_name_is_text_not_markup():
    text = describe(made(source="<img src=x onerror=alert(1)>.bvh"), {})
    assert "<img" not in text
    assert "&lt;img" in text


def test_a_page_is_built_and_ends_with_its_session(engine, queue, monkeypatch):
    """The whole page without a browser: every area has its root, and closing the tab stops its work."""
    owners, gate = [], threading.Event()
    submit = queue.submit
    monkeypatch.setattr(
        queue, "submit", lambda who, *rest, **options: owners.append(who) or submit(who, *rest, **options)
    )
    document = Document()
    with set_curdoc(document):
        app.make_app(queue).server_doc(document, title="motionloom")
        areas = {root.name for root in document.roots}
        assert {"topbar", "compose_tabs", "compose", "browse", "stage", "takes", "inspector", "page"} <= areas
    assert owners, "loading the page asks for the engine"
    work = submit(owners[0], "work", lambda _progress, _cancel: gate.wait(10))
    for destroyed in list(document.session_destroyed_callbacks):
        destroyed(SimpleNamespace(_document=document, id="session"))
    gate.set()
    assert work.wait(10)
    assert work.cancel_asked()
