"""`motionloom library`: where projects are kept, and a copy of it."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated

import typer

from engines.errors import FormatError

app = typer.Typer(no_args_is_help=True, help="Where the studio keeps projects and takes, and how to copy it.")
LibraryOption = Annotated[
    str | None, typer.Option(metavar="URL", help="Another library than your own: a file, or a SQLAlchemy URL.")
]


@app.command()
def info(library: LibraryOption = None) -> None:
    """Say where the library is and what is in it."""
    from studio.library import open_library
    from studio.wording import counted, since

    opened = open_library(library)
    typer.echo(opened.place)
    now = time.time()
    for project in opened.projects():
        about = f"{counted(project.takes, 'take')} · {since(project.changed, now)}"
        typer.echo(f"  {project.name:<40}{about}")
    opened.close()


@app.command()
def copy(
    target: Annotated[Path, typer.Argument(metavar="FILE", help="The copy; a file of that name must not exist.")],
    library: LibraryOption = None,
) -> None:
    """Copy a library in a file, whole, also while a studio is at work in it.

    The copy is a library itself: motionloom studio --library FILE opens it.
    """
    from studio.library import database, open_library

    if target.exists():
        raise FormatError(target, "is there already; accepted: the name of a new file.")
    if not target.parent.is_dir():
        raise FormatError(target, "there is no such folder.")
    opened = open_library(library)
    try:
        typer.echo(database.copy(opened.engine, target))
    finally:
        opened.close()
