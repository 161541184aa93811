"""`motionloom data`: real motion capture into the cache that training and the motion browser read."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from engines.errors import OutOfRangeError
from studio.commands.console import progress_bar

if TYPE_CHECKING:
    from engines.datasets import Clip
    from engines.datasets.prepare import Failure

app = typer.Typer(
    no_args_is_help=True,
    help="""Real motion capture: prepare it once, see what is there.

[bold]Examples[/bold]

motionloom data prepare --source downloads/

motionloom data list""",
)
_SHOWN = 20
"""So many of the clips left out are named; the rest are counted."""


@app.command("prepare")
def prepare(
    source: Annotated[
        Path, typer.Option("--source", metavar="DIR", help="Folder with the archives, or with them unpacked.")
    ],
    corpora: Annotated[
        str | None, typer.Option(metavar="LIST", help="Comma between: bandai-namco, cmu, utd-mhad. All by default.")
    ] = None,
    workers: Annotated[int | None, typer.Option(metavar="N", help="Processes; all cores by default.")] = None,
) -> None:
    """Read every clip of the data sets, check it, and store it on the house skeleton.

    [bold]Examples[/bold]

    motionloom data prepare --source downloads/

    motionloom data prepare --source downloads/ --corpora cmu,utd-mhad --workers 2

    The cache is made anew and holds the data sets of this run only. Prints its path, and the clips that were left out
    with the reason for each.
    """
    from engines import datasets

    if workers is not None and workers < 1:
        raise OutOfRangeError("--workers", workers, "1 or more")
    names = tuple(datasets.CORPORA) if corpora is None else _names(corpora)
    with progress_bar("prepare", unit="clip") as progress:
        path, failures = datasets.prepare(
            source, names, progress=lambda done, total, _name: progress(done, total), workers=workers
        )
    typer.echo(path)
    _print_left_out(failures)


@app.command("list")
def show() -> None:
    """Tell which data sets are prepared: clips and minutes of each, of each action, and their licences.

    [bold]Examples[/bold]

    motionloom data list
    """
    from engines import datasets
    from engines.errors import FormatError

    try:
        clips = datasets.load()
    except FormatError as none_yet:
        typer.echo(f"{none_yet}", err=True)
        clips = []
    typer.secho(f"{'data set':<28}{'clips':>7}{'minutes':>10}  licence", bold=True)
    for name, corpus in datasets.CORPORA.items():
        own = [clip for clip in clips if clip.corpus == name]
        amounts = f"{len(own):>7,}{_minutes(own):>10.1f}" if own else f"{'missing':>17}"
        typer.echo(f"{name:<28}{amounts}  {corpus.licence}")
        if not own:
            typer.echo(f"  (motionloom data prepare --source DIR, with {corpus.archive} in DIR)")
    splits = Counter(clip.split for clip in clips)
    parts = ", ".join(f"{splits[part]:,} {part}" for part in ("train", "val", "test"))
    typer.echo(f"{'in all':<28}{len(clips):>7,}{_minutes(clips):>10.1f}  {parts}")
    if clips:
        _print_actions(clips)


def _print_actions(clips: Sequence[Clip]) -> None:
    from engines.actions import VOCABULARY

    typer.secho(f"\n{'action':<28}{'clips':>7}{'minutes':>10}  data sets", bold=True)
    for action in VOCABULARY:
        own = [clip for clip in clips if clip.action == action.name]
        if own:
            sources = ", ".join(sorted({clip.corpus for clip in own}))
            typer.echo(f"{action.name:<28}{len(own):>7,}{_minutes(own):>10.1f}  {sources}")
    rest = [clip for clip in clips if clip.action is None]
    if rest:
        typer.echo(f"{'(no action)':<28}{len(rest):>7,}{_minutes(rest):>10.1f}")


def _print_left_out(failures: Sequence[Failure]) -> None:
    if not failures:
        return
    typer.echo(f"{len(failures):,} clips were left out:", err=True)
    for failure in failures[:_SHOWN]:
        typer.echo(f"  {failure.clip}: {failure.reason}", err=True)
    if len(failures) > _SHOWN:
        typer.echo(f"  and {len(failures) - _SHOWN:,} more (--verbose names them all)", err=True)


def _minutes(clips: Iterable[Clip]) -> float:
    return sum(clip.motion.duration for clip in clips) / 60


def _names(text: str) -> tuple[str, ...]:
    return tuple(part.strip().lower() for part in text.split(",") if part.strip())
