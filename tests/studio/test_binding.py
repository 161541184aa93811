from __future__ import annotations

import param
import pytest
from bokeh.document import Document
from panel.io.state import set_curdoc
from panel.models.esm import DataEvent

from studio.views.binding import tie
from studio.views.parts import Page


class State(param.Parameterized):
    theme = param.String("dark")


@pytest.fixture
def document():
    document = Document()
    with set_curdoc(document):
        yield document


def test_all_that_follows_from_a_value_a_person_sets_travels_in_one_message(document):
    page, state, held = Page(), State(), []
    tie(page, state, theme="theme")
    state.param.watch(lambda _: held.append(document.callbacks.hold_value), "theme")
    page.theme = "light"
    assert (state.theme, held) == ("light", ["combine"])
    assert document.callbacks.hold_value is None


def test_all_that_follows_from_a_press_travels_in_one_message(document):
    held = []
    page = Page().on("undo", lambda _: held.append(document.callbacks.hold_value))
    page._process_event(DataEvent(None, {"do": "undo"}))
    assert held == ["combine"]
    assert document.callbacks.hold_value is None
