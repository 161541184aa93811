"""The top bar, and what belongs to the page as a whole: shortcuts, colours, help, the line in the corner."""

from __future__ import annotations

from engines import __version__
from studio.session import Session
from studio.views.binding import follow, tie
from studio.views.parts import Page, TopBar


def top_bar(session: Session) -> TopBar:
    """Name of the scene, undo and redo, import, export, colours, help."""
    bar = TopBar(sizing_mode="stretch_both", margin=0)
    tie(bar, session.state, scene="scene", undo_name="undo_name", redo_name="redo_name", theme="theme")
    return bar


def page(session: Session, bar: TopBar) -> Page:
    """The invisible part that hears shortcuts; the bar's buttons and the keys mean the same."""
    state = session.state
    whole = Page(about=f"motionloom {__version__}. Everything runs on this machine; nothing is sent anywhere.")
    tie(whole, state, theme="theme", message="message")
    follow(whole, state, ["scene"], lambda: {"title": f"{state.scene} · motionloom"})

    def import_file(_message: dict) -> None:
        state.compose_tab = "import"
        whole._send_msg({"choose": True})

    def show_export(_message: dict) -> None:
        state.inspector_tab = "export"

    for part in (bar, whole):
        part.on("undo", lambda _: session.undo())
        part.on("redo", lambda _: session.redo())
        part.on("import", import_file)
        part.on("export", show_export)
    whole.on("generate", lambda _: session.generate())
    return whole
