"""The app: a page for each browser session, and the server that hands them out, to this machine only by default."""

from __future__ import annotations

import atexit
import logging
import os
import shutil
import signal
import socket
import sys
import tempfile
import threading
import webbrowser
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

import panel as pn
from panel.io.resources import LOCAL_DIST
from tornado import web
from tornado.process import task_id
from tornado.websocket import WebSocketClosedError

from engines.errors import MotionloomError, OutOfRangeError
from studio import downloads, exchange, tasks
from studio.jobs import JobQueue, shared_queue
from studio.library import Library, open_library
from studio.links import Link
from studio.serving import LOCAL, Access, end_with, processes
from studio.session import Session
from studio.settings import GenerateSettings
from studio.state import StudioState
from studio.views import character, compose, inspector, stage, style, takes, topbar
from studio.views.forms import column
from studio.views.parts import ASSETS, read_asset

log = logging.getLogger(__name__)

MESSAGE_LIMIT = 8 * 2**20
"""Largest message a browser may send, bytes; files travel in pieces of 1 MB."""
_PORTS_TRIED = 20
_LOOK_EVERY = 2000
"""Milliseconds after which a page looks whether others changed its project."""


@dataclass(frozen=True)
class Keeping:
    """Where the projects of all pages are kept."""

    library: Library | None = None
    problem: str = ""
    """Why there is no library."""


def keep(url: str | None = None) -> Keeping:
    """Open the library; where it cannot be used, the studio works without, and says why."""
    try:
        return Keeping(open_library(url))
    except MotionloomError as problem:
        log.warning("%s Takes are kept in memory only.", problem)
        return Keeping(None, str(problem))


def make_app(queue: JobQueue | None = None, keeping: Keeping | None = None) -> pn.Template:
    """The page of one browser session. Its work is stopped and its files are removed when the session ends."""
    doc = pn.state.curdoc
    if doc is not None:
        # styles come from here also where the page itself was handed out by another process
        doc.template_variables["dist_url"] = LOCAL_DIST
    kept = keeping or Keeping()
    session = Session(
        StudioState(), queue=queue, dispatch=_on_document(doc), library=kept.library, problem=kept.problem
    )
    link = Link.of_page(kept.library)
    session.state.param.update(frame=link.frame, compose_tab=link.tab)
    page = _lay_out(session)
    atexit.register(session.close)

    def leave(_context: Any) -> None:
        atexit.unregister(session.close)
        session.close()

    pn.state.on_session_destroyed(leave)
    pn.state.onload(lambda: session.start(link.project, link.take, link.asked, link.compared))
    if kept.library is not None:
        pn.state.add_periodic_callback(session.projects.refresh, period=_LOOK_EVERY)
    return page


def _on_document(doc: Any) -> Callable[[Callable[[], None]], None]:
    """Run functions on the thread and under the lock of a document; none any more once its browser has gone.

    What one of them changes travels to the browser in one message.
    """

    def together(act: Callable[[], None]) -> None:
        with pn.io.hold(doc):
            act()

    def dispatch(act: Callable[[], None]) -> None:
        if doc is None:
            act()
        elif doc.session_context is not None and not doc.session_context.destroyed:
            doc.add_next_tick_callback(lambda: together(act))

    return dispatch


def _lay_out(session: Session) -> pn.Template:
    page = pn.Template(read_asset("page.html"))
    field = compose.action_field(session)
    bar = topbar.top_bar(session)
    parts = {
        "topbar": bar,
        "compose_tabs": compose.compose_tabs(session),
        "compose": compose.compose_form(session, field),
        "go": column(
            compose.generate_button(session), style.style_button(session), character.character_button(session), gap=0
        ),
        "ideas": compose.examples(session),
        "browse": compose.action_grid(session),
        "styles": style.style_grid(session),
        "stage": stage.stage(session),
        "takes": takes.gallery(session),
        "inspector": inspector.inspector(session),
        "projects": topbar.project_list(session),
        "page": topbar.page(session, bar),
    }
    for name, part in parts.items():
        page.add_panel(name, part)
    page.add_variable("theme_css", read_asset("theme.css"))
    page.add_variable("favicon", quote(read_asset("favicon.svg")))
    return page


def _warm_up(_progress: Any, _cancel: Any) -> None:
    """Load what the first page needs while the browser is still opening."""
    from viewers import bodies
    from viewers.web.controls import encode_body

    tasks.load_engine(GenerateSettings().engine)
    encode_body(bodies.get(bodies.DEFAULT))


class _Departed(logging.Filter):
    """Says nothing of messages to browsers that have gone: closing a tab is no error."""

    def filter(self, record: logging.LogRecord) -> bool:
        return not (record.exc_info and isinstance(record.exc_info[1], WebSocketClosedError))


class _Download(web.RequestHandler):
    """Hands out finished exports."""

    async def get(self, key: str, name: str) -> None:
        path = downloads.find(key, name)
        if path is None:
            raise web.HTTPError(404)
        self.set_header("Content-Type", "application/octet-stream")
        self.set_header("Content-Disposition", f'attachment; filename="{name}"')
        self.set_header("Content-Length", str(path.stat().st_size))
        with path.open("rb") as file:
            while piece := file.read(2**18):
                self.write(piece)
                await self.flush()


def free_port(port: int, host: str = "127.0.0.1") -> int:
    """`port`, or the next one that is free.

    Raises:
        OutOfRangeError: none of the next twenty is free, or the address is not one of this machine.
    """
    for candidate in range(port, port + _PORTS_TRIED):
        with socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                probe.bind((host, candidate))
            except (OSError, OverflowError):
                continue
            return candidate
    raise OutOfRangeError("port", port, f"a free port on {host}; none is free from {port} to {port + _PORTS_TRIED - 1}")


def serve(  # noqa: PLR0913, PLR0917 (each is a thing of its own)
    port: int = 5006,
    host: str = "127.0.0.1",
    open_browser: bool = True,
    queue: JobQueue | None = None,
    library: str | None = None,
    access: Access | None = None,
    num_procs: int = 1,
    **options: Any,
) -> Any:
    """Serve the studio until interrupted.

    Args:
        port: wanted; the next free one is taken when it is in use.
        host: address to listen on; other machines reach the studio only if this says so.
        open_browser: show the page.
        queue: where long work runs; shared by the process unless given.
        library: SQLAlchemy URL, or path of a SQLite file; in the user's data folder unless given.
        access: who may open the page; whoever reaches it unless given.
        num_procs: so many processes answer; 0 for one a processor.
        options: passed on to `panel.serve`, as `threaded=True` or `start=False`.

    Raises:
        MotionloomError: `access` or `num_procs` say something that cannot work.
    """
    access = (access or Access()).checked(host)
    count = processes(num_procs)
    chosen = free_port(port, host)
    if chosen != port:
        log.warning("port %d is taken; using %d", port, chosen)
    logging.getLogger("asyncio").addFilter(_Departed())
    if threading.current_thread() is threading.main_thread():
        # as on Ctrl+C: what sessions left behind is cleared away on the way out
        signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
    exchange.sweep()
    kept = keep(library)
    told = {
        "port": chosen,
        "address": host,
        "title": "motionloom",
        "static_dirs": {"assets": str(ASSETS)},
        "extra_patterns": [(rf"/{downloads.ROUTE}/([\w-]+)/([\w.-]+)", _Download)],
        "websocket_max_message_size": MESSAGE_LIMIT,
        **access.options(host, chosen),
        **options,
    }
    page: dict[str, Any] = {"/": lambda: make_app(queue, kept)}
    if count > 1:
        return _serve_in_several(page, told, count, open_browser)
    (queue or shared_queue()).submit("server", "warm up", _warm_up)
    return pn.serve(page, show=open_browser, **told)


def _serve_in_several(page: dict[str, Any], told: dict[str, Any], count: int, open_browser: bool) -> None:
    """Serve by several processes that share the port. Threads, and what they hold, begin after these are split off."""
    parent = os.getpid()
    folder = Path(tempfile.mkdtemp(prefix=exchange.mark()))
    atexit.register(lambda: os.getpid() == parent and shutil.rmtree(folder, ignore_errors=True))
    downloads.share(folder)
    server: Any = pn.serve(page, show=False, start=False, num_procs=count, **told)  # the parent waits in here
    end_with(parent)
    shared_queue().submit("server", "warm up", _warm_up)
    if open_browser and task_id() == 0:
        webbrowser.open(f"http://{'localhost' if told['address'] in LOCAL else told['address']}:{told['port']}/")
    server.start()
    server.io_loop.start()
