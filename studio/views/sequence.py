"""Sequence: the tab that puts blocks on the timeline, and the timeline in the player."""

from __future__ import annotations

from typing import Any

import panel as pn

from engines import registry
from studio.arranging import as_shown
from studio.session import Session
from studio.settings import usual_engine
from studio.views.binding import follow, tie
from studio.views.forms import column, dressed
from studio.views.parts import Sequence
from studio.wording import counted, duration

_HOW = {False: "each on its own", True: "each going on"}
_ABOUT = {
    False: "Each block is made on its own; transitions lead from one to the next.",
    True: "Each action goes on from what stands before it; those after a change are made again.",
}


def sequence_form(session: Session) -> pn.Column:
    """Who makes the actions; a block in words, a clip of the picked take; what goes for all blocks."""
    return column(_engine(session), _blocks(session), gap=10)


def _engine(session: Session) -> pn.widgets.Select:
    """Who makes the actions: the engine of the other tabs, or one that goes on from what stands before."""
    state = session.state
    select = dressed(pn.widgets.Select, label="Actions by", options={state.engine: ""})

    def show(*_: Any) -> None:
        chosen = state.sequence.engine
        names = dict.fromkeys(filter(None, (state.engine, usual_engine(), *registry.sequencers(), chosen)))
        usual = {state.engine: chosen if chosen == state.engine else ""}
        options = {f"{name}, {_HOW[name in registry.SEQUENCERS]}": usual.get(name, name) for name in names}
        select.param.update(options=options, value=chosen, visible=state.compose_tab == "sequence" and len(options) > 1)

    state.param.watch(show, ["sequence", "engine", "compose_tab"])
    show()
    select.param.watch(lambda event: session.arranging.by(event.new), "value")
    return select


def _blocks(session: Session) -> Sequence:
    """A block in words, a clip of the picked take; what goes for all blocks."""
    state, arranging = session.state, session.arranging
    part = Sequence(sizing_mode="stretch_width", margin=0)

    def shown() -> dict[str, Any]:
        take, sequence = state.take(), state.sequence
        count = counted(len(sequence.blocks), "block")
        return {
            "take": take.title.lower() if take else "",
            "words": "text" in state.capabilities,
            "blocks": len(sequence.blocks),
            "about": f"{count}, {duration(sequence.seconds)}." if sequence else "",
            "how": _ABOUT[(sequence.engine or state.engine) in registry.SEQUENCERS],
            "error": state.sequence_error,
            "visible": state.compose_tab == "sequence",
        }

    known = ["takes", "selected", "capabilities", "engine", "sequence", "sequence_error", "compose_tab"]
    follow(part, state, known, shown)
    part.on("add", arranging.act)
    part.on("clip", lambda _: arranging.act({"do": "add", "kind": "clip", "take": state.selected}))
    part.on("renew", arranging.act)
    part.on("clear", lambda _: arranging.clear())
    return part


def tie_timeline(player: Any, session: Session) -> None:
    """Show the blocks in the player, and do what a person does to them there."""
    state = session.state
    shown = ["sequence", "heard", "sequence_error", "compose_tab", "selected", "actions", "styles", "engines"]
    follow(player, state, [*shown, "capabilities"], lambda: {"sequence": as_shown(session)})
    tie(player, state, block="block")
    player.param.watch(lambda event: session.arranging.act(event.new), "arranged")
