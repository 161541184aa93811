"""Vary: what can be made of takes that are there."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import panel as pn

from studio.session import Session
from studio.takes import Take
from studio.views.binding import follow, tie
from studio.views.draw_map import draw_map
from studio.views.forms import column
from studio.views.parts import DrawMap, Vary


def vary(session: Session) -> pn.Column:
    """What can be made of takes, and the map of an action."""
    return column(_takes(session, "blend"), _map(session), _takes(session, "later"), gap=18)


def _map(session: Session) -> DrawMap:
    """Draws of an action as points, and what lies between them."""
    state, mapping = session.state, session.varying.map
    part = draw_map(mapping, "Map of an action", "Forty draws as dots, like beside like.")

    def offered() -> dict[str, Any]:
        able = "interpolate" in state.capabilities
        return {"asked": mapping.subject(), "problem": mapping.problem(), "visible": able or not state.engine_ready}

    follow(part, state, ["action", "actions", "capabilities", "engine_ready", "engine"], offered)
    return part


def _takes(session: Session, section: str) -> Vary:
    """A blend of two takes; or another action from the playhead on, and other ways to go on."""
    state, varying = session.state, session.varying
    part = Vary(section=section, sizing_mode="stretch_width", margin=0)
    tie(
        part, state, first="blend_from", second="blend_to", share="blend_share", strip="blend_strip",
        problem="blend_problem", between="blend_ready", mixing="blending", selected="selected", action="next_action",
        seconds="next_seconds", count="count", busy="generating", error="vary_error",
    )  # fmt: skip
    follow(part, state, ["takes"], lambda: {"sources": [_entry(take) for take in varying.sources()]})
    follow(part, state, ["actions"], lambda: {"actions": [action.name for action in state.actions]})
    follow(part, state, ["playhead"], lambda: {"at": f"{state.playhead:.1f} s"})
    follow(part, state, ["capabilities", "selected", "takes", "engine"], lambda: dict(_problems(session)))

    def told(act: Callable[[], None], message: dict[str, Any]) -> None:
        wanted = {"next_action": str(message["action"]), "next_seconds": message["seconds"], "count": message["count"]}
        try:
            state.param.update(**wanted)
        except ValueError:
            return  # out of range: the field has gone back to what it was
        act()

    part.on("keep", lambda _: varying.keep())
    part.on("cancel", lambda _: session.cancel_generate())
    part.on("change", lambda message: told(varying.change, message))
    part.on("go_on", lambda message: told(varying.go_on, message))
    return part


def _entry(take: Take) -> dict[str, str]:
    """A take to choose."""
    return {"id": take.id, "text": f"{take.title} · {take.subject[:24]}"}


def _problems(session: Session) -> dict[str, Any]:
    """Why the engine cannot do it."""
    return {
        "go_problem": session.varying.go_problem(),
        "change_problem": session.varying.change_problem(),
    }
