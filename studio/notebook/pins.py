"""What is pinned of the motion to come, as widgets of a notebook."""

from __future__ import annotations

from typing import Any

import ipywidgets as widgets

from studio.notebook.controls import Ties, field, note
from studio.pinned import JOINTS


def constraints(ties: Ties) -> Any:
    """Buttons that pin, the list of what is pinned, and the same typed."""
    state, pins = ties.maker.state, ties.maker.pins
    half = widgets.Layout(width="50%")
    pose = ties.press(pins.pose, "Pin this pose", tooltip="The chosen take's pose at the playhead", layout=half)
    frames = ties.press(pins.frames, "Keep frames", tooltip="The chosen take up to the playhead", layout=half)
    tools = {
        "path": widgets.ToggleButton(description="Draw a path", tooltip="Draw on the floor of the player", layout=half),
        "joint": widgets.ToggleButton(description="Pin a joint", tooltip="Drag a joint of the figure", layout=half),
    }
    for name, button in tools.items():
        ties.act(button, lambda on, name=name: _take_up(state, name, on))
    loop = widgets.Checkbox(description="Loop: end as it began", indent=False)
    ties.act(loop, pins.loop)
    listed, fault = widgets.VBox(), widgets.HTML()

    def show() -> None:
        ready = state.take() is not None
        for button in (pose, frames, *tools.values()):
            button.disabled = not ready
        for name, button in tools.items():
            button.value = state.tool == name
        loop.value = state.pinned.loop
        fault.value = note(state.pin_error, fault=True)

    def relist() -> None:
        listed.children = [_entry(ties, key, words) for key, words in state.pinned.listed(state.fps)]

    ties.follow(["takes", "selected", "tool", "pinned", "pin_error"], show)
    ties.follow(["pinned", "fps"], relist)
    rows = [widgets.HBox([pose, frames]), widgets.HBox(list(tools.values())), loop, listed, fault, *_typed(ties)]
    return widgets.VBox(rows)


def _take_up(state: Any, tool: str, on: bool) -> None:
    """The mouse draws that, or nothing any more."""
    if on:
        state.tool = tool
    elif state.tool == tool:
        state.tool = "none"


def _entry(ties: Ties, key: str, words: str) -> Any:
    """A line of the list, with its button."""
    remove = ties.press(
        lambda: ties.maker.pins.remove(key), "", icon="times", tooltip=f"Remove {words}", layout={"width": "32px"}
    )
    return widgets.HBox([widgets.Label(words, layout={"flex": "1 1 auto"}), remove])


def _typed(ties: Ties) -> list[Any]:
    """A path and a joint's place, typed; Enter or leaving the field sets it."""
    pins = ties.maker.pins
    path = field(widgets.Text, "Path x,z", placeholder="0,0 0,1 1,2", continuous_update=False)
    ties.act(path, lambda text: pins.path_text(text) if text.strip() else None)
    joint = field(
        widgets.Dropdown, "Joint", options=[(name.replace("_", " "), name) for name in JOINTS], value="left_wrist"
    )
    place = field(widgets.Text, "at x, y, z", placeholder="0.3, 1.2, 0.4", continuous_update=False)
    ties.act(place, lambda text: pins.joint_text(joint.value, text) if text.strip() else None)
    return [path, joint, place]
