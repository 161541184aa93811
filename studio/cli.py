"""The command line.

`motionloom studio | generate | caption | stylize | character | render | convert | info | library | data | train |
evaluate`

Each command is a small module in `studio/commands/`; torch and Panel are imported when a command needs them, so that
`motionloom --help` answers at once. Exit codes: 0 done, 1 a mistake that can be mended (one line says which),
2 wrong usage, 130 cancelled.
"""

from __future__ import annotations

import logging
import sys
from typing import Annotated

import typer

from engines import __version__
from engines.errors import Cancelled, MotionloomError
from studio.commands import (
    caption,
    character,
    convert,
    data,
    evaluate,
    generate,
    info,
    library,
    render,
    studio,
    stylize,
    train,
)

app = typer.Typer(
    name="motionloom",
    no_args_is_help=True,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    help="""An interactive studio for human motion: generate, watch, edit and export, on a laptop, offline.

Start with [bold]motionloom studio[/bold]: it opens the app in your browser. Everything the app does is also here,
by the same names and with the same settings file.""",
)
app.command("studio")(studio.studio)
app.command("generate")(generate.generate)
app.command("caption")(caption.caption)
app.command("stylize")(stylize.stylize)
app.command("character")(character.character)
app.command("render")(render.render)
app.command("convert")(convert.convert)
app.command("info")(info.info)
app.add_typer(library.app, name="library")
app.add_typer(data.app, name="data")
app.add_typer(train.app, name="train")
app.command("evaluate")(evaluate.evaluate)


def _show_version(asked: bool) -> None:
    if asked:
        typer.echo(f"motionloom {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Print the version and exit.")
    ] = False,
    verbose: Annotated[bool, typer.Option("--verbose", "-v", help="Say more about what is being done.")] = False,
) -> None:
    logging.basicConfig(
        level=logging.INFO if verbose else logging.WARNING, format="%(levelname)s %(name)s: %(message)s"
    )


def main() -> None:
    """Entry point of the `motionloom` command."""
    try:
        app(prog_name="motionloom")
    except Cancelled as stop:
        typer.echo(f"cancelled: {stop}", err=True)
        sys.exit(130)
    except MotionloomError as problem:
        typer.echo(f"error: {problem}", err=True)
        sys.exit(1)
    except OSError as problem:
        typer.echo(f"error: {problem.filename or ''}: {problem.strerror or problem}".replace(": :", ":"), err=True)
        sys.exit(1)


if __name__ == "__main__":
    main()
