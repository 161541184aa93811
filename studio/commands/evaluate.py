"""`motionloom evaluate`: the papers' tables for engines here, on held-out real motion."""

from __future__ import annotations

import hashlib
import platform
import shlex
import signal
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from datetime import UTC, datetime
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from engines.errors import MotionloomError, OutOfRangeError, UnknownLabelError
from studio.commands.console import progress_bar

if TYPE_CHECKING:
    from engines.evaluation import Results

_PROTOCOLS = {"sequences": "sequences", "actions": "actions", "texts": "text", "styles": "stylise"}
"""Each protocol, and what an engine must be able to do for it."""
_PACKAGES = ("motionloom", "numpy", "scipy", "torch", "scikit-learn")


def evaluate(  # noqa: PLR0913, PLR0917 (one parameter an option)
    engines: Annotated[
        list[str],
        typer.Argument(
            metavar="ENGINE[:VARIANT]...", help="What to judge; `:all` for every variant, `@FILE` for other weights."
        ),
    ],
    out: Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="Folder of the report; goes on there.")],
    protocol: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="sequences, actions, texts or styles; if none, the first of them that fits."),
    ] = None,
    data: Annotated[str, typer.Option(metavar="NAME", help="Real motions: held-out (val and test), test or val.")] = (
        "held-out"
    ),
    repeats: Annotated[int, typer.Option(metavar="N", help="How often everything is measured.")] = 20,
    motions: Annotated[int, typer.Option(metavar="N", help="Generated in each repeat.")] = 3000,
    frames: Annotated[int, typer.Option(metavar="N", help="Actions: length of each, frames (20 a second).")] = 60,
    by: Annotated[str, typer.Option(metavar="WAY", help="Styles: told by label, motion or prior.")] = "label",
    corpus: Annotated[str, typer.Option(metavar="NAME", help="Styles: whose motions are put in them.")] = (
        "bandai-namco"
    ),
    tempo: Annotated[bool, typer.Option("--tempo", help="Styles: engines may also change how fast motions go.")] = (
        False
    ),
    seed: Annotated[int, typer.Option(metavar="N", help="The same seed gives the same table.")] = 0,
    threads: Annotated[int | None, typer.Option(metavar="N", help="Processor threads; as torch likes if none.")] = None,
    fresh: Annotated[bool, typer.Option("--fresh", help="Begin anew what is in the folder.")] = False,
) -> None:
    """Judge engines by the protocol of their paper: a table with 95 % intervals, and a page to look at.

    [bold]Examples[/bold]

    motionloom evaluate action2motion --repeats 2 --motions 300 --out report/

    motionloom evaluate action2motion:all --out report/     (the four decoders; the papers' 20 times 3,000 motions)

    motionloom evaluate action2motion:glmi-m action2motion:glmi-m@my.safetensors --data test --out mine/

    motionloom evaluate loom --protocol styles --repeats 30 --motions 300 --out styles/

    motionloom evaluate multiact --motions 1000 --repeats 5 --out sequences/

    The protocol `actions` is Action2Motion's, with the recogniser of actions as judge; `texts` is Text2Motion's, for
    engines that take sentences: R-precision, distances and FID in the space that motions share with sentences;
    `styles` is generative stylization's: held-out motions in other manners, the style told by its name, by a clip that
    has it, or by neither.

    Writes index.html (open it in a browser), table.md, table.csv, table.json and rows.json. Ctrl+C keeps every finished
    repeat; the same command goes on from there, with more repeats too. Needs prepared data (`motionloom data prepare`).
    """
    for name, value in (("--repeats", repeats), ("--threads", threads)):
        if value is not None and value < 1:
            raise OutOfRangeError(name, value, "1 or more")
    from engines.evaluation import evaluate as run

    if protocol not in {None, *_PROTOCOLS}:
        raise UnknownLabelError("protocol", protocol, _PROTOCOLS)
    wanted = [part for spec in engines for part in _parse(spec)]
    if threads is not None:
        import torch

        torch.set_num_threads(threads)
    named = {name: _load(name) for name in dict.fromkeys(wanted)}
    match protocol or _fitting(named):
        case "texts":
            bench, results = _by_texts(named, data, motions, seed)
        case "sequences":
            named |= _other_ways()
            bench, results = _by_sequences(named, data, motions, frames, seed)
        case "styles":
            bench, results = _by_styles(named, data, by, corpus, motions, tempo, seed)
        case _:
            bench, results = _by_actions(named, data, motions, frames, seed)
    out.mkdir(parents=True, exist_ok=True)
    if not fresh:
        results.go_on_from(out / "rows.json")
    with _stoppable() as stopped, progress_bar("evaluate", unit="motion") as bar:
        run(
            bench,
            named,
            results,
            repeats=repeats,
            progress=lambda done, total, _row: bar(done, total),
            cancel=stopped,
            finished=lambda _row: results.save(out / "rows.json"),
        )
    _tell(out, bench, named, results, repeats)


def _fitting(engines: Mapping[str, Any]) -> str:
    """The protocol that all of them can be judged by."""
    for protocol, ability in _PROTOCOLS.items():
        if all(ability in engine.capabilities for engine in engines.values()):
            return protocol
    able = "; ".join(f"{name}: {', '.join(sorted(e.capabilities)) or 'nothing'}" for name, e in engines.items())
    raise MotionloomError(f"no protocol fits all of them: actions, text or stylise is needed, and they can do: {able}.")


def _by_actions(engines: Mapping[str, Any], data: str, motions: int, frames: int, seed: int) -> tuple[Any, Results]:
    from engines import datasets
    from engines.evaluation import ActionBench, Options, Results
    from engines.metrics.evaluators import recogniser
    from engines.weights_file import SHIPPED

    options = Options(data, motions, frames, seed)  # pyright: ignore[reportArgumentType] (checked next)
    options.check()
    judge = recogniser.load("action")
    bench = ActionBench(engines, datasets.load(), judge, options)
    return bench, Results(bench.basis(_digest(SHIPPED / "evaluator-action.safetensors")), judge.labels)


def _other_ways() -> dict[str, Any]:
    """The simple ways, and what the studio's timeline makes."""
    from engines.evaluation import ways
    from studio import tasks
    from studio.timeline_engine import TimelineEngine

    return {**ways.ways(tasks.load_engine("action2motion")), "loom, timeline": TimelineEngine("loom")}


def _by_sequences(engines: Mapping[str, Any], data: str, motions: int, frames: int, seed: int) -> tuple[Any, Results]:
    from engines import datasets
    from engines.evaluation import Results, SequenceBench, SequenceOptions
    from engines.metrics.evaluators import recogniser
    from engines.weights_file import SHIPPED

    options = SequenceOptions(data, motions, frames, seed)  # pyright: ignore[reportArgumentType] (checked next)
    options.check()
    judge = recogniser.load("action")
    bench = SequenceBench(engines, datasets.load(), judge, options)
    return bench, Results(bench.basis(_digest(SHIPPED / "evaluator-action.safetensors")), judge.labels)


def _by_texts(engines: Mapping[str, Any], data: str, motions: int, seed: int) -> tuple[Any, Results]:
    from engines import datasets
    from engines.evaluation import Results, TextBench, TextOptions
    from engines.metrics.evaluators import co_embedding
    from engines.weights_file import SHIPPED

    options = TextOptions(data, motions, seed)  # pyright: ignore[reportArgumentType] (checked next)
    options.check()
    bench = TextBench(engines, datasets.load(), co_embedding.load(), options)
    return bench, Results(bench.basis(_digest(SHIPPED / "evaluator-text.safetensors")), ())


def _by_styles(  # noqa: PLR0913, PLR0917 - what a person chooses
    engines: Mapping[str, Any], data: str, by: str, corpus: str, motions: int, tempo: bool, seed: int
) -> tuple[Any, Results]:
    from engines import datasets
    from engines.evaluation import Results, StyleBench, StyleOptions
    from engines.metrics.evaluators import recogniser
    from engines.weights_file import SHIPPED

    options = StyleOptions(data, by, corpus, motions, tempo, seed)  # pyright: ignore[reportArgumentType] (checked next)
    options.check()
    manners, contents = recogniser.load("style"), recogniser.load("content")
    bench = StyleBench(engines, datasets.load(), manners, contents, options)
    hashes = " ".join(_digest(SHIPPED / f"evaluator-{task}.safetensors") for task in ("style", "content"))
    return bench, Results(bench.basis(hashes), ())


def _tell(out: Path, bench: Any, named: Mapping[str, Any], results: Any, repeats: int) -> None:
    """Write the report, and print its table."""
    from engines.evaluation import tables
    from studio.report import write_report

    page = write_report(out, bench, named, results, repeats, _facts())
    rows = results.shown(list(named), repeats)
    columns = tables.columns(rows)
    for row in rows:
        typer.secho(row.name, bold=True)
        for name, found in row.estimates.items():
            typer.echo(f"  {tables.heading(columns[name]):<34}{tables.cell(found):>20}")
    for reason, names in bench.left_out.items():
        typer.echo(f"left out, {reason}: {', '.join(names)}", err=True)
    typer.echo(page)


def _parse(spec: str) -> list[str]:
    """`action2motion:all` -> a name for each variant; anything else is itself.

    Raises:
        UnknownLabelError: no engine of that name.
    """
    from engines import registry
    from studio import tasks

    name, _, weights = spec.partition("@")
    name, _, variant = name.partition(":")
    known = {**registry.available(), **registry.stylisers()}
    if name not in known and not weights:
        raise UnknownLabelError("engine", name, known)
    if variant != "all":
        return [spec]
    return [f"{name}:{each}" for each in getattr(tasks.load_engine(name), "variants", ())] or [name]


def _load(spec: str) -> Any:
    """The engine of `name`, `name:variant` or `name:variant@weights`."""
    import engines

    rest, _, weights = spec.partition("@")
    name, _, variant = rest.partition(":")
    options = {"variant": variant, "checkpoint": weights}
    return engines.load(name, **{key: value for key, value in options.items() if value})


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _facts() -> dict[str, str]:
    """What the page says of how it was made."""
    versions = []
    for package in _PACKAGES:
        try:
            versions.append(f"{package} {metadata.version(package)}")
        except metadata.PackageNotFoundError:
            continue
    return {
        "command": shlex.join(["motionloom", *sys.argv[1:]]),
        "made": f"{datetime.now(UTC):%Y-%m-%d %H:%M} UTC",
        "with": f"{', '.join(versions)}; Python {platform.python_version()}, {platform.system()} {platform.machine()}",
    }


@contextmanager
def _stoppable() -> Iterator[Callable[[], bool]]:
    """Ctrl+C asks for a stop between two batches; a second one stops at once."""
    asked = False

    def ask(number: int, _frame: object) -> None:
        nonlocal asked
        asked = True
        signal.signal(number, before)

    before = signal.signal(signal.SIGINT, ask)
    try:
        yield lambda: asked
    finally:
        signal.signal(signal.SIGINT, before)
