"""Compose: what to generate, built from what the engine says it can do, and import."""

from __future__ import annotations

from html import escape
from typing import Any

import panel as pn

from engines import formats
from studio import tasks
from studio.exchange import IMPORTS, UPLOAD_LIMIT
from studio.pinned import JOINTS
from studio.session import Session
from studio.settings import MAX_BEST_OF, MAX_COUNT, MAX_GUIDANCE, MAX_PROMPT
from studio.understanding import Understanding
from studio.varying import VARIES
from studio.views.binding import follow, tie
from studio.views.character import character_form
from studio.views.forms import column, dressed, fold, html, row
from studio.views.lengths import lengths
from studio.views.parts import (
    ASSETS,
    ActionField,
    ActionGrid,
    Constraints,
    Examples,
    Generate,
    Length,
    Prompt,
    Seed,
    Segments,
    Upload,
)  # fmt: skip
from studio.views.sequence import sequence_form
from studio.views.style import style_form
from studio.views.vary import vary
from studio.wording import counted

EXAMPLES = (
    "a person walks forward and turns left",
    "someone runs, then jumps",
    "a person waves with the right hand, proudly",
    "an old person walks slowly and bows",
    "a person boxes, left and right in turn",
)
"""Prompts that fill the field."""


def compose_tabs(session: Session) -> Segments:
    """Which kind of request is made."""
    state = session.state
    tabs = Segments(role="tablist", label="Compose", sizing_mode="stretch_width", margin=0)
    tie(tabs, state, value="compose_tab")

    def kinds() -> dict[str, Any]:
        words = [("text", "Text")] if "text" in state.capabilities else []
        styles = [("style", "Style")] if session.styling.state.engine else []
        variations = [("vary", "Vary")] if state.capabilities & VARIES else []
        first, last = (
            [("action", "Action"), *words, ("sequence", "Sequence")],
            [("character", "Character"), ("import", "Import")],
        )
        return {"options": [*first, *styles, *variations, *last]}

    follow(tabs, state, ["capabilities"], kinds)
    return tabs


def compose_form(session: Session, field: ActionField) -> pn.Column:
    """The controls of the open tab, above the button and the actions."""
    state = session.state
    words = _prompt(session)
    folds = column(_constraints(session), _advanced(session), gap=6)
    asked = column(field, words, _shape(session), folds, gap=10)
    files = column(_upload(session), html(_readable()), gap=18)
    varied, styled, cast = vary(session), style_form(session), character_form(session)

    def show(*_: Any) -> None:
        tab = state.compose_tab
        asked.visible, files.visible, varied.visible = tab in ("action", "text"), tab == "import", tab == "vary"
        styled.visible, cast.visible = tab == "style", tab == "character"
        field.visible, words.visible = tab != "text", tab == "text"

    state.param.watch(show, "compose_tab")
    show()
    return column(asked, sequence_form(session), styled, varied, cast, files, gap=0)


def _prompt(session: Session) -> Prompt:
    """The motion in words."""
    part = Prompt(limit=MAX_PROMPT, sizing_mode="stretch_width", margin=0)
    tie(part, session.state, value="prompt")

    def said(words: str) -> None:
        part.understood = words

    Understanding(session, said)
    return part


def examples(session: Session) -> Examples:
    """Prompts to begin with, under the button where there are no actions to browse."""
    part = Examples(examples=list(EXAMPLES), sizing_mode="stretch_both", margin=0)
    follow(part, session.state, ["compose_tab"], lambda: {"visible": session.state.compose_tab == "text"})
    return part


def _constraints(session: Session) -> Constraints:
    """What is pinned, where the engine can be told."""
    state, pins = session.state, session.pins
    part = Constraints(joints=list(JOINTS), sizing_mode="stretch_width", margin=0)
    tie(part, state, tool="tool", error="pin_error")

    def show() -> dict[str, Any]:
        return {
            "items": [list(item) for item in state.pinned.listed(state.fps)],
            "loop": state.pinned.loop,
            "ready": state.take() is not None,
            "visible": "constraints" in state.capabilities,
        }

    follow(part, state, ["pinned", "fps", "selected", "takes", "capabilities"], show)
    part.param.watch(lambda event: pins.loop(event.new), "loop")
    acts = {
        "pose": lambda _: pins.pose(),
        "frames": lambda _: pins.frames(),
        "remove": lambda message: pins.remove(str(message.get("key", ""))),
        "clear": lambda _: pins.clear(),
        "path_text": lambda message: pins.path_text(str(message.get("text", ""))),
        "joint_text": lambda message: pins.joint_text(str(message.get("joint", "")), str(message.get("text", ""))),
    }
    for what, act in acts.items():
        part.on(what, act)
    return part


def _advanced(session: Session) -> pn.Card:
    """Strength of guidance, and best of several, where the engine has them."""
    state = session.state
    guidance = dressed(
        pn.widgets.FloatSlider, label="Guidance (0: freely, 10: to the letter)", start=0.0, end=MAX_GUIDANCE,
        step=0.1, format="0.0",
    )  # fmt: skip
    best = dressed(pn.widgets.IntInput, label="Best of: draws for each take", start=1, end=MAX_BEST_OF)
    guidance.value, best.value = state.guidance, state.best_of
    state.param.watch(lambda event: setattr(guidance, "value", event.new), "guidance")
    guidance.param.watch(lambda event: setattr(state, "guidance", event.new), "value_throttled")
    tie(best, state, value="best_of")
    card = fold(html("<span class='fold'>Advanced</span>"), guidance, best)

    def show(*_: Any) -> None:
        guidance.visible, best.visible = "guidance" in state.capabilities, "best_of" in state.capabilities
        card.visible = guidance.visible or best.visible

    state.param.watch(show, "capabilities")
    show()
    return card


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
            "names": list(known),
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

    def place() -> dict[str, Any]:
        return {"visible": state.compose_tab in ("action", "sequence"), "adds": state.compose_tab == "sequence"}

    follow(grid, state, ["compose_tab"], place)
    grid.on("generate", lambda _: session.generate())
    grid.on("add", session.arranging.act)
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
    count = dressed(pn.widgets.IntInput, label="Variations", step=1, start=1, end=MAX_COUNT)
    seed = Seed(sizing_mode="stretch_width", margin=0)
    tie(count, state, value="count")
    tie(seed, state, value="seed", locked="seed_locked")
    engine, variant = _engine(session)
    lines = [row(_length(session), count), lengths(session), row(seed, variant, _style(session), wrap=118)]
    count.styles = {**count.styles, "flex": "0 0 84px"}
    box = column(*lines, gap=10)
    state.param.watch(
        lambda event: setattr(box, "objects", [engine, *lines] if len(event.new) > 1 else lines), "engines"
    )
    return box


def _length(session: Session) -> Length:
    """How long, where the engine does not find it."""
    state = session.state
    part = Length(sizing_mode="stretch_width", margin=0)
    tie(part, state, found="as_long")

    def show() -> dict[str, Any]:
        return {
            "seconds": round(state.frames / state.fps, 2),
            "most": state.max_frames / state.fps,
            "finds": "lengths" in state.capabilities,
            "pinned": bool(state.pinned),
        }

    follow(part, state, ["frames", "fps", "max_frames", "capabilities", "pinned"], show)
    part.on("say", lambda message: state.say_length(round(float(message["seconds"]) * state.fps)))
    return part


def _style(session: Session) -> pn.widgets.Select:
    """In which manner, where the engine has styles."""
    state = session.state
    style = dressed(pn.widgets.Select, label="Style", options={"any": ""})

    def show(*_: Any) -> None:
        known = {"any": "", **{name: name for name in state.styles}}
        style.param.update(options=known, value=state.style if state.style in known.values() else "")
        style.visible = "styles" in state.capabilities

    state.param.watch(show, ["styles", "style", "capabilities"])
    show()
    style.param.watch(lambda event: setattr(state, "style", event.new or ""), "value")
    return style


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


def generate_button(session: Session) -> Generate:
    """The button and the line under it; not beside the import."""
    state = session.state
    button = Generate(sizing_mode="stretch_width", margin=0)
    tie(
        button, state, busy="generating", progress="generate_progress", error="generate_error", note="generate_note",
    )  # fmt: skip
    asked = ["request", "action", "prompt", "style", "frames", "count", "seed", "bone_scale", "best_of", "pinned"]
    known = ["actions", "capabilities", "engine_ready", "generate_error", "fps", "max_frames", "generate_rate"]

    def show() -> dict[str, Any]:
        # an unknown action is named under its own field; here only what else stands in the way
        named = state.request == "action" and bool(state.nearest_actions())
        label = "Make the sequence" if state.request == "sequence" else f"Generate {counted(state.count, 'take')}"
        return {"problem": state.problem(), "forecast": state.forecast(), "named": named, "label": label}

    follow(button, state, [*asked, *known, "as_long", "length_known", "sequence"], show)
    follow(button, state, ["compose_tab"], lambda: {"visible": state.compose_tab in ("action", "text", "sequence")})
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

    def active() -> dict[str, Any]:
        return {"active": not (session.styling.wants_a_file() or session.casting.wants_a_file())}

    follow(part, state, ["compose_tab"], active)
    follow(part, session.styling.state, ["way"], active)
    part.on("piece", session.files.receive)
    return part
