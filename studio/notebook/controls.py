"""What a person sets before a draw, as widgets of a notebook: built from what the engine says it can do."""

from __future__ import annotations

from collections.abc import Callable
from html import escape
from typing import Any

import ipywidgets as widgets

from studio.notebook.maker import Maker, Manner
from studio.proportions import BONES, LONGEST, SHORTEST, bone_scale, factors
from studio.settings import MAX_BEST_OF, MAX_COUNT, MAX_GUIDANCE, MAX_SEED, MAX_STRENGTH

WIDTH = "300px"
_LABELS = "74px"


class Ties:
    """Widgets and the maker's state, each following the other.

    Args:
        maker: whose state it is; its lock is held whenever either changes the other.
    """

    def __init__(self, maker: Maker) -> None:
        self.maker = maker

    def tie(self, widget: Any, name: str, trait: str = "value") -> Any:
        """A trait of a widget and a parameter of the state. Returns the widget."""
        self.follow([name], lambda: setattr(widget, trait, getattr(self.maker.state, name)))
        return self.act(widget, lambda value: setattr(self.maker.state, name, value), trait)

    def follow(self, names: list[str], show: Callable[[], None]) -> None:
        """Call `show` now and after each change of the parameters."""
        show()
        self.maker.state.param.watch(lambda *_: show(), names)

    def act(self, widget: Any, act: Callable[[Any], None], trait: str = "value") -> Any:
        """Call `act(value)` when a person changes a trait of a widget. Returns the widget."""

        def changed(change: Any) -> None:
            with self.maker.lock:
                act(change["new"])

        widget.observe(changed, trait)
        return widget

    def press(self, act: Callable[[], None], text: str, **options: Any) -> Any:
        """A button that calls `act`."""
        button = widgets.Button(description=text, **options)

        def pressed(_: Any) -> None:
            with self.maker.lock:
                act()

        button.on_click(pressed)
        return button


def shown(widget: Any, visible: bool) -> None:
    """Show a widget or leave it out."""
    widget.layout.display = None if visible else "none"


def field(kind: type, text: str = "", **options: Any) -> Any:
    """A widget with its name to the left, as wide as its place."""
    made = kind(description=text, style={"description_width": _LABELS}, **options)
    made.layout.width = "auto"
    return made


def fold(text: str, body: Any) -> list[Any]:
    """A button that opens and closes what is under it; closed at first. A button, so that the keyboard reaches it."""
    button = widgets.ToggleButton(description=text, icon="caret-right", layout={"width": "auto"})

    def turned(change: Any) -> None:
        shown(body, change["new"])
        button.icon = "caret-down" if change["new"] else "caret-right"

    button.observe(turned, "value")
    shown(body, False)
    return [button, body]


def note(text: str, fault: bool = False) -> str:
    """Markup of a line for a person."""
    if not text:
        return ""
    colour = "var(--jp-error-color1, #c03a2d)" if fault else "var(--jp-ui-font-color2, #667)"
    return f'<div style="color: {colour}; line-height: 1.35; font-size: 12px; white-space: normal">{escape(text)}</div>'


def controls(maker: Maker) -> list[Any]:
    """The controls of an engine, in order; what it cannot be told has none."""
    ties, can = Ties(maker), maker.state.capabilities
    style = [_style(ties)] if "styles" in can else []
    if isinstance(maker.state, Manner):
        return [*style, *_manner(ties), *_shape(ties)[1:], *_go(ties)]
    made = [*_asked(ties), *style, *_shape(ties)]
    if "constraints" in can:
        from studio.notebook.pins import constraints

        made += fold("Constraints", constraints(ties))
    more = _advanced(ties)
    if more:
        made += fold("Advanced", widgets.VBox(more))
    return [*made, *_go(ties)]


def _asked(ties: Ties) -> list[Any]:
    """Action or words, whichever the engine takes."""
    state = ties.maker.state
    names = [action.name for action in state.actions]
    action = ties.tie(field(widgets.Combobox, "Action", options=names, continuous_update=False), "action")
    words = field(widgets.Textarea, "Prompt", rows=3, continuous_update=False, placeholder="a person walks and waves")
    ties.tie(words, "prompt")
    about = widgets.HTML(layout={"margin": f"0 2px 4px calc({_LABELS} + 8px)"})
    described = {known.name: known.description for known in state.actions}
    kind = widgets.ToggleButtons(options=[("Action", "action"), ("Text", "text")])
    kind.style.button_width = "88px"
    ties.tie(kind, "request")

    def show() -> None:
        text = state.request == "text"
        shown(action, not text)
        shown(words, text)
        about.value = "" if text else note(described.get(" ".join(state.action.lower().split()), ""))

    ties.follow(["request", "action"], show)
    both = bool(names) and "text" in state.capabilities
    return [*([kind] if both else []), *([action] if names else []), *([words] if "text" in state.capabilities else []),
            about]  # fmt: skip


def _style(ties: Ties) -> Any:
    options = [("any", ""), *((name, name) for name in ties.maker.state.styles)]
    return ties.tie(field(widgets.Dropdown, "Style", options=options), "style")


def _manner(ties: Ties) -> list[Any]:
    """How much of a manner, and whether its tempo too, where the engine can be told."""
    slider = field(widgets.FloatSlider, "Strength", max=MAX_STRENGTH, step=0.05, readout_format=".2f")
    made = [ties.tie(slider, "strength")]
    if "tempo" in ties.maker.state.capabilities:
        made.append(ties.tie(field(widgets.Checkbox, "Its tempo too"), "tempo"))
    return made


def _shape(ties: Ties) -> list[Any]:
    """Length, how many, seed, and the model where there is a choice."""
    state = ties.maker.state
    seconds = field(widgets.BoundedFloatText, "Seconds", min=0.1, max=600.0, step=0.5)

    def length() -> None:
        seconds.max = state.max_frames / state.fps
        seconds.value = round(state.frames / state.fps, 2)

    def said(value: float) -> None:
        if value != round(state.frames / state.fps, 2):  # and not what is shown to be found
            state.say_length(round(value * state.fps))

    ties.follow(["frames", "fps", "max_frames"], length)
    ties.act(seconds, said)
    ways = ties.tie(field(widgets.BoundedIntText, "Ways", min=1, max=MAX_COUNT), "count")
    seed = ties.tie(field(widgets.BoundedIntText, "Seed", min=0, max=MAX_SEED), "seed")
    same = ties.tie(widgets.Checkbox(description="keep", indent=False, tooltip="The same motions again"), "seed_locked")
    same.layout = widgets.Layout(width="68px", margin="2px 2px 2px 6px")
    seed.layout.flex = "1 1 auto"
    rows = [seconds, ways, widgets.HBox([seed, same])]
    if "lengths" in state.capabilities:
        rows.insert(1, ties.tie(field(widgets.Checkbox, "As long as it takes"), "as_long"))
    if len(state.variants) > 1:
        model = field(widgets.Dropdown, "Model", options=list(state.variants), value=state.variant)
        ties.follow(["variant"], lambda: setattr(model, "value", state.variant))
        ties.act(model, ties.maker.load)
        rows.append(model)
    return rows


def _advanced(ties: Ties) -> list[Any]:
    """Strength of guidance, best of several, and lengths of bones, where the engine has them."""
    state, made = ties.maker.state, []
    if "guidance" in state.capabilities:
        slider = field(widgets.FloatSlider, "Guidance", max=MAX_GUIDANCE, step=0.1, readout_format=".1f")
        made.append(ties.tie(slider, "guidance"))
    if "best_of" in state.capabilities:
        made.append(ties.tie(field(widgets.BoundedIntText, "Best of", min=1, max=MAX_BEST_OF), "best_of"))
    if "scale_bones" in state.capabilities:
        made += _bones(ties)
    return made


def _bones(ties: Ties) -> list[Any]:
    state = ties.maker.state
    sliders = {
        name: field(
            widgets.FloatSlider,
            name.capitalize(),
            value=1.0,
            min=SHORTEST,
            max=LONGEST,
            step=0.01,
            continuous_update=False,
        )
        for name in BONES
    }

    def asked(_value: Any) -> None:
        scale = bone_scale({name: slider.value for name, slider in sliders.items()})
        if scale != state.bone_scale:
            state.bone_scale = scale

    def show() -> None:
        values = factors(state.bone_scale)
        for name, slider in sliders.items():
            slider.value = values[name]

    for slider in sliders.values():
        ties.act(slider, asked)
    if not state.bone_scale or set(state.bone_scale) <= {joint for joints in BONES.values() for joint in joints}:
        ties.follow(["bone_scale"], show)
    return list(sliders.values())


def _go(ties: Ties) -> list[Any]:
    """The button, its progress and the line under it."""
    maker, state = ties.maker, ties.maker.state
    go = ties.press(maker.generate, "Generate", button_style="primary", icon="play")
    stop = ties.press(maker.cancel, "Cancel", icon="times")
    go.layout.width = stop.layout.width = "50%"
    bar = widgets.FloatProgress(min=0.0, max=1.0, layout={"width": "auto", "height": "10px"})
    said = widgets.HTML()

    def forget() -> None:
        """What became of the last draw is said until something else is asked."""
        state.param.update(message="", generate_note="", generate_error="")

    def show() -> None:
        problem = state.problem()
        go.disabled = state.generating or bool(problem)
        stop.disabled = not state.generating
        bar.layout.visibility = "visible" if state.generating else "hidden"
        bar.value = state.generate_progress
        if problem or state.generate_error:
            said.value = note(problem or state.generate_error, fault=True)
        else:
            said.value = note(state.generate_note or ("" if state.generating else state.message) or state.forecast())

    asked = _ASKED + ["strength", "tempo"] * isinstance(state, Manner)
    ties.follow(asked, forget)
    ties.follow([*asked, *_TOLD], show)
    return [widgets.HBox([go, stop]), bar, said]


_ASKED = [
    "request", "action", "prompt", "style", "frames", "count", "seed", "bone_scale", "guidance", "best_of", "pinned",
    "variant", "as_long",
]  # fmt: skip
"""Parameters of the state that are asked."""
_TOLD = [
    "length_known", "fps", "max_frames", "engine_ready", "generating", "generate_progress", "generate_error",
    "generate_note", "message",
]  # fmt: skip
"""Parameters that change what is said about a draw."""
