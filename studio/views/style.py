"""Style: a take in another manner."""

from __future__ import annotations

from typing import Any

import panel as pn

from studio import tasks
from studio.exchange import IMPORTS, UPLOAD_LIMIT
from studio.session import Session
from studio.settings import MAX_COUNT, MAX_STRENGTH
from studio.takes import Take
from studio.views.binding import follow, tie
from studio.views.draw_map import draw_map
from studio.views.forms import column, dressed, row
from studio.views.parts import ASSETS, ActionGrid, Generate, Manner, Seed, Segments, Upload

_WAYS = {"style": "Name", "like": "Clip", "chance": "Surprise", "map": "Map"}


def style_form(session: Session) -> pn.Column:
    """Which take, how the manner is said, and how much of it."""
    styling = session.styling
    ways = Segments(label="How the manner is said", sizing_mode="stretch_width", margin=0)
    tie(ways, styling.state, value="way")

    def offered() -> dict[str, Any]:
        known = styling.state.styles or not styling.state.ready
        return {"options": [(way, text) for way, text in _WAYS.items() if known or way != "style"]}

    follow(ways, styling.state, ["styles", "ready"], offered)
    like, options = _like(session), _options(session)
    themap = draw_map(styling.map, "Map of styles", "The take in every style as dots, like beside like.")
    told = lambda: {"asked": styling.map.subject(), "problem": styling.map.problem()}  # noqa: E731
    follow(themap, styling.state, ["source", "ready", "error"], told)

    def show(*_: Any) -> None:
        way = styling.state.way
        like.visible, options.visible, themap.visible = way == "like", way != "map", way == "map"

    styling.state.param.watch(show, "way")
    show()
    return column(_takes(session, "Take", "source"), ways, like, options, themap, gap=10)


def _takes(session: Session, label: str, name: str) -> pn.widgets.Select:
    """Choose a take."""
    state = session.styling.state
    select = dressed(pn.widgets.Select, label=label, options={"none yet": ""})

    def show(*_: Any) -> None:
        known = {_entry(take): take.id for take in reversed(session.state.takes)}
        value = getattr(state, name)
        found = value if value in known.values() else ""
        select.param.update(options=known if found else {"choose a take": "", **known}, value=found)

    session.state.param.watch(show, "takes")
    state.param.watch(show, name)
    show()
    select.param.watch(lambda event: setattr(state, name, event.new or ""), "value")
    return select


def _entry(take: Take) -> str:
    return f"{take.title} · {take.subject[:28]}"


def _like(session: Session) -> pn.Column:
    """The take whose manner is taken, which may come from a file."""
    styling, state = session.styling, session.state
    part = Upload(
        accept=list(IMPORTS), limit=UPLOAD_LIMIT, text="or drop one", label="Reference clip", compact=True,
        sizing_mode="stretch_width", margin=0,
    )  # fmt: skip
    tie(part, state, error="import_error", status="import_status")

    def active() -> dict[str, Any]:
        return {"active": styling.wants_a_file()}

    follow(part, state, ["compose_tab"], active)
    follow(part, styling.state, ["way"], active)
    part.on("piece", lambda message: session.files.receive(message, styling.refer))
    return column(_takes(session, "As in", "like"), part, gap=8)


def _options(session: Session) -> pn.Column:
    """How much of the manner, how many, and how it is shown."""
    styling = session.styling
    state = styling.state
    part = Manner(most=MAX_STRENGTH, sizing_mode="stretch_width", margin=0)
    tie(part, state, strength="strength", feet="feet", tempo="tempo")
    follow(part, state, ["capabilities"], lambda: {"timed": "tempo" in state.capabilities})
    count = dressed(pn.widgets.IntInput, label="How many", step=1, start=1, end=MAX_COUNT)
    tie(count, state, value="count")
    seed = Seed(sizing_mode="stretch_width", margin=0)
    tie(seed, session.state, value="seed", locked="seed_locked")
    model = dressed(pn.widgets.Select, label="Model", options=[""])

    def show(*_: Any) -> None:
        kinds = list(dict.fromkeys([*state.variants, state.variant]))
        model.param.update(options=kinds, value=state.variant, visible=len(kinds) > 1)

    state.param.watch(show, ["variants", "variant"])
    show()
    model.param.watch(lambda event: setattr(state, "variant", event.new), "value")
    return column(part, row(count, seed), model, gap=10)


def style_button(session: Session) -> Generate:
    """The button and the line under it."""
    state, styling = session.state, session.styling
    button = Generate(sizing_mode="stretch_width", margin=0)
    tie(button, state, busy="generating", progress="generate_progress", error="generate_error")

    def show() -> dict[str, Any]:
        take = styling.take()
        return {
            "label": f"Stylise {take.title.lower()}" if take else "Stylise",
            "problem": styling.problem(),
            "forecast": styling.forecast(),
            "visible": state.compose_tab == "style" and styling.state.way != "map",
        }

    asked = ["source", "way", "style", "like", "strength", "count", "ready", "error", "styles"]
    follow(button, styling.state, asked, show)
    follow(button, state, ["compose_tab", "takes"], show)
    button.on("generate", lambda _: styling.stylise())
    button.on("cancel", lambda _: session.cancel_generate())
    return button


def style_grid(session: Session) -> ActionGrid:
    """The styles to choose from, each as the same walk in it."""
    styling = session.styling
    grid = ActionGrid(noun="style", sizing_mode="stretch_both", margin=0)
    tie(grid, styling.state, value="style")
    follow(grid, styling.state, ["styles"], lambda: {"actions": [_card(name) for name in styling.state.styles]})

    def seen() -> dict[str, Any]:
        return {"visible": session.state.compose_tab == "style" and styling.state.way == "style"}

    follow(grid, session.state, ["compose_tab"], seen)
    follow(grid, styling.state, ["way"], seen)
    grid.on("generate", lambda _: styling.stylise())
    return grid


def _card(style: str) -> dict[str, str]:
    picture = f"styles/{tasks.slug(style)}.webp"
    shipped = (ASSETS / picture).is_file()
    return {
        "name": style, "description": f"A walk, {style}", "group": "",
        "picture": f"assets/{picture}" if shipped else "",
    }  # fmt: skip
