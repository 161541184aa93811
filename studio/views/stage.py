"""The stage: the player with its transport, showing the takes that are picked."""

from __future__ import annotations

from functools import cache
from operator import is_
from typing import Any

import numpy as np
import panel as pn

from engines import SMPL22, Motion
from engines.errors import MotionloomError
from studio.edits import WORDS
from studio.pinning import as_shown
from studio.session import Session
from studio.settings import EDITS
from studio.views.binding import follow, tie
from studio.views.forms import html
from studio.views.parts import StageBar
from studio.views.sequence import tie_timeline


def stage(session: Session) -> pn.Column:
    """The 3D player over the whole middle, with a bar on it that says which takes are shown."""
    state = session.state
    nobody = html(sizing_mode="stretch_both")

    def say(*_: Any) -> None:
        coming = state.generating or not (state.engine_ready or state.generate_error)
        words = "The first people are on their way…" if coming else "Nobody here yet. Generate, or drop a motion file."
        seen = bool(state.shown) or state.compose_tab == "sequence"
        nobody.param.update(object=f"<p class='nobody'>{words}</p>", visible=not seen)

    state.param.watch(say, ["generating", "engine_ready", "generate_error", "shown", "compose_tab"])
    say()
    return pn.Column(nobody, _Stage(session).place, sizing_mode="stretch_both", margin=0)


class _Stage:
    """The player, made with the first takes, since it has nothing to show before.

    Args:
        session: whose takes it shows.
    """

    def __init__(self, session: Session) -> None:
        self.session = session
        self.place = pn.Column(_bar(session), sizing_mode="stretch_both", margin=0)
        self.player: Any = None
        self.ids: list[str] = []
        """The takes on it, in its order."""
        self.motions: list[Motion] = []
        session.state.param.watch(self._show, ["shown", "takes", "edited", "preview", "compose_tab"])
        session.state.param.watch(self._reselect, "selected")
        session.state.param.watch(self._dress, "worn")
        self._show()

    def _show(self, *_: Any) -> None:
        """Show the takes as they are now; nothing is sent where all are as before."""
        there = self._there()
        ids, names, motions = [row[0] for row in there], [row[1] for row in there], [row[2] for row in there]
        same = len(motions) == len(self.motions) and all(map(is_, motions, self.motions))
        if ids == self.ids and same:
            self._reselect()
            return
        self.ids, self.motions = ids, motions
        self.place.visible = bool(motions)
        if self.player is not None and motions:
            self.player.show_motions(motions, names)
        elif motions:
            self.player = self._make(names)
            self.place.append(self.player)
        self._reselect()

    def _there(self) -> list[tuple[str, str, Motion]]:
        """(id, name, motion) of all that is to be seen; ids are empty in a preview."""
        state = self.session.state
        if state.preview:
            return [("", name, motion) for name, motion in state.preview]
        takes = [take for take in map(state.take, state.shown) if take is not None]
        if not takes and state.compose_tab == "sequence":
            return [("", "", _at_rest())]  # the timeline is the player's, and nobody is here yet
        return [(take.id, take.title, motion) for take in takes if (motion := self.session.editing.motion(take))]

    def _reselect(self, *_: Any) -> None:
        selected = self.session.state.selected
        if self.player is None:
            return
        take = self.session.takes.get(selected)
        self.player.edits = ",".join(take.edits) if take else ""
        if self.session.state.preview:
            self.player.selected = len(self.ids) // 2
        else:
            self.player.selected = self.ids.index(selected) if selected in self.ids else 0

    def _make(self, names: list[str]) -> Any:
        from viewers.web.player import PanelPlayer

        state = self.session.state
        player = PanelPlayer(
            self.motions, body=state.worn, labels=names, height=None, sizing_mode="stretch_both", margin=0,
            theme=state.theme, global_keys=True, playing=state.frame < 0, frame=max(0, state.frame),
            editable=",".join(f"{name}={WORDS[name]}" for name in EDITS),
        )  # fmt: skip
        tie(player, state, theme="theme", tool="tool", open_strips="open_strips")
        follow(player, state, ["strips"], lambda: {"strips": state.strips})
        follow(player, state, ["pinned", "fps", "capabilities", "request"], lambda: {"pinned": _pins(self.session)})
        player.param.watch(self._picked, "selected")
        player.param.watch(self._moved, ["frame", "playing"])
        player.param.watch(self._drawn, "drawn")
        player.param.watch(self._edited, "edits")
        tie_timeline(player, self.session)
        return player

    def _dress(self, *_: Any) -> None:
        """Show the same takes with another body."""
        if self.player is None:
            return
        try:
            self.player.wear(self.session.state.worn)
        except MotionloomError as problem:
            self.session.state.body_error = str(problem)

    # ---- what the person does in it -----------------------------------------------------------------------

    def _picked(self, event: Any) -> None:
        if 0 <= event.new < len(self.ids) and self.ids[event.new]:
            self.session.select(self.ids[event.new])

    def _moved(self, *_: Any) -> None:
        playhead = self.player.frame / self.player.motions[0].fps
        frame = -1 if self.player.playing else self.player.frame
        self.session.state.param.update(playhead=playhead, frame=frame)

    def _drawn(self, event: Any) -> None:
        what, pins = event.new, self.session.pins
        if what.get("kind") == "path":
            pins.path(what["points"])
        elif what.get("kind") == "joint":
            pins.joint(what["joint"], what["place"], what["frame"] / what["fps"])

    def _edited(self, event: Any) -> None:
        self.session.editing.set(self.session.state.selected, event.new.split(","))


@cache
def _at_rest() -> Motion:
    """Somebody who stands there."""
    turns = np.zeros((1, len(SMPL22), 4))
    turns[..., 0] = 1.0
    return Motion(SMPL22, turns, np.zeros((1, 3)), 20.0).on_ground()


def _pins(session: Session) -> dict[str, Any]:
    """What is pinned, for the player; nothing where the engine is not told of it."""
    state = session.state
    told = "constraints" in state.capabilities and state.request != "sequence"
    return as_shown(state.pinned, state.fps) if told else {}


def _bar(session: Session) -> StageBar:
    state = session.state
    bar = StageBar(margin=0)
    tie(bar, state, mode="stage_mode")

    def show() -> dict[str, Any]:
        take = state.take()
        together = sum(other.group == take.group for other in state.takes) if take else 0
        return {"together": together, "ticked": len(state.compared)}

    follow(bar, state, ["takes", "selected", "compared"], show)
    return bar
