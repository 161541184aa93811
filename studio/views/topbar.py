"""The top bar and the projects, and what belongs to the page as a whole: shortcuts, colours, help, the address."""

from __future__ import annotations

from engines import __version__
from studio import casting, links
from studio.session import Session
from studio.views.binding import follow, tie
from studio.views.parts import Page, ProjectList, TopBar


def top_bar(session: Session) -> TopBar:
    """Name of the project, whether it is saved, undo and redo, import, export, colours, help."""
    bar = TopBar(sizing_mode="stretch_both", margin=0)
    tie(
        bar, session.state, scene="scene", undo_name="undo_name", redo_name="redo_name", theme="theme", saved="saved",
        saved_note="saved_note",
    )  # fmt: skip
    return bar


def project_list(session: Session) -> ProjectList:
    """The projects in a dialog."""
    state, projects = session.state, session.projects
    part = ProjectList()
    tie(
        part, state, projects="projects", deleted="deleted_projects", current="project", search="projects_search",
        saved="saved", saved_note="saved_note",
    )  # fmt: skip
    state.param.watch(lambda _event: projects.list(), "projects_search")
    acts = {
        "list": lambda _: projects.list(),
        "new": lambda _: projects.new(),
        "retry": lambda _: projects.refresh(),
        "open": lambda message: projects.open(str(message.get("key", "")), str(message.get("take", ""))),
        "delete": lambda message: projects.delete(str(message.get("key", ""))),
        "restore": lambda message: projects.restore(str(message.get("key", ""))),
    }
    for what, act in acts.items():
        part.on(what, act)
    return part


def page(session: Session, bar: TopBar) -> Page:
    """The invisible part that hears shortcuts; the bar's buttons and the keys mean the same."""
    state, library = session.state, session.projects.library
    whole = Page(
        about=f"motionloom {__version__}. Everything runs on this machine; nothing is sent anywhere.",
        cookie=links.cookie(library.id) if library else "",
    )
    tie(whole, state, theme="theme", message="message")
    follow(whole, state, ["scene"], lambda: {"title": f"{state.scene} · motionloom"})
    shown = ["project", "selected", "frame", "compose_tab", "compared"]
    follow(whole, state, shown, lambda: {"address": links.Link.of_state(state)})

    def import_file(_message: dict) -> None:
        state.compose_tab = "import"
        whole._send_msg({"choose": True})

    def show_export(_message: dict) -> None:
        state.inspector_tab = "export"

    for part in (bar, whole):
        part.on("redo", lambda _: session.redo())
        part.on("import", import_file)
        part.on("export", show_export)
    bar.on("undo", lambda _: session.undo())
    # the key takes back a correction of a picture first, as in any program that draws
    whole.on("undo", lambda _: (session.casting.wants_a_file() and session.casting.undo()) or session.undo())
    made = {"style": session.styling.stylise, casting.TAB: session.casting.make}
    whole.on("generate", lambda _: made.get(state.compose_tab, session.generate)())
    return whole
