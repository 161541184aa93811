"""`motionloom data`: real motion capture into the cache that training and the motion browser read."""

from __future__ import annotations

import random
import sys
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from engines.errors import OutOfRangeError, UnknownLabelError
from studio.commands.console import progress_bar

if TYPE_CHECKING:
    from engines.datasets import Clip
    from engines.datasets.describe import Summary
    from engines.datasets.prepare import Failure

app = typer.Typer(
    no_args_is_help=True,
    help="""Real motion capture: prepare it once, see what is there.

[bold]Examples[/bold]

motionloom data prepare --source downloads/

motionloom data list

motionloom data describe cmu --plot cmu.svg""",
)
_SHOWN = 20
"""So many of the clips left out are named; the rest are counted."""


@app.command("prepare")
def prepare(
    source: Annotated[
        Path, typer.Option("--source", metavar="DIR", help="Folder with the archives, or with them unpacked.")
    ],
    corpora: Annotated[
        str | None,
        typer.Option(metavar="LIST", help="Names as in `data list`, comma between. By default all that are found."),
    ] = None,
    workers: Annotated[int | None, typer.Option(metavar="N", help="Processes; all cores by default.")] = None,
) -> None:
    """Read every clip of the data sets, check it, and store it on the house skeleton.

    [bold]Examples[/bold]

    motionloom data prepare --source downloads/

    motionloom data prepare --source downloads/ --corpora cmu,utd-mhad --workers 2

    The cache is made anew and holds the data sets of this run only. Prints its path, and the clips that were left out
    with the reason for each. `motionloom data list` tells where each data set is had from and what to put where.
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
def show(
    source: Annotated[
        Path | None, typer.Option("--source", metavar="DIR", help="Tell also which data sets lie in this folder.")
    ] = None,
) -> None:
    """Tell which data sets are prepared: clips and minutes of each, of each action, and their licences.

    [bold]Examples[/bold]

    motionloom data list

    motionloom data list --source downloads/

    For a data set that is not prepared: the page to get it from, and what to put where.
    """
    from engines import datasets
    from engines.datasets import describe
    from engines.errors import FormatError

    present = describe.found(source) if source else {}
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
        if name in present:
            typer.echo(f"  found in {source}: {present[name]}")
        if not own:
            typer.echo(f"  from {corpus.download}\n  put into the source folder: {corpus.layout}")
    splits = Counter(clip.split for clip in clips)
    parts = ", ".join(f"{splits[part]:,} {part}" for part in ("train", "val", "test"))
    typer.echo(f"{'in all':<28}{len(clips):>7,}{_minutes(clips):>10.1f}  {parts}")
    if clips:
        _print_actions(clips)


@app.command("describe")
def describe_command(
    name: Annotated[
        str | None, typer.Argument(help="A data set, as in `data list`. All that are prepared by default.")
    ] = None,
    by: Annotated[
        str | None,
        typer.Option(metavar="WHAT", help="Count by action, style, label, fine, subject, split or corpus."),
    ] = None,
    plot: Annotated[
        Path | None, typer.Option("--plot", metavar="FILE", help="Draw the distribution to an .svg or .png file.")
    ] = None,
    captions: Annotated[
        int, typer.Option("--captions", metavar="N", help="Show so many clips with captions made from their motion.")
    ] = 0,
    seed: Annotated[int, typer.Option(metavar="N", help="Seed of the clips and captions shown.")] = 0,
) -> None:
    """Tell what is in the prepared data: how much, of what, in which parts, with a bar a label.

    [bold]Examples[/bold]

    motionloom data describe

    motionloom data describe bandai-namco --by style --plot styles.png

    motionloom data describe utd-mhad --captions 5
    """
    from engines import datasets
    from engines.datasets import describe

    if captions < 0:
        raise OutOfRangeError("--captions", captions, "0 or more")
    if name is not None and name not in datasets.CORPORA:
        raise UnknownLabelError("data set", name, datasets.CORPORA)
    if by is not None and by not in describe.BYS:
        raise UnknownLabelError("property of clips", by, describe.BYS)
    clips = datasets.load(corpora=None if name is None else [name])
    chosen: describe.By | None = next((item for item in describe.BYS if item == by), None)
    summary = describe.summarise(clips, chosen, name or "all data sets")
    _print_summary(summary)
    if captions:
        _print_captions(clips, captions, seed)
    if plot:
        typer.echo(describe.plot(summary, plot))


def _print_summary(summary: Summary) -> None:
    from engines.datasets import describe

    shortest, median, longest = summary.seconds
    parts = ", ".join(f"{summary.splits.get(part, 0):,} {part}" for part in ("train", "val", "test"))
    facts = {
        "clips": f"{summary.clips:,} ({parts})",
        "minutes": f"{summary.minutes:.1f}",
        "seconds a clip": f"{shortest:.1f} to {longest:.1f}, median {median:.1f}",
        "subjects": f"{summary.subjects:,}" if summary.subjects else "not told",
        "sentences": f"{summary.sentences:,} written by people",
    }
    typer.secho(summary.title, bold=True)
    for what, value in facts.items():
        typer.echo(f"{what:<30}{value}")
    typer.secho(f"\n{summary.by:<30}{'clips':>7}{'minutes':>10}", bold=True)
    unicode = "utf" in (sys.stdout.encoding or "").lower()
    for line in describe.bars(summary, mark="█" if unicode else "#"):
        typer.echo(line)


def _print_captions(clips: Sequence[Clip], count: int, seed: int) -> None:
    from engines.datasets.captions import captions

    draw = random.Random(seed)
    for clip in draw.sample(clips, min(count, len(clips))):
        about = ", ".join(part for part in (clip.action or clip.label, clip.style) if part)
        typer.secho(f"\n{clip.corpus}/{clip.name}" + (f" ({about})" if about else ""), bold=True)
        for text in captions(clip, seed)[:6]:
            typer.echo(f"  {text}")


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
