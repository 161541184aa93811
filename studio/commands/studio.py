"""`motionloom studio`: the app in the browser."""

from __future__ import annotations

from typing import Annotated

import typer


def studio(
    port: Annotated[int, typer.Option(metavar="N", help="Port; the next free one when it is taken.")] = 5006,
    host: Annotated[
        str, typer.Option(metavar="ADDRESS", help="Address to listen on; 0.0.0.0 lets other machines in.")
    ] = "127.0.0.1",
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open the browser.")] = True,
    library: Annotated[
        str | None,
        typer.Option(metavar="URL", help="Where projects are kept: a file, or a SQLAlchemy URL. [your data folder]"),
    ] = None,
) -> None:
    """Open the studio: generate, watch, compare and export motions in the browser.

    Only this machine can reach it unless --host says otherwise. Ctrl+C ends it. Every step is saved at once; where,
    and how to keep it in PostgreSQL or copy it: docs/library.md.

    [bold]Examples[/bold]

    motionloom studio

    motionloom studio --port 8080 --no-browser

    motionloom studio --library /srv/motions/library.db
    """
    from studio.app import serve

    serve(port=port, host=host, open_browser=browser, library=library)
