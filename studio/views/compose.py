"""Compose: what to generate, built from what the engine says it can do, and import."""

from __future__ import annotations

from html import escape
from typing import Any

import panel as pn

from engines import formats
from studio import tasks
from studio.exchange import IMPORTS, UPLOAD_LIMIT
from studio.session import Session
from studio.settings import MAX_COUNT
from studio.views.binding import follow, tie
from studio.views.forms import column, dressed, html, row
from studio.views.parts import ASSETS, ActionField, ActionGrid, Generate, Seed, Segments, Upload, read_asset

TABS = [("action", "Action"), ("import", "Import")]


def compose_tabs(session: Session) -> Segments:
    """Which kind of request is made."""
    tabs = Segments(options=TABS, role="tablist", label="Compose", sizing_mode="stretch_width", margin=0)
    tie(tabs, session.state, value="compose_tab")
    return tabs


def compose_form(session: Session, field: ActionField) -> pn.Column:
    """The controls of the open tab, above the actions."""
    state = session.state
    action = column(field, _shape(session), _body(session), _generate(session), gap=10)
    files = column(_upload(session), html(_readable()), gap=18)

    def show(*_: Any) -> None:
        action.visible, files.visible = state.compose_tab == "action", state.compose_tab == "import"

    state.param.watch(show, "compose_tab")
    show()
    return column(action, files, gap=0)


def action_field(session: Session) -> ActionField:
    """The action typed; an unknown one is named with the nearest known."""
    state = session.state
    field = ActionField(sizing_mode="stretch_width", margin=0)
    tie(field, state, value="action")

    def show() -> dict[str, Any]:
        known = {action.name: action for action in state.actions}
        nearest = state.nearest_actions() if state.engine_ready else []
        entry = known.get(" ".join(state.action.lower().split()))
        return {
            "description": entry.description if entry else "",
            "error": f"“{state.action}” is not an action this engine knows. Nearest:" if nearest else "",
            "nearest": nearest,
        }

    follow(field, state, ["action", "actions", "engine_ready"], show)
    return field


def action_grid(session: Session) -> ActionGrid:
    """The actions to choose from; typing in the field searches here (within the browser)."""
    state = session.state
    grid = ActionGrid(sizing_mode="stretch_both", margin=0)
    tie(grid, state, value="action")

    def show() -> dict[str, Any]:
        return {"actions": [_entry(action) for action in state.actions]}

    follow(grid, state, ["actions"], show)
    follow(grid, state, ["compose_tab"], lambda: {"visible": state.compose_tab == "action"})
    grid.on("generate", lambda _: session.generate())
    return grid


def _entry(action: Any) -> dict[str, str]:
    picture = f"{tasks.slug(action.name)}.webp"
    shipped = (ASSETS / "actions" / picture).is_file()
    return {
        "name": action.name,
        "description": action.description,
        "group": action.group,
        "picture": f"assets/actions/{picture}" if shipped else "",
    }


def _shape(session: Session) -> pn.Column:
    """Length, variations, seed, and engine and model where there is a choice."""
    state = session.state
    length = dressed(pn.widgets.FloatInput, label="Length, seconds", step=0.5, start=0.1, end=600.0, format="0.0[0]")
    count = dressed(pn.widgets.IntInput, label="Variations", step=1, start=1, end=MAX_COUNT)
    seed = Seed(sizing_mode="stretch_width", margin=0)
    tie(count, state, value="count")
    tie(seed, state, value="seed", locked="seed_locked")

    def shown(*_: Any) -> None:
        length.value = round(state.frames / state.fps, 2)
        length.end = state.max_frames / state.fps

    def asked(event: Any) -> None:
        if event.new is not None:
            state.frames = max(2, min(state.max_frames, round(event.new * state.fps)))
            shown()

    state.param.watch(shown, ["frames", "fps", "max_frames"])
    length.param.watch(asked, "value")
    shown()
    engine, variant = _engine(session)
    lines = [row(length, count), row(seed, variant)]
    box = column(*lines, gap=10)
    state.param.watch(
        lambda event: setattr(box, "objects", [engine, *lines] if len(event.new) > 1 else lines), "engines"
    )
    return box


def _engine(session: Session) -> tuple[pn.widgets.Select, pn.widgets.Select]:
    """Engine and variant, each shown where there is a choice."""
    state = session.state
    engine = dressed(pn.widgets.Select, label="Engine", options=[state.engine])
    variant = dressed(pn.widgets.Select, label="Model", options=[state.variant])

    def show(*_: Any) -> None:
        names = list(state.engines) or [state.engine]
        engine.param.update(options=names, value=state.engine)
        kinds = list(dict.fromkeys([*state.variants, state.variant]))
        several = "variants" in state.capabilities and len(kinds) > 1
        variant.param.update(options=kinds, value=state.variant, visible=several)

    state.param.watch(show, ["engines", "engine", "variants", "variant", "capabilities"])
    show()
    engine.param.watch(lambda event: state.param.update(engine=event.new, variant=""), "value")
    variant.param.watch(lambda event: state.param.update(variant=event.new), "value")
    return engine, variant


_BONES = {
    "Legs": ("left_knee", "right_knee", "left_ankle", "right_ankle"),
    "Arms": ("left_elbow", "right_elbow", "left_wrist", "right_wrist"),
    "Torso": ("spine1", "spine2", "spine3", "neck"),
    "Shoulders": ("left_shoulder", "right_shoulder"),
}


def _body(session: Session) -> pn.Card:
    """Length of bones, where the engine can scale them."""
    state = session.state
    sliders = {
        name: dressed(pn.widgets.FloatSlider, label=name, start=0.7, end=1.3, step=0.01, value=1.0, format="0.00")
        for name in _BONES
    }

    def asked(*_: Any) -> None:
        factors = {joint: s.value for name, s in sliders.items() for joint in _BONES[name] if s.value != 1.0}
        if factors != state.bone_scale:
            state.bone_scale = factors

    def show(*_: Any) -> None:
        for name, slider in sliders.items():
            slider.value = state.bone_scale.get(_BONES[name][0], 1.0)
        card.visible = "scale_bones" in state.capabilities

    title = html("<span class='fold'>Body proportions</span>")
    card = pn.Card(
        *sliders.values(), header=title, collapsed=True, margin=0, sizing_mode="stretch_width",
        stylesheets=[read_asset("card.css")],
    )  # fmt: skip
    for slider in sliders.values():
        slider.param.watch(asked, "value_throttled")
    state.param.watch(show, ["bone_scale", "capabilities"])
    show()
    return card


def _generate(session: Session) -> Generate:
    state = session.state
    button = Generate(sizing_mode="stretch_width", margin=0)
    tie(button, state, busy="generating", progress="generate_progress", error="generate_error", count="count")
    asked = ["action", "frames", "count", "seed", "bone_scale"]
    known = ["actions", "engine_ready", "generate_error", "fps", "max_frames", "generate_rate"]

    def show() -> dict[str, Any]:
        # an unknown action is named under its own field; here only what else stands in the way
        return {"problem": state.problem(), "forecast": state.forecast(), "named": bool(state.nearest_actions())}

    follow(button, state, asked + known, show)
    button.on("generate", lambda _: session.generate())
    button.on("cancel", lambda _: session.cancel_generate())
    return button


def _readable() -> str:
    """Markup: the kinds of file that can be imported."""
    rows = "".join(
        f"<tr><th scope='row'>{escape(kind.extensions[0])}</th><td>{escape(kind.description)}</td></tr>"
        for kind in formats.formats()
        if kind.reads
    )
    return f"<section class='plain'><h4>What can be imported</h4><table>{rows}</table></section>"


def _upload(session: Session) -> Upload:
    state = session.state
    part = Upload(accept=list(IMPORTS), limit=UPLOAD_LIMIT, sizing_mode="stretch_width", margin=0)
    tie(part, state, error="import_error", status="import_status")
    part.on("open", lambda _: state.param.update(compose_tab="import"))

    def piece(message: dict) -> None:
        session.files.receive(message["id"], message["name"], message["start"], message["size"], message["data"])

    part.on("piece", piece)
    return part
