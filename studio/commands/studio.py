"""`motionloom studio`: the app in the browser."""

from __future__ import annotations

from typing import Annotated

import typer

_MANY = "For several people"


def studio(  # noqa: PLR0913, PLR0917 (one parameter an option)
    port: Annotated[int, typer.Option(metavar="N", help="Port; the next free one when it is taken.")] = 5006,
    host: Annotated[
        str,
        typer.Option(
            "--host", "--address", metavar="ADDRESS", help="Address to listen on; 0.0.0.0 lets other machines in."
        ),
    ] = "127.0.0.1",
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open the browser.")] = True,
    library: Annotated[
        str | None,
        typer.Option(metavar="URL", help="Where projects are kept: a file, or a SQLAlchemy URL. [your data folder]"),
    ] = None,
    allow_websocket_origin: Annotated[
        list[str] | None,
        typer.Option(
            metavar="HOST:PORT", help="Address under which browsers see it; repeatable.", rich_help_panel=_MANY
        ),
    ] = None,
    num_procs: Annotated[
        int, typer.Option(metavar="N", help="Processes that serve; 0: one a processor.", rich_help_panel=_MANY)
    ] = 1,
    basic_auth: Annotated[
        str,
        typer.Option(
            metavar="PASSWORD|FILE",
            envvar="PANEL_BASIC_AUTH",
            rich_help_panel=_MANY,
            help="Ask for a password; FILE: JSON of names and passwords.",
        ),
    ] = "",
    oauth_provider: Annotated[
        str,
        typer.Option(
            metavar="NAME",
            envvar="PANEL_OAUTH_PROVIDER",
            help="Sign in by github, google, gitlab, azure, okta, auth0, generic …",
            rich_help_panel=_MANY,
        ),
    ] = "",
    oauth_key: Annotated[
        str, typer.Option(metavar="KEY", envvar="PANEL_OAUTH_KEY", help="As it gave you.", rich_help_panel=_MANY)
    ] = "",
    oauth_secret: Annotated[
        str, typer.Option(metavar="SECRET", envvar="PANEL_OAUTH_SECRET", help="Likewise.", rich_help_panel=_MANY)
    ] = "",
    oauth_redirect_uri: Annotated[
        str,
        typer.Option(
            metavar="URL",
            envvar="PANEL_OAUTH_REDIRECT_URI",
            help="Where it sends people back to.",
            rich_help_panel=_MANY,
        ),
    ] = "",
    cookie_secret: Annotated[
        str,
        typer.Option(
            metavar="TEXT",
            envvar="PANEL_COOKIE_SECRET",
            rich_help_panel=_MANY,
            help="Signs cookies, so that people stay signed in over a restart.",
        ),
    ] = "",
) -> None:
    """Open the studio: generate, watch, compare and export motions in the browser.

    Only this machine can reach it unless --host says otherwise. Ctrl+C ends it. Every step is saved at once; where,
    and how to keep it in PostgreSQL or copy it: docs/library.md. Passwords, other machines, many people:
    docs/serving.md.

    [bold]Examples[/bold]

    motionloom studio

    motionloom studio --port 8080 --no-browser

    motionloom studio --library /srv/motions/library.db

    motionloom studio --host 0.0.0.0 --basic-auth people.json --allow-websocket-origin lab.example.org:5006
    """
    from studio.app import serve
    from studio.serving import Access

    access = Access(
        basic_auth, oauth_provider, oauth_key, oauth_secret, oauth_redirect_uri, cookie_secret,
        tuple(allow_websocket_origin or ()),
    )  # fmt: skip
    serve(port=port, host=host, open_browser=browser, library=library, access=access, num_procs=num_procs)
