"""What a training leaves for people: `history.json`, `validation.json`, `losses.csv` and the page `losses.html`."""

from __future__ import annotations

import csv
import io
import json
import logging
import math
import time
from pathlib import Path
from typing import Any

from engines.errors import FormatError
from engines.training.files import write_beside
from engines.training.state import TrainingState

log = logging.getLogger(__name__)

_PAGE = Path(__file__).with_name("losses.html")
_FACTS = ("step", "seconds", "learning_rate", "gradient_norm", "total")
_MOST_POINTS = 1500
"""More points than this a line are thinned out on the page; the tables hold them all."""


def write_reports(state: TrainingState, folder: Path, title: str) -> None:
    """Write the logs and the page anew; a full disk is a warning here, for the training is worth more than its log."""
    try:
        write_beside(folder / "history.json", json.dumps(state.history))
        write_beside(folder / "validation.json", json.dumps(state.validation))
        write_beside(folder / "losses.csv", table(state))
        write_beside(folder / "losses.html", page(state, title))
    except FormatError as error:
        log.warning("%s", error)


def table(state: TrainingState) -> str:
    """All logged lines as CSV, in the order of their steps: split (train or val), step, seconds, total, terms, ..."""
    lines = [{"split": "train", "total": total_of(line), **line} for line in state.history]
    lines += [{"split": "val", **line} for line in state.validation]
    lines.sort(key=lambda line: (line["step"], line["split"]))
    columns = dict.fromkeys(["split", "step", "seconds", "total", *(name for line in lines for name in line)])
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows(lines)
    return text.getvalue()


def page(state: TrainingState, title: str) -> str:
    """A page of its own, no other file needed: a line a term, validation dashed; reloads itself while training runs."""
    facts = {
        "title": title,
        "step": state.step,
        "steps": state.plan.steps,
        "seconds": state.seconds,
        "written": time.time(),
        "finished": state.finished,
        "early": state.finished and state.step < state.plan.steps,
        "best": {"step": state.best_step, "total": state.best_total} if math.isfinite(state.best_total) else None,
        "parameters": sum(p.numel() for p in state.model.parameters()),
        "processes": state.share.world,
        "train": _series([{"total": total_of(line), **line} for line in state.history]),
        "validation": _series(state.validation),
    }
    data = json.dumps(facts).replace("<", "\\u003c")
    return _PAGE.read_text(encoding="utf-8").replace('"DATA"', data, 1).replace("TITLE", _escaped(title), 1)


def total_of(line: dict[str, float]) -> float:
    """The loss of a logged line: the sum of its terms."""
    return sum(value for name, value in line.items() if name not in _FACTS)


def _series(lines: list[dict[str, Any]]) -> dict[str, list[list[float]]]:
    """Term -> points (step, value), thinned out if there are very many."""
    every = max(1, -(-len(lines) // _MOST_POINTS))
    names = dict.fromkeys(name for line in lines for name in line if name not in {"step", "seconds"})
    kept = lines[::-1][::every][::-1]  # the newest is always there
    return {name: [[line["step"], float(f"{line[name]:.6g}")] for line in kept if name in line] for name in names}


def _escaped(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;")
