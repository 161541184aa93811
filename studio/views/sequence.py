"""Sequence: the tab that puts blocks on the timeline, and the timeline in the player."""

from __future__ import annotations

from typing import Any

from studio.arranging import as_shown
from studio.session import Session
from studio.views.binding import follow, tie
from studio.views.parts import Sequence
from studio.wording import counted, duration


def sequence_form(session: Session) -> Sequence:
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
            "error": state.sequence_error,
            "visible": state.compose_tab == "sequence",
        }

    follow(part, state, ["takes", "selected", "capabilities", "sequence", "sequence_error", "compose_tab"], shown)
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
