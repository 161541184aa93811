"""Row by row and repeat by repeat, whatever the protocol: progress, stopping, going on."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import Any, Literal, Protocol

from engines.errors import Cancelled, OutOfRangeError
from engines.evaluation.results import Repeat, Results, Row

Held = Literal["held-out", "test", "val"]
PARTS: Mapping[str, tuple[str, ...]] = {"held-out": ("val", "test"), "test": ("test",), "val": ("val",)}
"""What data the real motions may come from, and the splits it stands for."""
BATCH = 256
"""Motions generated and looked at together: bounds memory."""
PHYSICAL = 600
"""About so many motions of a repeat are measured physically."""
REAL, TRAINING = "real (held out)", "real (training)"
"""Rows of real motions: those held out, and those the engines and their judges were trained on."""

Progress = Callable[[int, int, str], None]
"""Called with motions generated, motions to generate in all, and the row at hand."""


class Bench(Protocol):
    """A paper's protocol: what the rows of one table share, and how a row is measured."""

    per_repeat: int
    """Motions generated in each repeat."""

    def real_rows(self) -> dict[str, int]:
        """Names of the rows of real motions, each with its number of clips."""
        ...

    def drawn(self, row: str, repeat: int) -> Any:
        """What is seen of the real motions of a row, in a repeat."""
        ...

    def generated(self, engine: Any, repeat: int, run: Run) -> Any:
        """What is seen of an engine's motions; asks `run` between batches whether to go on, and tells it of each."""
        ...

    def measured(self, repeat: int, row: Row, looked: Any, began: float) -> Repeat:
        """All figures of what was seen; `began` is the time (monotonic) the repeat began at."""
        ...


class Run:
    """How far an evaluation is, and whether it is to go on."""

    def __init__(self, progress: Progress | None, cancel: Callable[[], bool] | None, total: int) -> None:
        self.progress, self.cancel, self.row, self.repeat = progress, cancel, "", 0
        self.done, self.total = 0, total

    def ask(self) -> None:
        """Between batches.

        Raises:
            Cancelled: it is to stop; the repeat at hand is lost, all before it are kept.
        """
        if self.cancel and self.cancel():
            raise Cancelled(
                f"stopped in repeat {self.repeat + 1} of {self.row}, which was not kept; the same command goes on there"
            )

    def tell(self, more: int) -> None:
        """So many more motions are generated."""
        self.done += more
        if self.progress:
            self.progress(self.done, self.total, self.row)


def evaluate(  # noqa: PLR0913 - what a run needs, each part but the first three optional
    bench: Bench,
    engines: Mapping[str, Any],
    results: Results,
    *,
    repeats: int = 20,
    progress: Progress | None = None,
    cancel: Callable[[], bool] | None = None,
    finished: Callable[[Row], None] | None = None,
) -> None:
    """Fill the rows of the table, repeat by repeat; those that are in `results` already are not measured again.

    Args:
        bench: what the rows share.
        engines: by row name.
        results: gets the rows.
        repeats: how often everything is measured.
        progress: see `Progress`.
        cancel: asked between batches; stops with `Cancelled`, and what is finished stays.
        finished: called after each repeat with its row, to save the results.

    Raises:
        OutOfRangeError: no repeats.
        Cancelled: `cancel()` said so.
    """
    if repeats < 1:
        raise OutOfRangeError("repeats", repeats, "1 or more")
    rows = _rows(bench, engines, results)
    left = sum(max(0, repeats - len(row.repeats)) for row in rows if row.kind == "made")
    run = Run(progress, cancel, left * bench.per_repeat)
    for row in rows:
        for repeat in range(len(row.repeats), repeats):
            run.row, run.repeat = row.name, repeat
            if cancel and cancel():
                raise Cancelled(
                    f"stopped after {repeat} of {repeats} repeats of {row.name}; the same command goes on from there"
                )
            began = time.monotonic()
            if row.kind == "made":
                looked = bench.generated(engines[row.name], repeat, run)
            else:
                looked = bench.drawn(row.name, repeat)
                run.tell(0)
            row.repeats.append(bench.measured(repeat, row, looked, began))
            if finished is not None:
                finished(row)


def _rows(bench: Bench, engines: Mapping[str, Any], results: Results) -> list[Row]:
    """The real rows first, as they are soon done, then the engines' in the order given."""
    rows = [results.row(name, "real", clips=clips) for name, clips in bench.real_rows().items()]
    for name, engine in engines.items():
        about = {"engine": engine.name, "variant": getattr(engine, "variant", ""), "licence": engine.licence}
        rows.append(results.row(name, "made", engine.weights_hash, **about))
    return rows
