"""The stage: the player with its transport, showing the takes that are picked."""

from __future__ import annotations

from typing import Any

import panel as pn

from studio.pinning import as_shown
from studio.session import Session
from studio.views.binding import follow, tie
from studio.views.forms import html
from studio.views.parts import StageBar


def stage(session: Session) -> pn.Column:
    """The 3D player over the whole middle, with a bar on it that says which takes are shown.

    The player is made with the first takes, since it has nothing to show before.
    """
    state = session.state
    bar = _bar(session)
    place = pn.Column(bar, sizing_mode="stretch_both", margin=0)
    nobody = html(sizing_mode="stretch_both")
    player: Any = None

    def say(*_: Any) -> None:
        coming = state.generating or not (state.engine_ready or state.generate_error)
        words = (
            "The first people are on their way…" if coming else "Nobody here yet.<br>Generate, or drop a motion file."
        )
        nobody.object = f"<p class='nobody'>{words}</p>"

    def restage(*_: Any) -> None:
        nonlocal player
        there = [(take, session.motion(take)) for take in map(state.take, state.shown) if take is not None]
        motions = [motion for _take, motion in there if motion is not None]
        names = [take.title for take, motion in there if motion is not None]
        place.visible, nobody.visible = bool(motions), not motions
        if not motions:
            return
        if player is None:
            player = _player(session, motions, names)
            place.append(player)
        else:
            player.show_motions(motions, names)
        player.selected = state.shown.index(state.selected) if state.selected in state.shown else 0

    def reselect(event: Any) -> None:
        if player is not None and event.new in state.shown:
            player.selected = state.shown.index(event.new)

    state.param.watch(restage, "shown")
    state.param.watch(reselect, "selected")
    state.param.watch(say, ["generating", "engine_ready", "generate_error"])
    say()
    restage()
    return pn.Column(nobody, place, sizing_mode="stretch_both", margin=0)


def _player(session: Session, motions: list, names: list[str]) -> Any:
    from viewers.web.player import PanelPlayer

    state = session.state
    player = PanelPlayer(
        motions, labels=names, height=None, sizing_mode="stretch_both", margin=0, theme=state.theme, global_keys=True,
        playing=state.frame < 0, frame=max(0, state.frame),
    )  # fmt: skip
    tie(player, state, theme="theme", tool="tool")
    follow(player, state, ["pinned", "fps", "capabilities"], lambda: {"pinned": _pins(session)})

    def picked(event: Any) -> None:
        if 0 <= event.new < len(state.shown):
            session.select(state.shown[event.new])

    def moved(*_: Any) -> None:
        playhead = player.frame / player.motions[0].fps
        state.param.update(playhead=playhead, frame=-1 if player.playing else player.frame)

    def drawn(event: Any) -> None:
        what = event.new
        if what.get("kind") == "path":
            session.pins.path(what["points"])
        elif what.get("kind") == "joint":
            session.pins.joint(what["joint"], what["place"], what["frame"] / what["fps"])

    player.param.watch(picked, "selected")
    player.param.watch(moved, ["frame", "playing"])
    player.param.watch(drawn, "drawn")
    return player


def _pins(session: Session) -> dict[str, Any]:
    """What is pinned, for the player; nothing where the engine is not told of it."""
    state = session.state
    return as_shown(state.pinned, state.fps) if "constraints" in state.capabilities else {}


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
